// SPDX-License-Identifier: MIT
#include "visibility/lines/line_files.h"

#include "visibility/lines/line_row.h"

namespace alidade {
namespace {

void write_csv(const LineTable& table, OutputFile& file) {
  write_text(file, csv_names(line_row(table, 0)));
  for (std::size_t line = 0; line < table.pairs.size(); ++line)
    write_text(file, csv_values(line_row(table, line)));
}

void write_json(const LineTable& table, const RowFileHead& head, OutputFile& file) {
  JsonListWriter lines(file, members_of(head), "lines");
  for (std::size_t line = 0; line < table.pairs.size(); ++line) {
    Row row = line_row(table, line);
    if (table.reports[line].fresnel) row["obstructions"] = line_obstructions(table, line);
    lines.add(row);
  }
  lines.finish();
}

/// Where a line is cut: its first end, where it is blocked if that lies between, its second end.
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
  std::vector<glm::dvec3> places;
  std::vector<std::size_t> ends;
  for (std::size_t line = 0; line < table.pairs.size(); ++line) {
    const std::vector<glm::dvec3> joints = joints_of(table, line);
    places.insert(places.end(), joints.begin(), joints.end());
    ends.push_back(places.size());
  }
  std::optional<std::vector<glm::dvec3>> on_earth;
  if (to_lon_lat) on_earth = to_lon_lat(places);
  if (on_earth) places = *on_earth;
  JsonListWriter features(file, geojson_head(head, on_earth.has_value()), "features");
  for (std::size_t line = 0, place = 0; line < table.pairs.size(); ++line) {
    Row properties = line_row(table, line);
    const LineReport& report = table.reports[line];
    // A line that is blocked at its very start has no visible part.
    bool is_visible = !report.blocker || report.blocker->distance > 0.0;
    for (; place + 1 < ends[line]; ++place) {
      properties["visible"] = is_visible;
      features.add(geojson_feature(std::span(places).subspan(place, 2), properties));
      is_visible = false;
    }
    ++place;
  }
  features.finish();
  return on_earth.has_value();
}

}  // namespace

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

}  // namespace alidade
