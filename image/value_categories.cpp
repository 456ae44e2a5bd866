// SPDX-License-Identifier: MIT
#include "image/value_categories.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/enumerable_thread_specific.h>
#include <bit>
#include <cmath>
#include <map>

namespace alidade::image {
namespace {

/// Values and how many points have them; `fits` turns false as soon as they are too many, or not whole
/// numbers from 0 on.
struct ValueCounts {
  std::map<double, std::uint64_t> counts{};
  bool fits = true;

  void add(double value, std::uint64_t count) {
    constexpr double k_largest_whole = 0x1p53;
    if (!fits || std::isnan(value)) return;
    fits = value >= 0.0 && value <= k_largest_whole && value == std::floor(value);
    if (fits) counts[value] += count;
    fits = fits && counts.size() <= k_most_categories;
  }
};

ValueCounts counts_of(const PointValues& values) {
  tbb::enumerable_thread_specific<ValueCounts> of_threads;
  values.for_each_block([&](const ValueBlock& block) {
    ValueCounts& counts = of_threads.local();
    for (const double value : block.values) {
      if (!counts.fits) return;
      counts.add(value, 1);
    }
  });
  ValueCounts sums;
  for (const ValueCounts& each : of_threads) {
    sums.fits = sums.fits && each.fits;
    for (const auto& [value, count] : each.counts) sums.add(value, count);
  }
  return sums;
}

std::string label_of_mask(std::uint64_t mask) {
  std::vector<int> bits;
  for (int bit = 0; bit < 64; ++bit)
    if (mask >> bit & 1) bits.push_back(bit + 1);
  if (bits.empty()) return "none";
  return fmt::format("{}", fmt::join(bits, ", "));
}

}  // namespace

std::vector<ValueCategory> categories_of(const PointValues& values, ColorMap map, bool are_masks) {
  const ValueCounts found = counts_of(values);
  if (!found.fits || found.counts.empty()) return {};
  const double low = found.counts.begin()->first, high = found.counts.rbegin()->first;
  const bool counts_up =
      !are_masks && low <= 1.0 && high - low + 1.0 == static_cast<double>(found.counts.size());
  std::vector<ValueCategory> categories;
  for (const auto& [value, count] : found.counts) {
    const auto number = static_cast<std::uint64_t>(value);
    constexpr Color16 k_no_bit{0xb8b8};  // a light grey
    const Color16 color = are_masks && number == 0 ? k_no_bit
                          : counts_up ? to_color16(map_color(map, position_in({low, high}, value)))
                                      : distinct_color(are_masks ? categories.size() : number);
    categories.push_back({value,
                          {.color = color,
                           .number = are_masks ? "" : std::to_string(number),
                           .label = are_masks ? label_of_mask(number) : "",
                           .count = count}});
  }
  return categories;
}

PointValues bit_counts(const PointValues& masks) {
  return {masks.count, [masks](const VisitBlock& visit) {
            masks.for_each_block([&](const ValueBlock& block) {
              std::vector<double> counts(block.values.begin(), block.values.end());
              for (double& value : counts)
                if (value >= 0.0 && value < 0x1p64) value = std::popcount(static_cast<std::uint64_t>(value));
              visit({counts, block.first_id, block.ids});
            });
          }};
}

}  // namespace alidade::image
