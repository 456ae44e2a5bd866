// SPDX-License-Identifier: MIT
#include "visibility/read_observers.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <string_view>

#include "base/error.h"
#include "base/text_scanner.h"
#include "base/words.h"
#include "geo/gdal_reference.h"
#include "geo/vector_file.h"

namespace alidade::visibility {
namespace {

constexpr std::string_view k_form =
    "x,y[,z][,name][,height][,azimuth_min][,azimuth_max][,elevation_min][,elevation_max][,max_distance]";

/// What a column means: x, y and name by themselves, the others by their place in k_observer_fields.
constexpr std::size_t k_x = k_observer_fields.size(), k_y = k_x + 1, k_name = k_x + 2, k_unknown = k_x + 3;

std::size_t meaning_of(std::string_view name) {
  if (name == "x") return k_x;
  if (name == "y") return k_y;
  if (name == "name") return k_name;
  const auto field =
      std::ranges::find_if(k_observer_fields, [&](const ObserverField& one) { return one.is_called(name); });
  return field == k_observer_fields.end() ? k_unknown
                                          : static_cast<std::size_t>(field - k_observer_fields.begin());
}

std::vector<std::size_t> read_header(const TextScanner& scanner, std::string_view line) {
  std::vector<std::string_view> names;
  split_cells(line, ',', names);
  require_few_columns(scanner, names.size());
  if (parse_number(names.front())) scanner.fail("there is no header", std::string(k_form), quote(line));
  std::vector<std::size_t> columns;
  for (const std::string_view name : names) {
    const std::size_t meaning = meaning_of(name);
    if (meaning == k_unknown) scanner.fail("unknown column " + quote(name), "some of " + std::string(k_form));
    if (std::ranges::find(columns, meaning) != columns.end())
      scanner.fail(fmt::format("column {} stands twice", name));
    columns.push_back(meaning);
  }
  for (const auto& [meaning, name] : {std::pair(k_x, "x"), std::pair(k_y, "y")}) {
    if (std::ranges::find(columns, meaning) == columns.end())
      scanner.fail(fmt::format("column {} is missing", name), std::string(k_form));
  }
  return columns;
}

double number_in(const TextScanner& scanner, std::string_view cell, std::string_view column) {
  const std::optional<double> number = parse_number(cell);
  // Only a distance may be infinite, which check is made where observers get their place.
  if (!number || std::isnan(*number)) {
    scanner.fail(fmt::format("{} is not a number", column), "a number",
                 cell.empty() ? "nothing" : quote(cell));
  }
  return *number;
}

GivenObserver read_row(const TextScanner& scanner, std::string_view line,
                       const std::vector<std::size_t>& columns, const std::string& file) {
  std::vector<std::string_view> cells;
  split_cells(line, ',', cells);
  if (cells.size() != columns.size()) {
    scanner.fail(cells.size() > columns.size() ? "too many columns" : "too few columns",
                 std::to_string(columns.size()), std::to_string(cells.size()));
  }
  GivenObserver given{.source = fmt::format("{}:line {}", file, scanner.line_number())};
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (columns[i] == k_name)
      given.name = cells[i];
    else if (columns[i] == k_x)
      given.place.x = number_in(scanner, cells[i], "x");
    else if (columns[i] == k_y)
      given.place.y = number_in(scanner, cells[i], "y");
    else if (const ObserverField& field = k_observer_fields[columns[i]]; !cells[i].empty())
      given.*field.value = number_in(scanner, cells[i], field.name);
  }
  return given;
}

}  // namespace

std::vector<GivenObserver> read_observer_table(const std::filesystem::path& path) {
  InputFile file(path);
  return read_observer_table(file);
}

std::vector<GivenObserver> read_observer_table(InputFile& file) {
  TextScanner scanner(file);
  std::vector<std::size_t> columns;
  std::vector<GivenObserver> observers;
  while (const std::optional<std::string_view> line = scanner.next_line()) {
    if (trim(*line).empty()) continue;
    if (columns.empty())
      columns = read_header(scanner, *line);
    else
      observers.push_back(read_row(scanner, *line, columns, file.name()));
  }
  if (observers.empty()) {
    throw Error({.file = file.name(),
                 .problem = "holds no observers",
                 .expected = columns.empty() ? "CSV with the header " + std::string(k_form)
                                             : "a row for each behind the header"});
  }
  return observers;
}

void to_cloud_reference(std::vector<GivenObserver>& observers, const std::string& own,
                        const geo::ObserverReference& reference) {
  if (observers.empty()) return;
  const geo::GdalTransformation transformation =
      geo::transformation_to_cloud(own, reference, observers.front().source);
  if (!transformation) return;
  for (GivenObserver& observer : observers)
    observer.place = geo::transformed(observer.place, transformation, observer.source);
}

namespace {

constexpr const char* k_expected = "CSV, GeoJSON, GeoPackage or Shapefile with points";

/// Takes the attributes that are known.
void read_attributes(const geo::VectorFeature& feature, GivenObserver& observer) {
  if (const auto name = feature.field("name"); name && name->is_set) observer.name = name->text;
  for (const ObserverField& known : k_observer_fields) {
    std::optional<geo::VectorField> field = feature.field(known.name);
    if (!field) field = feature.field(known.short_name);
    if (!field || !field->is_set) continue;
    const std::optional<double> number = field->number ? field->number : parse_number(field->text);
    if (!number || std::isnan(*number)) {
      throw Error({.file = observer.source,
                   .problem = fmt::format("{} is not a number", known.name),
                   .expected = "a number",
                   .found = quote(field->text)});
    }
    observer.*known.value = *number;
  }
}

void add_feature(const geo::VectorFeature& feature, const std::filesystem::path& path,
                 std::vector<GivenObserver>& observers) {
  GivenObserver observer{.source = fmt::format("{}:feature {}", path.string(), feature.id())};
  const std::optional<std::vector<geo::VectorPoint>> points = feature.points();
  if (!points) {
    throw Error({.file = observer.source,
                 .problem = "is no point",
                 .expected = "a point for each observer",
                 .found = feature.geometry_type()});
  }
  read_attributes(feature, observer);
  for (const geo::VectorPoint& point : *points) {
    if (!std::isfinite(point.position.x) || !std::isfinite(point.position.y)) {
      throw Error({.file = observer.source,
                   .problem = "is a point without coordinates",
                   .expected = "finite numbers"});
    }
    GivenObserver& added = observers.emplace_back(observer);
    added.place = point.position;
    if (point.z) added.z = *point.z;
  }
}

std::vector<GivenObserver> read_vector_observers(const std::filesystem::path& path,
                                                 const geo::ObserverReference& reference) {
  std::vector<GivenObserver> observers;
  const std::string wkt = geo::read_vector_file(
      path, {.content = "observers", .expected = k_expected, .features = "points"},
      [&](void* feature) { add_feature(geo::VectorFeature(feature), path, observers); });
  if (observers.empty())
    throw Error({.file = path.string(), .problem = "holds no observers", .expected = "a point for each"});
  to_cloud_reference(observers, wkt, reference);
  return observers;
}

}  // namespace

std::vector<GivenObserver> read_observers(const std::filesystem::path& path,
                                          const geo::ObserverReference& reference) {
  const std::string ending = file_ending(path);
  if (ending != ".csv" && ending != ".txt") return read_vector_observers(path, reference);
  std::vector<GivenObserver> observers = read_observer_table(path);
  if (!reference.given.empty()) to_cloud_reference(observers, "", reference);
  return observers;
}

}  // namespace alidade::visibility
