// SPDX-License-Identifier: MIT
#pragma once

#include <tbb/parallel_for.h>
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

#include "base/progress.h"
#include "octree/tree_walk.h"

namespace alidade {

/// Visits every leaf once, in parallel, some hundred in a row by one `worker = make_worker()`, which is
/// called with one leaf after another in the order of the tree. `progress` is in points, and is called
/// several times a second, however long a leaf takes.
template <class MakeWorker>
void for_each_leaf_in_parallel(const TreeView& tree, const Progress& progress,
                               const MakeWorker& make_worker) {
  using Clock = std::chrono::steady_clock;
  constexpr std::size_t k_leaves_per_task = 1u << 8, k_most_leaves = 1u << 17;
  constexpr std::chrono::milliseconds k_short(100), k_long(400);
  std::size_t leaves_at_once = 4 * k_leaves_per_task;
  std::vector<Leaf> leaves;
  std::uint64_t done = 0;
  report(progress, done, tree.point_count);
  const auto work = [&] {
    const Clock::time_point start = Clock::now();
    const std::size_t tasks = (leaves.size() + k_leaves_per_task - 1) / k_leaves_per_task;
    tbb::parallel_for(std::size_t{0}, tasks, [&](std::size_t task) {
      auto worker = make_worker();
      const std::size_t end = std::min((task + 1) * k_leaves_per_task, leaves.size());
      for (std::size_t i = task * k_leaves_per_task; i < end; ++i) worker(leaves[i]);
    });
    for (const Leaf& leaf : leaves) done += leaf.count;
    leaves.clear();
    const Clock::duration time = Clock::now() - start;
    if (time < k_short) leaves_at_once = std::min(2 * leaves_at_once, k_most_leaves);
    if (time > k_long) leaves_at_once = std::max(leaves_at_once / 2, k_leaves_per_task);
    report(progress, done, tree.point_count);
  };
  for_each_leaf(tree, [&](const Leaf& leaf) {
    leaves.push_back(leaf);
    if (leaves.size() >= leaves_at_once) work();
  });
  if (!leaves.empty()) work();
}

}  // namespace alidade
