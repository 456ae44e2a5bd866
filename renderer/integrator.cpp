// SPDX-License-Identifier: MIT
#include "renderer/integrator.h"

#include <algorithm>

namespace alidade {
namespace {

constexpr std::uint32_t k_dimensions_per_vertex = 8;
constexpr int k_first_roulette_vertex = 3;

/// A place on a path, with what light scattered there needs.
struct Vertex {
  Surface surface;
  Basis basis;
  glm::dvec3 outgoing;  ///< in the basis
  Departure departure;

  Vertex(const Ray& ray, const Intersection& intersection, const Surface& surface_there)
      : surface(surface_there),
        basis(basis_around(surface.normal)),
        outgoing(basis.to_local(-ray.direction)) {
    departure.from = intersection.on_cloud ? Departure::From::point : Departure::From::object;
    departure.index = intersection.index;
    departure.center = intersection.center;
  }

  Departure leaving(const glm::dvec3& incoming) const {
    Departure result = departure;
    result.inward = incoming.z < 0.0;
    return result;
  }
  Rgb eval(const glm::dvec3& incoming) const {
    return alidade::eval(*surface.material, surface.color, outgoing, incoming);
  }
};

Rgb sunlight(const World& world, const SunDisc& sun, const Vertex& vertex, Sampler& sampler,
             std::uint64_t& ray_count) {
  const glm::dvec3 direction = sun.sample(sampler.next_2d());
  const glm::dvec3 incoming = vertex.basis.to_local(direction);
  const Rgb light = sun.sample_weight() * vertex.eval(incoming);
  if (light == Rgb(0.0f)) return light;
  ++ray_count;
  return world.blocked({vertex.surface.departure, direction}, vertex.leaving(incoming)) ? Rgb(0.0f) : light;
}

Rgb lamplight(const World& world, const Lights& lights, const Vertex& vertex, Sampler& sampler,
              std::uint64_t& ray_count) {
  const double u_choice = sampler.next_1d();
  const LightSample lamp = lights.sample(vertex.surface.departure, u_choice, sampler.next_2d());
  const glm::dvec3 incoming = vertex.basis.to_local(lamp.direction);
  const double both_pdf = lamp.pdf + pdf(*vertex.surface.material, vertex.outgoing, incoming);
  const Rgb light = lamp.radiance * vertex.eval(incoming) / static_cast<float>(both_pdf);
  if (light == Rgb(0.0f)) return light;
  ++ray_count;
  const auto met = world.nearest({vertex.surface.departure, lamp.direction}, vertex.leaving(incoming));
  return met && !met->on_cloud && met->index == lamp.object ? light : Rgb(0.0f);
}

/// Share of an emissive surface's light that counts for a ray which found it by itself.
float found_share(const Lights& lights, const Intersection& intersection, const glm::dvec3& from,
                  double bounce_pdf) {
  if (bounce_pdf == 0.0 || intersection.on_cloud) return 1.0f;
  return static_cast<float>(bounce_pdf / (bounce_pdf + lights.pdf(intersection.index, from)));
}

}  // namespace

PathResult trace_path(const World& world, const Lights& lights, const Ray& camera_ray, Sampler& sampler,
                      int max_bounces) {
  PathResult result;
  Ray ray = camera_ray;
  Departure departure;
  Rgb throughput(1.0f);
  double bounce_pdf = 0.0;    // of the last direction; 0 when it was specular or the camera's
  bool only_specular = true;  // nothing but mirrors and glass so far
  for (int bounce = 0;; ++bounce) {
    ++result.ray_count;
    const std::optional<Intersection> met = world.nearest(ray, departure);
    if (!met) {
      Rgb light = sky_radiance(lights.sky(), ray.direction);
      if (only_specular && lights.sun()) light += lights.sun()->radiance(ray.direction);
      result.radiance += throughput * light;
      return result;
    }
    result.met_surface = true;
    const Vertex vertex(ray, *met, world.surface_at(ray, *met));
    if (const auto* emissive = std::get_if<Emissive>(vertex.surface.material)) {
      result.radiance += throughput * emissive->radiance * found_share(lights, *met, ray.origin, bounce_pdf);
      return result;
    }
    if (bounce > max_bounces) return result;

    sampler.start_at(k_first_path_dimension + k_dimensions_per_vertex * static_cast<std::uint32_t>(bounce));
    const glm::dvec2 u = sampler.next_2d();
    const double u_choice = sampler.next_1d(), u_roulette = sampler.next_1d();
    if (!is_specular(*vertex.surface.material)) {
      if (lights.sun())
        result.radiance += throughput * sunlight(world, *lights.sun(), vertex, sampler, result.ray_count);
      if (lights.has_spheres())
        result.radiance += throughput * lamplight(world, lights, vertex, sampler, result.ray_count);
    }

    const auto next = sample(*vertex.surface.material, vertex.surface.color, vertex.outgoing, u, u_choice);
    if (!next) return result;
    throughput *= next->weight;
    if (bounce >= k_first_roulette_vertex) {
      const float survival = std::min(1.0f, std::max({throughput.r, throughput.g, throughput.b}));
      if (!(u_roulette < survival)) return result;
      throughput /= survival;
    }
    ray = {vertex.surface.departure, vertex.basis.to_world(next->incoming)};
    departure = vertex.leaving(next->incoming);
    bounce_pdf = next->pdf;
    only_specular = only_specular && next->specular;
  }
}

}  // namespace alidade
