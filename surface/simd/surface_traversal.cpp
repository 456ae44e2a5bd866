// SPDX-License-Identifier: MIT
#include "surface/simd/surface_traversal.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "surface/simd/surface_traversal.cpp"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

#include "octree/simd/choose_table.h"
#include "octree/simd/tracer-inl.h"
#include "surface/simd/disc_packet_test-inl.h"
#include "surface/simd/own_points-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

struct SurfaceTracers {
  template <bool any, class Use>
  static auto call(const SurfaceView& view, const SurfaceQuery& query, std::span<const Ray> rays,
                   std::size_t first_index, const Use& use) {
    const auto use_points = [&]<class Points>(const Points& points) {
      return use(Tracer<Points, any>(view.tree, points, rays, first_index));
    };
    if (query.discs) return use_points(Discs(view, query));
    if constexpr (!any) {
      if (query.measure == Measure::entry) return use_points(OwnRadius<Measure::entry>(view, query));
    }
    return use_points(OwnRadius<Measure::t>(view, query));
  }
};

constexpr SurfaceTraversal k_surface_traversal =
    TraversalBy<SurfaceView, SurfaceQuery, SurfaceHit, SurfaceTracers>::k_table;

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alidade::simd {

const SurfaceTraversal& surface_traversal(InstructionSet instruction_set) {
  ALIDADE_CHOOSE_TABLE(instruction_set, k_surface_traversal)
}

}  // namespace alidade::simd
#endif  // HWY_ONCE
