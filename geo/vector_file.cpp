// SPDX-License-Identifier: MIT
#include "geo/vector_file.h"

#include <fmt/format.h>
#include <cmath>
#include <limits>
#include <memory>

#include "base/error.h"
#include "geo/gdal_reference.h"

namespace alidade::geo {
namespace {

GdalDataset open_vector_file(const std::filesystem::path& path, const VectorContent& content) {
  // Tested here, because GDAL opens many texts that are not names of files.
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw file_error(path, "not a file", content.expected);
  RegisterOGRGeoJSON();
  RegisterOGRGeoPackage();
  RegisterOGRShape();
  const char* const drivers[] = {"GeoJSON", "GPKG", "ESRI Shapefile", nullptr};
  GdalDataset dataset(GDALOpenEx(path.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR,
                                 drivers, nullptr, nullptr));
  if (!dataset)
    throw file_error(path, "cannot read the file as " + content.content, content.expected,
                     CPLGetLastErrorMsg());
  return dataset;
}

/// wkbNone for null.
OGRwkbGeometryType type_of(OGRGeometryH geometry) {
  return geometry != nullptr ? wkbFlatten(OGR_G_GetGeometryType(geometry)) : wkbNone;
}

std::string type_name(OGRGeometryH geometry) {
  return geometry != nullptr ? OGRGeometryTypeToName(type_of(geometry)) : "no geometry";
}

/// The only layer. Errors: none, or several.
OGRLayerH only_layer(const GdalDataset& dataset, const std::filesystem::path& path,
                     const VectorContent& content) {
  const int count = GDALDatasetGetLayerCount(dataset.get());
  if (count == 1) return GDALDatasetGetLayer(dataset.get(), 0);
  std::string names;
  for (int i = 0; i < count; ++i)
    names += (i > 0 ? ", " : "") + std::string(OGR_L_GetName(GDALDatasetGetLayer(dataset.get(), i)));
  throw file_error(path, count == 0 ? "contains no layer" : "contains several layers",
                   "one layer of " + content.features, count == 0 ? "nothing" : names);
}

std::string wkt_of_layer(OGRLayerH layer) {
  const OGRSpatialReferenceH reference = OGR_L_GetSpatialRef(layer);
  if (reference == nullptr) return "";
  return wkt_in_format(reference, "FORMAT=WKT2_2018");
}

/// The point of that number.
VectorPoint point_of(OGRGeometryH geometry, int number = 0) {
  VectorPoint point{.position = {OGR_G_GetX(geometry, number), OGR_G_GetY(geometry, number)}};
  if (OGR_G_Is3D(geometry) != 0) point.z = OGR_G_GetZ(geometry, number);
  if (OGR_G_IsEmpty(geometry) != 0) point.position.x = std::numeric_limits<double>::quiet_NaN();
  return point;
}

VectorPath path_of(OGRGeometryH line, bool is_ring, bool is_hole) {
  VectorPath path{.points = {}, .is_ring = is_ring, .is_hole = is_hole};
  const int count = OGR_G_GetPointCount(line) - (is_ring ? 1 : 0);
  for (int i = 0; i < count; ++i) path.points.push_back(point_of(line, i));
  return path;
}

/// Whether they are lines and polygons.
bool add_paths(OGRGeometryH geometry, std::vector<VectorPath>& paths) {
  const OGRwkbGeometryType type = type_of(geometry);
  if (type == wkbLineString) {
    paths.push_back(path_of(geometry, false, false));
    return true;
  }
  const bool is_polygon = type == wkbPolygon;
  if (!is_polygon && type != wkbMultiLineString && type != wkbMultiPolygon && type != wkbGeometryCollection)
    return false;
  for (int i = 0; i < OGR_G_GetGeometryCount(geometry); ++i) {
    const OGRGeometryH part = OGR_G_GetGeometryRef(geometry, i);
    if (is_polygon)
      paths.push_back(path_of(part, true, i > 0));
    else if (!add_paths(part, paths))
      return false;
  }
  return true;
}

/// A copy without arcs; null of null.
GdalHandle<OGR_G_DestroyGeometry> without_arcs(OGRGeometryH geometry) {
  return GdalHandle<OGR_G_DestroyGeometry>(
      geometry != nullptr ? OGR_G_GetLinearGeometry(geometry, 0.0, nullptr) : nullptr);
}

void add_polygon(OGRGeometryH polygon, const std::string& source, std::vector<PlanePolygon>& polygons) {
  PlanePolygon& added = polygons.emplace_back();
  for (int i = 0; i < OGR_G_GetGeometryCount(polygon); ++i) {
    const OGRGeometryH ring = OGR_G_GetGeometryRef(polygon, i);
    std::vector<glm::dvec2>& corners = added.rings.emplace_back();
    for (int corner = 0; corner < OGR_G_GetPointCount(ring); ++corner) {
      const glm::dvec2 position{OGR_G_GetX(ring, corner), OGR_G_GetY(ring, corner)};
      if (!std::isfinite(position.x) || !std::isfinite(position.y))
        throw file_error(source, "a vertex is not finite", "finite numbers");
      corners.push_back(position);
    }
  }
}

void add_polygons(OGRGeometryH geometry, const std::string& source, std::vector<PlanePolygon>& polygons) {
  const OGRwkbGeometryType type = type_of(geometry);
  if (type == wkbPolygon) return add_polygon(geometry, source, polygons);
  if (type != wkbMultiPolygon && type != wkbGeometryCollection)
    throw file_error(source, "unsupported geometry", "polygons", type_name(geometry));
  for (int i = 0; i < OGR_G_GetGeometryCount(geometry); ++i)
    add_polygons(OGR_G_GetGeometryRef(geometry, i), source, polygons);
}

}  // namespace

long long VectorFeature::id() const {
  return OGR_F_GetFID(feature_);
}

std::string VectorFeature::geometry_type() const {
  return type_name(OGR_F_GetGeometryRef(feature_));
}

std::optional<std::vector<VectorPoint>> VectorFeature::points() const {
  const OGRGeometryH geometry = OGR_F_GetGeometryRef(feature_);
  const OGRwkbGeometryType type = type_of(geometry);
  if (type == wkbPoint) return std::vector{point_of(geometry)};
  if (type != wkbMultiPoint) return std::nullopt;
  std::vector<VectorPoint> points;
  for (int i = 0; i < OGR_G_GetGeometryCount(geometry); ++i)
    points.push_back(point_of(OGR_G_GetGeometryRef(geometry, i)));
  return points;
}

std::optional<std::vector<VectorPath>> VectorFeature::paths() const {
  std::vector<VectorPath> paths;
  if (!add_paths(without_arcs(OGR_F_GetGeometryRef(feature_)).get(), paths)) return std::nullopt;
  return paths;
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
  if (CPLGetLastErrorType() >= CE_Failure)
    throw file_error(path, std::string("corrupt file: ") + CPLGetLastErrorMsg());
  return wkt_of_layer(layer);
}

MoveToCloud move_to_cloud(const std::string& own, const ObserverReference& reference,
                          const std::string& source) {
  const auto transformation =
      std::make_shared<const GdalTransformation>(transformation_to_cloud(own, reference, source));
  if (!*transformation) return nullptr;
  return [transformation](const glm::dvec2& position, const std::string& owner) {
    const QuietGdal quiet;
    const std::optional<glm::dvec2> image = transformed(position, *transformation);
    if (image) return *image;
    throw file_error(owner, "cannot transform a position to the cloud's reference system", {},
                     fmt::format("{}, {}", position.x, position.y));
  };
}

std::vector<PlanePolygon> read_polygons(const std::filesystem::path& path,
                                        const ObserverReference& reference) {
  std::vector<PlanePolygon> polygons;
  const auto take = [&](void* feature) {
    const std::string source = fmt::format("{}:feature {}", path.string(), OGR_F_GetFID(feature));
    add_polygons(without_arcs(OGR_F_GetGeometryRef(feature)).get(), source, polygons);
  };
  const std::string wkt = read_vector_file(path,
                                           {.content = "polygons",
                                            .expected = "GeoJSON, GeoPackage or Shapefile with polygons",
                                            .features = "polygons"},
                                           take);
  std::erase_if(polygons, [](const PlanePolygon& polygon) { return polygon.rings.empty(); });
  if (polygons.empty()) throw file_error(path, "contains no polygons", "at least one");
  const MoveToCloud move = move_to_cloud(wkt, reference, path.string());
  if (!move) return polygons;
  for (PlanePolygon& polygon : polygons) {
    for (std::vector<glm::dvec2>& ring : polygon.rings) {
      for (glm::dvec2& corner : ring) corner = move(corner, path.string());
    }
  }
  return polygons;
}

}  // namespace alidade::geo
