// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_LANES_INL_H
#undef ALIDADE_SIMD_LANES_INL_H
#else
#define ALIDADE_SIMD_LANES_INL_H
#endif

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <bit>
#include <cstdint>

#include "octree/octree.h"
#include "octree/query.h"
#include "octree/simd/ray_state.h"
#include "octree/tree_walk.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// One lane per child of a node, as far as the machine has so many.
using ChildLanes = hn::CappedTag<float, 16>;
/// Lanes for the points of a leaf.
using PointLanes = hn::CappedTag<float, 16>;

/// As many values as D has lanes, from any address.
template <class D, class T>
HWY_INLINE hn::Vec<D> load_as_float(D d, const T* values) {
  const hn::RebindToSigned<D> ints;
  return hn::ConvertTo(d, hn::PromoteTo(ints, hn::LoadU(hn::Rebind<T, D>(), values)));
}

#if HWY_TARGET == HWY_AVX3
/// The bits of a mask register, by an instruction of our choice: gcc 12 may store 16 bits of a mask on the
/// stack and load 32 as its number.
template <class Bits>
HWY_INLINE unsigned in_general_register(Bits mask) {
  unsigned bits;
  if constexpr (sizeof(Bits) == 1) {
    asm("kmovb %1, %0" : "=r"(bits) : "k"(mask));
  } else if constexpr (sizeof(Bits) == 2) {
    asm("kmovw %1, %0" : "=r"(bits) : "k"(mask));
  } else {
    asm("kmovd %1, %0" : "=r"(bits) : "k"(mask));
  }
  return bits;
}
#endif

/// Bit i = lane i of the mask.
template <class D, class Mask>
HWY_INLINE unsigned mask_bits(D d, const Mask& mask) {
#if HWY_TARGET == HWY_AVX3
  (void)d;
  return in_general_register(mask.raw);
#elif HWY_TARGET == HWY_AVX2
  (void)d;
  if constexpr (sizeof(hn::TFromD<D>) == sizeof(double)) {
    return static_cast<unsigned>(_mm256_movemask_pd(mask.raw));
  } else {
    return static_cast<unsigned>(_mm256_movemask_ps(mask.raw));
  }
#else
  static_assert(hn::MaxLanes(D()) <= 8);
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  return bytes[0];
#endif
}

/// mask_bits() for bytes, up to 32 of them.
template <class D, class Mask>
HWY_INLINE unsigned byte_mask_bits(D d, const Mask& mask) {
#if HWY_TARGET == HWY_AVX3
  (void)d;
  return in_general_register(mask.raw);
#else
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  return bytes[0] | static_cast<unsigned>(bytes[1]) << 8 | static_cast<unsigned>(bytes[2]) << 16 |
         static_cast<unsigned>(bytes[3]) << 24;
#endif
}

/// Brings lanes of a mask, of 32 bits each, to the front of vectors.
template <class D>
class Compressor {
 public:
#if HWY_TARGET == HWY_AVX2
  // Highway's Compress copies a table to the stack at every call, as gcc 12 compiles it.
  HWY_INLINE Compressor(D d, const hn::Mask<D>& mask)
      : bits_(mask_bits(hn::RebindToFloat<D>(), to_float(d, mask))) {
    order_ = _mm256_srlv_epi32(_mm256_set1_epi32(static_cast<int>(k_numbers_of_bits[bits_])),
                               _mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28));
  }
  template <class V>
  HWY_INLINE V operator()(const V& v) const {
    const hn::DFromV<V> d;
    const hn::RebindToSigned<decltype(d)> ints;
    return hn::BitCast(
        d, hn::Vec<decltype(ints)>{_mm256_permutevar8x32_epi32(hn::BitCast(ints, v).raw, order_)});
  }
  std::uint32_t count() const {
    return static_cast<std::uint32_t>(std::popcount(bits_));
  }

 private:
  static HWY_INLINE hn::Mask<hn::RebindToFloat<D>> to_float(D, const hn::Mask<D>& mask) {
    return hn::RebindMask(hn::RebindToFloat<D>(), mask);
  }
  unsigned bits_;
  __m256i order_;
#else
  HWY_INLINE Compressor(D, const hn::Mask<D>& mask) : mask_(mask) {}
  template <class V>
  HWY_INLINE V operator()(const V& v) const {
    return hn::Compress(v, hn::RebindMask(hn::DFromV<V>(), mask_));
  }
  std::uint32_t count() const {
    return static_cast<std::uint32_t>(hn::CountTrue(D(), mask_));
  }

 private:
  hn::Mask<D> mask_;
#endif
};

inline std::uint32_t index_of_lowest_bit(std::uint32_t bits) {
  return static_cast<std::uint32_t>(std::countr_zero(bits));
}

