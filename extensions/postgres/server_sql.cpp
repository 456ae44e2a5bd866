// SPDX-License-Identifier: MIT
#include "extensions/postgres/server_sql.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/words.h"
#include "database/sql/sql_tokens.h"

namespace alidade::database {
namespace {

/// In the order of ServerType.
constexpr const char* k_type_names[] = {"smallint",         "integer",     "bigint", "real",
                                        "double precision", "numeric(20)", "bytea"};

/// Bytes as a literal of PostgreSQL.
template <class Values>
std::string bytes_text(const Values& values) {
  std::string text = "'\\x";
  for (const std::byte byte : std::as_bytes(std::span(values))) text += fmt::format("{:02x}", byte);
  return text + "'::bytea";
}

constexpr const char* k_never = "false";
constexpr double k_infinity = std::numeric_limits<double>::infinity();

/// The largest absolute coordinate. Requires that none is NaN.
double reach(const glm::dvec3& position) {
  return std::max({std::abs(position.x), std::abs(position.y), std::abs(position.z)});
}

/// A number as text that is read as the same number.
std::string number(double value) {
  return fmt::format("'{}'::float8", value);
}

std::string call(const char* function, const glm::dvec3& origin, const glm::dvec3& direction) {
  std::string text = function;
  text += "(";
  for (const glm::dvec3& three : {origin, direction}) {
    for (int axis = 0; axis < 3; ++axis) text += number(three[axis]) + ",";
  }
  return text + "x,y,z)";
}

/// Adds the limits on a value that is always at least `least`, if they exclude anything. Infinite limits of
/// the wrong side exclude every point.
void add_limits(const std::string& value, const Interval& limits, double size, double least,
                std::vector<std::string>& all) {
  if (!(limits.low <= limits.high) || limits.low == k_infinity || limits.high == -k_infinity) {
    all.emplace_back(k_never);
    return;
  }
  const auto margin = [&](double limit) { return 1e-9 * std::abs(limit) + 1e-9 + 1e-12 * size; };
  const double low = limits.low - margin(limits.low), high = limits.high + margin(limits.high);
  if (limits.low > -k_infinity && low > least) all.push_back(value + " >= " + number(low));
  if (limits.high < k_infinity) all.push_back(value + " <= " + number(high));
}

std::string condition(const PointFilter& filter) {
  std::vector<std::string> all;
  for (const LineCondition& line : filter.lines) {
    const glm::dvec3& origin = line.ray.origin;
    const glm::dvec3& direction = line.ray.direction;
    add_limits(call("dist_ray", origin, direction), line.distance, reach(origin), 0.0, all);
    add_limits(call("dist_plane", origin, direction), line.t, reach(origin), -k_infinity, all);
  }
  for (const PlaneCondition& plane : filter.planes) {
    add_limits(call("dist_plane", plane.plane.point, plane.plane.normal), plane.distance,
               reach(plane.plane.point), -k_infinity, all);
  }
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 normal(0.0);
    normal[axis] = 1.0;
    const Interval side{filter.box.min[axis], filter.box.max[axis]};
    const double size = std::max(std::isfinite(side.low) ? std::abs(side.low) : 0.0,
                                 std::isfinite(side.high) ? std::abs(side.high) : 0.0);
    // Distances to the plane through the origin are the coordinates.
    add_limits(call("dist_plane", glm::dvec3(0.0), normal), side, size, -k_infinity, all);
  }
  return all.empty() ? "true" : fmt::format("({})", fmt::join(all, " AND "));
}

}  // namespace

ServerType server_type(const StoredColumn& column) {
  using enum ServerType;
  // In the order of ScalarType.
  constexpr ServerType k_types[] = {bytea,   smallint, smallint, integer, smallint,        bigint,
                                    integer, numeric,  bigint,   real,    double_precision};
  constexpr int k_id_blob = 0;
  if (column.blob == k_id_blob) return bigint;
  if (column.is_scaled()) return double_precision;
  return k_types[static_cast<int>(column.type)];
}

