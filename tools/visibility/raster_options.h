// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "tools/options.h"
#include "tools/visibility/checkpoint_options.h"
#include "tools/visibility/map_options.h"
#include "tools/visibility/observer_options.h"
#include "tools/visibility/occluder_options.h"
#include "visibility/raster/viewshed.h"
#include "visibility/raster/viewshed_file.h"

namespace alidade {

/// Whose defaults hold for what is not said.
enum class DefaultSet { gdal, grass };

/// What was asked of `alidade visibility raster`.
struct RasterCommand {
  std::vector<std::filesystem::path> files;
  bool partial = false;
  ObserverOptions observers;
  OccluderRequest occluders;
  MapOptions map;
  CheckpointRequest checkpoint;
  std::optional<DefaultSet> like;    ///< empty: gdal
  std::optional<ViewshedMode> mode;  ///< empty: visible
  std::optional<double> curvature;
  std::optional<double> highest;
  std::optional<int> places_across;
  std::optional<std::uint8_t> visible_value, invisible_value, out_of_range_value;
  std::filesystem::path output;
  bool overwrite = false;
  std::optional<int> threads;
  VerbosityOptions verbosity;
};

/// Declares the command's options; they fill what is returned.
std::shared_ptr<RasterCommand> add_raster_options(CLI::App& raster);

inline DefaultSet default_set(const RasterCommand& command) {
  return command.like.value_or(DefaultSet::gdal);
}

/// The values of the chosen set, but for those that were given.
SeenValues seen_values_of(const RasterCommand& command);

}  // namespace alidade
