// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "renderer/color/color_map.h"
#include "tools/options.h"
#include "tools/visibility/load_visibility_cloud.h"
#include "tools/visibility/occluder_options.h"
#include "tools/visibility/write_points.h"
#include "visibility/ground.h"
#include "visibility/sky_view.h"

// What `visibility sky` and `visibility sun` share: numbers for every point, or for every cell of the ground.

namespace alidade {

/// What both commands are asked.
struct SkyRequest {
  std::vector<std::filesystem::path> files;
  OccluderRequest occluders;
  std::optional<SkyReceiver> receiver;      ///< points only
  std::optional<double> cell_size, height;  ///< maps only
  double max_distance = std::numeric_limits<double>::infinity();
  std::filesystem::path output, preview;  ///< preview: maps only; empty: none
  bool overwrite = false;
  std::optional<int> threads;
  VerbosityOptions verbosity;

  /// Whether the answers are for cells, by the ending of the output.
  bool is_map() const;
};

/// Declares all of that but for what stands at the end: add_threads, add_verbosity.
void add_sky_request(CLI::App& command, SkyRequest& request);

/// Errors that need no cloud: the output's name or place; options that mean nothing for this kind of output.
void check_sky_request(const SkyRequest& request);

/// Fails before the work if what it ends in cannot be written here: errors of load_module_function().
void load_sky_writers(const SkyRequest& request);

/// The ground, and the cells asked for.
struct SkyGround {
  Ground ground;
  RasterGrid grid;
};
SkyGround load_sky_ground(const SkyRequest& request, const VisibilityCloud& cloud);

/// Numbers by point id as a column of LAS or PLY; they must outlive it. `value` answers that of a point.
ResultColumn float_column(const std::string& name, const std::string& description,
                          std::function<float(std::size_t id)> value);

/// A map as GeoTIFF, nothing where a value is not a number.
struct SkyBand {
  std::span<const float> values;
  std::string description, unit;
};
void write_sky_map(const SkyRequest& request, const VisibilityCloud& cloud, const RasterGrid& grid,
                   std::span<const SkyBand> bands, std::vector<std::pair<std::string, std::string>> metadata);

/// The picture of a map, if one is asked for: colours over the relief of the ground, from 0 to `highest`.
struct SkyPicture {
  std::string title;
  std::string label;  ///< what the numbers are
  ColorMap colors = ColorMap::viridis;
  double highest = 1.0;
  std::vector<std::string> notes{};
};
void write_sky_preview(const SkyRequest& request, const VisibilityCloud& cloud, const Ground& ground,
                       const Raster<float>& values, const SkyPicture& picture);

/// "0.02 to 0.97, mean 0.61": of the values that are numbers.
std::string range_and_mean(const std::function<float(std::size_t)>& value, std::size_t count);

}  // namespace alidade
