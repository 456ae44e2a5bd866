// SPDX-License-Identifier: MIT
#pragma once

#include <tbb/parallel_for.h>

#include <algorithm>
#include <vector>

#include "base/progress.h"
#include "octree/tree_walk.h"

namespace alidade {

/// Visits every leaf once, in parallel, some hundred in a row by one `worker = make_worker()`, which is
/// called with one leaf after another in the order of the tree. `progress` is in points.
template <class MakeWorker>
void for_each_leaf_in_parallel(const TreeView& tree, const Progress& progress,
                               const MakeWorker& make_worker) {
  constexpr std::size_t k_leaves_at_once = 1u << 15, k_leaves_per_task = 1u << 8;
  std::vector<Leaf> leaves;
  std::uint64_t done = 0;
  report(progress, done, tree.point_count);
  const auto work = [&] {
    const std::size_t tasks = (leaves.size() + k_leaves_per_task - 1) / k_leaves_per_task;
    tbb::parallel_for(std::size_t{0}, tasks, [&](std::size_t task) {
      auto worker = make_worker();
      const std::size_t end = std::min((task + 1) * k_leaves_per_task, leaves.size());
      for (std::size_t i = task * k_leaves_per_task; i < end; ++i) worker(leaves[i]);
    });
    for (const Leaf& leaf : leaves) done += leaf.count;
    leaves.clear();
    report(progress, done, tree.point_count);
  };
  for_each_leaf(tree, [&](const Leaf& leaf) {
    leaves.push_back(leaf);
    if (leaves.size() == k_leaves_at_once) work();
  });
  if (!leaves.empty()) work();
}

}  // namespace alidade
