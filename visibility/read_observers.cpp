// SPDX-License-Identifier: MIT
#include "visibility/read_observers.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "base/csv_table.h"
#include "base/error.h"
#include "base/words.h"

namespace alidade::visibility {
namespace {

constexpr std::string_view k_form =
    "x,y[,z][,name][,height][,azimuth_min][,azimuth_max][,elevation_min][,elevation_max][,max_distance]";

/// Meanings of columns: these, or an index in k_observer_fields.
constexpr std::size_t k_x = k_observer_fields.size(), k_y = k_x + 1, k_name = k_x + 2;

std::optional<std::size_t> meaning_of(std::string_view name) {
  if (name == "x") return k_x;
  if (name == "y") return k_y;
  if (name == "name") return k_name;
  const auto field =
      std::ranges::find_if(k_observer_fields, [&](const ObserverField& one) { return one.is_called(name); });
  if (field == k_observer_fields.end()) return {};
  return static_cast<std::size_t>(field - k_observer_fields.begin());
}

double number_in(const CsvTable& table, std::string_view cell, std::string_view column) {
  const std::optional<double> number = parse_number(cell);
  // Only a distance may be infinite; place_observers() checks that.
  if (!number || std::isnan(*number))
    table.fail(fmt::format("invalid {}", column), "a number", cell.empty() ? "nothing" : quote(cell));
  return *number;
}

GivenObserver read_row(const CsvTable& table) {
  GivenObserver given{.source = table.source()};
  for (std::size_t i = 0; i < table.cells().size(); ++i) {
    const std::size_t column = table.columns()[i];
    const std::string_view cell = table.cells()[i];
    if (column == k_name)
      given.name = cell;
    else if (column == k_x)
      given.position.x = number_in(table, cell, "x");
    else if (column == k_y)
      given.position.y = number_in(table, cell, "y");
    else if (const ObserverField& field = k_observer_fields[column]; !cell.empty())
      given.*field.value = number_in(table, cell, field.name);
  }
  return given;
}

constexpr const char* k_expected = "CSV, GeoJSON, GeoPackage or Shapefile with points";

/// Takes the attributes that observers have.
void read_attributes(const geo::VectorFeature& feature, GivenObserver& observer) {
  if (const auto name = feature.field("name"); name && name->is_set) observer.name = name->text;
  for (const ObserverField& known : k_observer_fields) {
    std::optional<geo::VectorField> field = feature.field(known.name);
    if (!field) field = feature.field(known.short_name);
    if (!field || !field->is_set) continue;
    const std::optional<double> number = field->number ? field->number : parse_number(field->text);
    if (!number || std::isnan(*number)) {
      throw Error(observer.source, {}, fmt::format("invalid {}", known.name), "a number", quote(field->text));
    }
    observer.*known.value = *number;
  }
}

/// An observer moved to a point of its feature.
GivenObserver moved_to(const geo::VectorPoint& point, GivenObserver given) {
  if (!std::isfinite(point.position.x) || !std::isfinite(point.position.y))
    throw Error({.file = given.source, .problem = "point without coordinates", .expected = "finite numbers"});
  given.position = point.position;
  if (point.z) given.z = *point.z;
  return given;
}

void add_feature(const geo::VectorFeature& feature, const std::filesystem::path& path,
                 std::vector<GivenObserver>& observers) {
  GivenObserver observer{.source = fmt::format("{}:feature {}", path.string(), feature.id())};
  const std::optional<std::vector<geo::VectorPoint>> points = feature.points();
  if (!points) {
    throw Error(observer.source, {}, "unsupported geometry", "a point for each observer",
                feature.geometry_type());
  }
  read_attributes(feature, observer);
  for (const geo::VectorPoint& point : *points) observers.push_back(moved_to(point, observer));
}

/// Adds the points of a feature as objects, or its lines and polygons as one.
void add_feature(const geo::VectorFeature& feature, const std::filesystem::path& path,
                 GivenObjects& objects) {
  GivenObserver corner{.source = fmt::format("{}:feature {}", path.string(), feature.id())};
  read_attributes(feature, corner);
  if (const std::optional<std::vector<geo::VectorPoint>> points = feature.points()) {
    for (const geo::VectorPoint& point : *points) objects.add_segment(moved_to(point, corner));
    return;
  }
  const std::optional<std::vector<geo::VectorPath>> paths = feature.paths();
  if (!paths) {
    throw Error(corner.source, {}, "unsupported geometry", "points, lines or polygons",
                feature.geometry_type());
  }
  const std::size_t number = objects.count();
  for (const geo::VectorPath& line : *paths) {
    // The walls of a courtyard are not visible from outside.
    if (line.points.empty() || line.is_hole) continue;
    ObjectPart part{.object = number, .shape = ObjectShape::wall, .begin = objects.corners.size()};
    if (line.is_ring) part.shape = ObjectShape::outline;
    for (const geo::VectorPoint& point : line.points) objects.corners.push_back(moved_to(point, corner));
    part.end = objects.corners.size();
    objects.parts.push_back(part);
  }
}

std::vector<GivenObserver> read_vector_observers(const std::filesystem::path& path,
                                                 const geo::ObserverReference& reference) {
  std::vector<GivenObserver> observers;
  const std::string wkt = geo::read_vector_file(
      path, {.content = "observers", .expected = k_expected, .features = "points"},
      [&](void* feature) { add_feature(geo::VectorFeature(feature), path, observers); });
  if (observers.empty())
    throw Error({.file = path.string(), .problem = "contains no observers", .expected = "a point for each"});
  to_cloud_reference(observers, wkt, reference);
  return observers;
}

}  // namespace

std::vector<GivenObserver> read_observer_table(const std::filesystem::path& path) {
  InputFile file(path);
  return read_observer_table(file);
}

std::vector<GivenObserver> read_observer_table(InputFile& file) {
  CsvTable table(file, meaning_of, std::string(k_form));
  for (const auto& [column, name] : {std::pair(k_x, "x"), std::pair(k_y, "y")}) {
    if (!table.columns().empty() && !table.has(column))
      table.fail(fmt::format("missing column {}", name), std::string(k_form));
  }
  std::vector<GivenObserver> observers;
  while (table.next()) observers.push_back(read_row(table));
  if (observers.empty()) table.fail_as_empty("observers");
  return observers;
}

void to_cloud_reference(std::vector<GivenObserver>& observers, const std::string& own,
                        const geo::ObserverReference& reference) {
  if (observers.empty()) return;
  const geo::MoveToCloud move = geo::move_to_cloud(own, reference, observers.front().source);
  if (!move) return;
  for (GivenObserver& observer : observers) observer.position = move(observer.position, observer.source);
}

std::vector<GivenObserver> read_observers(const std::filesystem::path& path,
                                          const geo::ObserverReference& reference) {
  if (!has_extension(path, {".csv", ".txt"})) return read_vector_observers(path, reference);
  std::vector<GivenObserver> observers = read_observer_table(path);
  if (!reference.given.empty()) to_cloud_reference(observers, "", reference);
  return observers;
}

GivenObjects read_objects(const std::filesystem::path& path, const geo::ObserverReference& reference) {
  GivenObjects objects;
  std::string wkt;
  const bool is_table = has_extension(path, {".csv", ".txt"});
  if (is_table) {
    for (const GivenObserver& row : read_observer_table(path)) objects.add_segment(row);
  } else {
    wkt = geo::read_vector_file(
        path,
        {.content = "objects",
         .expected = "CSV, GeoJSON, GeoPackage or Shapefile with points, lines or polygons",
         .features = "objects"},
        [&](void* feature) { add_feature(geo::VectorFeature(feature), path, objects); });
  }
  if (objects.parts.empty()) throw file_error(path, "contains no objects", "points, lines or polygons");
  if (!is_table || !reference.given.empty()) to_cloud_reference(objects.corners, wkt, reference);
  return objects;
}

}  // namespace alidade::visibility
