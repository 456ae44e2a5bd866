// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <span>

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

}  // namespace alidade
