// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "visibility/sight_line.h"

namespace alidade {

/// Lines that are made of straight chords, one after another, which may overlap.
struct ChordLines {
  std::span<const SightLine> chords;
  std::span<const double> starts;      ///< metres from the start of its line to that of each chord
  std::span<const std::size_t> begin;  ///< first chord of each line, and the end
};

/// What blocks such lines, as sight_line.h has it for straight ones. Crossings are counted over all chords of
/// a line, those of one point with two chords as one. Blocker::distance is from the line's start. Cost: that
/// of the chords; with a transparency above 1 all that blocks a line is found, with 70 B for each point while
/// some thousand chords are asked. Errors: not as many answers as lines.
void first_blockers(const Occluders& occluders, const ChordLines& lines,
                    std::span<std::optional<Blocker>> blockers);

}  // namespace alidade
