// SPDX-License-Identifier: MIT
#include "octree/simd/search.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octree/simd/point_search.cpp"
#include <hwy/foreach_target.h>

#include "octree/query_targets.h"
#include "octree/simd/choose_table.h"
#include "octree/simd/point_kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

void find(const TreeView& tree, const glm::dvec3& point, const PointQuery& query, std::size_t k,
          std::size_t query_index, std::vector<PointHit>& answers) {
  const PointTarget target(point, query, query_index);
  const PointKernel kernel(tree, point, query.radius, static_cast<bool>(query.filter));
  if (k >= tree.point_count) {
    AllCollector<PointTarget> all(tree, target, answers);
    NearestFirst(tree, kernel, all, query.max_level, k_all).run();
    all.finish();
  } else {
    NearestCollector<PointTarget> nearest(tree, target, k, 0.0, 0.0, answers);
    const bool knows_all_points = !query.filter && query.max_level == k_all_levels;
    NearestFirst(tree, kernel, nearest, query.max_level, knows_all_points ? k : k_all).run();
    nearest.finish();
  }
}

std::size_t count(const TreeView& tree, const glm::dvec3& point, const PointQuery& query, std::size_t k,
                  std::size_t query_index) {
  const PointTarget target(point, query, query_index);
  const bool knows_all_points = !query.filter && query.max_level == k_all_levels;
  const PointKernel kernel(tree, point, query.radius, !knows_all_points);
  CountCollector<PointTarget> counter(tree, target, k);
  NearestFirst(tree, kernel, counter, query.max_level, k_all).run();
  return counter.count();
}

constexpr PointSearch k_point_search{find, count};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alidade::simd {

const PointSearch& point_search(InstructionSet instruction_set) {
  ALIDADE_CHOOSE_TABLE(instruction_set, k_point_search)
}

bool suits_lanes(const TreeView& tree, const glm::dvec3& point, const PointQuery& query) {
  if (tree.node_count == 0) return false;
  double width = 0.0, away = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    width = std::max(width, tree.lattice.scale[axis] * power_of_two(tree.root_level));
    away = std::max({away, tree.bounds.min[axis] - point[axis], point[axis] - tree.bounds.max[axis]});
  }
  return width < 1e15 && away <= 64.0 * width && (query.radius < 1e15 || std::isinf(query.radius));
}

}  // namespace alidade::simd
#endif  // HWY_ONCE
