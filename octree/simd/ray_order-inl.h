// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_RAY_ORDER_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_RAY_ORDER_INL_H
#undef ALIDADE_SIMD_RAY_ORDER_INL_H
#else
#define ALIDADE_SIMD_RAY_ORDER_INL_H
#endif

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "base/ray.h"
#include "octree/simd/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// Numbers of rays by octant, and in each octant so that rays side by side go much alike: by cells of a coarse grid over
/// those coordinates of origins and directions that differ most. Rays of one cell keep their order. Cost: some
/// nanoseconds per ray.
class RayOrder {
 public:
  /// distance: what rays travel, metres, roughly; a difference of directions counts so much times as one of origins.
  RayOrder(std::span<const Ray> rays, double distance) : numbers_(rays.size()) {
    static_assert(sizeof(Ray) == k_columns * sizeof(double));
    const hn::CappedTag<double, k_columns> d;
    const hn::Rebind<std::int32_t, decltype(d)> ints;
    constexpr std::size_t lanes = hn::MaxLanes(hn::CappedTag<double, k_columns>());
    // A cell for every few rays: counting goes through all cells.
    const int bits = std::clamp(static_cast<int>(std::bit_width(rays.size())) - 2, 0, k_most_bits);
    Cells cells(rays, distance, bits);
    std::vector<std::uint32_t> begin((std::size_t{8} << bits) + 1);
    std::vector<std::uint16_t> keys(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const double* const columns = &rays[i].origin.x;
      std::int32_t cell = 0;
      for (std::size_t lane = 0; lane < lanes * (k_columns / lanes); lane += lanes) {
        const auto steps = hn::Mul(hn::Sub(hn::LoadU(d, columns + lane), hn::LoadU(d, cells.low + lane)),
                                   hn::LoadU(d, cells.scale + lane));
        const auto weighted = hn::Mul(hn::DemoteTo(ints, steps), hn::LoadU(ints, cells.weight + lane));
        cell += hn::GetLane(hn::SumOfLanes(ints, weighted));
      }
      const auto key =
          static_cast<std::uint16_t>(octant_of(rays[i]) << bits | static_cast<std::uint32_t>(cell));
      keys[i] = key;
      ++begin[key];
    }
    std::uint32_t sum = 0;
    for (std::size_t key = 0; key < begin.size(); ++key) {
      if (key % (std::size_t{1} << bits) == 0) octant_begin_[key >> bits] = sum;
      sum += std::exchange(begin[key], sum);
    }
    for (std::size_t i = 0; i < rays.size(); ++i) numbers_[begin[keys[i]]++] = static_cast<std::uint32_t>(i);
  }

  std::span<const std::uint32_t> of_octant(unsigned octant) const {
    return std::span(numbers_).subspan(octant_begin_[octant],
                                       octant_begin_[octant + 1] - octant_begin_[octant]);
  }

 private:
  static constexpr int k_most_bits = 11;
  static constexpr std::size_t k_columns = 8;  ///< of a ray; the last two are not used

  struct Cells {
    double low[k_columns], scale[k_columns] = {};
    std::int32_t weight[k_columns] = {};

    Cells(std::span<const Ray> rays, double distance, int all_bits) {
      const hn::CappedTag<double, k_columns> d;
      double high[k_columns];
      for (std::size_t lane = 0; lane < k_columns; lane += hn::Lanes(d)) {
        auto least = hn::LoadU(d, &rays[0].origin.x + lane), greatest = least;
        for (const Ray& ray : rays) {
          const auto columns = hn::LoadU(d, &ray.origin.x + lane);
          least = hn::Min(least, columns);
          greatest = hn::Max(greatest, columns);
        }
        hn::StoreU(least, d, low + lane);
        hn::StoreU(greatest, d, high + lane);
      }
      // Every bit goes to the column whose cells are the longest.
      std::array<double, 6> length;
      std::array<int, 6> bits{};
      for (std::size_t column = 0; column < 6; ++column)
        length[column] = (high[column] - low[column]) * (column < 3 ? 1.0 : distance);
      for (int bit = 0; bit < all_bits; ++bit) {
        const auto longest = static_cast<std::size_t>(std::ranges::max_element(length) - length.begin());
        ++bits[longest];
        length[longest] *= 0.5;
      }
      int shift = 0;
      for (std::size_t column = 0; column < 6; ++column) {
        if (bits[column] == 0 || !(high[column] > low[column])) continue;
        scale[column] = ((1 << bits[column]) - 0.001) / (high[column] - low[column]);
        weight[column] = 1 << shift;
        shift += bits[column];
      }
    }
  };

  std::vector<std::uint32_t> numbers_;
  std::array<std::uint32_t, 9> octant_begin_{};
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
