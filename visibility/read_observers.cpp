// SPDX-License-Identifier: MIT
#include "visibility/read_observers.h"

#include <fmt/format.h>
#include <ogr_api.h>

#include <cmath>

#include "base/error.h"
#include "base/text_scanner.h"
#include "base/words.h"
#include "geo/vector_file.h"
#include "visibility/observer_fields.h"
#include "visibility/observer_table.h"

namespace alidade {
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
                                                 const ObserverReference& reference) {
  std::vector<GivenObserver> observers;
  const std::string wkt =
      read_vector_file(path, {.content = "observers", .expected = k_expected, .features = "points"},
                       [&](void* feature) { add_feature(feature, path, observers); });
  if (observers.empty())
    throw Error({.file = path.string(), .problem = "holds no observers", .expected = "a point for each"});
  to_cloud_reference(observers, wkt, reference);
  return observers;
}

}  // namespace

std::vector<GivenObserver> read_observers(const std::filesystem::path& path,
                                          const ObserverReference& reference) {
  const std::string ending = file_ending(path);
  if (ending != ".csv" && ending != ".txt") return read_vector_observers(path, reference);
  std::vector<GivenObserver> observers = read_observer_table(path);
  if (!reference.given.empty()) to_cloud_reference(observers, "", reference);
  return observers;
}

}  // namespace alidade
