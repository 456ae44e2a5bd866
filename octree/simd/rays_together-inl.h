// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_RAYS_TOGETHER_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_RAYS_TOGETHER_INL_H
#undef ALIDADE_SIMD_RAYS_TOGETHER_INL_H
#else
#define ALIDADE_SIMD_RAYS_TOGETHER_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "octree/simd/lanes-inl.h"
#include "octree/simd/ray_state.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// One lane per ray.
using RayLanes = hn::CappedTag<float, 16>;
using RayNumbers = hn::RebindToUnsigned<RayLanes>;
using RayVector = hn::Vec<RayLanes>;

/// What vectors may touch behind the end of a list.
constexpr std::uint32_t k_list_padding = 16;

/// Columns of a table with eight floats to the row, one lane per row.
struct EightColumns {
  RayVector column[8];
};

/// rows: whole vectors of numbers of rows, each within the table.
HWY_INLINE EightColumns load_columns(const float* table, const std::uint32_t* rows) {
  const RayLanes d;
  EightColumns loaded;
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX2
  const hn::RebindToUnsigned<hn::RepartitionToWide<RayLanes>> pairs;
  RayVector row[8];
  for (int i = 0; i < 8; ++i) {
    const hn::Full256<float> half;
#if HWY_TARGET == HWY_AVX3
    row[i] = hn::Combine(d, hn::LoadU(half, table + std::size_t{8} * rows[i + 8]),
                         hn::LoadU(half, table + std::size_t{8} * rows[i]));
#else
    row[i] = hn::LoadU(half, table + std::size_t{8} * rows[i]);
#endif
  }
  // Within blocks of four columns: rows by twos, then by fours.
  RayVector fours[2][4];
  for (int i = 0; i < 2; ++i) {
    const auto low_a = hn::BitCast(pairs, hn::InterleaveLower(d, row[4 * i], row[4 * i + 1]));
    const auto high_a = hn::BitCast(pairs, hn::InterleaveUpper(d, row[4 * i], row[4 * i + 1]));
    const auto low_b = hn::BitCast(pairs, hn::InterleaveLower(d, row[4 * i + 2], row[4 * i + 3]));
    const auto high_b = hn::BitCast(pairs, hn::InterleaveUpper(d, row[4 * i + 2], row[4 * i + 3]));
    fours[i][0] = hn::BitCast(d, hn::InterleaveLower(pairs, low_a, low_b));
    fours[i][1] = hn::BitCast(d, hn::InterleaveUpper(pairs, low_a, low_b));
    fours[i][2] = hn::BitCast(d, hn::InterleaveLower(pairs, high_a, high_b));
    fours[i][3] = hn::BitCast(d, hn::InterleaveUpper(pairs, high_a, high_b));
  }
  for (int i = 0; i < 4; ++i) {
    loaded.column[i] = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(fours[1][i]), fours[0][i]);
    loaded.column[4 + i] = hn::OddEvenBlocks(fours[1][i], hn::SwapAdjacentBlocks(fours[0][i]));
  }
#else
  constexpr std::size_t k_most_lanes = 16;
  alignas(64) float columns[8][k_most_lanes];
  for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane)
    for (int i = 0; i < 8; ++i) columns[i][lane] = table[std::size_t{8} * rows[lane] + i];
  for (int i = 0; i < 8; ++i) loaded.column[i] = hn::Load(d, columns[i]);
#endif
  return loaded;
}

/// Lanes of a vector at `first` in a list of `count`.
HWY_INLINE hn::Mask<RayLanes> lanes_in_list(std::uint32_t first, std::uint32_t count) {
  return hn::FirstN(RayLanes(), count - first);
}

/// A vector of rays as boxes meet them; lanes from `count` on meet nothing.
struct RayGroup {
  RayVector inverse[3], t_low, origin_t[3], t_cut;

  RayGroup(const RayBoxes* boxes, const std::uint32_t* rays, std::uint32_t count) {
    static_assert(sizeof(RayBoxes) == 8 * sizeof(float));
    const EightColumns columns = load_columns(reinterpret_cast<const float*>(boxes), rays);
    for (int axis = 0; axis < 3; ++axis) {
      inverse[axis] = columns.column[axis];
      origin_t[axis] = columns.column[4 + axis];
    }
    t_low = columns.column[3];
    t_cut = columns.column[7];
    const RayLanes d;
    if (count < hn::Lanes(d))
      t_cut =
          hn::IfThenElse(hn::FirstN(d, count), t_cut, hn::Set(d, -std::numeric_limits<float>::infinity()));
  }
};

/// Rays that meet something, with where they do.
struct RayList {
  std::uint32_t* rays;
  float* t_near;  ///< null for rays at the root
  std::uint32_t count;

  /// Appends lanes of a mask.
  HWY_INLINE void add(const hn::Vec<RayNumbers>& numbers, const RayVector& t,
                      const hn::Mask<RayLanes>& mask) {
    const RayLanes d;
    const RayNumbers n;
    // A whole vector at a time: what stands past the count is written over or is padding.
    hn::StoreU(hn::Compress(numbers, hn::RebindMask(n, mask)), n, rays + count);
    hn::StoreU(hn::Compress(t, mask), d, t_near + count);
    count += static_cast<std::uint32_t>(hn::CountTrue(d, mask));
  }

  /// Discards the rays that need nothing any more that begins at t_near.
  void discard(const RayBoxes* boxes) {
    const RayLanes d;
    const RayNumbers n;
    const hn::RebindToSigned<RayLanes> places;
    const auto* floats = reinterpret_cast<const float*>(boxes);
    const std::uint32_t before = count;
    count = 0;
    for (std::uint32_t i = 0; i < before; i += static_cast<std::uint32_t>(hn::Lanes(d))) {
      const auto numbers = hn::LoadU(n, rays + i);
      const auto t = hn::LoadU(d, t_near + i);
      const auto cut = hn::GatherIndex(d, floats + 7, hn::BitCast(places, hn::ShiftLeft<3>(numbers)));
      add(numbers, t, hn::And(hn::Le(t, cut), lanes_in_list(i, before)));
    }
    pad();
  }

  /// Vectors at the end read the first ray again.
  void pad() {
    const RayLanes d;
    const RayNumbers n;
    if (count == 0) return;
    hn::StoreU(hn::Set(n, rays[0]), n, rays + count);
    if (t_near) hn::StoreU(hn::Set(d, t_near[0]), d, t_near + count);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
