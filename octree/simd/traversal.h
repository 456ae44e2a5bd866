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
/// arithmetic would discard too; what remains is decided by octree/candidate.h. So all sets give the same
/// bits. Requires: a checked query of measure t, entry or crossing, checked rays with directions of length 1
/// but for rounding, a tree that is not empty, no length beyond 1e15.
struct Traversal {
  std::optional<Hit> (*closest)(const TreeView& tree, const Ray& ray, const RayQuery& query,
                                std::size_t query_index);
  bool (*occluded)(const TreeView& tree, const Ray& ray, const RayQuery& query, std::size_t query_index);
  /// Many rays on one thread, through the tree together: the faster the more of the tree they share.
  /// first_index: query_index of rays[0].
  void (*closest_stream)(const TreeView& tree, std::span<const Ray> rays, const RayQuery& query,
                         std::size_t first_index, std::span<std::optional<Hit>> hits);
  void (*occluded_stream)(const TreeView& tree, std::span<const Ray> rays, const RayQuery& query,
                          std::size_t first_index, std::span<std::uint8_t> answers);
};

/// The traversal for an available instruction set (not `best`).
const Traversal& traversal(InstructionSet instruction_set);

}  // namespace alidade::simd
