// SPDX-License-Identifier: MIT
#include "geo/write_catalog.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/output_file.h"
#include "base/shown_text.h"
#include "cloud/catalog.h"
#include "geo/earth.h"
#include "geo/geopackage.h"
#include "geo/reproject.h"

namespace alidade::geo {
namespace {

using Json = nlohmann::ordered_json;

/// The outline of a box on the ground, counterclockwise, with the middles of its sides: they bend on the
/// globe.
std::array<glm::dvec3, 8> outline(const Bounds& box) {
  const glm::dvec3 &low = box.min, &high = box.max, middle = box.center();
  return {{{low.x, low.y, 0},
           {middle.x, low.y, 0},
           {high.x, low.y, 0},
           {high.x, middle.y, 0},
           {high.x, high.y, 0},
           {middle.x, high.y, 0},
           {low.x, high.y, 0},
           {low.x, middle.y, 0}}};
}

/// Longitudes and latitudes of the outlines of all files; none where they are unknown.
std::vector<std::vector<glm::dvec3>> outlines_on_globe(std::span<const CatalogFile> rows,
                                                       std::span<const Crs> systems) {
  std::vector<std::vector<glm::dvec3>> outlines(rows.size());
  for (std::size_t system = 0; system < systems.size(); ++system) {
    if (systems[system].empty()) continue;
    std::vector<std::size_t> files;
    std::vector<glm::dvec3> positions;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (rows[i].system != system || rows[i].box.empty()) continue;
      files.push_back(i);
      std::ranges::copy(outline(rows[i].box), std::back_inserter(positions));
    }
    // All at once: to set up the transformation takes longer than to apply it.
    const auto moved = lon_lat(systems[system], positions);
    for (std::size_t i = 0; i < files.size(); ++i) {
      const std::span<const glm::dvec3> own = std::span<const glm::dvec3>(positions).subspan(8 * i, 8);
      const auto alone = moved ? std::nullopt : lon_lat(systems[system], own);
      if (moved)
        outlines[files[i]].assign(moved->begin() + 8 * static_cast<std::ptrdiff_t>(i),
                                  moved->begin() + 8 * static_cast<std::ptrdiff_t>(i + 1));
      if (alone) outlines[files[i]] = *alone;
    }
  }
  return outlines;
}

/// The properties of the projection extension that name a system: its code, else its definition.
Json projection_of(const Crs& crs) {
  const Json parsed = Json::parse(projjson_of(crs), nullptr, false);
  if (!parsed.is_object()) return {{"proj:code", nullptr}};
  if (const auto id = parsed.find("id"); id != parsed.end() && id->is_object() && id->contains("code")) {
    const Json& code = id->at("code");
    return {{"proj:code", id->value("authority", "EPSG") + ":" +
                              (code.is_string() ? code.get<std::string>() : code.dump())}};
  }
  return {{"proj:code", nullptr}, {"proj:projjson", parsed}};
}

/// The dimensions of points, as the pointcloud extension lists them; extra dimensions are left out.
Json schemas_of(AttributeSet attributes) {
  struct Dimensions {
    AttributeSet attribute;
    std::vector<const char*> names;
    int size;
    const char* type;
  };
  static const std::vector<Dimensions> k_dimensions = {
      {{}, {"X", "Y", "Z"}, 8, "floating"},
      {Attribute::intensity, {"Intensity"}, 2, "unsigned"},
      {Attribute::returns, {"ReturnNumber", "NumberOfReturns"}, 1, "unsigned"},
      {Attribute::classification, {"Classification"}, 1, "unsigned"},
      {Attribute::scan_angle, {"ScanAngleRank"}, 4, "floating"},
      {Attribute::user_data, {"UserData"}, 1, "unsigned"},
      {Attribute::point_source_id, {"PointSourceId"}, 2, "unsigned"},
      {Attribute::gps_time, {"GpsTime"}, 8, "floating"},
      {Attribute::color, {"Red", "Green", "Blue"}, 2, "unsigned"},
      {Attribute::near_infrared, {"Infrared"}, 2, "unsigned"},
      {Attribute::normal, {"NormalX", "NormalY", "NormalZ"}, 4, "floating"}};
  Json schemas = Json::array();
  for (const Dimensions& dimensions : k_dimensions) {
    if ((dimensions.attribute.bits & ~attributes.bits) != 0) continue;
    for (const char* const name : dimensions.names)
      schemas.push_back({{"name", name}, {"size", dimensions.size}, {"type", dimensions.type}});
  }
  return schemas;
}

const char* media_type(const std::string& format) {
  if (format == "COPC") return "application/vnd.laszip+copc";
  if (format == "LAZ") return "application/vnd.laszip";
  return format == "LAS" ? "application/vnd.las" : "application/octet-stream";
}

Json item_of(const CatalogFile& row, std::span<const glm::dvec3> ring, const Json& projection) {
  Json item = {{"type", "Feature"},
               {"stac_version", "1.0.0"},
               {"stac_extensions",
                {"https://stac-extensions.github.io/pointcloud/v1.0.0/schema.json",
                 "https://stac-extensions.github.io/projection/v2.0.0/schema.json"}},
               {"id", row.name},
               {"geometry", nullptr}};
  if (!ring.empty()) {
    Bounds globe;
    Json corners = Json::array();
    for (const glm::dvec3& corner : ring) {
      globe.grow(corner);
      corners.push_back({corner.x, corner.y});
    }
    corners.push_back(corners.front());
    item["geometry"] = {{"type", "Polygon"}, {"coordinates", Json::array({corners})}};
    item["bbox"] = {globe.min.x, globe.min.y, globe.max.x, globe.max.y};
  }
  Json properties = {{"datetime", row.date}};
  if (!row.modified.empty()) properties["updated"] = row.modified;
  properties.update({{"pc:count", row.point_count}, {"pc:type", "other"}, {"pc:encoding", row.format}});
  properties["pc:schemas"] = schemas_of(row.attributes);
  properties.update(projection);
  if (!row.box.empty()) {
    const glm::dvec3 &low = row.box.min, &high = row.box.max;
    properties["proj:bbox"] = {low.x, low.y, low.z, high.x, high.y, high.z};
  }
  item["properties"] = std::move(properties);
  item["links"] = Json::array();
  item["assets"]["data"] = {{"href", row.is_url ? row.name : href_of(row.name)},
                            {"type", media_type(row.format)},
                            {"roles", {"data"}},
                            {"file:size", row.byte_count}};
  return item;
}

}  // namespace

