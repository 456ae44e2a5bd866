// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_RAY_INTERLEAVE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_RAY_INTERLEAVE_INL_H
#undef ALIDADE_SIMD_RAY_INTERLEAVE_INL_H
#else
#define ALIDADE_SIMD_RAY_INTERLEAVE_INL_H
#endif

#include <memory>
#include <new>
#include <span>

#include "octree/simd/ray_traversal-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// Many rays, a few of them under way at a time by turns: while one does its step, the memory that the others
/// need next is on its way to the processor. For rays that have little of the tree in common.
/// rays: numbers in the batch.
template <Measure measure, bool any, Radii radii>
void trace_interleaved(const Traversed<measure, any, radii>& traversed, const RayBatch& batch,
                       std::span<const std::uint32_t> rays) {
  using Walk = RayWalk<measure, any, radii>;
  constexpr std::size_t k_under_way = 12;
  struct Turn {
    alignas(Walk) std::byte walk[sizeof(Walk)];
    bool has_leaves = false;
  };
  const auto turns = std::make_unique_for_overwrite<Turn[]>(k_under_way);
  const auto walk_of = [](Turn& turn) { return std::launder(reinterpret_cast<Walk*>(turn.walk)); };
  const Visit root = root_visit(traversed.setup.tree);
  std::size_t next = 0, active = 0;
  const auto start = [&](Turn& turn) {
    new (turn.walk) Walk(traversed, batch[rays[next++]], root);
    turn.has_leaves = false;
  };
  while (active < k_under_way && next < rays.size()) start(turns[active++]);
  while (active > 0) {
    for (std::size_t i = 0; i < active;) {
      Turn& turn = turns[i];
      Walk& walk = *walk_of(turn);
      if (!turn.has_leaves && walk.look(traversed)) {
        walk.prefetch_leaves(traversed);
        turn.has_leaves = true;
        ++i;
        continue;
      }
      if (turn.has_leaves) walk.test_leaves(traversed);
      turn.has_leaves = false;
      if (walk.go_on(traversed)) {
        walk.prefetch_node(traversed);
        ++i;
      } else if (next < rays.size()) {
        start(turn);
        ++i;
      } else {
        --active;
        if (i != active) turn = turns[active];
      }
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
