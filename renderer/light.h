// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "renderer/scene.h"
#include "renderer/sky.h"
#include "renderer/sun.h"

// Where light comes from, prepared for sampling. The rule that counts everything once:
// - sky: found by rays that meet nothing;
// - sun: sampled directly at every surface that is not specular. Its disc is seen only by camera rays and
// their reflections in
//   mirrors and glass; a ray that has been scattered never sees it, so light bundled by mirrors and glass
//   (caustics of the sun, which would come as speckles) is left out;
// - emissive spheres: sampled directly and found by rays, the two weighted by multiple importance sampling
// (balance heuristic,
//   Veach and Guibas 1995);
// - emissive ground and cloud: found by rays.

namespace alidade {

/// A direction towards an emissive sphere.
struct LightSample {
  std::size_t object = 0;  ///< index of the sphere; visible if a ray along `direction` meets it first
  glm::dvec3 direction{0.0};
  Rgb radiance{0.0f};
  double pdf = 0.0;  ///< per solid angle, choice of the sphere included
};

class Lights {
 public:
  explicit Lights(const Scene& scene);

  const Sky& sky() const { return *sky_; }
  const std::optional<SunDisc>& sun() const { return sun_; }

  /// Whether there are emissive spheres.
  bool has_spheres() const { return !spheres_.empty(); }

  /// Chooses a sphere in proportion to its power and a direction evenly over its visible cap. Requires
  /// has_spheres().
  LightSample sample(const glm::dvec3& position, double u_choice, const glm::dvec2& u) const;

  /// Density with which `sample` would have chosen a direction that meets this object; 0 for objects that are
  /// not sampled.
  double pdf(std::size_t object, const glm::dvec3& position) const;

 private:
  struct SphereLight {
    std::size_t object = 0;
    Sphere sphere;
    Rgb radiance{0.0f};
    double chance = 0.0, cumulative = 0.0;
  };

  const Sky* sky_;
  std::optional<SunDisc> sun_;
  std::vector<SphereLight> spheres_;
};

}  // namespace alidade
