// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_SHARED_RADIUS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_SHARED_RADIUS_INL_H
#undef ALIDADE_SIMD_SHARED_RADIUS_INL_H
#else
#define ALIDADE_SIMD_SHARED_RADIUS_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>

#include "octree/candidate.h"
#include "octree/octree.h"
#include "octree/simd/ray_state.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

template <class Points, bool any>
class LeafGroupTest;
template <class Points, bool any>
class PacketLeafTest;

// What points are to rays is a template parameter of the traversal, Points: here spheres of one radius, in
// surface/simd/own_points-inl.h spheres of the points' own radii, and discs.

/// Spheres of the query's radius. Keeps references, which must outlive it.
template <Measure order>
class SharedRadius {
 public:
  using Answer = Hit;
  /// index: storage index of the point.
  static Answer answer(const Hit& hit, std::uint32_t /*index*/) { return hit; }
  /// By what answers are ordered. Of discs t is that of the crossing.
  static constexpr Measure measure = order;
  /// With own_radii there are, in floats not below them, radii(lanes, storage index) of points, and
  /// slot_reach(lanes, node, axis, slot): how far from their points rays meet those below slots, at most.
  static constexpr bool own_radii = false;
  /// With are_discs there are crossings(), where a ray meets the points of a leaf, and at_discs() is what of
  /// the ray they take (surface/simd/disc_test-inl.h).
  static constexpr bool are_discs = false;
  /// What tests the points of a leaf against many rays.
  template <bool any>
  using GroupTest = LeafGroupTest<SharedRadius, any>;
  /// And against the rays of a packet.
  template <bool any>
  using PacketTest = PacketLeafTest<SharedRadius, any>;

  SharedRadius(const TreeView& tree, const RayQuery& query) : tree_(tree), query_(query) {}

  QueryConditions conditions() const {
    return {query_.radius, query_.entry_min, query_.max_level, query_.filter, own_radii, measure};
  }
  /// Of the point at a storage index.
  double radius_at(std::uint32_t) const { return query_.radius; }
  /// The point as an answer, if it is one.
  std::optional<Hit> evaluate(const Ray& ray, std::uint32_t index, const glm::dvec3& position,
                              std::size_t query_index, Filters filters) const {
    return alidade::evaluate(ray, query_, query_.radius, position, point_id(tree_, index), query_index,
                             filters);
  }
  std::nullptr_t at_discs(const ActiveRay&, const float*, double, double) const { return nullptr; }
  /// Called before points of a leaf are examined.
  void touch(const Leaf&) const {}
  /// Fetches what is read of points beside their coordinates, from a storage index on.
  HWY_INLINE void fetch(std::uint32_t, std::size_t) const {}

 private:
  const TreeView& tree_;
  const RayQuery& query_;
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
