// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <string>
#include <utility>

#include "base/error.h"
#include "cloud/fit_lattice.h"

namespace alidade {

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
