// SPDX-License-Identifier: MIT
#include "jobs/visibility/map_request.h"

#include <fmt/format.h>
#include <cmath>

#include "base/words.h"
#include "cloud/axis_units.h"
#include "geo/earth.h"
#include "geo/gdal_library.h"
#include "image/font.h"
#include "image/image_file.h"
#include "jobs/outputs.h"
#include "visibility/raster/map_targets.h"

namespace alidade::jobs {
namespace {

/// The name of a unit; international and survey feet have the same name.
std::string name_of(double metres) {
  constexpr double k_foot = 0.3048, k_rounding = 1e-5;
  if (std::fabs(metres - 1.0) < k_rounding) return "m";
  return std::fabs(metres - k_foot) < k_rounding ? "ft" : "";
}

Bounds parse_area(const std::string& text) {
  const std::vector<std::string> words = split_list(text, 4, "XMIN,YMIN,XMAX,YMAX");
  const Bounds area{{parse_number(words[0]), parse_number(words[1]), 0.0},
                    {parse_number(words[2]), parse_number(words[3]), 0.0}};
  if (area.empty())
    throw UsageError("limits out of order; expected XMIN,YMIN,XMAX,YMAX with min <= max, found '" + text +
                     "'");
  return area;
}

void add_ground(const Fields& fields, MapRequest& map) {
  const Fields group = fields.group("Ground");
  group.choice(
      "--ground",
      "ground: points of the classes 2, 9 and 11 (ground, water, road surface), the lowest points, or "
      "the highest, which are roofs and crowns as in a surface model (default: auto, by class if there "
      "is class 2)",
      map.ground_source,
      {{"auto", visibility::GroundSource::automatic},
       {"class", visibility::GroundSource::classified},
       {"lowest", visibility::GroundSource::lowest},
       {"highest", visibility::GroundSource::highest}});
  group.number("--ground-cell", "LENGTH",
               "cell size of the ground (default: the mean distance of the points of these classes, or of "
               "all points four times that, for the highest twice)",
               map.ground_cell, 1e-6, 1e9);
  group.number(
      "--ground-reach", "LENGTH",
      "no ground, and no value in maps, beyond this distance from the cloud's points (default: 10; for cells "
      "of maps three cells of the ground, at least 1)",
      map.ground_reach, 0.0, 1e9);
}

std::string ground_text(const visibility::Ground& ground) {
  const geo::RasterGrid& grid = ground.heights().grid;
  if (ground.source() == visibility::GroundSource::terrain)
    return fmt::format("heights of the raster in cells of {:.4g}", grid.cell_size);
  const std::string points = ground.source() == visibility::GroundSource::classified
                                 ? "points of classes 2, 9 and 11"
                             : ground.source() == visibility::GroundSource::highest ? "highest points"
                                                                                    : "lowest points";
  return fmt::format("{} in cells of {:.4g}, {:.1f} % of them measured", points, grid.cell_size,
                     100.0 * static_cast<double>(ground.measured_cells()) / static_cast<double>(grid.size()));
}

}  // namespace

CloudUnit cloud_unit(const Crs& crs) {
  if (crs.empty()) return {};
  CloudUnit unit;
  unit.metres = geo::metres_per_unit(crs);
  if (!unit.metres) {
    const std::string stated = plane_unit_label(crs);
    if (stated.empty()) return {};
    unit.metres = stated == "ft" ? k_foot.metres : 1.0;
  }
  unit.name = name_of(*unit.metres);
  return unit;
}

void add_map_fields(const Fields& fields, MapRequest& map) {
  const Fields group = fields.group(k_map_group);
  group.file("--preview", "FILE.png", "also write an image with relief, marks, scale bar and legend",
             map.preview);
  group.number("--resolution", "LENGTH",
               "cell size (default: 1, 2 or 5 times a power of ten, for at most 1000 cells along a side, "
               "none smaller than those of the ground; of a raster its own cells)",
               map.resolution, 1e-6, 1e9);
  group.value("--extent", "XMIN,YMIN,XMAX,YMAX", "only this part of the cloud (default: all of it)", map.area,
              parse_area);
  add_ground(fields, map);
}

std::string given_map_field(const MapRequest& map) {
  if (!map.preview.empty()) return "--preview";
  if (map.resolution) return "--resolution";
  if (map.area) return "--extent";
  if (map.target_height) return "--target-height";
  if (map.ground_source) return "--ground";
  if (map.ground_cell) return "--ground-cell";
  return map.ground_reach ? "--ground-reach" : "";
}

void load_map_writer(const MapRequest& map) {
  geo::load_gdal();
  if (map.preview.empty()) return;
  image::load_library();
  if (file_extension(map.preview) != ".png")
    throw file_error(map.preview, "unknown output format", "the extension .png");
  image::find_font();
}

visibility::Ground find_map_ground(const MapRequest& map, const VisibilityCloud& cloud, Listener& listener) {
  if (!cloud.has_points() && (map.ground_source || map.ground_cell || map.ground_reach)) {
    throw input_error("--ground, --ground-cell and --ground-reach do not apply to a raster",
                      "none of them: the ground is the heights of the raster");
  }
  visibility::GroundOptions options;
  options.source = map.ground_source.value_or(visibility::GroundSource::automatic);
  options.cell_size = map.ground_cell;
  options.reach = map.ground_reach.value_or(options.reach);
  options.scanned_reach = map.ground_reach;
  visibility::Ground ground = find_ground(cloud, options, listener);
  const bool is_raised = cloud.has_points() && cloud.terrain.surface != nullptr;
  listener.note("ground: " + ground_text(ground) + (is_raised ? "; the terrain where it is higher" : ""));
  return ground;
}

Bounds map_area(const MapRequest& map, const VisibilityCloud& cloud) {
  Bounds all = cloud.area();
  if (!map.area) return all;
  if (cloud.terrain.surface != nullptr) all.grow(geo::area_of(cloud.terrain.surface->heights().grid));
  const Bounds area = geo::cropped(all, *map.area);
  if (area.empty()) {
    throw Error({.problem = cloud.has_points() ? "--extent contains no points of the cloud"
                                               : "--extent contains no cells of the raster"});
  }
  return area;
}

geo::RasterGrid map_grid(const MapRequest& map, const Bounds& area, const visibility::Ground& ground,
                         int bands, const std::string& unit, Listener& listener) {
  const geo::RasterGrid& own = ground.heights().grid;
  const bool is_raster = ground.source() == visibility::GroundSource::terrain;
  const geo::RasterGrid grid =
      is_raster && !map.resolution
          ? geo::part_over(own, area)
          : geo::grid_over(area, map.resolution.value_or(visibility::usual_resolution(area, own.cell_size)));
  geo::check_map_memory(grid, bands);
  listener.note(fmt::format("map: {} x {} cells of {:g}{}{}", grid.columns, grid.rows, grid.cell_size,
                            unit.empty() ? "" : " ", unit));
  return grid;
}

MapMetadata map_metadata(const VisibilityRequest& request, const VisibilityCloud& cloud,
                         const visibility::Ground& ground) {
  constexpr const char* k_shapes[] = {"auto", "disc", "sphere"};
  const visibility::OccluderOptions& blocks = cloud.occluders->options();
  std::string names;
  for (const std::filesystem::path& file : request.files.names())
    names += (names.empty() ? "" : "\n") + kept_name(file);
  return {{"alidade_command", request.command},
          {"alidade_cloud_files", names},
          {"alidade_ground", ground_text(ground)},
          {"alidade_what_blocks", cloud.what_blocks},
          {"alidade_occluder", k_shapes[static_cast<std::size_t>(blocks.shape)]},
          {"alidade_radius", blocks.radius ? fmt::format("{:.17g}", *blocks.radius) : "auto"},
          {"alidade_transparency", std::to_string(blocks.transparency)}};
}

}  // namespace alidade::jobs
