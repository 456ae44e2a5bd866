// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "base/instruction_set.h"
#include "octree/octree.h"
#include "octree/query.h"

namespace alidade::simd {

/// Queries by the distance to a point, compiled for one instruction set. Lanes only discard what double
/// arithmetic would discard too; what remains is decided by octree/candidate.h. So all sets give the same
/// bits. Requires: checked query and point; a tree and a point that suit lanes.
struct PointSearch {
  /// Appends the k first points in order.
  void (*find)(const TreeView& tree, const glm::dvec3& point, const PointQuery& query, std::size_t k,
               std::size_t query_index, std::vector<PointHit>& answers);
  std::size_t (*count)(const TreeView& tree, const glm::dvec3& point, const PointQuery& query, std::size_t k,
                       std::size_t query_index);
};

/// The search for an available instruction set (not `best`).
const PointSearch& point_search(InstructionSet instruction_set);

/// Whether floats can tell the points of the tree apart from there: not an empty tree, not one of lengths
/// beyond what floats can square, and no place so far away that all points are equally near.
bool suits_lanes(const TreeView& tree, const glm::dvec3& point, const PointQuery& query);

}  // namespace alidade::simd
