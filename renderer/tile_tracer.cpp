// SPDX-License-Identifier: MIT
#include "renderer/tile_tracer.h"

#include <glm/geometric.hpp>

namespace alidade::renderer {
namespace {

/// Depth along the camera's axis over distance along the ray. A panorama has no axis: its depth is the
/// distance.
double depth_share(const camera::Camera& camera, const Ray& ray) {
  if (std::holds_alternative<camera::EquirectangularLens>(camera.lens)) return 1.0;
  return glm::dot(ray.direction, camera.pose.forward);
}

void fill_pixel(const camera::Camera& camera, const World& world, const Ray& ray, const Intersection& met,
                const HitTrust& trust, std::size_t pixel, image::Film& film) {
  const double share = depth_share(camera, ray);
  if (film.holds(image::Layer::depth)) film.depth[pixel] = static_cast<float>(met.t * share);
  if (film.holds(image::Layer::depth_sigma))
    film.depth_sigma[pixel] = static_cast<float>(trust.sigma * share);
  if (film.holds(image::Layer::support)) film.support[pixel] = trust.support;
  if (film.holds(image::Layer::distance)) film.distance[pixel] = static_cast<float>(met.t);
  if (film.holds(image::Layer::id)) {
    film.id[pixel] =
        met.on_cloud ? static_cast<std::uint32_t>(met.index + 1) : static_cast<std::uint32_t>(~met.index);
  }
  if (!film.holds(image::Layer::normal) && !film.holds(image::Layer::position) &&
      !film.holds(image::Layer::albedo))
    return;
  const Surface surface = world.surface_at(ray, met);
  if (film.holds(image::Layer::normal)) {
    const bool away = glm::dot(surface.normal, ray.direction) > 0.0;
    film.normal[pixel] = glm::vec3(away ? -surface.normal : surface.normal);
  }
  if (film.holds(image::Layer::position)) film.position[pixel] = surface.position;
  if (film.holds(image::Layer::albedo)) film.albedo[pixel] = albedo(*surface.material, surface.color);
}

/// What rays through the same point of each pixel of a box meet.
struct PixelRays {
  /// in_pixel: from the pixel's corner, pixels.
  PixelRays(const camera::Projection& projection, const World& world, const image::PixelBox& box,
            const glm::dvec2& in_pixel, const image::Film& film) {
    for (int y = box.top; y < box.bottom; ++y) {
      for (int x = box.left; x < box.right; ++x) {
        const std::optional<Ray> ray = projection.ray(glm::dvec2(x, y) + in_pixel);
        if (!ray) continue;
        rays.push_back(*ray);
        pixels.push_back(film.index(x, y));
      }
    }
    met.resize(rays.size());
    world.nearest(rays, std::vector<RayOrigin>(rays.size()), met);
  }

  std::vector<Ray> rays;
  std::vector<std::size_t> pixels;
  std::vector<std::optional<Intersection>> met;
};

void fill_coverage(const camera::Projection& projection, const World& world, const image::PixelBox& box,
                   image::Film& film) {
  constexpr int k_side = 4;
  for (int i = 0; i < k_side * k_side; ++i) {
    const PixelRays through(projection, world, box,
                            (glm::dvec2(i % k_side, i / k_side) + 0.5) / static_cast<double>(k_side), film);
    for (std::size_t r = 0; r < through.rays.size(); ++r)
      if (through.met[r] && through.met[r]->on_cloud)
        film.coverage[through.pixels[r]] += 1.0f / (k_side * k_side);
  }
}

}  // namespace

std::vector<PathResult> sample_tiles(const RenderTask& task, std::span<const TileSamples> work) {
  std::size_t count = 0;
  for (const TileSamples& tile : work) count += tile.count();
  std::vector<CameraPath> paths;
  std::vector<std::size_t> numbers;  // in the results
  paths.reserve(count);
  numbers.reserve(count);
  std::size_t number = 0;
  for (const TileSamples& tile : work) {
    for (int y = tile.box.top; y < tile.box.bottom; ++y) {
      for (int x = tile.box.left; x < tile.box.right; ++x) {
        for (std::uint32_t sample = tile.first; sample < tile.last; ++sample, ++number) {
          Sampler sampler(task.settings.seed, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
                          sample);
          const glm::dvec2 in_pixel = sampler.next_2d();
          const std::optional<Ray> ray = task.projection.ray({x + in_pixel.x, y + in_pixel.y});
          if (!ray) continue;
          paths.push_back({*ray, sampler});
          numbers.push_back(number);
        }
      }
    }
  }
  std::vector<PathResult> traced(paths.size());
  trace_samples(task.world, task.lights, task.settings, task.ao_distance, paths, traced, task.look);
  if (traced.size() == count) return traced;
  std::vector<PathResult> results(count);
  for (std::size_t i = 0; i < traced.size(); ++i) results[numbers[i]] = traced[i];
  return results;
}

void fill_center_layers(const camera::Projection& projection, const World& world, const image::PixelBox& box,
                        image::Film& film) {
  const PixelRays center(projection, world, box, glm::dvec2(0.5), film);
  std::vector<HitTrust> trust(center.rays.size());
  if (film.holds(image::Layer::depth_sigma) || film.holds(image::Layer::support))
    world.trust(center.rays, center.met, trust);
  for (std::size_t i = 0; i < center.rays.size(); ++i)
    if (center.met[i])
      fill_pixel(projection.camera(), world, center.rays[i], *center.met[i], trust[i], center.pixels[i],
                 film);
  if (film.holds(image::Layer::coverage)) fill_coverage(projection, world, box, film);
}

}  // namespace alidade::renderer
