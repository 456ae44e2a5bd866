// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "base/error.h"
#include "cloud/cloud_reader.h"
#include "cloud/lattice.h"

namespace alidade {

/// A lattice for points of free coordinates. Scales are powers of ten, whole numbers are the offset. Rounding
/// to the lattice stays within the files' own resolution wherever 32 bits reach that far; otherwise, and for
/// resolution 0, the scale is the finest power of ten that 32 bits hold. All axes share one scale if they
/// can. Errors: coordinates beyond 1e300.
Lattice fit_lattice(std::span<const CoordinateSurvey> surveys);

/// How many steps to add to positions on `from` so that they stand on `to`; empty if the lattices differ in
/// scale or by a fraction of a step. A fraction up to 1e-5 steps, or up to twice the distance from the larger
/// offset to the next double, is none: more than that the offsets cannot say. Where the scale is finer than
/// such doubles, all offsets agree, and world coordinates are no finer either.
std::optional<glm::i64vec3> steps_between(const Lattice& from, const Lattice& to);

/// Brings positions of a file from its lattice onto that of the cloud it is joined to.
class LatticeShift {
 public:
  /// Errors: steps_between() finds no way.
  LatticeShift(const Lattice& from, const Lattice& to, std::string file) : file_(std::move(file)) {
    const std::optional<glm::i64vec3> steps = steps_between(from, to);
    if (!steps) throw Error({.file = file_, .problem = "does not share the lattice of the files before it"});
    steps_ = *steps;
  }

  /// Errors: 32 bits do not hold the new position.
  LatticePosition operator()(const LatticePosition& position) const {
    const glm::i64vec3 steps = glm::i64vec3(position) + steps_;
    const LatticePosition shifted(steps);
    if (glm::i64vec3(shifted) != steps) {
      throw Error({.file = file_,
                   .problem = "lies too far from the first file to share its lattice of 32-bit steps",
                   .found = fmt::format("step {}, {}, {}", steps.x, steps.y, steps.z)});
    }
    return shifted;
  }

 private:
  std::string file_;
  glm::i64vec3 steps_{0};
};

}  // namespace alidade
