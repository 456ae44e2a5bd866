// SPDX-License-Identifier: MIT
#include "geo/geopackage.h"

#include <fmt/format.h>
#include <cassert>

#include "base/output_file.h"
#include "geo/gdal_reference.h"

namespace alidade::geo {
namespace {

using Geometry = GdalHandle<OGR_G_DestroyGeometry>;

[[noreturn]] void fail(const std::filesystem::path& file, const char* what) {
  const std::string said = CPLGetLastErrorMsg();
  throw file_error(file,
                   fmt::format("cannot write the GeoPackage: {}{}{}", what, said.empty() ? "" : ": ", said));
}

/// The plane reference of a system. For a missing one the format has "undefined Cartesian"; GDAL takes
/// degrees instead if it is given none.
GdalReference reference_or_undefined(const Crs& crs) {
  GdalReference reference = plane_reference(crs);
  if (reference) return reference;
  reference.reset(OSRNewSpatialReference(nullptr));
  OSRSetLocalCS(reference.get(), "Undefined Cartesian SRS");
  return reference;
}

void add_ring(OGRGeometryH polygon, const std::vector<glm::dvec2>& corners) {
  const OGRGeometryH ring = OGR_G_CreateGeometry(wkbLinearRing);
  for (const glm::dvec2& corner : corners) OGR_G_AddPoint_2D(ring, corner.x, corner.y);
  OGR_G_CloseRings(ring);
  OGR_G_AddGeometryDirectly(polygon, ring);
}

Geometry geometry_of(const std::vector<PlanePolygon>& polygons) {
  Geometry all(polygons.empty() ? nullptr : OGR_G_CreateGeometry(wkbMultiPolygon));
  for (const PlanePolygon& one : polygons) {
    const OGRGeometryH polygon = OGR_G_CreateGeometry(wkbPolygon);
    for (const std::vector<glm::dvec2>& ring : one.rings) add_ring(polygon, ring);
    OGR_G_AddGeometryDirectly(all.get(), polygon);
  }
  return all;
}

Geometry geometry_of(const std::vector<glm::dvec3>& corners) {
  Geometry line(corners.empty() ? nullptr : OGR_G_CreateGeometry(wkbLineString25D));
  for (const glm::dvec3& corner : corners) OGR_G_AddPoint(line.get(), corner.x, corner.y, corner.z);
  return line;
}

struct SetField {
  OGRFeatureH feature;
  int column;
  void operator()(std::monostate) const { OGR_F_SetFieldNull(feature, column); }
  void operator()(std::int64_t value) const { OGR_F_SetFieldInteger64(feature, column, value); }
  void operator()(double value) const { OGR_F_SetFieldDouble(feature, column, value); }
  void operator()(const std::string& value) const { OGR_F_SetFieldString(feature, column, value.c_str()); }
};

void add_columns(OGRLayerH layer, const VectorLayer& like, const std::filesystem::path& file) {
  for (const auto& [name, type] : like.columns) {
    const OGRFieldType kind = type == ColumnType::whole_number ? OFTInteger64
                              : type == ColumnType::number     ? OFTReal
                                                               : OFTString;
    const GdalHandle<OGR_Fld_Destroy> column(OGR_Fld_Create(name.c_str(), kind));
    if (OGR_L_CreateField(layer, column.get(), TRUE) != OGRERR_NONE) fail(file, "cannot create a column");
  }
}

void add_feature(OGRLayerH layer, const LayerFeature& feature, const std::filesystem::path& file) {
  const GdalHandle<OGR_F_Destroy> row(OGR_F_Create(OGR_L_GetLayerDefn(layer)));
  for (std::size_t column = 0; column < feature.values.size(); ++column)
    std::visit(SetField{row.get(), static_cast<int>(column)}, feature.values[column]);
  Geometry geometry = std::visit([](const auto& shape) { return geometry_of(shape); }, feature.shape);
  if (geometry) OGR_F_SetGeometryDirectly(row.get(), geometry.release());
  if (OGR_L_CreateFeature(layer, row.get()) != OGRERR_NONE) fail(file, "cannot add a row");
}

void add_layer(const GdalDataset& dataset, const VectorLayer& contents, const GdalReference& reference,
               const std::filesystem::path& file) {
  const std::string description = "DESCRIPTION=" + contents.description;
  const char* const options[] = {description.c_str(), nullptr};
  const OGRwkbGeometryType type = contents.shape == LayerShape::polygons ? wkbMultiPolygon : wkbLineString25D;
  const OGRLayerH layer = GDALDatasetCreateLayer(dataset.get(), contents.name.c_str(), reference.get(), type,
                                                 const_cast<char**>(options));
  if (layer == nullptr) fail(file, "cannot create a layer");
  add_columns(layer, contents, file);
  for (const LayerFeature& feature : contents.features) {
    assert(feature.values.size() == contents.columns.size());
    add_feature(layer, feature, file);
  }
}

}  // namespace

void write_geopackage(const std::filesystem::path& file, const std::vector<VectorLayer>& layers,
                      const Crs& crs, bool overwrite) {
  check_geopackage_name(file);
  OutputFile output(file, overwrite);
  const QuietGdal quiet;
  // Bytes do not depend on when the file is written.
  const GdalOption date("OGR_CURRENT_DATE", "2014-02-10T00:00:00.000Z");
  RegisterOGRGeoPackage();
  const GdalReference reference = reference_or_undefined(crs);
  const GDALDriverH driver = GDALGetDriverByName("GPKG");
  if (driver == nullptr) fail(file, "GDAL lacks the GPKG driver");
  const GdalMemoryFile memory(".gpkg");
  CPLErrorReset();
  GdalDataset dataset(GDALCreate(driver, memory.name(), 0, 0, 0, GDT_Unknown, nullptr));
  if (!dataset) fail(file, "cannot create the file");
  // One transaction: without it every row would be one.
  if (GDALDatasetStartTransaction(dataset.get(), FALSE) != OGRERR_NONE) fail(file, "cannot begin");
  for (const VectorLayer& layer : layers) add_layer(dataset, layer, reference, file);
  if (GDALDatasetCommitTransaction(dataset.get()) != OGRERR_NONE) fail(file, "cannot complete the file");
  dataset.reset();
  if (CPLGetLastErrorType() >= CE_Failure || memory.bytes().empty()) fail(file, "cannot complete the file");
  output.write(memory.bytes());
  output.commit();
}

}  // namespace alidade::geo
