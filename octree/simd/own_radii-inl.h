// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_OWN_RADII_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_OWN_RADII_INL_H
#undef ALIDADE_SIMD_OWN_RADII_INL_H
#else
#define ALIDADE_SIMD_OWN_RADII_INL_H
#endif

#include "octree/query.h"
#include "octree/simd/lanes-inl.h"
#include "octree/simd/ray_state.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

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
