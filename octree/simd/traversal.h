// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "base/instruction_set.h"
#include "octree/octree.h"
#include "octree/query.h"

namespace alidade::simd {

/// Ray queries on a tree, compiled for one instruction set. Lanes only discard, and only what double
/// arithmetic would discard too; what remains is decided by octree/candidate.h or surface/decide_point.h. So
/// all sets give the same bits. View: TreeView, or what has one and more of its points. Requires: a checked
/// query that is not by distance, checked rays with directions of length 1 but for rounding, a tree that is
/// not empty, no length beyond 1e15.
template <class View, class Query, class Answer>
struct RayTraversal {
  std::optional<Answer> (*closest)(const View& view, const Ray& ray, const Query& query,
                                   std::size_t query_index);
  bool (*occluded)(const View& view, const Ray& ray, const Query& query, std::size_t query_index);
  /// Many rays on one thread, through the tree together: the faster the more of the tree they share.
  /// first_index: query_index of rays[0].
  void (*closest_stream)(const View& view, std::span<const Ray> rays, const Query& query,
                         std::size_t first_index, std::span<std::optional<Answer>> hits);
  void (*occluded_stream)(const View& view, std::span<const Ray> rays, const Query& query,
                          std::size_t first_index, std::span<std::uint8_t> answers);
};

using Traversal = RayTraversal<TreeView, RayQuery, Hit>;

/// The traversal for an available instruction set (not `best`).
const Traversal& traversal(InstructionSet instruction_set);

}  // namespace alidade::simd
