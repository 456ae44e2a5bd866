// SPDX-License-Identifier: MIT
#include "renderer/integrator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "renderer/sampling.h"

namespace alidade::renderer {
namespace {

constexpr std::uint32_t k_dimensions_per_vertex = 8;
constexpr int k_first_roulette_vertex = 3;

/// What a path remembers of the surfaces behind it.
struct PathState {
  double pdf = 0.0;              ///< of the last direction; 0 when it was specular or the camera's
  bool scattered = false;        ///< whether any surface was neither mirror nor glass
  glm::dvec3 scattered_at{0.0};  ///< on the last such surface
  double scattered_pdf = 0.0;    ///< of the direction chosen there
  double roughness = 0.0;        ///< the largest so far, at most k_diffuse_roughness
};

/// The material as a path takes it that has met this roughness. Mirrors stay mirrors: no glint of a light is
/// sampled in them.
Material regularized(const Material& material, double roughness) {
  const auto* metal = std::get_if<Metal>(&material);
  if (metal == nullptr || metal->roughness >= roughness || is_specular(material)) return material;
  return Metal{metal->albedo, roughness};
}

double roughness_of(const Material& material) {
  const auto* metal = std::get_if<Metal>(&material);
  return metal == nullptr ? k_diffuse_roughness : std::min(metal->roughness, k_diffuse_roughness);
}

/// A vertex of a path, with what light scattered there needs.
struct Vertex {
  Surface surface;
  Material material;
  Basis basis;
  glm::dvec3 wo;  ///< in the basis
  RayOrigin ray_origin;

  Vertex(const Ray& ray, const Intersection& intersection, const Surface& surface_there, double roughness)
      : surface(surface_there),
        material(regularized(*surface.material, roughness)),
        basis(basis_around(surface.normal)),
        wo(basis.to_local(-ray.direction)),
        ray_origin(intersection.leaving(false)) {}

  RayOrigin leaving(const glm::dvec3& wi) const {
    RayOrigin result = ray_origin;
    result.inward = wi.z < 0.0;
    return result;
  }
  Rgb eval(const glm::dvec3& wi) const { return renderer::eval(material, surface.color, wo, wi); }
};

/// Weight of sun or sky found by a ray against the same sampled, for its chance over that of the sample:
/// power heuristic, so that what a diffuse surface hardly ever finds is left to the samples. 1 minus it is
/// the other weight.
float mis_weight(double chance) {
  const double chance_sq = chance * chance;
  return static_cast<float>(chance_sq / (1.0 + chance_sq));
}

/// Rays of many paths to one light each.
struct LightRays {
  std::vector<Ray> rays;
  std::vector<RayOrigin> ray_origins;
  std::vector<std::size_t> paths;
  std::vector<Rgb> radiance;         ///< what the path gains if the light is seen
  std::vector<std::size_t> objects;  ///< of lamps: the emissive sphere

  void clear() {
    rays.clear();
    ray_origins.clear();
    paths.clear();
    radiance.clear();
    objects.clear();
  }

