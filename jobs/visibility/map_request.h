// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cloud/crs.h"
#include "geo/raster.h"
#include "jobs/visibility/visibility_cloud.h"
#include "visibility/raster/ground.h"

namespace alidade::jobs {

/// The unit of x and y of a cloud.
struct CloudUnit {
  std::string name{};              ///< "m", "ft", or empty if it is another one or not known
  std::optional<double> metres{};  ///< of one of them; empty if that is not known
};

/// The unit by GDAL, which reads the definition of a code, else plane_unit_label() (cloud/axis_units.h).
/// Requires: not degrees. Errors: those of geo::load_gdal().
CloudUnit cloud_unit(const Crs& crs);

// What all maps of the ground have in common: viewsheds, maps of the sky, maps of the sun.

/// What all maps are requested with.
struct MapRequest {
  std::optional<double> resolution, target_height;
  std::optional<Bounds> area;
  std::optional<visibility::GroundSource> ground_source;
  std::optional<double> ground_cell, ground_reach;
  std::filesystem::path preview;  ///< empty: none
};

constexpr const char* k_map_group = "Map";

/// Declares the fields in groups of their own; they fill `map`. The target height is add_target_height()'s.
void add_map_fields(const Fields& fields, MapRequest& map);

/// Name of the first of these fields that was given, as "--extent"; empty: none.
std::string given_map_field(const MapRequest& map);

/// Loads what maps are written with. Errors: a preview that is not a PNG; those of geo::load_gdal(),
/// image::load_library() and image::find_font().
void load_map_writer(const MapRequest& map);

/// The ground below the cloud; notes how the ground was found.
visibility::Ground find_map_ground(const MapRequest& map, const VisibilityCloud& cloud, Listener& listener);

/// The requested part of the cloud or terrain; without --extent the bounds of the points if there are any.
/// Errors: --extent contains nothing of it.
Bounds map_area(const MapRequest& map, const VisibilityCloud& cloud);

/// The cells over an area, which it notes: by default of usual_resolution(), not finer than the ground, or
/// the cells of a raster. Errors: too many cells, or too many for the memory with so many bands.
geo::RasterGrid map_grid(const MapRequest& map, const Bounds& area, const visibility::Ground& ground,
                         int bands, const std::string& unit, Listener& listener);

/// Keys and texts of a map's file.
using MapMetadata = std::vector<std::pair<std::string, std::string>>;

/// The metadata of every map: command, cloud files, ground, what blocks. Requires measured occluders.
MapMetadata map_metadata(const VisibilityRequest& request, const VisibilityCloud& cloud,
                         const visibility::Ground& ground);

/// The nodata value of float bands.
constexpr double k_no_float = -9999.0;

}  // namespace alidade::jobs
