// SPDX-License-Identifier: MIT
#include "geo/read_polygons.h"

#include <fmt/format.h>
#include <ogr_api.h>

#include <cmath>
#include <memory>

#include "base/error.h"
#include "geo/gdal_reference.h"

namespace alidade::geo {
namespace {

void add_polygon(OGRGeometryH polygon, const std::string& source, std::vector<PlanePolygon>& polygons) {
  PlanePolygon& added = polygons.emplace_back();
  for (int i = 0; i < OGR_G_GetGeometryCount(polygon); ++i) {
    const OGRGeometryH ring = OGR_G_GetGeometryRef(polygon, i);
    std::vector<glm::dvec2>& corners = added.rings.emplace_back();
    for (int corner = 0; corner < OGR_G_GetPointCount(ring); ++corner) {
      const glm::dvec2 position{OGR_G_GetX(ring, corner), OGR_G_GetY(ring, corner)};
      if (!std::isfinite(position.x) || !std::isfinite(position.y))
        throw file_error(source, "a vertex is not finite", "numbers");
      corners.push_back(position);
    }
  }
}

void add_polygons(OGRGeometryH geometry, const std::string& source, std::vector<PlanePolygon>& polygons) {
  const OGRwkbGeometryType type = geometry != nullptr ? wkbFlatten(OGR_G_GetGeometryType(geometry)) : wkbNone;
  if (type == wkbPolygon) return add_polygon(geometry, source, polygons);
  if (type != wkbMultiPolygon && type != wkbGeometryCollection) {
    throw file_error(source, "not a polygon", "polygons",
                     geometry != nullptr ? OGRGeometryTypeToName(type) : "no geometry");
  }
  for (int i = 0; i < OGR_G_GetGeometryCount(geometry); ++i)
    add_polygons(OGR_G_GetGeometryRef(geometry, i), source, polygons);
}

}  // namespace

std::vector<PlanePolygon> read_polygons(const std::filesystem::path& path,
                                        const ObserverReference& reference) {
  std::vector<PlanePolygon> polygons;
  const auto take = [&](void* feature) {
    const std::string source = fmt::format("{}:feature {}", path.string(), OGR_F_GetFID(feature));
    const OGRGeometryH given = OGR_F_GetGeometryRef(feature);
    // A copy without arcs.
    const GdalHandle<OGR_G_DestroyGeometry> geometry(
        given != nullptr ? OGR_G_GetLinearGeometry(given, 0.0, nullptr) : nullptr);
    add_polygons(geometry.get(), source, polygons);
  };
  const std::string wkt = read_vector_file(path,
                                           {.content = "polygons",
                                            .expected = "GeoJSON, GeoPackage or Shapefile with polygons",
                                            .features = "polygons"},
                                           take);
  std::erase_if(polygons, [](const PlanePolygon& polygon) { return polygon.rings.empty(); });
  if (polygons.empty()) throw file_error(path, "contains no polygons", "at least one");
  const GdalTransformation transformation = transformation_to_cloud(wkt, reference, path.string());
  if (!transformation) return polygons;
  for (PlanePolygon& polygon : polygons) {
    for (std::vector<glm::dvec2>& ring : polygon.rings) {
      for (glm::dvec2& corner : ring) corner = transformed(corner, transformation, path.string());
    }
  }
  return polygons;
}

}  // namespace alidade::geo
