// SPDX-License-Identifier: MIT
#include "octree/simd/traversal.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octree/simd/traversal.cpp"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

#include "octree/simd/choose_table.h"
#include "octree/simd/shared_radius-inl.h"
#include "octree/simd/tracer-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

struct OctreeTracers {
  template <bool any, class Use>
  static auto call(const TreeView& tree, const RayQuery& query, std::span<const Ray> rays,
                   std::size_t first_index, const Use& use) {
    using ByT = SharedRadius<Measure::t>;
    using ByEntry = SharedRadius<Measure::entry>;
    if constexpr (!any) {
      if (query.measure == Measure::entry)
        return use(Tracer<ByEntry, any>(tree, ByEntry(tree, query), rays, first_index));
    }
    return use(Tracer<ByT, any>(tree, ByT(tree, query), rays, first_index));
  }
};

constexpr Traversal k_traversal = TraversalBy<TreeView, RayQuery, Hit, OctreeTracers>::k_table;

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alidade::simd {

const Traversal& traversal(InstructionSet instruction_set) {
  ALIDADE_CHOOSE_TABLE(instruction_set, k_traversal)
}

}  // namespace alidade::simd
#endif  // HWY_ONCE