std::string server_index(const std::string& quoted_name) {
  return "CREATE INDEX ON " + quoted_name +
         " USING brin (cloud_point(x, y, z)) WITH (pages_per_range = 8, autosummarize = on)";
}

void check_server_table(const std::string& name) {
  constexpr std::size_t k_longest = 40;
  const auto is_control = [](char character) {
    return static_cast<unsigned char>(character) < 0x20 || character == 0x7f;
  };
  check_that(
      !name.empty() && name.size() <= k_longest && std::ranges::none_of(name, is_control) && is_utf8(name),
      "invalid table name", fmt::format("1 to {} bytes of UTF-8 without control characters", k_longest),
      fmt::format("{} bytes", name.size()));
}

void check_column_count(const std::vector<StoredColumn>& columns) {
  constexpr std::size_t k_most = 1600, k_axes = 3;
  check_that(columns.size() + k_axes <= k_most, "too many attributes for a PostgreSQL table",
             fmt::format("at most {} columns", k_most), std::to_string(columns.size() + k_axes));
}

std::string server_columns(const std::vector<StoredColumn>& columns) {
  std::string text =
      "id bigint NOT NULL, x double precision NOT NULL, y double precision NOT NULL, "
      "z double precision NOT NULL";
  for (std::size_t i = 1; i < columns.size(); ++i)
    text += ", " + sql_name(columns[i].name) + " " + k_type_names[static_cast<int>(server_type(columns[i]))];
  return text;
}

CloudRow cloud_row(const PiecewiseCloud& whole, const Bounds& box) {
  return {.lattice = whole.rest.lattice,
          .point_count = whole.point_count,
          .box = box,
          .crs = whole.rest.crs,
          .gps_time_is_standard = whole.rest.gps_time_is_standard};
}

std::string cloud_row_table(const std::string& quoted_name) {
  return "CREATE TABLE " + quoted_name +
         "(version integer NOT NULL, scale_x double precision NOT NULL, scale_y double precision NOT NULL, "
         "scale_z double precision NOT NULL, offset_x double precision NOT NULL, "
         "offset_y double precision NOT NULL, offset_z double precision NOT NULL, points bigint NOT NULL, "
         "min_x double precision, min_y double precision, min_z double precision, "
         "max_x double precision, max_y double precision, max_z double precision, "
         "crs text, geotiff_keys bytea, geotiff_doubles bytea, geotiff_ascii bytea, "
         "gps_time_is_standard boolean NOT NULL)";
}

std::string cloud_row_insert(const std::string& quoted_name, const CloudRow& row) {
  std::vector<std::string> values = {std::to_string(k_cloud_row_version)};
  const auto add = [&](const glm::dvec3& three, bool is_there) {
    for (int axis = 0; axis < 3; ++axis)
      values.push_back(is_there ? fmt::format("'{}'", three[axis]) : "NULL");
  };
  add(row.lattice.scale, true);
  add(row.lattice.offset, true);
  values.push_back(std::to_string(row.point_count));
  add(row.box.min, !row.box.empty());
  add(row.box.max, !row.box.empty());
  values.push_back(is_utf8(row.crs.wkt) ? sql_text(row.crs.wkt) : "NULL");
  values.push_back(bytes_text(row.crs.geotiff_keys));
  values.push_back(bytes_text(row.crs.geotiff_doubles));
  values.push_back(bytes_text(row.crs.geotiff_ascii));
  values.push_back(row.gps_time_is_standard ? "true" : "false");
  return fmt::format("INSERT INTO {} VALUES ({})", quoted_name, fmt::join(values, ", "));
}

std::string filter_condition(std::span<const PointFilter> any_of) {
  std::vector<std::string> all;
  for (const PointFilter& filter : any_of) all.push_back(condition(filter));
  return all.empty() ? k_never : fmt::format("{}", fmt::join(all, " OR "));
}

}  // namespace alidade::database
