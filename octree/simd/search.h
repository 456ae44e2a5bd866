// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/instruction_set.h"
#include "octree/octree.h"
#include "octree/query.h"

namespace alidade::simd {

/// More neighbours take so long to choose that sharing the way to them gains little.
constexpr std::size_t k_most_in_turn = 64;

/// No spacing has these bits.
constexpr std::uint16_t k_unknown_spacing = 0xffff;

/// Queries of one family, by any measure and with any conditions, compiled for one instruction set: of rays
/// those that Traversal (octree/simd/traversal.h) does not answer, of points, and of boxes. Lanes only
/// discard what double arithmetic would discard too; what remains is decided by octree/candidate.h. So all
/// sets give the same bits. World coordinates grow with lattice steps, so a box in the world is a box of
/// lattice steps, and no test needs a number that is not whole: nodes are compared byte by byte, points 16
/// bits at a time, and what is wholly inside is not compared at all. Requires: checked query and target; a
/// tree and a target that suit lanes.
template <TargetGeometry T>
struct Search {
  /// Appends the k first points in order.
  void (*find)(const TreeView& tree, const T& target, const QueryOf<T>& query, std::size_t k,
               std::size_t query_index, std::vector<AnswerOf<T>>& answers);
  std::size_t (*count)(const TreeView& tree, const T& target, const QueryOf<T>& query, std::size_t k,
                       std::size_t query_index);
  /// Of points, null for other targets: appends the k first points of one target after another, and where
  /// those of each end. Fast where each target is near the one before. reach: the distance of the k-th point
  /// of targets near the first one, 0 if unknown; becomes that of the last ones. Requires: no filter.
  void (*find_in_turn)(const TreeView& tree, std::span<const T> targets, const QueryOf<T>& query,
                       std::size_t k, double& reach, std::vector<AnswerOf<T>>& answers,
                       std::vector<std::size_t>& ends) = nullptr;
  /// Of points: for one target after another, each of which is the position of a point, its spacing to the
  /// n-th neighbour as it is stored (octree/spacing.h), or k_unknown_spacing where floats do not settle it.
  void (*spacings_in_turn)(const TreeView& tree, std::span<const T> targets, std::size_t n, double& reach,
                           std::uint16_t* spacings) = nullptr;
};

/// The search for an available instruction set (not `best`).
template <TargetGeometry T>
const Search<T>& search(InstructionSet instruction_set);
template <>
const Search<Ray>& search<Ray>(InstructionSet instruction_set);
template <>
const Search<glm::dvec3>& search<glm::dvec3>(InstructionSet instruction_set);
template <>
const Search<Bounds>& search<Bounds>(InstructionSet instruction_set);

// suits_lanes(): whether floats can distinguish the points of the tree; never those of an empty one.

/// Along there: a direction of length 1 but for rounding, no lengths beyond what floats can square, no line
/// so far away that all points are equally near.
bool suits_lanes(const TreeView& tree, const Ray& ray, const RayQuery& query);
/// From there: no lengths beyond what floats can square, no point so far away that all points are equally
/// near.
bool suits_lanes(const TreeView& tree, const glm::dvec3& point, const PointQuery& query);
/// Any box.
inline bool suits_lanes(const TreeView& tree, const Bounds&, const PointQuery&) {
  return tree.node_count != 0;
}

}  // namespace alidade::simd
