// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "base/instruction_set.h"
#include "octree/octree.h"
#include "octree/query.h"

namespace alidade::simd {

/// Ray queries that `Traversal` does not answer, by any measure and with any conditions, compiled for one
/// instruction set. Lanes only discard what double arithmetic would discard too; what remains is decided by
/// octree/candidate.h. So all sets give the same bits. Requires: checked query and ray; a tree and a ray that
/// suit lanes.
struct RaySearch {
  /// Appends the k first points in order.
  void (*find)(const TreeView& tree, const Ray& ray, const RayQuery& query, std::size_t k,
               std::size_t query_index, std::vector<Hit>& answers);
  std::size_t (*count)(const TreeView& tree, const Ray& ray, const RayQuery& query, std::size_t k,
                       std::size_t query_index);
};

/// The search for an available instruction set (not `best`).
const RaySearch& ray_search(InstructionSet instruction_set);

/// Whether floats can tell the points of the tree apart along there: not an empty tree, a direction of length
/// 1 but for rounding, no lengths beyond what floats can square, and no line so far away that all points are
/// equally near.
bool suits_lanes(const TreeView& tree, const Ray& ray, const RayQuery& query);

}  // namespace alidade::simd
