// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "octree/octree.h"
#include "octree/query.h"
#include "octree/tree_query.h"

namespace alidade {

class CopcTiles;

/// `find` and `count` of octree/query.h by Algorithm 1 (octree/tree_query.h), over an Octree or CopcTiles.
/// The answers are those of the octree of the whole cloud, bit for bit. Adds the work to `work`. Remote files
/// of CopcTiles that targets meet are opened ahead, many at once, and their points read, too, if all points
/// that a target meets are needed: one request after another would mostly wait for servers. Requires: a query
/// without errors. Errors: those of targets; of reading files.
template <TargetGeometry T, class Index>
struct ExplainedQuery {
  /// No more than the `most` first answers of each target.
  static Answers<AnswerOf<T>> find(const Index& index, std::span<const T> targets, const QueryOf<T>& query,
                                   std::size_t most, QueryStatistics& work);
  static void count(const Index& index, std::span<const T> targets, const QueryOf<T>& query,
                    std::span<std::size_t> counts, QueryStatistics& work);
};

}  // namespace alidade
