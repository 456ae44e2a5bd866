// SPDX-License-Identifier: MIT
#include "visibility/lines/line_files.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string_view>

#include "base/csv_table.h"

namespace alidade::visibility {
namespace {

constexpr std::string_view k_form =
    "from,to, or from_x,from_y,to_x,to_y[,from_z][,to_z][,from_height][,to_height][,from][,to]";

/// The columns of an end; the first end's columns are before the second's.
enum Column { name_column, x_column, y_column, z_column, height_column, k_end_columns };
constexpr std::array<std::string_view, 2 * k_end_columns> k_columns{
    "from", "from_x", "from_y", "from_z", "from_height", "to", "to_x", "to_y", "to_z", "to_height"};

std::optional<std::size_t> column_of(std::string_view name) {
  const auto found = std::ranges::find(k_columns, name);
  if (found == k_columns.end()) return {};
  return static_cast<std::size_t>(found - k_columns.begin());
}

void check_columns(const CsvTable& table) {
  bool any_position = false, all_positions = true, all_names = true;
  for (const std::size_t end : {std::size_t{0}, std::size_t{k_end_columns}}) {
    all_positions = all_positions && table.has(end + x_column) && table.has(end + y_column);
    all_names = all_names && table.has(end + name_column);
    for (std::size_t column = x_column; column < k_end_columns; ++column)
      any_position = any_position || table.has(end + column);
  }
  if (any_position ? !all_positions : !all_names) table.fail("missing columns", std::string(k_form));
}

void take_cell(const CsvTable& table, std::size_t column, std::string_view cell, GivenPair& pair) {
  GivenObserver& end = column < k_end_columns ? pair.from : pair.to;
  const std::size_t meaning = column % k_end_columns;
  if (meaning == name_column) {
    end.name = cell;
    return;
  }
  if (cell.empty() && (meaning == z_column || meaning == height_column)) return;
  const std::optional<double> number = parse_number(cell);
  if (!number || !std::isfinite(*number))
    table.fail(fmt::format("invalid {}", k_columns[column]), "a finite number",
               cell.empty() ? "nothing" : quote(cell));
  if (meaning == x_column) end.position.x = *number;
  if (meaning == y_column) end.position.y = *number;
  if (meaning == z_column) end.z = *number;
  if (meaning == height_column) end.height = *number;
}

GivenPair read_row(const CsvTable& table) {
  GivenPair pair;
  pair.from.source = pair.to.source = table.source();
  pair.has_positions = table.has(x_column);
  for (std::size_t i = 0; i < table.cells().size(); ++i)
    take_cell(table, table.columns()[i], table.cells()[i], pair);
  if (!pair.has_positions && (pair.from.name.empty() || pair.to.name.empty()))
    table.fail("missing endpoint name", "the names of two positions");
  return pair;
}

void add_position(Row& row, const std::string& name, const glm::dvec3& position) {
  row[name + "_x"] = position.x;
  row[name + "_y"] = position.y;
  row[name + "_z"] = position.z;
}

void write_csv(const LineTable& table, OutputFile& file) {
  file.write(csv_names(line_row(table, 0)));
  for (std::size_t line = 0; line < table.pairs.size(); ++line) file.write(csv_values(line_row(table, line)));
}

void write_json(const LineTable& table, const RowFileHead& head, OutputFile& file) {
  JsonListWriter lines(file, members_of(head), "lines");
  for (std::size_t line = 0; line < table.pairs.size(); ++line) {
    Row row = line_row(table, line);
    for (const auto& measure : table.measures) measure->add_members(line, table.classifications, row);
    lines.add(row);
  }
  lines.finish();
}

/// The first end of a line, where it is blocked if that is between the ends, and its second end.
std::vector<glm::dvec3> joints_of(const LineTable& table, std::size_t line) {
  const glm::dvec3 from = table.pairs[line].from.position, to = table.pairs[line].to.position;
  const LineReport& report = table.reports[line];
  std::vector<glm::dvec3> joints{from};
  if (report.blocker && report.blocker->distance > 0.0 && report.blocker->distance < report.length)
    joints.push_back(from + report.blocker->distance / report.length * (to - from));
  joints.push_back(to);
  return joints;
}

bool write_geojson(const LineTable& table, const RowFileHead& head, const ToLonLat& to_lon_lat,
                   OutputFile& file) {
  std::vector<glm::dvec3> positions;
  std::vector<std::size_t> ends;
  for (std::size_t line = 0; line < table.pairs.size(); ++line) {
    const std::vector<glm::dvec3> joints = joints_of(table, line);
    positions.insert(positions.end(), joints.begin(), joints.end());
    ends.push_back(positions.size());
  }
  std::optional<std::vector<glm::dvec3>> on_earth;
  if (to_lon_lat) on_earth = to_lon_lat(positions);
  if (on_earth) positions = *on_earth;
  JsonListWriter features(file, geojson_head(head, on_earth.has_value()), "features");
  for (std::size_t line = 0, joint = 0; line < table.pairs.size(); ++line) {
    Row properties = line_row(table, line);
    const LineReport& report = table.reports[line];
    // A line that is blocked at its very start has no visible part.
    bool is_visible = !report.blocker || report.blocker->distance > 0.0;
    for (; joint + 1 < ends[line]; ++joint) {
      properties["visible"] = is_visible;
      features.add(geojson_feature(std::span(positions).subspan(joint, 2), properties));
      is_visible = false;
    }
    ++joint;
  }
  features.finish();
  return on_earth.has_value();
}

}  // namespace

Row line_row(const LineTable& table, std::size_t line) {
  const LinePair& pair = table.pairs[line];
  const LineReport& report = table.reports[line];
  Row row;
  row["line"] = line;
  row["from"] = pair.from_name;
  row["to"] = pair.to_name;
  add_position(row, "from", pair.from.position);
  add_position(row, "to", pair.to.position);
  row["length"] = report.length;
  row["visible"] = !report.blocker;
  if (!table.unscanned.empty()) row["unscanned"] = table.unscanned[line];
  const std::optional<Blocker>& blocker = report.blocker;
  row["blocker"] = blocker ? id_value(blocker->point_id) : Row();
  row["blocker_class"] = blocker ? class_value(table.classifications, blocker->point_id) : Row();
  row["blocker_at"] = blocker ? Row(blocker->distance) : Row();
  for (int axis = 0; axis < 3; ++axis)
    row[std::string("blocker_") + "xyz"[axis]] = blocker ? Row(blocker->position[axis]) : Row();
  row["clearance"] = report.nearest ? Row(report.nearest->distance) : Row();
  add_point(row, "clearance", report.nearest, table.classifications);
  for (const auto& measure : table.measures) measure->add_columns(line, table.classifications, row);
  return row;
}

std::vector<GivenPair> read_pair_table(const std::filesystem::path& path) {
  InputFile file(path);
  CsvTable table(file, column_of, std::string(k_form));
  if (!table.columns().empty()) check_columns(table);
  std::vector<GivenPair> pairs;
  while (table.next()) pairs.push_back(read_row(table));
  if (pairs.empty()) table.fail_as_empty("pairs");
  return pairs;
}

bool write_lines(const LineTable& table, RowForm form, const RowFileHead& head, const ToLonLat& to_lon_lat,
                 const std::filesystem::path& file, bool overwrite) {
  OutputFile output(file, overwrite);
  bool is_done = true;
  if (form == RowForm::csv) write_csv(table, output);
  if (form == RowForm::json) write_json(table, head, output);
  if (form == RowForm::geojson) is_done = write_geojson(table, head, to_lon_lat, output);
  output.commit();
  return is_done;
}

}  // namespace alidade::visibility
