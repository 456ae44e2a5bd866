// SPDX-License-Identifier: MIT
#include "visibility/read_observers.h"

#include <fmt/format.h>
#include <ogr_api.h>
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
void read_attributes(OGRFeatureH feature, GivenObserver& observer) {
  const auto field_of = [&](std::string_view name) {
    return OGR_F_GetFieldIndex(feature, std::string(name).c_str());
  };
  if (const int name = field_of("name"); name >= 0 && OGR_F_IsFieldSetAndNotNull(feature, name))
    observer.name = OGR_F_GetFieldAsString(feature, name);
  for (const ObserverField& field : k_observer_fields) {
    int index = field_of(field.name);
    if (index < 0) index = field_of(field.short_name);
    if (index < 0 || !OGR_F_IsFieldSetAndNotNull(feature, index)) continue;
    const OGRFieldType type = OGR_Fld_GetType(OGR_F_GetFieldDefnRef(feature, index));
    const bool is_number = type == OFTInteger || type == OFTInteger64 || type == OFTReal;
    const std::string text = OGR_F_GetFieldAsString(feature, index);
    const std::optional<double> number =
        is_number ? OGR_F_GetFieldAsDouble(feature, index) : parse_number(text);
    if (!number || std::isnan(*number)) {
      throw Error({.file = observer.source,
                   .problem = fmt::format("{} is not a number", field.name),
                   .expected = "a number",
                   .found = quote(text)});
    }
    observer.*field.value = *number;
  }
}

void add_point(OGRGeometryH point, GivenObserver observer, std::vector<GivenObserver>& observers) {
  observer.place = {OGR_G_GetX(point, 0), OGR_G_GetY(point, 0)};
  if (OGR_G_Is3D(point) != 0) observer.z = OGR_G_GetZ(point, 0);
  if (OGR_G_IsEmpty(point) != 0 || !std::isfinite(observer.place.x) || !std::isfinite(observer.place.y)) {
    throw Error(
        {.file = observer.source, .problem = "is a point without coordinates", .expected = "finite numbers"});
  }
  observers.push_back(std::move(observer));
}

void add_feature(OGRFeatureH feature, const std::filesystem::path& path,
                 std::vector<GivenObserver>& observers) {
  GivenObserver observer{.source = fmt::format("{}:feature {}", path.string(), OGR_F_GetFID(feature))};
  const OGRGeometryH geometry = OGR_F_GetGeometryRef(feature);
  const OGRwkbGeometryType type = geometry != nullptr ? wkbFlatten(OGR_G_GetGeometryType(geometry)) : wkbNone;
  if (type != wkbPoint && type != wkbMultiPoint) {
    throw Error({.file = observer.source,
                 .problem = "is no point",
                 .expected = "a point for each observer",
                 .found = geometry != nullptr ? OGRGeometryTypeToName(type) : "no geometry"});
  }
  read_attributes(feature, observer);
  if (type == wkbPoint) return add_point(geometry, std::move(observer), observers);
  for (int i = 0; i < OGR_G_GetGeometryCount(geometry); ++i)
    add_point(OGR_G_GetGeometryRef(geometry, i), observer, observers);
}

std::vector<GivenObserver> read_vector_observers(const std::filesystem::path& path,
                                                 const geo::ObserverReference& reference) {
  std::vector<GivenObserver> observers;
  const std::string wkt =
      geo::read_vector_file(path, {.content = "observers", .expected = k_expected, .features = "points"},
                            [&](void* feature) { add_feature(feature, path, observers); });
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
