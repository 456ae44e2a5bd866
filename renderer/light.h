// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "geo/earth.h"
#include "renderer/sampling.h"
#include "renderer/scene.h"
#include "renderer/sky.h"

namespace alidade::renderer {

/// The sun prepared for tracing. Its radiance is uniform over the disc, so a surface that faces it receives
/// pi sin^2(half the angle) times that: exactly the irradiance that the scene states.
class SunDisc {
 public:
  explicit SunDisc(const geo::Sun& sun) : irradiance_(sun.irradiance) {
    basis_ = basis_around(glm::normalize(geo::compass_direction(sun.azimuth, sun.elevation)));
    const double half_sine = sine_cosine_of_degrees(0.25 * sun.angular_diameter).sine;
    const double cap_height = 2.0 * half_sine * half_sine;
    cap_height_ = cap_height < k_smallest_cap ? 0.0 : cap_height;
  }

  /// Towards the middle of the disc.
  const glm::dvec3& center() const { return basis_.normal; }

  /// Parallel light comes from a point that no ray can hit. So does that of a disc below 0.00002 degrees,
  /// whose edge would drown in the rounding of directions.
  bool is_parallel() const { return cap_height_ == 0.0; }

  /// What a ray sees that ends in the disc; zero for any other and for parallel light.
  Rgb radiance(const glm::dvec3& direction) const {
    const bool inside = !is_parallel() && glm::dot(direction, basis_.normal) >= 1.0 - cap_height_;
    return inside ? irradiance_ / static_cast<float>(projected_solid_angle()) : Rgb(0.0f);
  }

  /// A direction towards the disc, evenly.
  glm::dvec3 sample(const glm::dvec2& u) const {
    return is_parallel() ? center() : basis_.to_world(sample_cone(u, cap_height_));
  }

  /// Of the disc; one over it is the density of `sample`. 0 for parallel light.
  double solid_angle() const { return 2.0 * k_pi * cap_height_; }

  /// Radiance over density of a sampled direction: what the scattering function times cosine is multiplied
  /// with.
  Rgb sample_weight() const {
    // Solid angle over projected solid angle, 2 pi h / (pi h (2 - h)): 1 for a small disc.
    return irradiance_ * static_cast<float>(2.0 / (2.0 - cap_height_));
  }

 private:
  static constexpr double k_smallest_cap = 1e-14;

  double projected_solid_angle() const { return k_pi * cap_height_ * (2.0 - cap_height_); }

  Basis basis_;
  Rgb irradiance_;
  double cap_height_ = 0.0;  ///< 1 - cosine of half the angular diameter
};

// Where light comes from, prepared for sampling. The rules that count everything once:
// - smooth sky (constant, gradient): found by rays that meet nothing;
// - sun, sky from an image and emissive spheres (lamps): sampled directly at every surface that is not
//   specular, and found by rays. The two are weighted by multiple importance sampling (Veach and Guibas
//   1995): power heuristic for sun and sky, balance heuristic for lamps;
// - emissive ground and cloud: found by rays.
// Light that mirrors and glass bundle onto other surfaces (caustics) is met so rarely that it would come as
// speckles. So sun and lamps found by way of mirrors and glass after scattering count only with the square of
// the chance (at most 1) that the scattering direction had of meeting the light straight: its visible_share
// times the density there over that of a uniform hemisphere. That leaves out the caustics of all small lights
// on diffuse surfaces, and keeps lights all around and those seen in sharp metal. The bright spots of a sky
// from an image are such small lights, too: a direction that is sampled at most k_spot_density times as
// densely as a uniform hemisphere counts in full, so broad skies lose nothing; beyond it the share falls with
// the density.

/// A direction towards an emissive sphere.
struct LightSample {
  std::size_t object = 0;  ///< index of the sphere; visible if a ray along `direction` meets it first
  glm::dvec3 direction{0.0};
  Rgb radiance{0.0f};
  double pdf = 0.0;  ///< per solid angle, choice of the sphere included
};

/// How much more densely than a uniform hemisphere a part of the sky may be sampled before it counts as a
/// small light: a speckle that it leaves is at most that much brighter than its surroundings.
inline constexpr double k_spot_density = 8.0;

class Lights {
 public:
  /// Errors: a sky from an image that has not been read, a sun by time whose position has not been computed.
  explicit Lights(const Scene& scene);

  const Sky& sky() const { return *sky_; }
  /// The sky's image if it has one that is not black: the part of the sky that is sampled.
  const SkyImage* sky_image() const { return sky_image_; }
  const std::optional<SunDisc>& sun() const { return sun_; }

  /// Whether there are emissive spheres.
  bool has_spheres() const { return !spheres_.empty(); }

  /// Chooses a sphere in proportion to its power and a direction evenly over its visible cap. Requires
  /// has_spheres().
  LightSample sample(const glm::dvec3& position, double u_choice, const glm::dvec2& u) const;

  /// Density with which `sample` would have chosen a direction that meets this object; 0 for objects that are
  /// not sampled.
  double pdf(std::size_t object, const glm::dvec3& position) const;

  /// Which part of a hemisphere this object fills as seen from there, at most 1; 1 for objects that are not
  /// sampled.
  double visible_share(std::size_t object, const glm::dvec3& position) const;

 private:
  struct SphereLight {
    std::size_t object = 0;
    Sphere sphere;
    Rgb radiance{0.0f};
    double chance = 0.0, cumulative = 0.0;
  };

  const SphereLight* find(std::size_t object) const;

  const Sky* sky_;
  const SkyImage* sky_image_ = nullptr;
  std::optional<SunDisc> sun_;
  std::vector<SphereLight> spheres_;
};

}  // namespace alidade::renderer
