// SPDX-License-Identifier: MIT
#include "database/cloud_statistics.h"

#include <tbb/parallel_invoke.h>
#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>
#include <unordered_map>
#include <variant>

#include "base/parallel.h"
#include "database/stored_column.h"

namespace alidade::database {
namespace {

/// The bits of k_flag_names (cloud/attributes.h: PointFlags).
constexpr std::array<int, 5> k_flag_bits = {0, 1, 2, 3, 7};

/// The number in a column of SQL; empty for NULL and for bytes.
std::optional<double> number_of(const ColumnValue& value) {
  return std::visit(
      [](const auto& held) -> std::optional<double> {
        if constexpr (std::is_arithmetic_v<std::decay_t<decltype(held)>>)
          return static_cast<double>(held);
        else
          return std::nullopt;
      },
      value);
}

/// Finds the quantiles k_quantiles of many values that are not stored: each pass over all values determines
/// 16 more bits of the quantiles.
class QuantileSearch {
 public:
  /// Adds a value; every pass adds the same values.
  void add(double value) {
    const std::uint64_t key = key_of(value + 0.0);  // -0 is 0
    all_bits_ &= key;
    any_bits_ |= key;
    for (Bin& bin : bins_) {
      if ((key & known_) == bin.prefix) ++bin.counts[key >> shift_ & 0xffff];
    }
  }

  /// Ends a pass over `count` values, one at least. Returns whether the quantiles are known.
  bool end_pass(std::uint64_t count) {
    if (known_ == 0) {
      for (std::size_t i = 0; i < sought_.size(); ++i) {
        const double rank = std::ceil(k_quantiles[i] * static_cast<double>(count));
        sought_[i].rank = static_cast<std::uint64_t>(std::max(rank, 1.0)) - 1;
      }
    }
    for (Sought& one : sought_) narrow(one);
    known_ |= std::uint64_t{0xffff} << shift_;
    shift_ -= k_digit_bits;
    if (((all_bits_ ^ any_bits_) & ~known_) == 0) return true;
    bins_.clear();
    for (const Sought& one : sought_) {
      if (bins_.empty() || bins_.back().prefix != one.prefix) bins_.push_back({one.prefix});
    }
    return false;
  }

  std::array<double, k_quantiles.size()> values() const {
    std::array<double, k_quantiles.size()> values{};
    std::ranges::transform(sought_, values.begin(), [this](const Sought& one) {
      // All values have the remaining bits in common.
      return value_of_key(one.prefix | (all_bits_ & ~known_));
    });
    return values;
  }

 private:
  static constexpr int k_digit_bits = 16;
  static constexpr std::uint64_t k_sign = std::uint64_t{1} << 63;

  /// A whole number for each value, in the order of the values.
  static std::uint64_t key_of(double value) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    return bits & k_sign ? ~bits : bits | k_sign;
  }
  static double value_of_key(std::uint64_t key) {
    return std::bit_cast<double>(key & k_sign ? key & ~k_sign : ~key);
  }

  /// How many keys begin with `prefix`, by their next 16 bits.
  struct Bin {
    std::uint64_t prefix = 0;
    std::vector<std::uint64_t> counts = std::vector<std::uint64_t>(1 << k_digit_bits);
  };
  /// The key of this rank among those that begin with `prefix`.
  struct Sought {
    std::uint64_t prefix = 0, rank = 0;
  };

  void narrow(Sought& one) const {
    const auto bin = std::ranges::find(bins_, one.prefix, &Bin::prefix);
    std::uint64_t digit = 0;
    for (; one.rank >= bin->counts[digit]; ++digit) one.rank -= bin->counts[digit];
    one.prefix |= digit << shift_;
  }

