// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "octree/error.h"
#include "tools/message.h"
#include "tools/picture_command.h"
#include "tools/visibility/commands.h"
#include "tools/visibility/map_writer.h"
#include "tools/visibility/raster_options.h"
#include "visibility/map_unit.h"
#include "visibility/viewshed_area.h"

namespace alidade {
namespace {

constexpr const char* k_mode_words[] = {"visible", "count", "height", "fraction"};

using Metadata = std::vector<std::pair<std::string, std::string>>;

ViewshedMode mode_of(const RasterCommand& command) {
  return command.mode.value_or(ViewshedMode::visible);
}

/// Errors that need no cloud.
void check_options(const RasterCommand& command) {
  check_raster_name(command.output);
  std::vector<std::filesystem::path> inputs = command.files;
  if (!command.observers.file.empty()) inputs.push_back(command.observers.file);
  check_writable(command.output, command.overwrite, inputs);
  if (!command.preview.empty()) {
    if (command.preview.extension() != ".png") {
      throw Error({.file = command.preview.string(),
                   .problem = "previews are written as PNG",
                   .expected = "a name ending in .png"});
    }
    inputs.push_back(command.output);
    check_writable(command.preview, command.overwrite, inputs);
  }
  if (command.highest <= command.target_height.value_or(0.0) && mode_of(command) == ViewshedMode::height)
    throw Error({.problem = "--highest must be above --target-height"});
}

/// Sight bent as asked for, or as the chosen set has it where the cloud's unit is known.
SightCurve curve_of(const RasterCommand& command, MapUnit unit) {
  if (unit == MapUnit::degree) {
    if (command.curvature.value_or(0.0) > 0.0) {
      throw Error({.problem = "sight cannot be bent over a map in degrees",
                   .expected = "a cloud in a projected reference system, or --curvature 0"});
    }
    if (!command.verbosity.quiet)
      say_warning("the cloud's coordinates are degrees: lengths and heights do not fit together");
    return {};
  }
  const bool usual = default_set(command) == DefaultSet::gdal && unit != MapUnit::unknown;
  return SightCurve(command.curvature.value_or(usual ? k_usual_curvature : 0.0), metres_per_unit(unit));
}

Ground find_ground(const RasterCommand& command, const VisibilityCloud& cloud) {
  ProgressLine line("finding the ground", "points", command.verbosity.verbosity());
  GroundOptions options = command.ground;
  options.source = command.ground_source.value_or(GroundSource::automatic);
  options.progress = line.callback();
  Ground ground = make_ground(cloud.octree(), cloud.columns.classifications, options);
  line.finish();
  return ground;
}

std::string unit_text(MapUnit unit) {
  return unit == MapUnit::metre ? "m" : unit == MapUnit::foot ? "ft" : "";
}

/// What the map was made with, for people and for its metadata.
struct Parameters {
  std::string ground, sight;
};

Parameters parameters_of(const RasterCommand& command, const ViewshedOptions& options, const Ground& ground) {
  Parameters parameters;
  const std::uint64_t cells = ground.heights().grid.size();
  parameters.ground =
      fmt::format("{} in cells of {:.4g}, {:.1f} % of them measured",
                  ground.source() == GroundSource::classified ? "points of class 2" : "lowest points",
                  ground.heights().grid.cell_size,
                  100.0 * static_cast<double>(ground.measured_cells()) / static_cast<double>(cells));
  const ObserverDefaults& defaults = command.observers.defaults;
  parameters.sight = fmt::format(
      "defaults like {}; observers {:g} above the ground, {:g} above a z of their own; targets {:g} above "
      "the "
      "ground; "
      "curvature {:g}; maximum distance {:g}; azimuth {:g} to {:g}, elevation {:g} to {:g}",
      default_set(command) == DefaultSet::gdal ? "gdal_viewshed" : "r.viewshed",
      defaults.height.value_or(defaults.height_on_ground), defaults.height.value_or(0.0),
      options.target_height, options.curve.coefficient(), defaults.max_distance, defaults.azimuth_min,
      defaults.azimuth_max, defaults.elevation_min, defaults.elevation_max);
  if (mode_of(command) == ViewshedMode::visible) {
    const SeenValues values = seen_values_of(command);
    parameters.sight +=
        fmt::format("; values {} seen, {} not, {} out of range", values.visible, values.invisible,
                    values.out_of_range ? std::to_string(*values.out_of_range) : "no data");
  }
  if (mode_of(command) == ViewshedMode::height)
    parameters.sight += fmt::format("; up to {:g}", options.highest);
  if (mode_of(command) == ViewshedMode::fraction)
    parameters.sight += fmt::format("; {0} x {0} places per cell", options.places_across);
  return parameters;
}

Metadata metadata_of(const RasterCommand& command, const Parameters& parameters,
                     std::span<const Observer> observers, const Occluders& occluders,
                     const CommandLine& words) {
  constexpr std::size_t k_most_observers = 100;
  Metadata metadata{{"alidade_command", picture_command(words)},
                    {"alidade_mode", k_mode_words[static_cast<std::size_t>(mode_of(command))]},
                    {"alidade_sight", parameters.sight},
                    {"alidade_ground", parameters.ground}};
  std::string files, places;
  for (const std::filesystem::path& file : command.files)
    files += (files.empty() ? "" : "\n") + file.string();
  metadata.emplace_back("alidade_cloud_files", files);
  metadata.emplace_back("alidade_observer_count", std::to_string(observers.size()));
  for (const Observer& one : observers.first(std::min(observers.size(), k_most_observers))) {
    places += fmt::format("{}{}: {:.17g} {:.17g} {:.17g}", places.empty() ? "" : "\n", one.name,
                          one.position.x, one.position.y, one.position.z);
  }
  metadata.emplace_back("alidade_observers", places);
  const OccluderOptions& blocks = occluders.options();
  constexpr const char* k_shapes[] = {"auto", "disc", "sphere"};
  metadata.emplace_back("alidade_occluder", k_shapes[static_cast<std::size_t>(blocks.shape)]);
  metadata.emplace_back("alidade_radius", blocks.radius ? fmt::format("{:.17g}", *blocks.radius) : "auto");
  metadata.emplace_back("alidade_transparency", std::to_string(blocks.transparency));
  return metadata;
}

RasterGrid grid_of(const RasterCommand& command, const VisibilityCloud& cloud,
                   std::span<const Observer> observers) {
  Bounds area = cloud.octree().bounds();
  if (command.area) {
    area = cropped(area, *command.area);
    if (area.empty()) throw Error({.problem = "--area holds nothing of the cloud"});
  }
  area = area_in_reach(area, observers);
  return grid_over(area, command.resolution.value_or(usual_resolution(area)));
}

struct SeenShare {
  double percent = 0.0;       ///< of the cells with a value
  std::uint64_t without = 0;  ///< cells that have none
};

SeenShare seen_share(const Viewshed& viewshed, ViewshedMode mode) {
  std::uint64_t seen = 0, looked_at = 0;
  for (const float value : viewshed.values.values) {
    if (std::isnan(value) || value == k_out_of_range) continue;
    ++looked_at;
    seen += mode == ViewshedMode::height ? value == 0.0f : value > 0.0f;
  }
  return {looked_at == 0 ? 0.0 : 100.0 * static_cast<double>(seen) / static_cast<double>(looked_at),
          viewshed.values.values.size() - looked_at};
}

ExitCode run(RasterCommand command, const CommandLine& words) {
  constexpr double k_grass_observer = 1.75;
  check_options(command);
  const Verbosity verbosity = command.verbosity.verbosity();
  const auto say = [&](const std::string& text) {
    if (verbosity != Verbosity::quiet) say_note(text);
  };
  if (default_set(command) == DefaultSet::grass)
    command.observers.defaults.height_on_ground = k_grass_observer;
  const auto cloud = load_visibility_cloud(command.files, command.occluders, AttributeSet(), verbosity);
  const Crs& crs = cloud->cloud.cloud.crs;
  const MapUnit unit = map_unit(crs);
  ViewshedOptions options;
  options.mode = mode_of(command);
  options.target_height = command.target_height.value_or(0.0);
  options.curve = curve_of(command, unit);
  options.places_across = command.places_across;
  options.highest = command.highest;

  const Ground ground = find_ground(command, *cloud);
  const std::vector<Observer> observers = load_observers(
      command.observers, *cloud, verbosity, [&](const glm::dvec2& place) { return ground.at(place); });
  const RasterGrid grid = grid_of(command, *cloud, observers);
  const Parameters parameters = parameters_of(command, options, ground);
  say("ground: " + parameters.ground);
  say("sight: " + parameters.sight);
  say(fmt::format("map: {} x {} cells of {:g}{}{}", grid.columns, grid.rows, grid.cell_size,
                  unit_text(unit).empty() ? "" : " ", unit_text(unit)));

  ProgressLine line("looking", "sight lines", verbosity);
  options.progress = line.callback();
  const auto start = std::chrono::steady_clock::now();
  const Viewshed seen = viewshed(*cloud->occluders, ground, observers, grid, options);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  line.finish();

  const ViewshedBand band =
      viewshed_band(seen, options.mode, seen_values_of(command), observers.size(), unit_text(unit));
  const RasterContents contents{
      .grid = grid,
      .bands = {band.band()},
      .crs = crs,
      .metadata = metadata_of(command, parameters, observers, *cloud->occluders, words)};
  load_raster_writer()(command.output, contents, command.overwrite);
  if (!command.preview.empty()) {
    MapPicture picture = viewshed_picture(seen, options.mode, observers, unit_text(unit), options.highest);
    load_map_drawer()(picture, ground, command.preview, command.overwrite);
  }
  const SeenShare share = seen_share(seen, options.mode);
  say(fmt::format(
      "{} sight lines in {:.1f} s ({}/s); seen {:.1f} % of the cells in range, {} cells without a value; "
      "wrote {}",
      short_count(static_cast<double>(seen.line_count)), seconds,
      short_count(static_cast<double>(seen.line_count) / seconds), share.percent, share.without,
      command.output.string()));
  return ExitCode::done;
}

}  // namespace

Command add_visibility_raster(CLI::App& visibility, const CommandLine& command_line) {
  CLI::App* const raster =
      visibility.add_subcommand("raster", "Make a map of what is seen of the ground: a viewshed");
  const std::shared_ptr<RasterCommand> command = add_raster_options(*raster);
  raster->footer(
      "Form:\n"
      "  alidade visibility raster CLOUD... --observer X,Y[,Z] --resolution LENGTH -o FILE.tif [OPTIONS]\n"
      "\n"
      "Every cell is looked at in its middle, on the ground or --target-height above it, along a line "
      "through "
      "the points\n"
      "themselves: below crowns, bridges and balconies. Cells where the cloud has no ground have no data.\n"
      "\n"
      "Values by --mode:\n"
      "  visible   byte    255 seen, 0 not seen or out of range, 254 no data; with --like grass 1, 0, 255 no "
      "data\n"
      "  count     uint16  0 .. observers; 65535 no data or out of range (uint32 from 65535 observers on)\n"
      "  height    float   in the unit of the cloud; --highest where it is not seen even there; -9999 no "
      "data\n"
      "  fraction  float   0 .. 1; -9999 no data or out of range\n"
      "\n"
      "Lengths are in metres (the unit of the cloud's CRS); angles in degrees. The map is the same on any "
      "number "
      "of threads.\n"
      "The metadata of the file (gdalinfo) tells all that was used. More: docs/visibility.md.\n"
      "\n"
      "Examples:\n"
      "  alidade visibility raster site.las --observer 690000,5325000 --resolution 1 -o seen.tif\n"
      "  alidade visibility raster site.las --observers masts.gpkg --mode count -o masts.tif --preview "
      "masts.png\n"
      "  alidade visibility raster site.alidade --observer 690000,5325000,640 --mode height -o height.tif\n"
      "  alidade visibility raster site.las --observer 690000,5325000 --like grass --max-distance 300 -o "
      "near.tif\n");
  return {raster, [command, command_line] {
            ExitCode code = ExitCode::failed;
            with_threads(command->threads, [&] { code = run(*command, command_line); });
            return code;
          }};
}

}  // namespace alidade
