// SPDX-License-Identifier: MIT
#include "geo/vector_file.h"

#include <ogr_api.h>
#include <ogr_srs_api.h>
#include <ogrsf_frmts.h>
#include <limits>
#include <memory>

#include "base/error.h"
#include "geo/gdal_reference.h"

namespace alidade::geo {
namespace {

GdalDataset open_vector_file(const std::filesystem::path& path, const VectorContent& content) {
  // Tested here, because GDAL interprets many a text that is not the name of a file as something to read.
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw file_error(path, "not a file", content.expected);
  RegisterOGRGeoJSON();
  RegisterOGRGeoPackage();
  RegisterOGRShape();
  const char* const drivers[] = {"GeoJSON", "GPKG", "ESRI Shapefile", nullptr};
  GdalDataset dataset(GDALOpenEx(path.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR,
                                 drivers, nullptr, nullptr));
  if (!dataset)
    throw file_error(path, "cannot read it as " + content.content, content.expected, CPLGetLastErrorMsg());
  return dataset;
}

/// The only layer. Errors: none, or several.
OGRLayerH only_layer(const GdalDataset& dataset, const std::filesystem::path& path,
                     const VectorContent& content) {
  const int count = GDALDatasetGetLayerCount(dataset.get());
  if (count == 1) return GDALDatasetGetLayer(dataset.get(), 0);
  std::string names;
  for (int i = 0; i < count; ++i) {
    if (i > 0) names += ", ";
    names += OGR_L_GetName(GDALDatasetGetLayer(dataset.get(), i));
  }
  throw file_error(path, count == 0 ? "contains no layer" : "contains several layers",
                   "one layer of " + content.features, count == 0 ? "nothing" : names);
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

VectorPoint point_of(OGRGeometryH geometry) {
  VectorPoint point{.position = {OGR_G_GetX(geometry, 0), OGR_G_GetY(geometry, 0)}};
  if (OGR_G_Is3D(geometry) != 0) point.z = OGR_G_GetZ(geometry, 0);
  if (OGR_G_IsEmpty(geometry) != 0) point.position.x = std::numeric_limits<double>::quiet_NaN();
  return point;
}

}  // namespace

long long VectorFeature::id() const {
  return OGR_F_GetFID(feature_);
}

std::string VectorFeature::geometry_type() const {
  const OGRGeometryH geometry = OGR_F_GetGeometryRef(feature_);
  return geometry != nullptr ? OGRGeometryTypeToName(wkbFlatten(OGR_G_GetGeometryType(geometry)))
                             : "no geometry";
}

std::optional<std::vector<VectorPoint>> VectorFeature::points() const {
  const OGRGeometryH geometry = OGR_F_GetGeometryRef(feature_);
  const OGRwkbGeometryType type = geometry != nullptr ? wkbFlatten(OGR_G_GetGeometryType(geometry)) : wkbNone;
  if (type == wkbPoint) return std::vector{point_of(geometry)};
  if (type != wkbMultiPoint) return std::nullopt;
  std::vector<VectorPoint> points;
  for (int i = 0; i < OGR_G_GetGeometryCount(geometry); ++i)
    points.push_back(point_of(OGR_G_GetGeometryRef(geometry, i)));
  return points;
}

std::optional<VectorField> VectorFeature::field(std::string_view name) const {
  const int index = OGR_F_GetFieldIndex(feature_, std::string(name).c_str());
  if (index < 0) return std::nullopt;
  if (!OGR_F_IsFieldSetAndNotNull(feature_, index)) return VectorField{};
  VectorField field{.is_set = true, .text = OGR_F_GetFieldAsString(feature_, index)};
  const OGRFieldType type = OGR_Fld_GetType(OGR_F_GetFieldDefnRef(feature_, index));
  if (type == OFTInteger || type == OFTInteger64 || type == OFTReal)
    field.number = OGR_F_GetFieldAsDouble(feature_, index);
  return field;
}

std::string read_vector_file(const std::filesystem::path& path, const VectorContent& content,
                             const std::function<void(void* feature)>& take) {
  const QuietGdal quiet;
  const GdalDataset dataset = open_vector_file(path, content);
  const OGRLayerH layer = only_layer(dataset, path, content);
  CPLErrorReset();
  OGR_L_ResetReading(layer);
  while (const GdalHandle<OGR_F_Destroy> feature{OGR_L_GetNextFeature(layer)}) take(feature.get());
  if (CPLGetLastErrorType() >= CE_Failure) throw file_error(path, "corrupt file", {}, CPLGetLastErrorMsg());
  return wkt_of_layer(layer);
}

}  // namespace alidade::geo
