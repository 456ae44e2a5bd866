// SPDX-License-Identifier: MIT
// render_bench CLOUD CAMERA.json [SAMPLES [sphere|smooth]]: renders the cloud like
//   alidade render --cloud CLOUD --camera CAMERA.json --size 600x400
// and then casts rays like those of its paths, in batches, on the bare octree and with Embree.
// Prints rows of a table in Markdown.
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "camera/camera.h"
#include "camera/camera_json.h"
#include "camera/projection.h"
#include "octree/tree_walk.h"
#include "renderer/light.h"
#include "renderer/read_scene.h"
#include "renderer/render.h"
#include "renderer/sampler.h"
#include "renderer/sampling.h"
#include "renderer/world.h"
#ifdef ALIDADE_WITH_EMBREE
#include "tests/support/embree_spheres.h"
#endif

namespace alidade {

using namespace geo;
using namespace image;
using namespace camera;
using namespace renderer;

namespace {

constexpr int k_rows = 8;  // of a batch

struct Batch {
  std::vector<Ray> rays;
  bool occlusion = false;
};

/// Rays like those of paths through some rows of pixels: those of the camera, then from each surface one to
/// the sun and one that a diffuse surface scatters.
void add_paths(const World& world, const Projection& projection, const SunDisc& sun, int first_row,
               std::uint32_t sample, std::vector<Batch>& batches) {
  constexpr int k_surfaces = 4;
  const Camera& camera = projection.camera();
  std::vector<Ray> rays;
  std::vector<Sampler> samplers;
  for (int y = first_row; y < std::min(first_row + k_rows, camera.height); ++y) {
    for (int x = 0; x < camera.width; ++x) {
      Sampler sampler(1, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), sample);
      if (const std::optional<Ray> ray = projection.ray(glm::dvec2(x, y) + sampler.next_2d())) {
        rays.push_back(*ray);
        samplers.push_back(sampler);
      }
    }
  }
  std::vector<RayOrigin> origins(rays.size());
  for (int surfaces = 0; surfaces <= k_surfaces && !rays.empty(); ++surfaces) {
    batches.push_back({rays, false});
    if (surfaces == k_surfaces) return;
    std::vector<std::optional<Intersection>> met(rays.size());
    world.nearest(rays, origins, met);
    Batch shadows{{}, true};
    std::vector<Ray> scattered;
    std::vector<RayOrigin> left;
    std::vector<Sampler> going_on;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (!met[i]) continue;
      const Surface surface = world.surface_at(rays[i], *met[i]);
      const bool inside = glm::dot(surface.normal, rays[i].direction) > 0.0;
      const glm::dvec3 facing = inside ? -surface.normal : surface.normal;
      const glm::dvec3 to_sun = sun.sample(samplers[i].next_2d());
      if (glm::dot(to_sun, facing) > 0.0) shadows.rays.push_back({surface.ray_origin, to_sun});
      const glm::dvec3 direction = sample_cosine_hemisphere(samplers[i].next_2d());
      scattered.push_back({surface.ray_origin, basis_around(facing).to_world(direction)});
      left.push_back(met[i]->leaving(inside));
      going_on.push_back(samplers[i]);
    }
    batches.push_back(std::move(shadows));
    rays = std::move(scattered);
    origins = std::move(left);
    samplers = std::move(going_on);
  }
}

std::vector<Batch> rays_of_paths(const Scene& scene, const LoadedCloud& cloud) {
  const World world(scene, &cloud);
  const Projection projection(*scene.camera);
  const SunDisc sun(*scene.sun);
  std::vector<Batch> batches;
  for (int sample = 0; sample < scene.render.samples; ++sample)
    for (int y = 0; y < scene.camera->height; y += k_rows)
      add_paths(world, projection, sun, y, static_cast<std::uint32_t>(sample), batches);
  return batches;
}

double seconds_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

struct Measured {
  double seconds = 0.0;
  std::size_t met = 0;
};

/// Every batch by one thread, as in the renderer.
template <class RunBatch>
Measured measure(std::span<const Batch> batches, const RunBatch& run_batch) {
  std::atomic<std::size_t> met{0};
  const double seconds = seconds_of([&] {
    tbb::parallel_for(std::size_t{0}, batches.size(), [&](std::size_t i) {
      tbb::task_arena alone(1);
      alone.execute([&] { met += run_batch(batches[i]); });
    });
  });
  return {seconds, met};
}

/// Returns how many rays meet something; so do the others.
std::size_t query_octree(const LoadedCloud& cloud, const RayQuery& query, const Batch& batch) {
  if (batch.occlusion) {
    std::vector<std::uint8_t> answers(batch.rays.size());
    occluded(cloud.octree, batch.rays, query, answers);
    return static_cast<std::size_t>(std::ranges::count(answers, 1));
  }
  std::vector<std::optional<Hit>> hits(batch.rays.size());
  closest(cloud.octree, batch.rays, query, hits);
  return static_cast<std::size_t>(
      std::ranges::count_if(hits, [](const auto& hit) { return hit.has_value(); }));
}

