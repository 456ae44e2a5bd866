// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <span>

#include "extensions/radiation/energy_light.h"
#include "visibility/sky/sun_hours.h"

namespace alidade::visibility {

/// What a receiver gets from sun and sky in a period.
struct Radiation {
  float hours = 0.0f;  ///< of direct sun
  float beam = 0.0f;   ///< Wh/m2 of the receiver, by the sun's disc: irradiance times the cosine of incidence
  float diffuse = 0.0f;    ///< Wh/m2, by the part of the sky that it sees
  float reflected = 0.0f;  ///< Wh/m2, by the ground that it faces, or by everything that it sees

  float global() const { return beam + diffuse + reflected; }
};

struct RadiationOptions {
  SkyReceiver receiver = SkyReceiver::surface;
  double max_distance = std::numeric_limits<double>::infinity();  ///< nothing farther blocks; metres
  /// Normal of every receiver, of length 1, with z >= 0, instead of that of `receiver`.
  std::optional<glm::dvec3> normal{};
  double albedo = 0.2;  ///< share of its light that the ground reflects, [0, 1]
  /// 0, or 1: light is reflected by everything that the receivers see (bounced_light.h), with one albedo.
  int bounces = 0;
  /// Every target receives as a small sphere does: a quarter of the light from each direction. For targets
  /// without a surface; does not apply to fans and to `reflected`.
  bool is_sphere = false;
};

/// Radiation of every target, period by period: hours as sun_hours(), of whose bins and fans these are.
///
/// Reflected light is that of an even ground below an open sky: albedo times the global energy of the open
/// horizontal times (1 - z) / 2, with z that of the receiver's normal; things around it neither shade nor
/// brighten it. Source: Liu and Jordan, The Long-Term Average Performance of Flat-Plate Solar-Energy
/// Collectors, 1963; as in r.sun.
///
/// With a bounce reflected light is that of a BouncedLight of these targets instead.
///
/// Requires and costs as sun_hours(). Errors: as sun_hours(); albedo or bounces out of range.
void radiation(const Occluders& occluders, std::span<const SkyTarget> targets, const EnergyLight& light,
               const RadiationOptions& options, std::span<Radiation> answers);

/// The normal of a target as a receiver.
glm::dvec3 receiver_normal(const SkyTarget& target, const RadiationOptions& options);

}  // namespace alidade::visibility
