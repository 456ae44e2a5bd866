// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "renderer/scene.h"
#include "renderer/sky.h"
#include "renderer/sun.h"

// Where light comes from, prepared for sampling. The rules that count everything once:
// - even sky (constant, gradient): found by rays that meet nothing;
// - sun, sky from a picture and emissive spheres (lamps): sampled directly at every surface that is not
//   specular, and found by rays. The two are weighted by multiple importance sampling (Veach and Guibas
//   1995): power heuristic for sun and sky, balance heuristic for lamps;
// - emissive ground and cloud: found by rays.
// Light that mirrors and glass bundle onto other surfaces (caustics) is met so rarely that it would come as
// speckles. So sun and lamps found by way of mirrors and glass after scattering count only with the square of
// the chance (at most 1) that the scattering direction had of meeting the light straight: its visible_share
// times the density there over that of an even hemisphere. That leaves out the caustics of all small lights
// on diffuse surfaces, and keeps lights all around and those seen in sharp metal. Of a sky from a picture the
// bright spots are such small lights: a place that is sampled k_spot_density times as densely as an even
// hemisphere, or less, counts in full, so broad skies lose nothing; beyond it the share falls with the
// density.

namespace alidade {

/// A direction towards an emissive sphere.
struct LightSample {
  std::size_t object = 0;  ///< index of the sphere; visible if a ray along `direction` meets it first
  glm::dvec3 direction{0.0};
  Rgb radiance{0.0f};
  double pdf = 0.0;  ///< per solid angle, choice of the sphere included
};

/// How much more densely than an even hemisphere a part of the sky may be sampled without being taken for a
/// small light: a speckle it may leave is no brighter than that times its surroundings.
inline constexpr double k_spot_density = 8.0;

class Lights {
 public:
  /// Errors: a sky from a picture that has not been read, a sun by time that has not been placed.
  explicit Lights(const Scene& scene);

  const Sky& sky() const { return *sky_; }
  /// The sky's picture if it has one that is not black: the part of the sky that is sampled.
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

}  // namespace alidade
