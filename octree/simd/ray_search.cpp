// SPDX-License-Identifier: MIT
#include "octree/simd/search.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octree/simd/ray_search.cpp"
#include <hwy/foreach_target.h>

#include "octree/query_targets.h"
#include "octree/simd/choose_table.h"
#include "octree/simd/ray_kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

bool knows_all_points(const RayQuery& query) {
  return !query.filter && query.max_level == k_all_levels;
}

/// A sphere without limits is entered nowhere.
bool admits_none(const RayQuery& query) {
  return std::isinf(query.radius) && query.entry_min > -std::numeric_limits<double>::infinity();
}

template <Measure measure>
void find_first(const TreeView& tree, const Ray& ray, const RayQuery& query, std::size_t k,
                std::size_t query_index, std::vector<Hit>& answers) {
  const RayTarget target(ray, query, query_index);
  const LineFromRoot line(tree, ray);
  const RayKernel<measure> kernel(tree, line, ray, query, static_cast<bool>(query.filter));
  constexpr bool is_place = measure != Measure::distance;
  NearestCollector<RayTarget> nearest(tree, target, k, is_place ? line.shift : 0.0,
                                      is_place ? line.error : 0.0, answers);
  NearestFirst(tree, kernel, nearest, query.max_level, knows_all_points(query) ? k : k_all).run();
  nearest.finish();
}

void find(const TreeView& tree, const Ray& ray, const RayQuery& query, std::size_t k, std::size_t query_index,
          std::vector<Hit>& answers) {
  if (admits_none(query)) return;
  if (k < tree.point_count) {
    if (query.measure == Measure::distance) {
      find_first<Measure::distance>(tree, ray, query, k, query_index, answers);
    } else if (query.measure == Measure::t) {
      find_first<Measure::t>(tree, ray, query, k, query_index, answers);
    } else {
      find_first<Measure::entry>(tree, ray, query, k, query_index, answers);
    }
    return;
  }
  const RayTarget target(ray, query, query_index);
  const LineFromRoot line(tree, ray);
  const RayKernel<Measure::t> kernel(tree, line, ray, query, static_cast<bool>(query.filter));
  AllCollector<RayTarget> all(tree, target, answers);
  NearestFirst(tree, kernel, all, query.max_level, k_all).run();
  all.finish();
}

std::size_t count(const TreeView& tree, const Ray& ray, const RayQuery& query, std::size_t k,
                  std::size_t query_index) {
  if (admits_none(query)) return 0;
  const RayTarget target(ray, query, query_index);
  const LineFromRoot line(tree, ray);
  const RayKernel<Measure::t> kernel(tree, line, ray, query, !knows_all_points(query));
  CountCollector<RayTarget> counter(tree, target, k);
  NearestFirst(tree, kernel, counter, query.max_level, k_all).run();
  return counter.count();
}

constexpr RaySearch k_ray_search{find, count};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alidade::simd {

const RaySearch& ray_search(InstructionSet instruction_set) {
  ALIDADE_CHOOSE_TABLE(instruction_set, k_ray_search)
}

bool suits_lanes(const TreeView& tree, const Ray& ray, const RayQuery& query) {
  if (tree.node_count == 0) return false;
  const glm::dvec3& d = ray.direction;
  const double square = d.x * d.x + d.y * d.y + d.z * d.z;
  double width = 0.0;
  for (int axis = 0; axis < 3; ++axis)
    width = std::max(width, tree.lattice.scale[axis] * power_of_two(tree.root_level));
  const LineFromRoot line(tree, ray);
  return std::fabs(square - 1.0) <= 2e-15 && width < 1e15 && line.away <= 256.0 * width && line.error < 1.0 &&
         (query.radius < 1e15 || std::isinf(query.radius));
}

}  // namespace alidade::simd
#endif  // HWY_ONCE