  std::uint64_t all_bits_ = ~std::uint64_t{0}, any_bits_ = 0;  ///< AND and OR of all keys
  std::uint64_t known_ = 0;                                    ///< bits that earlier passes have determined
  int shift_ = 64 - k_digit_bits;                              ///< of the bits that this pass determines
  std::vector<Bin> bins_ = std::vector<Bin>(1);
  std::array<Sought, k_quantiles.size()> sought_{};
};

/// Rows between two checks for an interruption.
constexpr std::size_t k_rows_between_pauses = std::size_t{1} << 18;
using Pause = std::function<void()>;

/// Calls visit(number) for every finite number of a column, in the order of the rows.
template <class Visit>
void for_each_number(const PointColumns& cloud, const CloudColumn& column, const Pause& pause,
                     const Visit& visit) {
  for (std::size_t row = 0; row < cloud.size(); ++row) {
    if (row % k_rows_between_pauses == 0) pause();
    const std::optional<double> number = number_of(value_of(cloud, column, row));
    if (number && std::isfinite(*number)) visit(*number);
  }
}

ColumnStatistics column_statistics(const PointColumns& cloud, const CloudColumn& column, const Pause& pause) {
  ColumnStatistics statistics{.name = column.like.name};
  statistics.is_whole = column.values != nullptr && column.like.is_whole();
  statistics.least = std::numeric_limits<double>::infinity();
  statistics.most = -statistics.least;
  QuantileSearch search;
  // Differences from one of the values, so that large times and coordinates lose nothing.
  double base = 0.0, sum = 0.0, squares = 0.0;
  for_each_number(cloud, column, pause, [&](double value) {
    if (statistics.count++ == 0) base = value;
    sum += value - base;
    statistics.least = std::min(statistics.least, value);
    statistics.most = std::max(statistics.most, value);
    search.add(value);
  });
  statistics.missing = cloud.size() - statistics.count;
  if (statistics.count == 0) return statistics;
  const double count = static_cast<double>(statistics.count), mean = sum / count;
  bool is_known = search.end_pass(statistics.count);
  for_each_number(cloud, column, pause, [&](double value) {
    squares += (value - base - mean) * (value - base - mean);
    if (!is_known) search.add(value);
  });
  while (!is_known && !search.end_pass(statistics.count))
    for_each_number(cloud, column, pause, [&](double value) { search.add(value); });
  statistics.mean = base + mean;
  statistics.deviation = std::sqrt(squares / count);
  statistics.quantiles = search.values();
  return statistics;
}

/// Cells of a grid with this edge that hold points.
std::size_t occupied_cells(const PointColumns& cloud, const glm::dvec3& corner, double edge,
                           const Pause& pause) {
  // A bit for each cell of blocks of 8 x 8.
  std::unordered_map<std::uint64_t, std::uint64_t> blocks;
  std::uint64_t last_key = 0, *last = &blocks[0];
  for (std::size_t row = 0; row < cloud.size(); ++row) {
    if (row % k_rows_between_pauses == 0) pause();
    const glm::dvec3 position = cloud.world(row) - corner;
    const auto x = static_cast<std::uint64_t>(position.x / edge),
               y = static_cast<std::uint64_t>(position.y / edge);
    const std::uint64_t key = x >> 3 << 32 | y >> 3;
    if (key != last_key) last = &blocks[last_key = key];
    *last |= std::uint64_t{1} << ((x & 7) << 3 | (y & 7));
  }
  std::size_t count = 0;
  for (const auto& [key, cells] : blocks) count += static_cast<std::size_t>(std::popcount(cells));
  return count;
}

std::optional<CoverageStatistics> coverage_of(const PointColumns& cloud, const Pause& pause) {
  constexpr double k_spacings = 4.0, k_most_cells = 4e9;
  const Bounds box = bounds_of(cloud.lattice, cloud.positions);
  if (box.empty()) return std::nullopt;
  const glm::dvec3 size = box.size();
  const double count = static_cast<double>(cloud.size());
  CoverageStatistics coverage{.area = size.x * size.y};
  // The second time by the area that the first has measured: the box may be mostly empty.
  for (int time = 0; time < 2; ++time) {
    coverage.cell = k_spacings * std::sqrt(coverage.area / count);
    if (!(coverage.area > 0.0) || std::max(size.x, size.y) / coverage.cell > k_most_cells)
      return std::nullopt;
    coverage.area = static_cast<double>(occupied_cells(cloud, box.min, coverage.cell, pause)) *
                    coverage.cell * coverage.cell;
  }
  coverage.density = count / coverage.area;
  coverage.spacing = 1.0 / std::sqrt(coverage.density);
  const auto last = std::ranges::count_if(
      cloud.attributes.returns, [](const ReturnNumbers& numbers) { return numbers.number == numbers.count; });
  coverage.last_return_density =
      cloud.attributes.returns.empty() ? coverage.density : static_cast<double>(last) / coverage.area;
  return coverage;
}

}  // namespace

