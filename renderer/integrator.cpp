// SPDX-License-Identifier: MIT
#include "renderer/integrator.h"

#include <algorithm>

namespace alidade {
namespace {

constexpr std::uint32_t k_dimensions_per_vertex = 8;
constexpr int k_first_roulette_vertex = 3;

/// What a path remembers of the surfaces behind it.
struct Trail {
  double pdf = 0.0;              ///< of the last direction; 0 when it was specular or the camera's
  bool scattered = false;        ///< whether there was anything but mirrors and glass
  glm::dvec3 scattered_at{0.0};  ///< the last such place
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

/// A place on a path, with what light scattered there needs.
struct Vertex {
  Surface surface;
  Material material;
  Basis basis;
  glm::dvec3 outgoing;  ///< in the basis
  Departure departure;

  Vertex(const Ray& ray, const Intersection& intersection, const Surface& surface_there, double roughness)
      : surface(surface_there),
        material(regularized(*surface.material, roughness)),
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
    return alidade::eval(material, surface.color, outgoing, incoming);
  }
};

/// Weight of the sun found by a ray against the sun sampled, for its chance over that of the sample: power
/// heuristic, so that what a diffuse surface hardly ever finds is left to the samples. 1 minus it is the
/// other weight.
float found_weight(double chance) {
  const double chance_sq = chance * chance;
  return static_cast<float>(chance_sq / (1.0 + chance_sq));
}

Rgb sunlight(const World& world, const SunDisc& sun, const Vertex& vertex, Sampler& sampler,
             std::uint64_t& ray_count) {
  const glm::dvec3 direction = sun.sample(sampler.next_2d());
  const glm::dvec3 incoming = vertex.basis.to_local(direction);
  const double found_chance = sun.solid_angle() * pdf(vertex.material, vertex.outgoing, incoming);
  const Rgb light = sun.sample_weight() * vertex.eval(incoming) * (1.0f - found_weight(found_chance));
  if (light == Rgb(0.0f)) return light;
  ++ray_count;
  return world.blocked({vertex.surface.departure, direction}, vertex.leaving(incoming)) ? Rgb(0.0f) : light;
}

Rgb lamplight(const World& world, const Lights& lights, const Vertex& vertex, Sampler& sampler,
              std::uint64_t& ray_count) {
  const double u_choice = sampler.next_1d();
  const LightSample lamp = lights.sample(vertex.surface.departure, u_choice, sampler.next_2d());
  const glm::dvec3 incoming = vertex.basis.to_local(lamp.direction);
  const double both_pdf = lamp.pdf + pdf(vertex.material, vertex.outgoing, incoming);
  const Rgb light = lamp.radiance * vertex.eval(incoming) / static_cast<float>(both_pdf);
  if (light == Rgb(0.0f)) return light;
  ++ray_count;
  const auto met = world.nearest({vertex.surface.departure, lamp.direction}, vertex.leaving(incoming));
  return met && !met->on_cloud && met->index == lamp.object ? light : Rgb(0.0f);
}

/// Share that counts of a light found by way of mirrors and glass after scattering: the square of the chance
/// to find it straight from the scattering place, which fills this share of the hemisphere there.
float bundled_share(double visible_share, const Trail& trail) {
  const double chance = std::min(1.0, visible_share * std::max(1.0, 2.0 * k_pi * trail.scattered_pdf));
  return static_cast<float>(chance * chance);
}

/// Share of an emissive surface's light that counts for a ray which found it by itself.
float lamp_share(const Lights& lights, const Intersection& intersection, const Trail& trail) {
  if (intersection.on_cloud || !trail.scattered) return 1.0f;
  if (trail.pdf == 0.0)
    return bundled_share(lights.visible_share(intersection.index, trail.scattered_at), trail);
  return static_cast<float>(trail.pdf / (trail.pdf + lights.pdf(intersection.index, trail.scattered_at)));
}

/// The same for the sun.
float sun_share(const SunDisc& sun, const Trail& trail) {
  if (!trail.scattered) return 1.0f;
  if (trail.pdf == 0.0) return bundled_share(sun.solid_angle() / (2.0 * k_pi), trail);
  return found_weight(sun.solid_angle() * trail.pdf);
}

}  // namespace

PathResult trace_path(const World& world, const Lights& lights, const Ray& camera_ray, Sampler& sampler,
                      int max_bounces) {
  PathResult result;
  Ray ray = camera_ray;
  Departure departure;
  Rgb throughput(1.0f);
  Trail trail;
  for (int bounce = 0;; ++bounce) {
    ++result.ray_count;
    const std::optional<Intersection> met = world.nearest(ray, departure);
    if (!met) {
      Rgb light = sky_radiance(lights.sky(), ray.direction);
      if (lights.sun()) light += lights.sun()->radiance(ray.direction) * sun_share(*lights.sun(), trail);
      result.radiance += throughput * light;
      return result;
    }
    result.met_surface = true;
    const Vertex vertex(ray, *met, world.surface_at(ray, *met), trail.roughness);
    if (const auto* emissive = std::get_if<Emissive>(&vertex.material)) {
      result.radiance += throughput * emissive->radiance * lamp_share(lights, *met, trail);
      return result;
    }
    if (bounce > max_bounces) return result;

    sampler.start_at(k_first_path_dimension + k_dimensions_per_vertex * static_cast<std::uint32_t>(bounce));
    const glm::dvec2 u = sampler.next_2d();
    const double u_choice = sampler.next_1d(), u_roulette = sampler.next_1d();
    if (!is_specular(vertex.material)) {
      if (lights.sun())
        result.radiance += throughput * sunlight(world, *lights.sun(), vertex, sampler, result.ray_count);
      if (lights.has_spheres())
        result.radiance += throughput * lamplight(world, lights, vertex, sampler, result.ray_count);
    }

    const auto next = sample(vertex.material, vertex.surface.color, vertex.outgoing, u, u_choice);
    if (!next) return result;
    throughput *= next->weight;
    if (bounce >= k_first_roulette_vertex) {
      const float survival = std::min(1.0f, std::max({throughput.r, throughput.g, throughput.b}));
      if (!(u_roulette < survival)) return result;
      throughput /= survival;
    }
    ray = {vertex.surface.departure, vertex.basis.to_world(next->incoming)};
    departure = vertex.leaving(next->incoming);
    trail.pdf = next->pdf;
    if (next->specular) {
      // A curved mirror makes what is behind it small, and so more rarely met.
      trail.roughness = std::min(2.0 * trail.roughness, k_diffuse_roughness);
    } else {
      trail.scattered = true;
      trail.scattered_at = ray.origin;
      trail.scattered_pdf = next->pdf;
      trail.roughness = std::max(trail.roughness, roughness_of(vertex.material));
    }
  }
}

}  // namespace alidade