void write_catalog(const std::filesystem::path& path, std::span<const CatalogFile> rows,
                   std::span<const Crs> systems, bool overwrite, const Progress& progress) {
  const auto outlines = outlines_on_globe(rows, systems);
  std::vector<Json> projections;
  for (const Crs& crs : systems) projections.push_back(projection_of(crs));
  OutputFile file(path, overwrite);
  file.write("{\"type\":\"FeatureCollection\",\"features\":[");
  for (std::size_t i = 0; i < rows.size(); ++i) {
    report(progress, i, rows.size());
    file.write(i == 0 ? "\n" : ",\n");
    file.write(json_text(item_of(rows[i], outlines[i], projections[rows[i].system])));
  }
  file.write("\n]}\n");
  file.commit();
}

void write_footprints(const std::filesystem::path& path, std::span<const CatalogFile> rows,
                      std::span<const Crs> systems, bool overwrite) {
  for (const CatalogFile& row : rows) {
    const Crs &first = systems[rows.front().system], &own = systems[row.system];
    if (!first.empty() && !own.empty() && compare_crs(first, own) == CrsAgreement::different)
      throw file_error(row.name, "a GeoPackage of files of different reference systems",
                       crs_name(first) + ", or a .catalog.json", crs_name(own));
  }
  VectorLayer layer{.name = "footprints",
                    .description = "Boxes of point clouds",
                    .shape = LayerShape::polygons,
                    .columns = {{"file", ColumnType::text},
                                {"format", ColumnType::text},
                                {"points", ColumnType::whole_number},
                                {"z_min", ColumnType::number},
                                {"z_max", ColumnType::number},
                                {"bytes", ColumnType::whole_number},
                                {"modified", ColumnType::text}},
                    .features = {}};
  for (const CatalogFile& row : rows) {
    std::vector<PlanePolygon> polygons;
    VectorValue low, high;
    if (!row.box.empty()) {
      low = row.box.min.z;
      high = row.box.max.z;
      std::vector<glm::dvec2> ring;
      for (std::size_t i = 0; i < 8; i += 2) ring.emplace_back(outline(row.box)[i]);
      polygons.push_back({{ring}});
    }
    layer.features.push_back(
        {polygons,
         {row.name, row.format, static_cast<std::int64_t>(row.point_count), low, high,
          static_cast<std::int64_t>(row.byte_count), row.modified.empty() ? VectorValue() : row.modified}});
  }
  write_geopackage(path, {layer}, systems[rows.front().system], overwrite);
}

}  // namespace alidade::geo
