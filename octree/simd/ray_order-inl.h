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

/// Numbers of rays by octant, and in each octant so that rays side by side go much alike: by cells of a
/// coarse grid over those coordinates of origins and directions that differ most, along a Morton curve. Rays
/// of one cell keep their order. Cost: some nanoseconds per ray.
class RayOrder {
 public:
  /// numbers: of the rays to be ordered. distance: what rays travel, metres, roughly; a difference of
  /// directions counts so much times as one of origins.
  RayOrder(std::span<const Ray> rays, std::span<const std::uint32_t> numbers, double distance)
      : numbers_(numbers.size()) {
    // A cell for every few rays: counting goes through all cells.
    constexpr int k_most_bits = 11;
    const int bits = std::clamp(static_cast<int>(std::bit_width(numbers.size())) - 2, 0, k_most_bits);
    const std::vector<Column> columns = columns_of(rays, distance, bits);
    std::vector<std::uint32_t> begin((std::size_t{8} << bits) + 1);
    std::vector<std::uint16_t> keys(numbers.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const Ray& ray = rays[numbers[i]];
      const double* const coordinates = &ray.origin.x;
      std::uint32_t key = octant_of(ray) << bits;
      for (const Column& column : columns)
        key |=
            column
                .key_bits[static_cast<std::size_t>((coordinates[column.number] - column.low) * column.scale)];
      keys[i] = static_cast<std::uint16_t>(key);
      ++begin[key];
    }
    std::uint32_t sum = 0;
    for (std::size_t key = 0; key < begin.size(); ++key) {
      if (key % (std::size_t{1} << bits) == 0) octant_begin_[key >> bits] = sum;
      sum += std::exchange(begin[key], sum);
    }
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers_[begin[keys[i]]++] = numbers[i];
  }

  std::span<const std::uint32_t> of_octant(unsigned octant) const {
    return std::span(numbers_).subspan(octant_begin_[octant],
                                       octant_begin_[octant + 1] - octant_begin_[octant]);
  }

 private:
  static constexpr std::size_t k_columns = 8;       ///< of a ray; the last two are not used
  static constexpr double k_least_extent = 1e-290;  ///< of a column; the inverse of less may overflow

  /// A coordinate that the key depends on.
  struct Column {
    std::size_t number;
    double low, scale;                    ///< its cell is (coordinate - low) * scale, rounded down
    std::vector<std::uint16_t> key_bits;  ///< by cell
  };

  static std::vector<Column> columns_of(std::span<const Ray> rays, double distance, int bits) {
    static_assert(sizeof(Ray) == k_columns * sizeof(double));
    const hn::CappedTag<double, k_columns> d;
    double low[k_columns], high[k_columns];
    for (std::size_t lane = 0; lane < k_columns; lane += hn::Lanes(d)) {
      auto least = hn::LoadU(d, &rays[0].origin.x + lane), greatest = least;
      for (const Ray& ray : rays) {
        const auto coordinates = hn::LoadU(d, &ray.origin.x + lane);
        least = hn::Min(least, coordinates);
        greatest = hn::Max(greatest, coordinates);
      }
      hn::StoreU(least, d, low + lane);
      hn::StoreU(greatest, d, high + lane);
    }
    // Every bit of the key, the highest first, goes to the column whose cells are the longest.
    std::array<double, 6> length;
    std::array<std::vector<int>, 6> shifts;
    for (std::size_t column = 0; column < 6; ++column)
      length[column] = (high[column] - low[column]) * (column < 3 ? 1.0 : distance);
    for (int bit = bits; bit-- > 0;) {
      const auto longest = static_cast<std::size_t>(std::ranges::max_element(length) - length.begin());
      shifts[longest].insert(shifts[longest].begin(), bit);
      length[longest] *= 0.5;
    }
    std::vector<Column> columns;
    for (std::size_t column = 0; column < 6; ++column) {
      const std::size_t cells = std::size_t{1} << shifts[column].size();
      if (cells == 1 || !(high[column] - low[column] > k_least_extent)) continue;
      const double scale = (static_cast<double>(cells) - 0.001) / (high[column] - low[column]);
      std::vector<std::uint16_t> key_bits(cells);
      for (std::size_t cell = 0; cell < cells; ++cell)
        for (std::size_t bit = 0; bit < shifts[column].size(); ++bit)
          key_bits[cell] |= static_cast<std::uint16_t>((cell >> bit & 1) << shifts[column][bit]);
      columns.push_back({column, low[column], scale, std::move(key_bits)});
    }
    return columns;
  }

  std::vector<std::uint32_t> numbers_;
  std::array<std::uint32_t, 9> octant_begin_{};
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
