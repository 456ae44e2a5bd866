// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/date_time.h"
#include "base/progress.h"
#include "cloud/point_cloud.h"

namespace alidade::database {

/// The shares below which quantiles are given.
inline constexpr std::array<double, 5> k_quantiles = {0.01, 0.25, 0.5, 0.75, 0.99};

inline constexpr std::array<const char*, 5> k_flag_names = {"synthetic", "key point", "withheld", "overlap",
                                                            "edge of flight line"};

/// The values of a column of numbers, without nodata.
struct ColumnStatistics {
  std::string name;  ///< as SQL has it (database/stored_column.h)
  bool is_whole = false;
  std::uint64_t count = 0, missing = 0;
  double least = 0.0, most = 0.0, mean = 0.0, deviation = 0.0;
  /// Values of the column itself: the least that at least this share of values does not exceed.
  std::array<double, k_quantiles.size()> quantiles{};
};

/// How densely points cover the plane, by the cells of a grid that hold any.
struct CoverageStatistics {
  double cell = 0.0;  ///< edge of a cell, in the unit of x and y: about 4 spacings
  double area = 0.0;  ///< of the cells that hold points
  double density = 0.0, last_return_density = 0.0;  ///< points per square of that unit
  double spacing = 0.0;                             ///< 1 / sqrt(density)
};

/// The contents of a cloud. Cost: two to four passes over each column, shared by threads (oneTBB). Memory:
/// 3 MB per thread and about 1/20 B per point.
struct CloudStatistics {
  std::uint64_t point_count = 0;
  std::vector<ColumnStatistics> columns{};
  std::map<int, std::uint64_t> classes{};                  ///< points of each class that occurs
  std::map<std::pair<int, int>, std::uint64_t> returns{};  ///< by number and count
  /// Points that have each; empty if the cloud has no flags.
  std::optional<std::array<std::uint64_t, k_flag_names.size()>> flags{};
  std::optional<CoverageStatistics> coverage{};  ///< empty for points on a line or at a single position
};

/// Requires the attributes to have been read. `progress` is in columns, and also called within them.
CloudStatistics statistics_of(const PointColumns& cloud, const Progress& progress = {});

/// The moment of an adjusted standard GPS time (LAS 1.4: GPS seconds minus 10^9). Source of leap seconds:
/// IERS Bulletin C, up to 2017; empty before the first day of GPS, 6 January 1980.
std::optional<Moment> moment_of_gps_time(double seconds);

}  // namespace alidade::database
