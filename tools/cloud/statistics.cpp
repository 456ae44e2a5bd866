// SPDX-License-Identifier: MIT
#include "tools/cloud/statistics.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <variant>

#include "database/cloud_column.h"
#include "geo/map_unit.h"
#include "image/color_points.h"
#include "image/point_color.h"

namespace alidade::tools {
namespace {

/// The bits of k_flag_names (cloud/attributes.h: PointFlags).
constexpr std::array<int, 5> k_flag_bits = {0, 1, 2, 3, 7};

/// The number that SQL sees; empty for no value and for bytes.
std::optional<double> number_of(const database::ColumnValue& value) {
  return std::visit(
      [](const auto& held) -> std::optional<double> {
        if constexpr (std::is_arithmetic_v<std::decay_t<decltype(held)>>)
          return static_cast<double>(held);
        else
          return std::nullopt;
      },
      value);
}

ColumnStatistics column_statistics(const PointCloud& cloud, const database::CloudColumn& column) {
  ColumnStatistics statistics{.name = column.like.name};
  const database::StoredColumn& like = column.like;
  const bool is_float = like.type == ScalarType::float32 || like.type == ScalarType::float64;
  statistics.is_whole = column.values != nullptr && !is_float && like.scale == 1.0 && like.offset == 0.0;
  std::vector<double> values;
  values.reserve(cloud.size());
  for (std::size_t row = 0; row < cloud.size(); ++row) {
    const std::optional<double> number = number_of(value_of(cloud, column, row));
    if (number && std::isfinite(*number)) values.push_back(*number);
  }
  statistics.count = values.size();
  statistics.missing = cloud.size() - values.size();
  if (values.empty()) return statistics;
  // Differences from one of the values, so that large times and coordinates lose nothing.
  const double base = values.front(), count = static_cast<double>(values.size());
  double sum = 0.0, squares = 0.0;
  for (const double value : values) sum += value - base;
  const double mean = sum / count;
  for (const double value : values) squares += (value - base - mean) * (value - base - mean);
  statistics.mean = base + mean;
  statistics.deviation = std::sqrt(squares / count);
  std::ranges::sort(values);
  statistics.least = values.front();
  statistics.most = values.back();
  for (std::size_t i = 0; i < k_quantiles.size(); ++i) {
    const double rank = std::ceil(k_quantiles[i] * count);
    statistics.quantiles[i] = values[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
  }
  return statistics;
}

/// Cells of a grid with this edge that hold points.
std::size_t occupied_cells(const PointCloud& cloud, const glm::dvec3& corner, double edge) {
  std::vector<std::uint64_t> cells(cloud.size());
  tbb::parallel_for(std::size_t{0}, cells.size(), [&](std::size_t row) {
    const glm::dvec3 position = cloud.world(row) - corner;
    cells[row] =
        static_cast<std::uint64_t>(position.x / edge) << 32 | static_cast<std::uint64_t>(position.y / edge);
  });
  tbb::parallel_sort(cells.begin(), cells.end());
  return static_cast<std::size_t>(std::unique(cells.begin(), cells.end()) - cells.begin());
}

std::optional<CoverageStatistics> coverage_of(const PointCloud& cloud) {
  constexpr double k_spacings = 4.0, k_most_cells = 4e9;
  const Bounds box = cloud.bounds();
  if (box.empty()) return std::nullopt;
  const glm::dvec3 size = box.size();
  const double count = static_cast<double>(cloud.size());
  CoverageStatistics coverage{.area = size.x * size.y};
  // The second time by the area that the first has found: the box may be mostly empty.
  for (int time = 0; time < 2; ++time) {
    coverage.cell = k_spacings * std::sqrt(coverage.area / count);
    if (!(coverage.area > 0.0) || std::max(size.x, size.y) / coverage.cell > k_most_cells)
      return std::nullopt;
    coverage.area =
        static_cast<double>(occupied_cells(cloud, box.min, coverage.cell)) * coverage.cell * coverage.cell;
  }
  coverage.density = count / coverage.area;
  coverage.spacing = 1.0 / std::sqrt(coverage.density);
  const auto last = std::ranges::count_if(
      cloud.returns, [](const ReturnNumbers& numbers) { return numbers.number == numbers.count; });
  coverage.last_return_density =
      cloud.returns.empty() ? coverage.density : static_cast<double>(last) / coverage.area;
  return coverage;
}

/// A number of a column as people write it.
std::string number_text(double value, bool is_whole) {
  if (is_whole) return fmt::format("{:.0f}", value);
  return std::fabs(value) >= 1e5 && std::fabs(value) < 1e15 ? fmt::format("{:.3f}", value)
                                                            : fmt::format("{:.6g}", value);
}

std::string share_row(const std::string& name, std::uint64_t count, std::uint64_t all) {
  return fmt::format(
      "  {:<30}{:>14}{:>9.2f} %\n", name, count,
      100.0 * static_cast<double>(count) / static_cast<double>(std::max<std::uint64_t>(all, 1)));
}

std::string coverage_text(const CoverageStatistics& coverage, const Crs& crs) {
  const geo::MapUnit kind = geo::map_unit(crs);
  const char* const unit = kind == geo::MapUnit::unknown ? "unit" : geo::unit_name(kind);
  return fmt::format(
      "density     {0:.4g} points per {4}2, {1:.4g} of last returns; spacing {2:.3g} {4}; area {3:.6g} {4}2 "
      "(cells of {5:.3g} {4} with points)\n",
      coverage.density, coverage.last_return_density, coverage.spacing, coverage.area, unit, coverage.cell);
}

std::string time_text(const CloudStatistics& statistics, const PointCloud& cloud) {
  const auto times = std::ranges::find(statistics.columns, "gps_time", &ColumnStatistics::name);
  if (times == statistics.columns.end() || times->count == 0) return "";
  if (!cloud.gps_time_is_standard) {
    const auto first = image::gps_weekday(static_cast<std::int64_t>(times->least)),
               last = image::gps_weekday(static_cast<std::int64_t>(times->most));
    return first && last ? fmt::format("time        {} to {} (GPS time of an unknown week)\n", *first, *last)
                         : "time        GPS times are neither standard nor of a week\n";
  }
  const auto first = moment_of_gps_time(times->least), last = moment_of_gps_time(times->most);
  if (!first || !last) return "time        GPS times before 1980\n";
  return fmt::format("time        {} to {}\n", date_time_text(*first), date_time_text(*last));
}

std::string fact_row(const std::string& name, const std::string& value) {
  return fmt::format("{:<12}{}\n", name, value);
}

/// What headers say that neither points nor the table above do.
std::string header_text(const PointCloud& cloud) {
  std::string text;
  const std::vector<std::string> codes = epsg_codes(cloud.crs);
  if (!codes.empty()) text += fact_row("EPSG", fmt::format("{}", fmt::join(codes, ", ")));
  const std::string height = geo::height_unit(cloud.crs);
  if (!cloud.crs.empty())
    text += fact_row("units", fmt::format("x, y {}; z {}", geo::unit_name(geo::map_unit(cloud.crs)),
                                          height.empty() ? "unknown" : height));
  std::set<std::string> said;
  for (const CloudFile& file : cloud.files) {
    std::string line = file.software.empty() ? "" : "by " + file.software;
    if (!file.system_identifier.empty()) line += (line.empty() ? "" : ", ") + file.system_identifier;
    if (!file.created.empty()) line += (line.empty() ? "" : ", ") + file.created;
    if (!line.empty() && said.insert(line).second) text += fact_row("written", line);
  }
  if (cloud.project_id != decltype(cloud.project_id){})
    text += fact_row("project", fmt::format("{:02x}", fmt::join(cloud.project_id, "")));
  if (cloud.file_source_id != 0) text += fact_row("source", fmt::format("{}", cloud.file_source_id));
  for (const VariableLengthRecord& record : cloud.records) {
    text += fact_row("record",
                     fmt::format("{} {}, {} bytes{}{}", record.user_id, record.record_id, record.data.size(),
                                 record.description.empty() ? "" : ": ", record.description));
  }
  return text;
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

CloudStatistics statistics_of(const PointCloud& cloud, const Progress& progress) {
  CloudStatistics statistics;
  const std::vector<database::CloudColumn> columns = database::cloud_columns(cloud);
  statistics.columns.resize(columns.size());
  std::mutex mutex;
  std::uint64_t done = 0;
  tbb::parallel_for(std::size_t{0}, columns.size(), [&](std::size_t i) {
    statistics.columns[i] = column_statistics(cloud, columns[i]);
    const std::scoped_lock lock(mutex);
    report(progress, ++done, columns.size());
  });
  std::erase_if(statistics.columns, [](const ColumnStatistics& column) { return column.count == 0; });
  for (const std::uint8_t kind : cloud.classifications) ++statistics.classes[kind];
  for (const ReturnNumbers& numbers : cloud.returns) ++statistics.returns[{numbers.number, numbers.count}];
  for (const PointFlags flags : cloud.flags) {
    for (std::size_t i = 0; i < k_flag_bits.size(); ++i)
      statistics.flags[i] += static_cast<std::uint64_t>(flags >> k_flag_bits[i] & 1);
  }
  statistics.coverage = coverage_of(cloud);
  return statistics;
}

nlohmann::ordered_json statistics_json(const CloudStatistics& statistics, const PointCloud& cloud) {
  using Json = nlohmann::ordered_json;
  Json columns = Json::object(), classes = Json::object(), returns = Json::array();
  for (const ColumnStatistics& column : statistics.columns) {
    columns[column.name] = {{"count", column.count},        {"missing", column.missing},
                            {"least", column.least},        {"most", column.most},
                            {"mean", column.mean},          {"deviation", column.deviation},
                            {"quantiles", column.quantiles}};
  }
  for (const auto& [kind, count] : statistics.classes) classes[std::to_string(kind)] = count;
  for (const auto& [numbers, count] : statistics.returns)
    returns.push_back({{"number", numbers.first}, {"of", numbers.second}, {"points", count}});
  Json json{{"columns", columns}, {"quantiles", k_quantiles}, {"classes", classes}, {"returns", returns}};
  if (!cloud.flags.empty()) {
    for (std::size_t i = 0; i < k_flag_names.size(); ++i)
      json["flags"][k_flag_names[i]] = statistics.flags[i];
  }
  if (statistics.coverage) {
    const CoverageStatistics& coverage = *statistics.coverage;
    json["coverage"] = {{"density", coverage.density},
                        {"last_return_density", coverage.last_return_density},
                        {"spacing", coverage.spacing},
                        {"area", coverage.area},
                        {"cell", coverage.cell}};
  }
  return json;
}

std::string statistics_text(const CloudStatistics& statistics, const PointCloud& cloud) {
  std::string text = header_text(cloud);
  if (statistics.coverage) text += coverage_text(*statistics.coverage, cloud.crs);
  text += time_text(statistics, cloud);
  const std::uint64_t all = cloud.size();
  if (!statistics.classes.empty()) text += "classes\n";
  const auto styles = image::class_styles();
  for (const auto& [number, count] : statistics.classes)
    text +=
        share_row(fmt::format("{:>3} {}", number, styles[static_cast<std::size_t>(number)].name), count, all);
  if (!statistics.returns.empty()) text += "returns\n";
  for (const auto& [numbers, count] : statistics.returns)
    text += share_row(fmt::format("{:>3} of {}", numbers.first, numbers.second), count, all);
  if (!cloud.flags.empty()) text += "flags\n";
  for (std::size_t i = 0; i < statistics.flags.size() && !cloud.flags.empty(); ++i)
    text += share_row(std::string("    ") + k_flag_names[i], statistics.flags[i], all);
  text += fmt::format("{:<18}{:>14}{:>14}{:>14}{:>14}{:>14}{:>14}{:>14}{:>14}\n", "column", "least", "1 %",
                      "25 %", "median", "75 %", "99 %", "most", "mean");
  for (const ColumnStatistics& column : statistics.columns) {
    text += fmt::format("{:<18}{:>14}", column.name, number_text(column.least, column.is_whole));
    for (const double quantile : column.quantiles)
      text += fmt::format("{:>14}", number_text(quantile, column.is_whole));
    text += fmt::format("{:>14}{:>14}", number_text(column.most, column.is_whole),
                        number_text(column.mean, false));
    if (column.missing > 0) text += fmt::format("  {} without value", column.missing);
    text += "\n";
  }
  return text;
}

}  // namespace alidade::tools
