// SPDX-License-Identifier: MIT
#include "visibility/row_text.h"

#include <nlohmann/json.hpp>

#include "base/shown_text.h"
#include "base/words.h"

namespace alidade::visibility {
namespace {

std::string cell_of(const Row& value) {
  if (value.is_null()) return "";
  if (value.is_boolean()) return value.get<bool>() ? "1" : "0";
  if (value.is_string()) return csv_cell(value.get<std::string>());
  return json_text(value);
}

}  // namespace

std::optional<RowForm> row_form(const std::filesystem::path& file) {
  const std::string extension = file_extension(file);
  if (extension == ".csv") return RowForm::csv;
  if (extension == ".json") return RowForm::json;
  if (extension == ".geojson") return RowForm::geojson;
  return std::nullopt;
}

std::string csv_names(const Row& row) {
  std::string line;
  for (const auto& [name, value] : row.items()) {
    if (!line.empty()) line += ',';
    line += csv_cell(name);
  }
  return line + "\n";
}

std::string csv_values(const Row& row) {
  std::string line;
  bool is_first = true;
  for (const auto& [name, value] : row.items()) {
    if (!is_first) line += ',';
    line += cell_of(value);
    is_first = false;
  }
  return line + "\n";
}

JsonListWriter::JsonListWriter(OutputFile& file, const Row& head, const std::string& list) : file_(file) {
  std::string begin = json_text(head);
  begin.pop_back();
  if (!head.empty()) begin += ",";
  file_.write(begin + "\"" + list + "\":[");
}

void JsonListWriter::add(const Row& element) {
  file_.write((is_first_ ? "\n" : ",\n") + json_text(element));
  is_first_ = false;
}

void JsonListWriter::finish() {
  file_.write("\n]}\n");
}

Row members_of(const RowFileHead& head) {
  Row members = Row::object();
  if (!head.command.empty()) members["command"] = head.command;
  members["cloud_files"] = head.cloud_files;
  return members;
}

Row geojson_head(const RowFileHead& head, bool on_earth) {
  Row members = {{"type", "FeatureCollection"}};
  members.update(members_of(head));
  members["coordinate_system"] =
      on_earth ? "longitude, latitude (WGS 84), z of the cloud" : "the coordinates of the cloud";
  return members;
}

Row geojson_feature(std::span<const glm::dvec3> positions, const Row& properties) {
  Row coordinates = Row::array();
  for (const glm::dvec3& position : positions)
    coordinates.push_back(Row::array({position.x, position.y, position.z}));
  Row geometry = Row::object();
  geometry["type"] = positions.size() == 1 ? "Point" : "LineString";
  geometry["coordinates"] = positions.size() == 1 ? coordinates[0] : coordinates;
  Row feature = Row::object();
  feature["type"] = "Feature";
  feature["geometry"] = geometry;
  feature["properties"] = properties;
  return feature;
}

bool write_positions(const PositionTable& table, const Row& members, RowForm form, const RowFileHead& head,
                     const ToLonLat& to_lon_lat, const std::filesystem::path& file, bool overwrite) {
  OutputFile output(file, overwrite);
  std::optional<std::vector<glm::dvec3>> on_earth;
  if (form == RowForm::csv) {
    output.write(csv_names(table.rows.front()));
    for (const Row& row : table.rows) output.write(csv_values(row));
  } else if (form == RowForm::json) {
    Row object = members_of(head);
    object.update(members);
    JsonListWriter rows(output, object, table.list);
    for (const Row& row : table.rows) rows.add(row);
    rows.finish();
  } else {
    if (to_lon_lat) on_earth = to_lon_lat(table.positions);
    const std::span<const glm::dvec3> positions = on_earth ? *on_earth : table.positions;
    Row object = geojson_head(head, on_earth.has_value());
    object.update(members);
    JsonListWriter features(output, object, "features");
    for (std::size_t i = 0; i < table.rows.size(); ++i)
      features.add(geojson_feature(positions.subspan(i, 1), table.rows[i]));
    features.finish();
  }
  output.commit();
  return form != RowForm::geojson || on_earth.has_value();
}

}  // namespace alidade::visibility
