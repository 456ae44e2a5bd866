// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>

#include "base/huge_memory.h"
#include "octree/building/sort_entry.h"
#include "octree/octree.h"

namespace alidade {

/// Box in lattice steps from the root's corner, inclusive; inverted when empty.
struct StepBox {
  Steps low{0xffffffffu, 0xffffffffu, 0xffffffffu};
  Steps high{0, 0, 0};

  void grow(const Steps& steps) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], steps[axis]);
      high[axis] = std::max(high[axis], steps[axis]);
    }
  }
  void grow(const StepBox& box) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], box.low[axis]);
      high[axis] = std::max(high[axis], box.high[axis]);
    }
  }
};

inline LatticePosition lattice_position(const LatticePosition& base, const Steps& steps) {
  LatticePosition position;
  for (int axis = 0; axis < 3; ++axis)
    position[axis] = static_cast<std::int32_t>(static_cast<std::uint32_t>(base[axis]) + steps[axis]);
  return position;
}

/// The arrays of an octree.
struct OctreeArrays {
  HugeArray<Node> nodes;
  HugeArray<std::uint16_t> coordinates;
  HugeArray<std::uint32_t> ids;
  /// By place, as long as the cloud, but only the pages of places from TreeView::first_exact on are ever
  /// touched.
  HugeArray<LatticePosition> positions;
};

/// Packs points into the arrays; from many threads, for different places.
class LeafWriter {
 public:
  LeafWriter(OctreeArrays& arrays, const LatticePosition& base) : arrays_(arrays), base_(base) {}

  /// Writes the points of a leaf below a frame, whose places start at `place`. Their box.
  template <class Entry>
  StepBox write(const Entry* entries, std::uint32_t count, const Steps& corner, int frame_level,
                std::uint32_t place) const {
    StepBox box;
    const int shift = coordinate_shift(frame_level);
    std::uint16_t* const coordinates = arrays_.coordinates.data() + std::size_t{3} * place;
    for (std::uint32_t i = 0; i < count; ++i) {
      const Steps steps = steps_of(entries[i]);
      for (int axis = 0; axis < 3; ++axis)
        coordinates[axis * count + i] = static_cast<std::uint16_t>((steps[axis] - corner[axis]) >> shift);
      arrays_.ids[place + i] = entries[i].id;
      if (shift > 0) arrays_.positions[place + i] = lattice_position(base_, steps);
      box.grow(steps);
    }
    return box;
  }

 private:
  OctreeArrays& arrays_;
  const LatticePosition base_;
};

}  // namespace alidade
