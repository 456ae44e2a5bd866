// SPDX-License-Identifier: MIT
#include "database/server/server_sql.h"

#include <fmt/format.h>

#include <span>

#include "base/words.h"
#include "database/sql_name.h"

namespace alidade {
namespace {

/// Bytes as PostgreSQL reads them.
template <class Values>
std::string bytes_text(const Values& values) {
  std::string text = "'\\x";
  for (const std::byte byte : std::as_bytes(std::span(values))) text += fmt::format("{:02x}", byte);
  return text + "'::bytea";
}

}  // namespace

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

}  // namespace alidade
