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

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