#ifdef ALIDADE_WITH_EMBREE
test::EmbreeSpheres embree_spheres(const LoadedCloud& cloud) {
  PointCloud points;
  points.lattice = cloud.octree.lattice();
  // In the order of the octree, which is Embree's best case.
  for_each_leaf(cloud.octree.view(), [&](const Leaf& leaf) {
    for (std::uint32_t i = 0; i < leaf.count; ++i)
      points.positions.push_back(position_of(cloud.octree.view(), leaf, i));
  });
  return test::EmbreeSpheres(points, cloud.radius, cloud.octree.bounds().min);
}

std::size_t query_embree(const test::EmbreeSpheres& spheres, const Batch& batch) {
  // A ray that leaves a sphere must not meet it again.
  constexpr float k_begin = 1e-4f;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  std::size_t met = 0;
  for (const Ray& ray : batch.rays) {
    RTCRayHit traced = spheres.prepare(ray, k_begin);
    if (batch.occlusion) {
      rtcOccluded1(spheres.scene(), &context, &traced.ray);
      met += traced.ray.tfar < 0.0f ? 1 : 0;
    } else {
      rtcIntersect1(spheres.scene(), &context, &traced);
      met += traced.hit.geomID != RTC_INVALID_GEOMETRY_ID ? 1 : 0;
    }
  }
  return met;
}
#endif

void row(const char* what, double rays, double seconds, double rays_per_second_of_render) {
  std::printf("| %s | %.2f M | %.2f | %.2f | %.2f |\n", what, 1e-6 * rays, seconds, 1e-6 * rays / seconds,
              rays / seconds / rays_per_second_of_render);
}

int run(const char* cloud_file, const char* camera_file, int samples, NormalMode normals) {
  Scene scene;
  scene.cloud.emplace().files = {cloud_file};
  scene.cloud->normals = normals;
  scene.sky = GradientSky{.horizon = {0.72f, 0.80f, 0.88f}, .zenith = {0.30f, 0.48f, 0.80f}};
  scene.sun = Sun{.irradiance = {2.2f, 2.1f, 1.95f}};
  scene.camera = resized(read_camera(camera_file), 600, 400);
  scene.render.samples = samples;
  const LoadedCloud cloud = load_cloud(*scene.cloud);

  RenderOptions options;
  options.layers = {Layer::color};
  render(scene, &cloud, options);
  RenderStatistics statistics;
  render(scene, &cloud, options, &statistics);

  const std::vector<Batch> batches = rays_of_paths(scene, cloud);
  const RayQuery query{.radius = cloud.radius,
                       .entry_min = smallest_entry(cloud.octree.bounds(), cloud.radius)};
  double rays = 0.0;
  for (const Batch& batch : batches) rays += static_cast<double>(batch.rays.size());

  const Measured bare =
      measure(batches, [&](const Batch& batch) { return query_octree(cloud, query, batch); });
  const auto render_rays = static_cast<double>(statistics.ray_count);
  const double speed = render_rays / statistics.seconds;
  std::printf("| what | rays | seconds | M rays/s | times the render |\n");
  std::printf("|---|--:|--:|--:|--:|\n");
  row("the whole render", render_rays, statistics.seconds, speed);
  row("rays of paths, the octree alone", rays, bare.seconds, speed);
#ifdef ALIDADE_WITH_EMBREE
  const test::EmbreeSpheres spheres = embree_spheres(cloud);
  const Measured embree = measure(batches, [&](const Batch& batch) { return query_embree(spheres, batch); });
  row("rays of paths, Embree alone", rays, embree.seconds, speed);
  std::printf("\nmeet something: %.4f of the rays, with Embree %.4f\n", static_cast<double>(bare.met) / rays,
              static_cast<double>(embree.met) / rays);
#endif
  return 0;
}

}  // namespace
}  // namespace alidade

int main(int count, char** arguments) {
  if (count < 3 || count > 5) {
    std::fprintf(stderr, "usage: render_bench CLOUD CAMERA.json [SAMPLES [sphere|smooth]]\n");
    return 2;
  }
  try {
    const bool sphere = count == 5 && std::string_view(arguments[4]) == "sphere";
    return alidade::run(arguments[1], arguments[2], count >= 4 ? std::atoi(arguments[3]) : 4,
                        sphere ? alidade::NormalMode::sphere : alidade::NormalMode::smooth);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "render_bench: %s\n", error.what());
    return 2;
  }
}
