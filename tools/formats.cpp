// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <iterator>
#include <nlohmann/json.hpp>
#include <vector>

#include "jobs/cloud_formats.h"
#include "tools/command.h"

namespace alidade::tools {
namespace {

using FormatFacts = jobs::AddedFormat::Facts;

constexpr FormatFacts k_clouds[] = {
    {"LAS", ".las", "1.0 to 1.4", "read, write 1.4", "point formats 0 to 10; extra bytes, records"},
    {"LAZ", ".laz", "1.0 to 1.4", "read, write 1.4", "point by point and in layers; without wave packets"},
    {"COPC", ".copc.laz", "1.0", "read, write", "queried in place, without reading all of it"},
    {"PLY", ".ply", "1.0", "read, write", "ascii, binary of both byte orders; colours of 8 bits"},
    {"PCD", ".pcd", "0.5 to 0.7", "read", "ascii, binary, compressed; organised clouds, viewpoints"},
    {"E57", ".e57", "1.0", "read", "poses, spherical coordinates, photographs (info --extract-images)"},
    {"PTX", ".ptx", "", "read", "poses of scans"},
    {"PTS", ".pts", "", "read", "intensities of -2048 to 2047"},
    {"CSV", ".csv, .txt", "", "read, write", "columns by their names"},
    {"XYZ", ".xyz, .txt", "", "read, write", "columns by their order; coordinates alone are written"},
    {"Alidade index", ".alidade", "2", "read, write", "octree and attributes, mapped from disk"},
    {"Catalog", ".catalog.json", "STAC 1.0", "read, write", "alidade catalog: many files and their bounds"},
};
constexpr FormatFacts k_others[] = {
    {"Elevation raster", ".tif, ...", "", "read, write", "all that GDAL reads; GeoTIFF is written"},
    {"Images", ".png, .jpg, .exr, .tif", "", "read, write", "all that OpenImageIO reads"},
    {"Mesh", ".ply, .obj", "", "read", "triangles beside the cloud (--mesh)"},
    {"Vector layer", ".geojson, .gpkg, .shp", "", "read, write",
     "observers, polygons; GeoJSON and GeoPackage are written"},
    {"Cameras", "COLMAP, transforms.json, ...", "", "read", "docs/cameras.md"},
};

/// All formats, those that extensions add among them.
std::vector<FormatFacts> all_formats() {
  std::vector<FormatFacts> all(std::begin(k_clouds), std::end(k_clouds));
  for (const bool is_read : {true, false}) {
    for (const jobs::AddedFormat& added : jobs::added_formats())
      if ((added.format != nullptr) == is_read) all.push_back(added.facts);
  }
  all.insert(all.end(), std::begin(k_others), std::end(k_others));
  return all;
}

struct FormatsCommand : RunRequest {
  bool json = false;
};

ExitCode run(const FormatsCommand& command) {
  if (command.json) {
    nlohmann::ordered_json formats = nlohmann::ordered_json::array();
    for (const FormatFacts& format : all_formats()) {
      formats.push_back({{"name", format.name},
                         {"extensions", format.extensions},
                         {"versions", format.versions},
                         {"use", format.use},
                         {"remarks", format.remarks}});
    }
    write_to_stdout(formats.dump(2) + "\n");
    return ExitCode::done;
  }
  std::string text = fmt::format("{:<17} {:<29} {:<11} {:<16} {}\n", "format", "name", "versions", "use", "");
  for (const FormatFacts& format : all_formats())
    text += fmt::format("{:<17} {:<29} {:<11} {:<16} {}\n", format.name, format.extensions, format.versions,
                        format.use, format.remarks);
  write_to_stdout(text);
  return ExitCode::done;
}

}  // namespace

Command add_formats(const Options& program) {
  auto command = std::make_shared<FormatsCommand>();
  const Options formats = program.command("formats", "List the formats of clouds, images and maps");
  formats.flag("--json", "print JSON instead of a table", command->json);
  return command_of(formats, command, run);
}

}  // namespace alidade::tools
