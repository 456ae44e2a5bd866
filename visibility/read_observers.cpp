// SPDX-License-Identifier: MIT
#include "visibility/read_observers.h"

#include <fmt/format.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>
#include <ogrsf_frmts.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "octree/cloud/text_scanner.h"
#include "octree/error.h"
#include "renderer/gdal_handles.h"
#include "visibility/file_ending.h"
#include "visibility/observer_fields.h"
#include "visibility/observer_table.h"

namespace alidade {
namespace {

constexpr const char* k_expected = "CSV, GeoJSON, GeoPackage or Shapefile with points";

struct DestroyFeature {
  void operator()(void* feature) const { OGR_F_Destroy(feature); }
};
using Feature = std::unique_ptr<void, DestroyFeature>;

GdalDataset open_vector_file(const std::filesystem::path& path) {
  // Asked here, because GDAL takes many a text that is no file's name for something to read.
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    throw Error({.file = path.string(), .problem = "is no file", .expected = k_expected});
  RegisterOGRGeoJSON();
  RegisterOGRGeoPackage();
  RegisterOGRShape();
  const char* const drivers[] = {"GeoJSON", "GPKG", "ESRI Shapefile", nullptr};
  GdalDataset dataset(GDALOpenEx(path.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR,
                                 drivers, nullptr, nullptr));
  if (!dataset) {
    throw Error({.file = path.string(),
                 .problem = "cannot be read as observers",
                 .expected = k_expected,
                 .found = CPLGetLastErrorMsg()});
  }
  return dataset;
}

/// The only layer. Errors: none, or several.
OGRLayerH only_layer(const GdalDataset& dataset, const std::filesystem::path& path) {
  const int count = GDALDatasetGetLayerCount(dataset.get());
  if (count == 1) return GDALDatasetGetLayer(dataset.get(), 0);
  std::string names;
  for (int i = 0; i < count; ++i) {
    if (i > 0) names += ", ";
    names += OGR_L_GetName(GDALDatasetGetLayer(dataset.get(), i));
  }
  throw Error({.file = path.string(),
               .problem = count == 0 ? "holds no layer" : "holds several layers",
               .expected = "one layer of points",
               .found = count == 0 ? "nothing" : names});
}

std::string wkt_of_layer(OGRLayerH layer) {
  const OGRSpatialReferenceH reference = OGR_L_GetSpatialRef(layer);
  if (reference == nullptr) return "";
  char* text = nullptr;
  const char* const options[] = {"FORMAT=WKT2_2018", nullptr};
  OSRExportToWktEx(reference, &text, options);
  std::string wkt = text != nullptr ? text : "";
  CPLFree(text);
  return wkt;
}

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

std::vector<GivenObserver> read_vector_file(const std::filesystem::path& path,
                                            const ObserverReference& reference) {
  std::vector<GivenObserver> observers;
  std::string wkt;
  {
    const QuietGdal quiet;
    const GdalDataset dataset = open_vector_file(path);
    const OGRLayerH layer = only_layer(dataset, path);
    wkt = wkt_of_layer(layer);
    CPLErrorReset();
    OGR_L_ResetReading(layer);
    while (const Feature feature{OGR_L_GetNextFeature(layer)}) add_feature(feature.get(), path, observers);
    if (CPLGetLastErrorType() >= CE_Failure)
      throw Error({.file = path.string(), .problem = "is damaged", .found = CPLGetLastErrorMsg()});
  }
  if (observers.empty())
    throw Error({.file = path.string(), .problem = "holds no observers", .expected = "a point for each"});
  to_cloud_reference(observers, wkt, reference);
  return observers;
}

}  // namespace

std::vector<GivenObserver> read_observers(const std::filesystem::path& path,
                                          const ObserverReference& reference) {
  const std::string ending = file_ending(path);
  if (ending != ".csv" && ending != ".txt") return read_vector_file(path, reference);
  std::vector<GivenObserver> observers = read_observer_table(path);
  if (!reference.given.empty()) to_cloud_reference(observers, "", reference);
  return observers;
}

}  // namespace alidade
