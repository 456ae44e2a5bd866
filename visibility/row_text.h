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

// Files with a row of named values for each of many things, which may lie somewhere, and the text of their rows
// as CSV, JSON and GeoJSON.

namespace alidade::visibility {

enum class RowForm { csv, json, geojson };

/// By the extension: .csv, .json or .geojson; empty for any other.
std::optional<RowForm> row_form(const std::filesystem::path& file);

/// What is said of a whole file, beside its rows. CSV cannot hold it.
struct RowFileHead {
  std::string command{};                   ///< command line, or empty
  std::vector<std::string> cloud_files{};  ///< what the points come from
};

/// Turns positions into longitude and latitude (degrees, WGS 84) and leaves z; empty if it cannot. A function,
/// so that programs without GDAL at hand can do without (geo/earth.h).
using ToLonLat = std::function<std::optional<std::vector<glm::dvec3>>(std::span<const glm::dvec3>)>;

/// Values by name, in the order of the columns.
using Row = nlohmann::ordered_json;

/// A line of CSV with the names, or the values: nothing for null, 1 and 0 for true and false, quotes where a
/// text needs them.
std::string csv_names(const Row& row);
std::string csv_values(const Row& row);

void write_text(OutputFile& file, const std::string& text);

/// A JSON object with a list as its last member, an element in a line of text each. Bytes that are no UTF-8
/// are replaced.
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

/// The members of a FeatureCollection, with a word on its coordinates, which are on Earth or not.
Row geojson_head(const RowFileHead& head, bool on_earth);

/// "Point" for one position, "LineString" for more.
Row geojson_feature(std::span<const glm::dvec3> positions, const Row& properties);

/// Writes rows that lie at a position each: CSV; JSON with them as `list`; or GeoJSON with points. `rows`: an array
/// of objects with the same members, at least one. `totals`: members of the file beside the rows, which CSV cannot
/// hold. Coordinates are turned by `to_lon_lat` for GeoJSON; the answer is whether they could be, true for the other
/// forms. Errors: the file exists and may not be replaced, or cannot be written.
bool write_point_rows(const Row& rows, std::span<const glm::dvec3> positions, const std::string& list,
                      const Row& totals, RowForm form, const RowFileHead& head, const ToLonLat& to_lon_lat,
                      const std::filesystem::path& file, bool overwrite);

}  // namespace alidade::visibility
