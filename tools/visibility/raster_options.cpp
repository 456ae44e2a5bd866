// SPDX-License-Identifier: MIT
#include "tools/visibility/raster_options.h"

#include <string>

#include "tools/cloud_options.h"
#include "visibility/raster/map_places.h"

namespace alidade {
namespace {

void add_output(CLI::App& raster, RasterCommand& command) {
  raster.add_option("-o,--output", command.output, "map to write: cloud-optimised GeoTIFF")
      ->option_text("FILE.tif")
      ->required()
      ->group(k_map_group);
  raster.add_flag("--overwrite", command.overwrite, "replace existing files")->group(k_map_group);
}

void add_values(CLI::App& raster, RasterCommand& command) {
  const char* const group = "Values";
  add_choice<ViewshedMode>(
      raster, "--mode",
      "visible: whether any observer sees the middle of the cell; count: how many do; height: the lowest "
      "height above the ground that is seen, to 0.01; fraction: share of free sight lines over observers and "
      "places of the cell (default: visible)",
      command.mode,
      {{"visible", ViewshedMode::visible},
       {"count", ViewshedMode::count},
       {"height", ViewshedMode::height},
       {"fraction", ViewshedMode::fraction}})
      ->group(group);
  const auto add_byte = [&](const char* names, const char* help, std::optional<std::uint8_t>& target) {
    add_value(raster, names, "0..255", help, [&target](const std::string& text) {
      target = static_cast<std::uint8_t>(parse_count(text, 0, 255));
    })->group(group);
  };
  add_byte("--visible-value,--vv", "of --mode visible: of cells that are seen (default: gdal 255, grass 1)",
           command.visible_value);
  add_byte("--invisible-value,--iv", "of cells that are not (default: 0)", command.invisible_value);
  add_byte(
      "--out-of-range-value,--ov",
      "of cells that nobody looks at: too far, or outside of the field of view (default: gdal 0, grass no "
      "data)",
      command.out_of_range_value);
  add_value(
      raster, "--highest", "LENGTH",
      "of --mode height: nothing higher is tried; stands for what is not even seen there (default: 200)",
      [&command](const std::string& text) { command.highest = parse_number(text, 1e-6, 1e6); })
      ->group(group);
  add_value(raster, "--places", "N", "of --mode fraction: N x N places in every cell (default: 3)",
            [&command](const std::string& text) {
              command.places_across = static_cast<int>(parse_count(text, 1, k_most_places_across));
            })
      ->group(group);
}

void add_sight(CLI::App& raster, RasterCommand& command) {
  const char* const group = "Sight";
  add_choice<DefaultSet>(
      raster, "--like",
      "whose defaults hold for what is not said. gdal (gdal_viewshed): observers 2 above the ground, "
      "curvature 0.85714 where the cloud's unit is known; grass (r.viewshed): observers 1.75 above the "
      "ground, curvature 0, values 1 and 0, no data out of range (default: gdal)",
      command.like, {{"gdal", DefaultSet::gdal}, {"grass", DefaultSet::grass}})
      ->group(group);
  CLI::Option* const curvature = add_value(
      raster, "--curvature,--cc", "C",
      "how much of the Earth's curvature counts: 0 flat, 1 without air, 0.85714 for light, 0.75 for radio",
      [&command](const std::string& text) { command.curvature = parse_number(text, 0.0, 10.0); });
  curvature->group(group);
  add_value(raster, "--refraction_coeff", "R",
            "the same as r.viewshed has it with -c and -r: curvature 1 - R",
            [&command](const std::string& text) { command.curvature = 1.0 - parse_number(text, 0.0, 1.0); })
      ->excludes(curvature)
      ->group(group);
}

}  // namespace

std::shared_ptr<RasterCommand> add_raster_options(CLI::App& raster) {
  auto command = std::make_shared<RasterCommand>();
  add_cloud_files(raster, "cloud", command->files, k_cloud_help)->option_text("CLOUD...")->required();
  add_output(raster, *command);
  add_map_options(raster, command->map);
  add_values(raster, *command);
  add_observer_options(raster, command->observers);
  add_target_height(raster, command->map.target_height);
  add_sight(raster, *command);
  add_occluder_options(raster, command->occluders);
  add_checkpoint_options(raster, command->checkpoint);
  add_partial(raster, command->partial);
  add_threads(raster, command->threads);
  add_verbosity(raster, command->verbosity);
  return command;
}

SeenValues seen_values_of(const RasterCommand& command) {
  SeenValues values;
  if (default_set(command) == DefaultSet::grass) values = {.visible = 1, .invisible = 0, .out_of_range = {}};
  values.visible = command.visible_value.value_or(values.visible);
  values.invisible = command.invisible_value.value_or(values.invisible);
  if (command.out_of_range_value) values.out_of_range = command.out_of_range_value;
  return values;
}

}  // namespace alidade
