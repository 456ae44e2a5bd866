// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "base/instruction_set.h"
#include "octree/octree.h"
#include "octree/query.h"

namespace alidade::simd {

/// Box queries, compiled for one instruction set. World coordinates grow with lattice steps, so a box in the
/// world is a box of lattice steps, and no test needs a number that is not whole: nodes are compared byte by
/// byte, points 16 bits at a time, and what stands wholly inside is not compared at all. Requires: checked
/// query and box, a tree that is not empty.
struct BoxSearch {
  /// Appends the k first points in order, by their ids.
  void (*find)(const TreeView& tree, const Bounds& box, const PointQuery& query, std::size_t k,
               std::size_t query_index, std::vector<PointHit>& answers);
  std::size_t (*count)(const TreeView& tree, const Bounds& box, const PointQuery& query, std::size_t k,
                       std::size_t query_index);
};

/// The search for an available instruction set (not `best`).
const BoxSearch& box_search(InstructionSet instruction_set);

/// Any box.
inline bool suits_lanes(const TreeView& tree, const Bounds&, const PointQuery&) {
  return tree.node_count != 0;
}

}  // namespace alidade::simd
