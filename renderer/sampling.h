// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <numbers>

#include "base/exact_math.h"

// From the unit square to discs, hemispheres, cones and spheres; each with its density. Pure functions: equal
// numbers in, equal directions out, on every machine. Sources: Pharr, Jakob, Humphreys, Physically Based
// Rendering, appendix A.

namespace alidade::renderer {

constexpr double k_pi = std::numbers::pi;

/// Three unit axes at right angles with the normal as z; directions in local coordinates have z = cosine to
/// the normal.
struct Basis {
  glm::dvec3 tangent{1.0, 0.0, 0.0}, bitangent{0.0, 1.0, 0.0}, normal{0.0, 0.0, 1.0};

  glm::dvec3 to_local(const glm::dvec3& world) const {
    return {glm::dot(world, tangent), glm::dot(world, bitangent), glm::dot(world, normal)};
  }
  glm::dvec3 to_world(const glm::dvec3& local) const {
    return local.x * tangent + local.y * bitangent + local.z * normal;
  }
};

/// A basis around a unit normal. Source: Duff et al., Building an Orthonormal Basis, Revisited, JCGT 2017.
inline Basis basis_around(const glm::dvec3& normal) {
  const double sign = std::copysign(1.0, normal.z);
  const double a = -1.0 / (sign + normal.z);
  const double b = normal.x * normal.y * a;
  return {{1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x},
          {b, sign + normal.y * normal.y * a, -normal.y},
          normal};
}

/// Unit disc, uniform density 1/pi; neighbours in the square stay neighbours. Source: Shirley and Chiu 1997.
inline glm::dvec2 sample_disc(const glm::dvec2& u) {
  const double x = 2.0 * u.x - 1.0, y = 2.0 * u.y - 1.0;
  if (x == 0.0 && y == 0.0) return {0.0, 0.0};
  const bool x_leads = std::fabs(x) > std::fabs(y);
  const double radius = x_leads ? x : y;
  const SineCosine angle = sine_cosine_of_turns(0.125 * (x_leads ? y / x : x / y));
  return x_leads ? glm::dvec2(radius * angle.cosine, radius * angle.sine)
                 : glm::dvec2(radius * angle.sine, radius * angle.cosine);
}

/// Upper hemisphere, density cosine / pi.
inline glm::dvec3 sample_cosine_hemisphere(const glm::dvec2& u) {
  const glm::dvec2 disc = sample_disc(u);
  return {disc.x, disc.y, std::sqrt(std::fmax(0.0, 1.0 - disc.x * disc.x - disc.y * disc.y))};
}
inline double pdf_cosine_hemisphere(double cosine) {
  return std::fmax(0.0, cosine) / k_pi;
}

/// Directions around +z whose cosine is at least 1 - `height`, uniform density. `height`, that of the
/// spherical cap, in (0, 2]; 2 is the whole sphere. Not the cosine, because 1 - cosine of a small angle loses
/// its digits.
inline glm::dvec3 sample_cone(const glm::dvec2& u, double height) {
  const double depth = u.x * height;
  const double sine = std::sqrt(std::fmax(0.0, depth * (2.0 - depth)));
  const SineCosine turn = sine_cosine_of_turns(u.y);
  return {sine * turn.cosine, sine * turn.sine, 1.0 - depth};
}
inline double pdf_cone(double height) {
  return 1.0 / (2.0 * k_pi * height);
}

}  // namespace alidade::renderer
