// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_PACKET_HITS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_PACKET_HITS_INL_H
#undef ALIDADE_SIMD_PACKET_HITS_INL_H
#else
#define ALIDADE_SIMD_PACKET_HITS_INL_H
#endif

#include <hwy/cache_control.h>

#include <optional>

#include "octree/candidate.h"
#include "octree/simd/packet_state-inl.h"
#include "octree/tree_walk.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// The points that rays of a packet meet as hits, several at a time: the operations of evaluate()
/// (octree/candidate.h) in their order, so that the numbers are the same bits.
class PacketHits {
 public:
  template <Radii radii>
  HWY_INLINE void add(const QuerySetup& setup, std::size_t lane, const Leaf& leaf, std::uint32_t point) {
    const TreeView& tree = setup.tree;
    index_[lane] = leaf.first + point;
    if (tree.ids) hwy::Prefetch(tree.ids + index_[lane]);
    const glm::dvec3 position = to_world(tree.lattice, position_of(tree, leaf, point));
    for (int axis = 0; axis < 3; ++axis) position_[axis][lane] = position[axis];
    radius_[lane] =
        radii == Radii::own ? own_radius(setup.query, spacing_at(tree, index_[lane])) : setup.query.radius;
  }

  void evaluate(const PacketRays& rays) {
    const DoubleLanes d;
    for (std::size_t lane = 0; lane < rays.count; lane += hn::Lanes(d)) {
      const auto relative = [&](int axis) {
        return hn::Sub(hn::Load(d, position_[axis] + lane), hn::Load(d, rays.origin[axis] + lane));
      };
      const auto x = relative(0), y = relative(1), z = relative(2);
      const auto dx = hn::Load(d, rays.direction[0] + lane), dy = hn::Load(d, rays.direction[1] + lane),
                 dz = hn::Load(d, rays.direction[2] + lane);
      const auto cross_x = hn::Sub(hn::Mul(y, dz), hn::Mul(z, dy)),
                 cross_y = hn::Sub(hn::Mul(z, dx), hn::Mul(x, dz)),
                 cross_z = hn::Sub(hn::Mul(x, dy), hn::Mul(y, dx));
      const auto t = hn::Add(hn::Add(hn::Mul(x, dx), hn::Mul(y, dy)), hn::Mul(z, dz));
      const auto distance = hn::Sqrt(
          hn::Add(hn::Add(hn::Mul(cross_x, cross_x), hn::Mul(cross_y, cross_y)), hn::Mul(cross_z, cross_z)));
      const auto radius = hn::Load(d, radius_ + lane);
      const auto half_chord_sq = hn::Sub(hn::Mul(radius, radius), hn::Mul(distance, distance));
      hn::Store(t, d, t_ + lane);
      hn::Store(distance, d, distance_ + lane);
      hn::Store(hn::Sub(t, hn::Sqrt(hn::Max(half_chord_sq, hn::Zero(d)))), d, entry_ + lane);
    }
  }

  /// Whether the point meets the conditions of the query.
  HWY_INLINE bool write(const QuerySetup& setup, const Ray& ray, std::size_t lane,
                        std::optional<Hit>& hit) const {
    if (!(distance_[lane] <= radius_[lane] && t_[lane] >= ray.t_min && t_[lane] <= ray.t_max &&
          entry_[lane] >= setup.query.entry_min))
      return false;
    hit = Hit{point_id(setup.tree, index_[lane]),
              {position_[0][lane], position_[1][lane], position_[2][lane]},
              t_[lane],
              distance_[lane],
              entry_[lane]};
    return true;
  }

 private:
  static constexpr std::size_t k_size = PacketRays::k_size;
  std::uint32_t index_[k_size];
  alignas(64) double position_[3][k_size], radius_[k_size];
  alignas(64) double t_[k_size], distance_[k_size], entry_[k_size];
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
