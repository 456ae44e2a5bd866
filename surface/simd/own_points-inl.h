// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_OWN_POINTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_OWN_POINTS_INL_H
#undef ALIDADE_SIMD_OWN_POINTS_INL_H
#else
#define ALIDADE_SIMD_OWN_POINTS_INL_H
#endif

#include <hwy/highway.h>

#include "octree/simd/lanes-inl.h"
#include "octree/simd/ray_state.h"
#include "octree/simd/shared_radius-inl.h"
#include "surface/decide_point.h"
#include "surface/disc_reach.h"
#include "surface/leaf_fitter.h"
#include "surface/simd/disc_test-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// From the upper halves of floats on, times a factor, but not more than `greatest`.
template <class D>
HWY_INLINE hn::Vec<D> scaled(D d, const std::uint16_t* halves, float factor, float greatest) {
  const hn::RebindToUnsigned<D> bits;
  const auto stored = hn::PromoteTo(bits, hn::LoadU(hn::Rebind<std::uint16_t, D>(), halves));
  const auto value = hn::BitCast(d, hn::ShiftLeft<16>(stored));
  return hn::Min(hn::Set(d, greatest), hn::Mul(hn::Set(d, factor), value));
}

/// Radii of points' own, from their spacings, in float; above the radii by at most 2^-21 of them.
class OwnRadii {
 public:
  OwnRadii(const SurfaceView& view, const SurfaceQuery& query)
      : spacings_(view.layers.spacings),
        slot_spacings_(view.layers.slot_spacings),
        factor_(float_above(query.spacing_factor)),
        greatest_(float_above(query.radius)) {}

  /// From a storage index on.
  template <class D>
  HWY_INLINE hn::Vec<D> of_points(D d, std::uint32_t index) const {
    return scaled(d, spacings_ + index, factor_, greatest_);
  }
  /// The greatest below the slots of a node, from one slot on.
  template <class D>
  HWY_INLINE hn::Vec<D> below_slots(D d, std::uint32_t node, std::size_t slot) const {
    return scaled(d, slot_spacings_ + std::size_t{k_node_width} * node + slot, factor_, greatest_);
  }

 private:
  const std::uint16_t* const spacings_;
  const std::uint16_t* const slot_spacings_;
  const float factor_, greatest_;
};

/// Points of a SurfaceCloud, whatever their shape: see SharedRadius. Keeps references, which must outlive it.
template <Measure order>
class OwnPoints {
 public:
  using Answer = SurfaceHit;
  static Answer answer(const Hit& hit, std::uint32_t index) { return {hit, index}; }
  static constexpr Measure measure = order;
  static constexpr bool own_radii = true;

  OwnPoints(const SurfaceView& view, const SurfaceQuery& query)
      : view_(view), query_(query), radii_(view, query) {}

  QueryConditions conditions() const {
    return {query_.radius, query_.entry_min, k_all_levels, query_.filter, own_radii, measure};
  }
  const SurfaceQuery& query() const { return query_; }
  double radius_at(std::uint32_t index) const { return own_radius(query_, spacing_at(view_.layers, index)); }
  std::optional<Hit> evaluate(const Ray& ray, std::uint32_t index, const glm::dvec3& position,
                              std::size_t query_index, Filters filters) const {
    return alidade::evaluate(ray, query_, view_, index, position, query_index, filters);
  }
  template <class D>
  HWY_INLINE hn::Vec<D> radii(D d, std::uint32_t index) const {
    return radii_.of_points(d, index);
  }

 protected:
  const SurfaceView& view_;
  const SurfaceQuery& query_;
  const OwnRadii radii_;
};

/// Spheres.
template <Measure order>
class OwnRadius : public OwnPoints<order> {
 public:
  static constexpr bool are_discs = false;
  template <bool any>
  using GroupTest = LeafGroupTest<OwnRadius, any>;
  template <bool any>
  using PacketTest = PacketLeafTest<OwnRadius, any>;

  using OwnPoints<order>::OwnPoints;

  template <class D>
  HWY_INLINE hn::Vec<D> slot_reach(D d, std::uint32_t node, int, std::size_t slot) const {
    return this->radii_.below_slots(d, node, slot);
  }
  std::nullptr_t at_discs(const ActiveRay&, const float*, double, double) const { return nullptr; }
  void touch(const Leaf&) const {}
  HWY_INLINE void fetch(std::uint32_t first, std::size_t count) const {
    fetch_array(this->view_.layers.spacings + first, count);
  }
};

template <bool any>
class DiscGroupTest;
template <bool any>
class DiscPacketTest;

/// Discs.
class Discs : public OwnPoints<Measure::t> {
 public:
  static constexpr bool are_discs = true;
  template <bool any>
  using GroupTest = DiscGroupTest<any>;
  template <bool any>
  using PacketTest = DiscPacketTest<any>;

  Discs(const SurfaceView& view, const SurfaceQuery& query)
      : OwnPoints(view, query),
        test_(view, query),
        reaches_(view.slot_reaches),
        reach_factor_(float_above(std::min(disc_reach_factor(query), k_far))),
        greatest_reach_(float_above(query.radius)) {
    if (reaches_ != nullptr) return;
    reaches_ = view.layers.slot_spacings;
    in_node_ = k_node_width;
    in_axis_ = 0;
    reach_factor_ = float_above(query.spacing_factor);
  }

  template <class D>
  HWY_INLINE hn::Vec<D> slot_reach(D d, std::uint32_t node, int axis, std::size_t slot) const {
    const std::uint16_t* const row = reaches_ + in_node_ * node + in_axis_ * static_cast<std::size_t>(axis);
    return scaled(d, row + slot, reach_factor_, greatest_reach_);
  }

  void touch(const Leaf& leaf) const { alidade::touch(view_, leaf); }
  HWY_INLINE void fetch(std::uint32_t first, std::size_t count) const {
    fetch_array(view_.layers.spacings + first, count);
    fetch_array(view_.stored_surfaces + first, count);
    fetch_array(view_.stored_edges + first, count);
  }

  const DiscTest& test() const { return test_; }
  HWY_INLINE RaysAtDiscs at_discs(const ActiveRay& ray, const float* along, double start,
                                  double error) const {
    return {along, LeftSheet(ray, query_, start, error)};
  }
  /// Of the points from a storage index on; lanes from `count` on are not used.
  HWY_INLINE Crossings crossings(std::uint32_t index, std::size_t count, const NearRay& points,
                                 const RaysAtDiscs& ray) const {
    return test_(test_.sheets(index, count), points, ray);
  }

 private:
  const DiscTest test_;
  const std::uint16_t* reaches_;
  std::size_t in_node_ = 3 * k_node_width, in_axis_ = k_node_width;  ///< from a node or axis to the next
  float reach_factor_;
  const float greatest_reach_;
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
