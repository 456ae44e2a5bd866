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
  /// distance: what rays travel, metres, roughly; a difference of directions counts so much times as one of
  /// origins. in_runs: rays that follow one another go much alike, so that four in a row of one octant share
  /// a cell.
  RayOrder(std::span<const Ray> rays, double distance, bool in_runs) : numbers_(rays.size()) {
    // A cell for every few rays: counting goes through all cells.
    constexpr int k_most_bits = 11;
    const int bits = std::clamp(static_cast<int>(std::bit_width(rays.size())) - 2, 0, k_most_bits);
    std::vector<std::uint8_t> octants(rays.size() + k_run, k_no_octant);
    const std::vector<Column> columns = columns_of(rays, distance, bits, octants);
    std::vector<std::uint32_t> begin((std::size_t{8} << bits) + 1);
    std::vector<std::uint16_t> keys(rays.size());
    const auto is_run = [&](std::size_t first) {
      return in_runs && std::equal(&octants[first] + 1, &octants[first] + k_run, &octants[first]);
    };
    const auto for_each_run = [&](const auto& use) {
      for (std::size_t first = 0; first < rays.size();) {
        const std::size_t count = is_run(first) ? k_run : 1;
        use(first, count);
        first += count;
      }
    };
    for_each_run([&](std::size_t first, std::size_t count) {
      const double* const coordinates = &rays[first + count / 2].origin.x;
      std::uint32_t key = std::uint32_t{octants[first]} << bits;
      for (const Column& column : columns)
        key |=
            column
                .key_bits[static_cast<std::size_t>((coordinates[column.number] - column.low) * column.scale)];
      keys[first] = static_cast<std::uint16_t>(key);
      begin[key] += static_cast<std::uint32_t>(count);
    });
    std::uint32_t sum = 0;
    for (std::size_t key = 0; key < begin.size(); ++key) {
      if (key % (std::size_t{1} << bits) == 0) octant_begin_[key >> bits] = sum;
      sum += std::exchange(begin[key], sum);
    }
    for_each_run([&](std::size_t first, std::size_t count) {
      std::uint32_t& next = begin[keys[first]];
      for (std::size_t i = 0; i < count; ++i) numbers_[next + i] = static_cast<std::uint32_t>(first + i);
      next += static_cast<std::uint32_t>(count);
    });
  }

  std::span<const std::uint32_t> of_octant(unsigned octant) const {
    return std::span(numbers_).subspan(octant_begin_[octant],
                                       octant_begin_[octant + 1] - octant_begin_[octant]);
  }

 private:
  static constexpr std::size_t k_columns = 8;  ///< of a ray; the last two are not used
  static constexpr std::size_t k_run = 4;
  static constexpr std::uint8_t k_no_octant = 8;
  static constexpr double k_least_extent = 1e-290;  ///< of a column; the inverse of less may overflow

  /// A coordinate that the key depends on.
  struct Column {
    std::size_t number;
    double low, scale;                    ///< its cell is (coordinate - low) * scale, rounded down
    std::vector<std::uint16_t> key_bits;  ///< by cell
  };

  /// Fills in the octants, too: the rays are read once.
  static std::vector<Column> columns_of(std::span<const Ray> rays, double distance, int bits,
                                        std::vector<std::uint8_t>& octants) {
    static_assert(sizeof(Ray) == k_columns * sizeof(double));
    const hn::CappedTag<double, k_columns> d;
    constexpr std::size_t k_vectors = k_columns / hn::MaxLanes(d);
    hn::Vec<decltype(d)> least[k_vectors], greatest[k_vectors];
    for (std::size_t v = 0; v < k_vectors; ++v)
      least[v] = greatest[v] = hn::LoadU(d, &rays[0].origin.x + v * hn::Lanes(d));
    for (std::size_t i = 0; i < rays.size(); ++i) {
      unsigned negative = 0;
      for (std::size_t v = 0; v < k_vectors; ++v) {
        const auto coordinates = hn::LoadU(d, &rays[i].origin.x + v * hn::Lanes(d));
        least[v] = hn::Min(least[v], coordinates);
        greatest[v] = hn::Max(greatest[v], coordinates);
        negative |= mask_bits(d, hn::Lt(coordinates, hn::Zero(d))) << (v * hn::Lanes(d));
      }
      octants[i] = static_cast<std::uint8_t>(negative >> 3 & 7u);
    }
    double low[k_columns], high[k_columns];
    for (std::size_t v = 0; v < k_vectors; ++v) {
      hn::StoreU(least[v], d, low + v * hn::Lanes(d));
      hn::StoreU(greatest[v], d, high + v * hn::Lanes(d));
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