  void add(std::size_t path, const Vertex& vertex, const glm::dvec3& direction, const glm::dvec3& wi,
           const Rgb& gain) {
    rays.push_back({vertex.surface.ray_origin, direction});
    ray_origins.push_back(vertex.leaving(wi));
    paths.push_back(path);
    radiance.push_back(gain);
  }
};

void sample_sun(const SunDisc& sun, std::size_t path, const Vertex& vertex, const Rgb& throughput,
                Sampler& sampler, LightRays& asked) {
  const glm::dvec3 direction = sun.sample(sampler.next_2d());
  const glm::dvec3 wi = vertex.basis.to_local(direction);
  const double found_chance = sun.solid_angle() * pdf(vertex.material, vertex.wo, wi);
  const Rgb light = sun.sample_weight() * vertex.eval(wi) * (1.0f - mis_weight(found_chance));
  if (light != Rgb(0.0f)) asked.add(path, vertex, direction, wi, throughput * light);
}

void sample_sky(const SkyImage& sky, std::size_t path, const Vertex& vertex, const Rgb& throughput,
                Sampler& sampler, LightRays& asked) {
  const SkySample chosen = sky.sample(sampler.next_2d());
  if (chosen.pdf == 0.0) return;
  const glm::dvec3 wi = vertex.basis.to_local(chosen.direction);
  const double found_chance = pdf(vertex.material, vertex.wo, wi) / chosen.pdf;
  // In double: the parts may be too large or small for float, their ratio is not.
  const Rgb weight(glm::dvec3(chosen.radiance) / chosen.pdf);
  const Rgb light = weight * vertex.eval(wi) * (1.0f - mis_weight(found_chance));
  if (light != Rgb(0.0f)) asked.add(path, vertex, chosen.direction, wi, throughput * light);
}

void sample_lamp(const Lights& lights, std::size_t path, const Vertex& vertex, const Rgb& throughput,
                 Sampler& sampler, LightRays& asked) {
  const double u_choice = sampler.next_1d();
  const LightSample lamp = lights.sample(vertex.surface.ray_origin, u_choice, sampler.next_2d());
  const glm::dvec3 wi = vertex.basis.to_local(lamp.direction);
  const double both_pdf = lamp.pdf + pdf(vertex.material, vertex.wo, wi);
  const Rgb light = lamp.radiance * vertex.eval(wi) / static_cast<float>(both_pdf);
  if (light == Rgb(0.0f)) return;
  asked.add(path, vertex, lamp.direction, wi, throughput * light);
  asked.objects.push_back(lamp.object);
}

/// Share that counts of a light found by way of mirrors and glass after scattering: the square of the chance
/// to find it straight from where light scattered, which fills this share of the hemisphere there.
float bundled_share(double visible_share, const PathState& state) {
  const double chance = std::min(1.0, visible_share * std::max(1.0, 2.0 * k_pi * state.scattered_pdf));
  return static_cast<float>(chance * chance);
}

/// Share of an emissive surface's light that counts for a ray which found it by itself.
float lamp_share(const Lights& lights, const Intersection& intersection, const PathState& state) {
  if (intersection.on_cloud || !state.scattered) return 1.0f;
  if (state.pdf == 0.0)
    return bundled_share(lights.visible_share(intersection.index, state.scattered_at), state);
  return static_cast<float>(state.pdf / (state.pdf + lights.pdf(intersection.index, state.scattered_at)));
}

/// Share of the sun's light that counts for a ray which met it.
float sun_share(const SunDisc& sun, const PathState& state) {
  if (!state.scattered) return 1.0f;
  if (state.pdf == 0.0) return bundled_share(sun.solid_angle() / (2.0 * k_pi), state);
  return mis_weight(sun.solid_angle() * state.pdf);
}

/// Share of the light of an image's sky that counts for a ray in this direction.
float sky_share(const SkyImage& sky, const glm::dvec3& direction, const PathState& state) {
  if (!state.scattered) return 1.0f;
  const double sampled = sky.pdf(direction);
  if (sampled == 0.0) return 1.0f;
  if (state.pdf == 0.0) return bundled_share(k_spot_density / (2.0 * k_pi * sampled), state);
  return mis_weight(state.pdf / sampled);
}

/// All that trace_paths has under way.
class PathTracer {
 public:
  PathTracer(const World& world, const Lights& lights, int max_bounces, std::span<PathResult> results)
      : world_(world), lights_(lights), max_bounces_(max_bounces), results_(results) {}

  void trace(std::span<const CameraPath> starts, const std::function<void()>& look) {
    for (std::size_t path = 0; path < starts.size(); ++path) {
      results_[path] = {};
      ways_.emplace_back(starts[path].sampler);
      go_on(path, starts[path].ray, {});
    }
    for (int bounce = 0; !next_.paths.empty(); ++bounce) {
      if (look) look();
      std::swap(now_, next_);
      next_.clear();
      met_.assign(now_.paths.size(), std::nullopt);
      world_.nearest(now_.rays, now_.ray_origins, met_);
      for (std::size_t i = 0; i < now_.paths.size(); ++i) advance(i, bounce);
      gather_from_afar(to_sun_);
      gather_from_afar(to_sky_);
      gather_lamplight();
    }
  }

 private:
  /// What a path takes along.
  struct Way {
    explicit Way(const Sampler& start) : sampler(start) {}

    Sampler sampler;
    Rgb throughput{1.0f};
    PathState state;
  };

  /// The paths that have not ended, each with its next ray.
  struct Front {
    std::vector<std::size_t> paths;
    std::vector<Ray> rays;
    std::vector<RayOrigin> ray_origins;

    void clear() {
      paths.clear();
      rays.clear();
      ray_origins.clear();
    }
  };

  void go_on(std::size_t path, const Ray& ray, const RayOrigin& ray_origin) {
    next_.paths.push_back(path);
    next_.rays.push_back(ray);
    next_.ray_origins.push_back(ray_origin);
  }

