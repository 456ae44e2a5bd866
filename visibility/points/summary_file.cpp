// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "visibility/points/summary.h"

namespace alidade::visibility {
namespace {

/// Null if there is no value.
template <class Value>
Row or_null(const std::optional<Value>& value) {
  return value ? Row(*value) : Row(nullptr);
}

Row share_of(double part, double all) {
  return all > 0.0 ? Row(part / all) : Row(nullptr);
}

/// Columns "distance_min" and so on; null without values.
void add_spread(const std::string& name, const std::optional<Spread>& spread, Row& row) {
  for (const auto& [measure, value] : {std::pair("min", &Spread::min), std::pair("median", &Spread::median),
                                       std::pair("mean", &Spread::mean), std::pair("max", &Spread::max),
                                       std::pair("deviation", &Spread::deviation)})
    row[name + "_" + measure] = spread ? Row((*spread).*value) : Row(nullptr);
}

void add_isovist(const std::optional<Isovist>& isovist, Row& row) {
  for (const auto& [measure, value] :
       {std::pair("area", &Isovist::area), std::pair("mean", &Isovist::mean), std::pair("max", &Isovist::max),
        std::pair("deviation", &Isovist::deviation), std::pair("open", &Isovist::open)})
    row[std::string("isovist_") + measure] = isovist ? Row((*isovist).*value) : Row(nullptr);
}

void add_bands(const ObserverSummary& summary, std::span<const double> limits, Row& row) {
  double from = 0.0;
  for (std::size_t i = 0; i < summary.bands.size(); ++i) {
    const double to = i < limits.size() ? limits[i] : std::numeric_limits<double>::infinity();
    const std::string band = fmt::format("{:g}_{:g}", from, to);
    row["area_" + band] = summary.bands[i].visible;
    row["share_" + band] = share_of(summary.bands[i].visible, summary.bands[i].all);
    from = to;
  }
}

Row row_of(const ObserverSummary& summary, const Observer& observer, std::span<const double> limits,
           const std::bitset<256>& classes) {
  Row row = {{"name", observer.name},
             {"x", observer.position.x},
             {"y", observer.position.y},
             {"z", observer.position.z},
             {"points", summary.visible_points},
             {"area", summary.area.visible},
             {"share", share_of(summary.area.visible, summary.area.all)}};
  add_bands(summary, limits, row);
  add_spread("distance", summary.distances, row);
  add_isovist(summary.isovist, row);
  row["volume"] = summary.volume;
  add_spread("horizon", summary.horizon, row);
  row["sky_view"] = summary.sky.cosine_weighted;
  row["sky_share"] = summary.sky.solid_angle;
  if (summary.class_areas.empty()) return row;
  row["ground_area"] = summary.ground_area();
  row["relief"] = or_null(summary.relief);
  row["diversity"] = or_null(summary.diversity);
  for (std::size_t number = 0; number < classes.size(); ++number) {
    if (classes.test(number))
      row[fmt::format("class_{}", number)] = share_of(summary.class_areas[number], summary.area.visible);
  }
  return row;
}

}  // namespace

bool write_summaries(std::span<const ObserverSummary> summaries, std::span<const Observer> observers,
                     const SummaryOptions& options, RowForm form, const RowFileHead& head,
                     const ToLonLat& to_lon_lat, const std::filesystem::path& file, bool overwrite) {
  std::bitset<256> classes;
  for (const std::uint8_t number : options.classes) classes.set(number);
  PositionTable table{.list = "observers", .rows = {}, .positions = {}};
  for (std::size_t i = 0; i < summaries.size(); ++i) {
    table.rows.push_back(row_of(summaries[i], observers[i], options.bands, classes));
    table.positions.push_back(observers[i].position);
  }
  return write_positions(table, Row::object(), form, head, to_lon_lat, file, overwrite);
}

}  // namespace alidade::visibility
