// SPDX-License-Identifier: MIT
#include "renderer/integrator.h"

#include <cmath>
#include <limits>

#include "renderer/sampling.h"

namespace alidade::renderer {
namespace {

/// Calls visit(path, ray, intersection, surface) for every path that meets a surface and finish(path) for the
/// others.
template <class OnSurface, class OnNothing>
void meet(const World& world, std::span<const CameraPath> paths, std::span<PathResult> results,
          const OnSurface& on_surface, const OnNothing& on_nothing) {
  std::vector<Ray> rays;
  rays.reserve(paths.size());
  for (const CameraPath& path : paths) rays.push_back(path.ray);
  std::vector<std::optional<Intersection>> met(rays.size());
  world.nearest(rays, std::vector<RayOrigin>(rays.size()), met);
  for (std::size_t path = 0; path < paths.size(); ++path) {
    results[path] = {.met_surface = met[path].has_value(), .ray_count = 1};
    if (met[path])
      on_surface(path, *met[path], world.surface_at(rays[path], *met[path]));
    else
      on_nothing(path);
  }
}

/// What a surface shows of itself, and whether light matters to it.
struct Shown {
  Rgb color{0.0f};
  bool shines = false;
};

Shown shown(const Surface& surface) {
  if (const auto* emissive = std::get_if<Emissive>(surface.material)) return {emissive->radiance, true};
  return {albedo(*surface.material, surface.color), false};
}

}  // namespace

double ambient_occlusion_distance(const RenderSettings& settings, const LoadedCloud* cloud) {
  if (settings.mode != RenderMode::ambient_occlusion) return 0.0;
  if (settings.ao_distance) return *settings.ao_distance;
  constexpr double k_share_of_extent = 0.05;
  const Bounds bounds = cloud != nullptr ? visible_bounds(*cloud) : Bounds();
  return bounds.empty() ? std::numeric_limits<double>::infinity()
                        : k_share_of_extent * glm::length(bounds.size());
}

void trace_ambient_occlusion(const World& world, const Sky& sky, double ao_distance,
                             std::span<const CameraPath> paths, std::span<PathResult> results) {
  std::vector<Ray> rays;
  std::vector<RayOrigin> ray_origins;
  std::vector<std::size_t> asked;
  std::vector<Rgb> colors;
  meet(
      world, paths, results,
      [&](std::size_t path, const Intersection& met, const Surface& surface) {
        const Shown seen = shown(surface);
        if (seen.shines) {
          results[path].radiance = seen.color;
          return;
        }
        const glm::dvec3 facing =
            glm::dot(surface.normal, paths[path].ray.direction) > 0.0 ? -surface.normal : surface.normal;
        Sampler sampler = paths[path].sampler;
        sampler.start_at(k_first_path_dimension);
        rays.push_back(
            {surface.ray_origin, basis_around(facing).to_world(sample_cosine_hemisphere(sampler.next_2d()))});
        ray_origins.push_back(met.leaving(glm::dot(facing, surface.normal) < 0.0));
        asked.push_back(path);
        colors.push_back(seen.color);
      },
      [&](std::size_t path) { results[path].radiance = sky_radiance(sky, paths[path].ray.direction); });
  std::vector<std::uint8_t> blocked(rays.size());
  world.blocked(rays, ray_origins, blocked, ao_distance);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    PathResult& result = results[asked[i]];
    ++result.ray_count;
    if (blocked[i] == 0) result.radiance = colors[i];
  }
}

void trace_headlight(const World& world, const Sky& sky, std::span<const CameraPath> paths,
                     std::span<PathResult> results) {
  meet(
      world, paths, results,
      [&](std::size_t path, const Intersection&, const Surface& surface) {
        const Shown seen = shown(surface);
        const double cosine = std::fabs(glm::dot(surface.normal, paths[path].ray.direction));
        results[path].radiance = seen.shines ? seen.color : seen.color * static_cast<float>(cosine);
      },
      [&](std::size_t path) { results[path].radiance = sky_radiance(sky, paths[path].ray.direction); });
}

void trace_flat(const World& world, std::span<const CameraPath> paths, std::span<PathResult> results) {
  meet(
      world, paths, results,
      [&](std::size_t path, const Intersection&, const Surface& surface) {
        results[path].radiance = shown(surface).color;
      },
      [](std::size_t) {});
}

void trace_samples(const World& world, const Lights& lights, const RenderSettings& settings,
                   double ao_distance, std::span<const CameraPath> paths, std::span<PathResult> results) {
  switch (settings.mode) {
    case RenderMode::path:
      return trace_paths(world, lights, paths, settings.max_bounces, results);
    case RenderMode::ambient_occlusion:
      return trace_ambient_occlusion(world, lights.sky(), ao_distance, paths, results);
    case RenderMode::headlight:
      return trace_headlight(world, lights.sky(), paths, results);
    case RenderMode::flat:
      return trace_flat(world, paths, results);
  }
}

}  // namespace alidade::renderer
