// SPDX-License-Identifier: MIT
// render_bench CLOUD CAMERA.json [SAMPLES [sphere|smooth]]: renders the cloud like
//   alidade render --cloud CLOUD --camera CAMERA.json --size 600x400
// and then casts the rays of that picture again, in the same batches, on the bare octree and with Embree.
// Prints rows of a table in Markdown.
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <string_view>

#include "camera/camera.h"
#include "octree/tree_walk.h"
#include "renderer/read_scene.h"
#include "renderer/render.h"
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

struct Batch {
  std::vector<Ray> rays;
  bool occlusion = false;
};

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

void row(const char* what, double rays, double seconds, double render_seconds, double met) {
  std::printf("| %s | %.2f M | %.2f | %.2f | %.2f | %.2f |\n", what, 1e-6 * rays, seconds,
              1e-6 * rays / seconds, render_seconds / seconds, met / rays);
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

  std::vector<Batch> batches;
  std::mutex mutex;
  const RayQuery query{.radius = cloud.radius,
                       .entry_min = smallest_entry(cloud.octree.bounds(), cloud.radius)};
  options.watch_rays = [&](std::span<const Ray> rays, bool occlusion) {
    const std::scoped_lock lock(mutex);
    batches.push_back({{rays.begin(), rays.end()}, occlusion});
  };
  render(scene, &cloud, options);
  double rays = 0.0;
  for (const Batch& batch : batches) rays += static_cast<double>(batch.rays.size());

  const Measured bare =
      measure(batches, [&](const Batch& batch) { return query_octree(cloud, query, batch); });
  const auto share = static_cast<double>(bare.met);
  std::printf("| what | rays | seconds | M rays/s | times the render | rays that meet something |\n");
  std::printf("|---|--:|--:|--:|--:|--:|\n");
  row("the whole render", rays, statistics.seconds, statistics.seconds, share);
  row("its rays, the octree alone", rays, bare.seconds, statistics.seconds, share);
#ifdef ALIDADE_WITH_EMBREE
  const test::EmbreeSpheres spheres = embree_spheres(cloud);
  const Measured embree = measure(batches, [&](const Batch& batch) { return query_embree(spheres, batch); });
  row("its rays, Embree alone", rays, embree.seconds, statistics.seconds, static_cast<double>(embree.met));
#endif
  std::printf(
      "\nqueries take %.0f %% of the render's processor time\n",
      100.0 * statistics.query_seconds / (statistics.seconds * tbb::this_task_arena::max_concurrency()));
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
