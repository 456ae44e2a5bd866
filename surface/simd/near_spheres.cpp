// SPDX-License-Identifier: MIT
#include "surface/surface_cloud.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "surface/simd/near_spheres.cpp"
#include <hwy/foreach_target.h>

#include "octree/answer_target.h"
#include "octree/simd/box_walk-inl.h"
#include "octree/simd/choose_table.h"
#include "octree/simd/local_point-inl.h"
#include "surface/leaf_fitter.h"
#include "surface/simd/own_points-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// The walk to the spheres that come near a position.
class NearSpheres {
 public:
  NearSpheres(const SurfaceView& view, const glm::dvec3& position, double reach, const SurfaceQuery& query,
              std::vector<PointSphere>& spheres)
      : view_(view),
        tree_(view.tree),
        position_(position),
        reach_(reach),
        reach_above_(float_above(reach)),
        query_(query),
        local_(view.tree, position),
        radii_(view, query),
        spheres_(spheres) {}

  void run() {
    Frame waiting[k_max_tree_depth * k_node_width];
    std::size_t count = 0;
    waiting[count++] = root_frame(tree_);
    while (count > 0) {
      const Frame frame = waiting[--count];
      const Node& node = tree_.nodes[frame.node];
      const Slots slots(node);
      const auto local = local_.at(frame.corner, frame.level);
      const unsigned near = near_slots(node, frame, local);
      for (unsigned leaves = near & slots.leaf; leaves != 0; leaves &= leaves - 1)
        visit_leaf(slots.leaf_in(node, frame, std::countr_zero(leaves)), frame.level, local);
      for (unsigned inner = near & slots.inner; inner != 0;) {
        const int last = std::bit_width(inner) - 1;
        inner &= ~(1u << last);
        waiting[count++] = slots.child_in(node, frame, last);
      }
    }
  }

 private:
  HWY_INLINE unsigned near_slots(const Node& node, const Frame& frame, const LocalPoint::Local& local) const {
    const ChildLanes d;
    const auto grid_step = static_cast<float>(power_of_two(frame.level - k_min_frame_level));
    const auto reach = hn::Set(d, reach_above_);
    unsigned near = 0;
    for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
      auto distance_sq = hn::Zero(d);
      for (int axis = 0; axis < 3; ++axis) {
        const auto [to_low, from_high] = gaps_of(local, local_.scale(), grid_step, node, axis, lane);
        const auto gap = hn::Max(hn::Max(to_low, from_high), hn::Zero(d));
        distance_sq = hn::MulAdd(gap, gap, distance_sq);
      }
      const auto radius = hn::Add(radii_.below_slots(d, frame.node, lane), reach);
      const auto limit_sq = hn::Mul(hn::Mul(radius, radius), hn::Set(d, k_up));
      near |= mask_bits(d, hn::Le(distance_sq, limit_sq)) << lane;
    }
    return near;
  }

  HWY_INLINE void visit_leaf(const Leaf& leaf, int level, const LocalPoint::Local& local) {
    const PointLanes d;
    const auto error = hn::Set(d, local.error + LeafCoordinates::lost(level, local_.widest_scale()));
    const auto reach = hn::Set(d, reach_above_);
    const LeafCoordinates coordinates(tree_, leaf, level, local_.scale(), local.point);
    std::uint32_t possible = 0;
    for (int first = 0; first < coordinates.count; first += static_cast<int>(hn::Lanes(d))) {
      const auto x = coordinates(0, first), y = coordinates(1, first), z = coordinates(2, first);
      const auto distance_sq = hn::MulAdd(z, z, hn::MulAdd(y, y, hn::Mul(x, x)));
      const auto radius = hn::Add(radii_.of_points(d, leaf.first + static_cast<std::uint32_t>(first)), reach);
      possible |= coordinates.in_leaf(hn::Le(distance_sq, SquaredRadius::outer(d, radius, error)), first)
                  << first;
    }
    if (possible == 0) return;
    touch(view_, leaf);
    StoredPoint stored[k_max_leaf_size + k_unpack_room];
    const std::size_t count = unpack(tree_, leaf, possible, stored);
    for (std::size_t i = 0; i < count; ++i) {
      const PointSphere sphere{to_world(tree_.lattice, stored[i].position),
                               own_radius(query_, spacing_at(view_.layers, stored[i].index)),
                               stored[i].index};
      if (distance(position_, sphere.center) <= sphere.radius + reach_) spheres_.push_back(sphere);
    }
  }

  const SurfaceView& view_;
  const TreeView& tree_;
  const glm::dvec3& position_;
  const double reach_;
  const float reach_above_;
  const SurfaceQuery& query_;
  const LocalPoint local_;
  const OwnRadii radii_;
  std::vector<PointSphere>& spheres_;
};

void find_spheres(const SurfaceView& view, const glm::dvec3& position, double reach,
                  const SurfaceQuery& query, std::vector<PointSphere>& spheres) {
  NearSpheres(view, position, reach, query, spheres).run();
}

constexpr auto k_find_spheres = &find_spheres;

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alidade {
namespace {

using FindSpheres = void (*)(const SurfaceView&, const glm::dvec3&, double, const SurfaceQuery&,
                             std::vector<PointSphere>&);

FindSpheres find_spheres_with(InstructionSet instruction_set) {
  using namespace simd;
  ALIDADE_CHOOSE_TABLE(instruction_set, k_find_spheres)
}

}  // namespace

void find_spheres(const SurfaceCloud& cloud, const glm::dvec3& position, double reach,
                  const SurfaceQuery& query, std::vector<PointSphere>& spheres) {
  const SurfaceView& view = cloud.view();
  const TreeView& tree = view.tree;
  if (cloud.size() == 0) return;
  const auto first = static_cast<std::ptrdiff_t>(spheres.size());
  if (simd::suits_lanes(tree, position, PointQuery{.radius = query.radius + reach}) &&
      query.spacing_factor < k_longest) {
    find_spheres_with(cloud.octree().instruction_set())(view, position, reach, query, spheres);
  } else {
    cloud.fit_all();
    for_each_leaf(tree, [&](const Leaf& leaf) {
      for (std::uint32_t i = 0; i < leaf.count; ++i) {
        const PointSphere sphere{to_world(tree.lattice, position_of(tree, leaf, i)),
                                 own_radius(query, spacing_at(view.layers, leaf.first + i)), leaf.first + i};
        if (distance(position, sphere.center) <= sphere.radius + reach) spheres.push_back(sphere);
      }
    });
  }
  // Leaves below wide frames are stored behind all others.
  if (!std::is_sorted(spheres.begin() + first, spheres.end(),
                      [](const PointSphere& a, const PointSphere& b) { return a.index < b.index; }))
    std::sort(spheres.begin() + first, spheres.end(),
              [](const PointSphere& a, const PointSphere& b) { return a.index < b.index; });
}

}  // namespace alidade
#endif  // HWY_ONCE
