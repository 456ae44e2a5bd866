// SPDX-License-Identifier: MIT
#include "visibility/row_text.h"

#include <nlohmann/json.hpp>

#include "base/words.h"

namespace alidade::visibility {
namespace {

std::string text_of(const Row& value) {
  return value.dump(-1, ' ', false, Row::error_handler_t::replace);
}

std::string quoted_where_needed(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char character : text) {
    quoted += character;
    if (character == '"') quoted += character;
  }
  return quoted + "\"";
}

std::string cell_of(const Row& value) {
  if (value.is_null()) return "";
  if (value.is_boolean()) return value.get<bool>() ? "1" : "0";
  if (value.is_string()) return quoted_where_needed(value.get<std::string>());
  return text_of(value);
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
    line += name;
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

void write_text(OutputFile& file, const std::string& text) {
  file.write(std::as_bytes(std::span(text)));
}

JsonListWriter::JsonListWriter(OutputFile& file, const Row& head, const std::string& list) : file_(file) {
  std::string begin = text_of(head);
  begin.pop_back();
  if (!head.empty()) begin += ",";
  write_text(file_, begin + "\"" + list + "\":[");
}

void JsonListWriter::add(const Row& element) {
  write_text(file_, (is_first_ ? "\n" : ",\n") + text_of(element));
  is_first_ = false;
}

void JsonListWriter::finish() {
  write_text(file_, "\n]}\n");
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

bool write_point_rows(const Row& rows, std::span<const glm::dvec3> positions, const std::string& list,
                      const Row& totals, RowForm form, const RowFileHead& head, const ToLonLat& to_lon_lat,
                      const std::filesystem::path& file, bool overwrite) {
  OutputFile output(file, overwrite);
  bool is_done = true;
  if (form == RowForm::csv) {
    write_text(output, csv_names(rows.front()));
    for (const Row& row : rows) write_text(output, csv_values(row));
  } else if (form == RowForm::json) {
    Row members = members_of(head);
    members.update(totals);
    JsonListWriter writer(output, members, list);
    for (const Row& row : rows) writer.add(row);
    writer.finish();
  } else {
    std::optional<std::vector<glm::dvec3>> on_earth;
    if (to_lon_lat) on_earth = to_lon_lat(positions);
    is_done = on_earth.has_value();
    if (on_earth) positions = *on_earth;
    Row members = geojson_head(head, is_done);
    members.update(totals);
    JsonListWriter features(output, members, "features");
    for (std::size_t i = 0; i < rows.size(); ++i)
      features.add(geojson_feature(positions.subspan(i, 1), rows[i]));
    features.finish();
  }
  output.commit();
  return is_done;
}

}  // namespace alidade::visibility