/// Where points lie relative to a line through the point that x, y, z count from: t along it, and the square
/// of the distance.
template <class V>
struct OnLine {
  V t, distance_sq;
};
template <class V>
HWY_INLINE OnLine<V> on_line(const V& x, const V& y, const V& z, const V& along_x, const V& along_y,
                             const V& along_z) {
  const V t = hn::MulAdd(z, along_z, hn::MulAdd(y, along_y, hn::Mul(x, along_x)));
  const V across_x = hn::NegMulAdd(t, along_x, x), across_y = hn::NegMulAdd(t, along_y, y),
          across_z = hn::NegMulAdd(t, along_z, z);
  return {t, hn::MulAdd(across_z, across_z, hn::MulAdd(across_y, across_y, hn::Mul(across_x, across_x)))};
}

/// The coordinates of a leaf's points, counted from a position near its frame's corner, in metres.
struct LeafCoordinates {
  using V = hn::Vec<PointLanes>;

  /// lattice_scale: metres per step; position: metres from the corner of the frame.
  HWY_INLINE LeafCoordinates(const TreeView& tree, const Leaf& leaf, int level, const float* lattice_scale,
                             const float* position)
      : values(tree.coordinates + std::size_t{3} * leaf.first), count(static_cast<int>(leaf.count)) {
    const PointLanes d;
    const int shift = coordinate_shift(level);
    const auto step = static_cast<float>(power_of_two(shift));
    for (int axis = 0; axis < 3; ++axis) {
      scale[axis] = hn::Set(d, lattice_scale[axis] * step);
      // Coordinates lose up to a step when they are shifted; half of it on either side of the middle.
      origin[axis] =
          hn::Set(d, position[axis] - (shift > 0 ? 0.5f * lattice_scale[axis] * (step - 1.0f) : 0.0f));
    }
  }

  /// What is lost of them. Nothing unless they are shifted.
  static HWY_INLINE float lost(int level, double widest_scale) {
    const int shift = coordinate_shift(level);
    return shift > 0 ? static_cast<float>(widest_scale) * static_cast<float>(power_of_two(shift)) : 0.0f;
  }

  /// Of the points from `first` on.
  HWY_INLINE V operator()(int axis, int first) const {
    return hn::MulSub(load_as_float(PointLanes(), values + axis * count + first), scale[axis], origin[axis]);
  }

  /// Bits of the mask that are points of the leaf.
  HWY_INLINE unsigned in_leaf(const hn::Mask<PointLanes>& mask, int first) const {
    const PointLanes d;
    const unsigned bits = mask_bits(d, mask);
    return count - first < static_cast<int>(hn::Lanes(d)) ? bits & ((1u << (count - first)) - 1u) : bits;
  }

  const std::uint16_t* values;
  const int count;
  V scale[3], origin[3];
};

/// Fetches the cache lines of some values. Always inlined, or else gcc may take it for nothing.
template <class T>
HWY_INLINE void fetch_array(const T* values, std::size_t count) {
  constexpr std::size_t k_in_line = 64 / sizeof(T);
  for (std::size_t i = 0; i < count; i += k_in_line) hwy::Prefetch(values + i);
}

/// For the few roundings of float expressions of positive numbers.
constexpr float k_up = 1.0f + 0x1p-20f, k_down = 1.0f - 0x1p-20f;

/// Whether spheres are surely entered at a limit or later. beyond: t of their points behind the limit, at
/// least; inside: their half chords squared, at most. beyond >= sqrt(inside), without roots.
template <class D, class V>
HWY_INLINE hn::Mask<D> enters_after(D d, V beyond, V inside) {
  return hn::And(hn::Ge(beyond, hn::Zero(d)),
                 hn::Ge(hn::Mul(hn::Mul(beyond, beyond), hn::Set(d, k_down)), inside));
}

/// What LeafTest::LeafFrame::outer_sq and LeafTest::inner_sq are for the query's radius, for radii of the
/// points' own, in floats that are above them by at most 2^-21 of them.
struct SquaredRadius {
  template <class D, class V>
  static HWY_INLINE V outer(D d, V above, V error) {
    const V outer = hn::Add(above, error);
    return hn::Mul(hn::Mul(outer, outer), hn::Set(d, k_up));
  }
  template <class D, class V>
  static HWY_INLINE V inner(D d, V above, V error) {
    const V inner = hn::Sub(hn::Mul(above, hn::Set(d, k_down)), error);
    const V square = hn::Mul(hn::Mul(inner, inner), hn::Set(d, k_down));
    return hn::IfThenElse(hn::Gt(inner, hn::Zero(d)), square, hn::Set(d, -1.0f));
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
