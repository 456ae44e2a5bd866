// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <type_traits>

#include "octree/octree_tree.h"
#include "octree/query_targets.h"

namespace alidade {

/// Calls use(tree, target) with an octree and a target as Algorithm 1 (octree/tree_query.h) takes them for
/// this query. Points with radii of their own are told by their places.
template <class Target, class Query, class Use>
auto with_tree_target(const TreeView& view, const Target& target, const Query& query, std::size_t query_index,
                      const Use& use) {
  if constexpr (std::is_same_v<Target, Ray>) {
    if (query.spacing_factor > 0.0)
      return use(OctreePlaces(view, query.max_level), OwnRadiusTarget(view, target, query, query_index));
  }
  return use(OctreeTree(view, query.max_level), make_target(target, query, query_index));
}

}  // namespace alidade
