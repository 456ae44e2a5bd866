// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "base/output_file.h"
#include "visibility/row_files.h"

// Rows of named values as the text of CSV, JSON and GeoJSON.

namespace alidade::visibility {

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

}  // namespace alidade::visibility
