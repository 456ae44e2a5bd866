// SPDX-License-Identifier: MIT
#pragma once

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <vector>

#include "base/progress.h"
#include "octree/tree_walk.h"

namespace alidade {

/// body(0) .. body(count - 1) in parallel, begun in this order: whoever is free takes the next. For work that
/// uses up memory along the way, of which only a few positions at a time should be in use.
template <class Body>
void for_each_in_order(std::size_t count, const Body& body) {
  std::atomic<std::size_t> next = 0;
  tbb::parallel_for(0, tbb::this_task_arena::max_concurrency(), [&](int) {
    for (std::size_t i = next++; i < count; i = next++) body(i);
  });
}

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
