// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>

#include "base/bounds.h"

namespace alidade {

/// A point as the cloud stores it: three 32-bit steps on the lattice.
using LatticePosition = glm::ivec3;

/// The grid of all points of a cloud, exactly as in LAS: world = offset + scale * steps.
/// `scale` is positive on every axis, in the unit of the CRS (metres unless the file states another).
struct Lattice {
  glm::dvec3 scale{0.001};
  glm::dvec3 offset{0.0};

  bool operator==(const Lattice&) const = default;
};

/// Lattice steps -> world. The only code that computes this: every part of Alidade (brute force, index,
/// writers) has the same double for the same point. Two roundings per axis, never fused.
inline glm::dvec3 to_world(const Lattice& lattice, const LatticePosition& position) {
  return {lattice.offset.x + lattice.scale.x * position.x, lattice.offset.y + lattice.scale.y * position.y,
          lattice.offset.z + lattice.scale.z * position.z};
}

/// World -> nearest lattice steps; empty if a coordinate is not finite or does not fit into 32 bits.
inline std::optional<LatticePosition> to_lattice(const Lattice& lattice, const glm::dvec3& world) {
  LatticePosition position;
  for (int axis = 0; axis < 3; ++axis) {
    const double steps = std::nearbyint((world[axis] - lattice.offset[axis]) / lattice.scale[axis]);
    if (!(steps >= -2147483648.0 && steps <= 2147483647.0)) return std::nullopt;
    position[axis] = static_cast<std::int32_t>(steps);
  }
  return position;
}

/// The fewest decimals that write every coordinate of an axis to a thousandth of a step; empty if 15 do not.
std::optional<int> decimals_of(const Lattice& lattice, int axis);

/// decimals_of() for messages: if that is more than 12, as for survey feet in metres, the decimals that round
/// to a thousandth of a step; empty if that takes more than 15.
std::optional<int> shown_decimals(const Lattice& lattice, int axis);

/// Lowest and highest lattice position of points on each axis; low is above high without points.
struct LatticeExtent {
  LatticePosition low{2147483647}, high{-2147483647 - 1};

  void grow(const LatticePosition& p) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  }
  void grow(const LatticeExtent& other) {
    grow(other.low);
    grow(other.high);
  }
};

/// The result of the first pass over a file without a lattice, from which a lattice is chosen.
struct CoordinateSurvey {
  Bounds bounds;  ///< of the finite points, world coordinates
  std::uint64_t finite_count = 0;
  std::uint64_t dropped_count = 0;  ///< points with a NaN or infinite coordinate
  /// The rounding of the file's own numbers, per axis: half an ulp of the largest float32, half of the last
  /// written digit for text (of the number with the most decimals), 0.5 for integers, 0 for float64 in
  /// binary. Per axis, because float32 northings are rounded to decimetres while heights beside them keep
  /// micrometres.
  glm::dvec3 resolution{0.0};
};

/// A lattice for points of free coordinates. Scales are powers of ten, offsets are whole numbers. Rounding to
/// the lattice stays within the files' own resolution if 32 bits suffice; otherwise, and for resolution 0,
/// the scale is the finest power of ten that 32 bits hold. All axes share one scale if possible. Errors:
/// coordinates beyond 1e300.
Lattice fit_lattice(std::span<const CoordinateSurvey> surveys);

/// Converts positions on one lattice to the same positions on another: factor * position + shift.
struct LatticeSteps {
  glm::i64vec3 factor{1}, shift{0};

  bool operator==(const LatticeSteps&) const = default;
};

/// The conversion from one lattice to another; empty if some positions of `from` are not on `to`. They are
/// if, on every axis, the step of `from` and the difference of the offsets are whole numbers of steps of
/// `to`, up to 1e-5 steps over all of 32 bits. A difference of offsets may also be off by twice the distance
/// from the larger offset to the next double, since offsets have no higher resolution. So all offsets agree
/// if the scale is finer than that distance; world coordinates do not resolve such a scale either.
std::optional<LatticeSteps> steps_between(const Lattice& from, const Lattice& to);

/// A lattice for the points of several lattices, within `bounds`. It has the offset of the first one. On
/// every axis it has the first of these scales that holds all positions exactly: that of the first lattice;
/// the finest scale of all, or a half, a fifth or a tenth of it, if 32 bits reach over `bounds`. Otherwise it
/// has the finest scale, or 10, 100, ... times that, so that 32 bits reach over `bounds`, and positions are
/// rounded. Requires at least one lattice.
Lattice joined_lattice(std::span<const Lattice> lattices, const Bounds& bounds);

/// Converts positions of a file from its lattice to that of the joined cloud: exactly if steps_between() is
/// not empty, else to the nearest position.
class LatticeShift {
 public:
  LatticeShift(const Lattice& from, const Lattice& to, std::string file);

  /// Errors: 32 bits do not hold the new position.
  LatticePosition operator()(const LatticePosition& position) const {
    if (!steps_) return nearest(position);
    const glm::i64vec3 steps = steps_->factor * glm::i64vec3(position) + steps_->shift;
    const LatticePosition shifted(steps);
    if (glm::i64vec3(shifted) != steps) reject(glm::dvec3(steps));
    return shifted;
  }

  /// Whether positions stay unchanged.
  bool is_none() const { return steps_ == LatticeSteps(); }

 private:
  LatticePosition nearest(const LatticePosition& position) const;
  [[noreturn]] void reject(const glm::dvec3& steps) const;

  std::string file_;
  Lattice from_, to_;
  std::optional<LatticeSteps> steps_;
};

}  // namespace alidade
