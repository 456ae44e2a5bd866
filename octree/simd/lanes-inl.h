// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_LANES_INL_H
#undef ALIDADE_SIMD_LANES_INL_H
#else
#define ALIDADE_SIMD_LANES_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "octree/octree.h"
#include "octree/query.h"
#include "octree/simd/ray_state.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// One lane per child of a node, as far as the machine has so many.
using ChildLanes = hn::CappedTag<float, k_node_width>;
/// Lanes for the points of a leaf.
using PointLanes = hn::CappedTag<float, 16>;

/// As many values as D has lanes, from any place.
template <class D, class T>
HWY_INLINE hn::Vec<D> load_as_float(D d, const T* values) {
  const hn::RebindToSigned<D> ints;
  return hn::ConvertTo(d, hn::PromoteTo(ints, hn::LoadU(hn::Rebind<T, D>(), values)));
}

/// Bit i = lane i of the mask.
template <class D, class Mask>
HWY_INLINE unsigned mask_bits(D d, const Mask& mask) {
#if HWY_TARGET == HWY_AVX3
  (void)d;
  return mask.raw;
#elif HWY_TARGET == HWY_AVX2
  (void)d;
  return static_cast<unsigned>(_mm256_movemask_ps(mask.raw));
#else
  static_assert(hn::MaxLanes(D()) <= 8);
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  return bytes[0];
#endif
}

/// Bit 7 of byte i becomes bit i.
HWY_INLINE unsigned gather_high_bits(std::uint64_t word) {
  return static_cast<unsigned>(((word >> 7) * 0x0102040810204080u) >> 56);
}

/// Radii of points' own (RayQuery::spacing_factor), from their spacings, in float.
class OwnRadii {
 public:
  explicit OwnRadii(const RayQuery& query)
      : factor_(float_above(query.spacing_factor)), greatest_(float_above(query.radius)) {}

  /// From spacings (octree.h) on; above the radii by at most 2^-21 of them.
  template <class D>
  HWY_INLINE hn::Vec<D> above(D d, const std::uint16_t* spacings) const {
    const hn::RebindToUnsigned<D> bits;
    const auto stored = hn::PromoteTo(bits, hn::LoadU(hn::Rebind<std::uint16_t, D>(), spacings));
    const auto spacing = hn::BitCast(d, hn::ShiftLeft<16>(stored));
    return hn::Min(hn::Set(d, greatest_), hn::Mul(hn::Set(d, factor_), spacing));
  }

  /// What LeafTest::Place::outer_sq and LeafTest::inner_sq are for the query's radius.
  template <class D, class V>
  static HWY_INLINE V outer_sq(D d, V above, V error) {
    const V outer = hn::Add(above, error);
    return hn::Mul(hn::Mul(outer, outer), hn::Set(d, 1.0f + 0x1p-20f));
  }
  template <class D, class V>
  static HWY_INLINE V inner_sq(D d, V above, V error) {
    const V inner = hn::Sub(hn::Mul(above, hn::Set(d, 1.0f - 0x1p-20f)), error);
    const V square = hn::Mul(hn::Mul(inner, inner), hn::Set(d, 1.0f - 0x1p-20f));
    return hn::IfThenElse(hn::Gt(inner, hn::Zero(d)), square, hn::Set(d, -1.0f));
  }

 private:
  float factor_, greatest_;
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