  /// The i-th path of now_ to its next surface and off again.
  void advance(std::size_t i, int bounce) {
    const std::size_t path = now_.paths[i];
    const Ray& ray = now_.rays[i];
    const std::optional<Intersection>& met = met_[i];
    PathResult& result = results_[path];
    Way& way = ways_[path];
    ++result.ray_count;
    if (!met) {
      Rgb light = sky_radiance(lights_.sky(), ray.direction);
      if (lights_.sky_image() != nullptr) light *= sky_share(*lights_.sky_image(), ray.direction, way.state);
      if (lights_.sun())
        light += lights_.sun()->radiance(ray.direction) * sun_share(*lights_.sun(), way.state);
      result.radiance += way.throughput * light;
      return;
    }
    result.met_surface = true;
    const Vertex vertex(ray, *met, world_.surface_at(ray, *met), way.state.roughness);
    if (const auto* emissive = std::get_if<Emissive>(&vertex.material)) {
      result.radiance += way.throughput * emissive->radiance * lamp_share(lights_, *met, way.state);
      return;
    }
    if (bounce > max_bounces_) return;

    Sampler& sampler = way.sampler;
    sampler.start_at(k_first_path_dimension + k_dimensions_per_vertex * static_cast<std::uint32_t>(bounce));
    const glm::dvec2 u = sampler.next_2d();
    const double u_choice = sampler.next_1d(), u_roulette = sampler.next_1d();
    if (!is_specular(vertex.material)) {
      if (lights_.sun()) sample_sun(*lights_.sun(), path, vertex, way.throughput, sampler, to_sun_);
      if (lights_.has_spheres()) sample_lamp(lights_, path, vertex, way.throughput, sampler, to_lamps_);
      if (lights_.sky_image() != nullptr)
        sample_sky(*lights_.sky_image(), path, vertex, way.throughput, sampler, to_sky_);
    }

    const auto next = sample(vertex.material, vertex.surface.color, vertex.wo, u, u_choice);
    if (!next) return;
    way.throughput *= next->weight;
    if (bounce >= k_first_roulette_vertex) {
      const Rgb& left = way.throughput;
      const float survival = std::min(1.0f, std::max({left.r, left.g, left.b}));
      if (!(u_roulette < survival)) return;
      way.throughput /= survival;
    }
    go_on(path, {vertex.surface.ray_origin, vertex.basis.to_world(next->wi)}, vertex.leaving(next->wi));
    remember(*next, vertex, way.state);
  }

  static void remember(const MaterialSample& next, const Vertex& vertex, PathState& state) {
    state.pdf = next.pdf;
    if (next.specular) {
      // A curved mirror makes what is behind it small, and so more rarely met.
      state.roughness = std::min(2.0 * state.roughness, k_diffuse_roughness);
    } else {
      state.scattered = true;
      state.scattered_at = vertex.surface.ray_origin;
      state.scattered_pdf = next.pdf;
      state.roughness = roughness_of(vertex.material);  // regularized(): at least that before
    }
  }

  void gather_from_afar(LightRays& asked) {
    blocked_.assign(asked.rays.size(), 0);
    world_.blocked(asked.rays, asked.ray_origins, blocked_);
    for (std::size_t i = 0; i < asked.rays.size(); ++i) gather(asked, i, blocked_[i] == 0);
    asked.clear();
  }

  void gather_lamplight() {
    met_.assign(to_lamps_.rays.size(), std::nullopt);
    world_.nearest(to_lamps_.rays, to_lamps_.ray_origins, met_);
    for (std::size_t i = 0; i < to_lamps_.rays.size(); ++i)
      gather(to_lamps_, i, met_[i] && !met_[i]->on_cloud && met_[i]->index == to_lamps_.objects[i]);
    to_lamps_.clear();
  }

  void gather(const LightRays& asked, std::size_t i, bool seen) {
    PathResult& result = results_[asked.paths[i]];
    ++result.ray_count;
    if (seen) result.radiance += asked.radiance[i];
  }

  const World& world_;
  const Lights& lights_;
  const int max_bounces_;
  const std::span<PathResult> results_;
  std::vector<Way> ways_;
  Front now_, next_;
  std::vector<std::optional<Intersection>> met_;
  LightRays to_sun_, to_sky_, to_lamps_;
  std::vector<std::uint8_t> blocked_;
};

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

/// The colour of a surface in images without lights.
struct Shown {
  Rgb color{0.0f};
  bool is_emissive = false;  ///< whether the colour is a radiance, not an albedo
};

Shown shown(const Surface& surface) {
  if (const auto* emissive = std::get_if<Emissive>(surface.material)) return {emissive->radiance, true};
  return {albedo(*surface.material, surface.color), false};
}

}  // namespace

void trace_paths(const World& world, const Lights& lights, std::span<const CameraPath> paths, int max_bounces,
                 std::span<PathResult> results, const std::function<void()>& look) {
  PathTracer(world, lights, max_bounces, results).trace(paths, look);
}

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
        if (seen.is_emissive) {
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
        results[path].radiance = seen.is_emissive ? seen.color : seen.color * static_cast<float>(cosine);
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
                   double ao_distance, std::span<const CameraPath> paths, std::span<PathResult> results,
                   const std::function<void()>& look) {
  switch (settings.mode) {
    case RenderMode::path:
      return trace_paths(world, lights, paths, settings.max_bounces, results, look);
    case RenderMode::ambient_occlusion:
      return trace_ambient_occlusion(world, lights.sky(), ao_distance, paths, results);
    case RenderMode::headlight:
      return trace_headlight(world, lights.sky(), paths, results);
    case RenderMode::flat:
      return trace_flat(world, paths, results);
  }
}

}  // namespace alidade::renderer
