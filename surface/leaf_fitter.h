// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>

#include "octree/octree.h"
#include "octree/tree_walk.h"
#include "surface/surface_cloud.h"

namespace alidade {

/// Fits the surfaces of leaves when they are first needed. Safe to use from many threads: whatever touches a
/// leaf first, its surfaces are the same.
class LeafFitter {
 public:
  /// SurfaceView::stored_edges of the first point of a leaf that is not fitted. No edge has this value.
  static constexpr std::uint8_t k_untouched = 1;

  virtual ~LeafFitter() = default;

  /// To be called before surfaces and edges of the leaf's points are read. Cost: a microsecond per point the
  /// first time, far more of a leaf with a stray point, whose neighbours are far away; other threads that
  /// touch the leaf meanwhile wait.
  void touch(const Leaf& leaf) const {
    if (std::atomic_ref(stored_edges_[leaf.first]).load(std::memory_order_acquire) == k_untouched) fit(leaf);
  }
  /// All leaves, in parallel. `progress` is in points.
  void touch_all(const Progress& progress = {}) const {
    if (all_touched_.load(std::memory_order_acquire)) return;
    for_each_leaf_in_parallel(tree_, progress, [this] { return [this](const Leaf& leaf) { touch(leaf); }; });
    all_touched_.store(true, std::memory_order_release);
  }

 protected:
  LeafFitter(const TreeView& tree, std::uint8_t* stored_edges) : tree_(tree), stored_edges_(stored_edges) {}

 private:
  virtual void fit(const Leaf& leaf) const = 0;

  const TreeView tree_;
  std::uint8_t* const stored_edges_;
  mutable std::atomic<bool> all_touched_ = false;
};

/// Before surfaces of a leaf's points are read.
inline void touch(const SurfaceView& view, const Leaf& leaf) {
  if (view.fitter != nullptr) view.fitter->touch(leaf);
}

}  // namespace alidade
