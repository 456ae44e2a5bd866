// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "base/bounds.h"
#include "base/color.h"
#include "base/ray.h"

namespace alidade {

/// Opaque surfaces with colours of their own, which rays meet from either side: a mesh, a terrain, an exact
/// site. (Points have surface/surface_cloud.h: their hits hold what rays that leave them need.) Safe to query
/// from many threads.
class Surfaces {
 public:
  struct Hit {
    double t = 0.0;                    ///< along the ray, metres
    glm::dvec3 normal{0.0, 0.0, 1.0};  ///< unit, towards the side the ray came from
    Rgb color{0.5f};                   ///< linear; grey where the surface has none
  };

  virtual ~Surfaces() = default;

  /// The first one with t_min <= t <= t_max, where t_min is at least 0. Equal answers for equal rays.
  virtual std::optional<Hit> nearest(const Ray& ray) const = 0;
  /// Whether nearest() would find a surface. Takes at most as long.
  virtual bool occluded(const Ray& ray) const = 0;
  /// Box around all surfaces, in world coordinates; an empty box if there is no surface.
  virtual const Bounds& bounds() const = 0;

 protected:
  Surfaces() = default;
  Surfaces(const Surfaces&) = default;
  Surfaces(Surfaces&&) = default;
  Surfaces& operator=(const Surfaces&) = default;
  Surfaces& operator=(Surfaces&&) = default;
};

}  // namespace alidade