std::optional<Moment> moment_of_gps_time(double seconds) {
  using namespace std::chrono;
  // The first days with one more second between GPS and UTC.
  static constexpr sys_days k_leaps[] = {
      1981y / July / 1,    1982y / July / 1,    1983y / July / 1,    1985y / July / 1,    1988y / January / 1,
      1990y / January / 1, 1991y / January / 1, 1992y / July / 1,    1993y / July / 1,    1994y / July / 1,
      1996y / January / 1, 1997y / July / 1,    1999y / January / 1, 2006y / January / 1, 2009y / January / 1,
      2012y / July / 1,    2015y / July / 1,    2017y / January / 1};
  constexpr sys_days k_first_day = 1980y / January / 6;
  constexpr double k_adjustment = 1e9, k_day = 86'400.0, k_most = 3e10;
  const double gps = seconds + k_adjustment;
  if (!(gps >= 0.0 && gps <= k_most)) return std::nullopt;
  double utc = gps;
  for (const sys_days leap : k_leaps) {
    const double start = static_cast<double>((leap - k_first_day).count()) * k_day;
    if (utc - 1.0 >= start) utc -= 1.0;
  }
  const double day = std::floor(utc / k_day);
  // To the microsecond, which is all that the number holds.
  const double rest = std::round((utc - day * k_day) * 1e6) / 1e6;
  return rest >= k_day ? Moment{k_first_day + days(static_cast<int>(day) + 1), 0.0}
                       : Moment{k_first_day + days(static_cast<int>(day)), rest};
}

CloudStatistics statistics_of(const PointColumns& cloud, const Progress& progress) {
  CloudStatistics statistics{.point_count = cloud.size()};
  const std::vector<CloudColumn> columns = cloud_columns(cloud);
  statistics.columns.resize(columns.size());
  std::mutex mutex;
  std::uint64_t done = 0;
  const auto report_columns = [&](std::uint64_t more) {
    const std::scoped_lock lock(mutex);
    report(progress, done += more, columns.size());
  };
  const Pause pause = [&] { report_columns(0); };
  const auto measure_columns = [&] {
    in_parallel(columns.size(), 1, [&](std::size_t i) {
      statistics.columns[i] = column_statistics(cloud, columns[i], pause);
      report_columns(1);
    });
  };
  tbb::parallel_invoke(measure_columns, [&] { statistics.coverage = coverage_of(cloud, pause); });
  std::erase_if(statistics.columns, [](const ColumnStatistics& column) { return column.count == 0; });
  for (const std::uint8_t kind : cloud.attributes.classifications) ++statistics.classes[kind];
  for (const ReturnNumbers& numbers : cloud.attributes.returns)
    ++statistics.returns[{numbers.number, numbers.count}];
  if (!cloud.attributes.flags.empty()) statistics.flags.emplace();
  for (const PointFlags flags : cloud.attributes.flags) {
    for (std::size_t i = 0; i < k_flag_bits.size(); ++i)
      (*statistics.flags)[i] += static_cast<std::uint64_t>(flags >> k_flag_bits[i] & 1);
  }
  return statistics;
}

}  // namespace alidade::database
