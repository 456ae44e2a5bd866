// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "octree/copc_tree.h"
#include "tools/query/tree_asker.h"

namespace alidade {

/// Asks a COPC file where it lies, as Asker asks an octree: by Algorithm 1 over the file's own hierarchy. Has
/// the same functions, and the same answers.
template <class Target>
class CopcAsker {
 public:
  using Query = typename Family<Target>::Query;
  using Answer = typename Family<Target>::Answer;

  /// The cache must outlive this object.
  CopcAsker(const CopcCache& cache, Query query) : tree_(cache), query_(std::move(query)) {}

  std::size_t k() const { return query_.k; }

  Answers<Answer> find(std::span<const Target> targets, std::size_t most) {
    Query query = query_;
    query.k = std::min(query.k, most);
    return asker_.find(tree_, targets, query);
  }

  std::vector<std::size_t> count(std::span<const Target> targets, bool any_is_enough) {
    Query query = query_;
    if (any_is_enough) query.k = 1;
    return asker_.count(tree_, targets, query);
  }

  QueryStatistics statistics() const { return asker_.statistics(); }

 private:
  CopcTree tree_;
  Query query_;
  TreeAsker<Target> asker_;
};

}  // namespace alidade
