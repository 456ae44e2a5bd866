// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/output_file.h"

// Files of rows of named values, with or without a position, as CSV, JSON and GeoJSON.

namespace alidade::visibility {

enum class RowForm { csv, json, geojson };

/// The form of a file by its extension, .csv, .json or .geojson; empty for any other.
std::optional<RowForm> row_form(const std::filesystem::path& file);

/// Metadata of a file. CSV cannot hold it.
struct RowFileHead {
  std::string command{};                   ///< command line, or empty
  std::vector<std::string> cloud_files{};  ///< what the points come from
};

/// Transforms positions to longitude and latitude (degrees, WGS 84) and leaves z; empty if it cannot. A
/// function, so that programs do without GDAL (geo/earth.h) where it is not at hand.
using ToLonLat = std::function<std::optional<std::vector<glm::dvec3>>(std::span<const glm::dvec3>)>;

/// Values by name, in the order of the columns.
using Row = nlohmann::ordered_json;

/// A line of CSV with the names, or the values: nothing for null, 1 and 0 for true and false; texts are
/// csv_cell() (base/shown_text.h).
std::string csv_names(const Row& row);
std::string csv_values(const Row& row);

/// A JSON object with a list as its last member, an element in a line of text each. Bytes that are not
/// UTF-8 are replaced.
class JsonListWriter {
 public:
  /// `head`: the other members; an object.
  JsonListWriter(OutputFile& file, const Row& head, const std::string& list);
  void add(const Row& element);
  void finish();

 private:
  OutputFile& file_;
  bool is_first_ = true;
};

/// The members of a head.
Row members_of(const RowFileHead& head);

/// The members of a FeatureCollection beside its features. on_earth: coordinates are longitude and latitude.
Row geojson_head(const RowFileHead& head, bool on_earth);

/// A "Point" if there is one position, a "LineString" if there are more.
Row geojson_feature(std::span<const glm::dvec3> positions, const Row& properties);

/// Rows with a position each.
struct PositionTable {
  std::string list;                   ///< name of their list in JSON: "places"
  std::vector<Row> rows;              ///< with the same names, in the same order
  std::vector<glm::dvec3> positions;  ///< one per row
};

/// Writes a table as CSV (names, then a line each), JSON (an object with the list) or GeoJSON (a Point each).
/// `members` are further members of the JSON object. The file is written completely or not at all. Returns
/// false if GeoJSON got the positions as they are, because there is no `to_lon_lat` or it cannot. Errors: an
/// existing file without `overwrite`; a full disk and other write failures. Requires a row.
bool write_positions(const PositionTable& table, const Row& members, RowForm form, const RowFileHead& head,
                     const ToLonLat& to_lon_lat, const std::filesystem::path& file, bool overwrite);

}  // namespace alidade::visibility
