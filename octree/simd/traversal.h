// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "octree/octree.h"
#include "octree/query.h"
#include "octree/simd/instruction_set.h"

namespace alidade::simd {

/// Ray queries on a tree, compiled for one instruction set. Lanes only discard, and only what double
/// arithmetic would discard too; what remains is decided by octree/candidate.h. So all sets give the same
/// bits. Requires: a checked query.
struct Traversal {
  std::optional<Hit> (*closest)(const TreeView& tree, const Ray& ray, const RayQuery& query);
  bool (*occluded)(const TreeView& tree, const Ray& ray, const RayQuery& query);
};

/// The traversal for an available instruction set (not `best`).
const Traversal& traversal(InstructionSet instruction_set);

}  // namespace alidade::simd
