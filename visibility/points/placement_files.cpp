// SPDX-License-Identifier: MIT
#include "visibility/points/placement_files.h"

#include "visibility/row_text.h"

namespace alidade {
namespace {

std::vector<Row> rows_of(const Placement& placement, std::span<const Observer> candidates) {
  std::vector<Row> rows;
  for (const ChosenPlace& place : placement.places) {
    const Observer& observer = candidates[place.candidate];
    Row row;
    row["place"] = rows.size() + 1;
    row["candidate"] = place.candidate;
    row["name"] = observer.name;
    row["x"] = observer.position.x;
    row["y"] = observer.position.y;
    row["z"] = observer.position.z;
    row["gain"] = place.gain;
    row["covered"] = place.covered;
    row["share"] = place.covered / placement.total;
    rows.push_back(row);
  }
  return rows;
}

Row members_with_totals(Row members, const Placement& placement) {
  members["total"] = placement.total;
  members["best_possible"] = placement.best_possible;
  return members;
}

bool write_geojson(const Placement& placement, const std::vector<Row>& rows,
                   std::span<const Observer> candidates, const RowFileHead& head, const ToLonLat& to_lon_lat,
                   OutputFile& file) {
  std::vector<glm::dvec3> places;
  for (const ChosenPlace& place : placement.places) places.push_back(candidates[place.candidate].position);
  std::optional<std::vector<glm::dvec3>> on_earth;
  if (to_lon_lat) on_earth = to_lon_lat(places);
  if (on_earth) places = *on_earth;
  JsonListWriter features(file, members_with_totals(geojson_head(head, on_earth.has_value()), placement),
                          "features");
  for (std::size_t i = 0; i < rows.size(); ++i)
    features.add(geojson_feature(std::span(places).subspan(i, 1), rows[i]));
  features.finish();
  return on_earth.has_value();
}

}  // namespace

bool write_placement(const Placement& placement, std::span<const Observer> candidates, RowForm form,
                     const RowFileHead& head, const ToLonLat& to_lon_lat, const std::filesystem::path& file,
                     bool overwrite) {
  const std::vector<Row> rows = rows_of(placement, candidates);
  OutputFile output(file, overwrite);
  bool is_done = true;
  if (form == RowForm::csv) {
    write_text(output, "place,candidate,name,x,y,z,gain,covered,share\n");
    for (const Row& row : rows) write_text(output, csv_values(row));
  } else if (form == RowForm::json) {
    JsonListWriter places(output, members_with_totals(members_of(head), placement), "places");
    for (const Row& row : rows) places.add(row);
    places.finish();
  } else {
    is_done = write_geojson(placement, rows, candidates, head, to_lon_lat, output);
  }
  output.commit();
  return is_done;
}

}  // namespace alidade
