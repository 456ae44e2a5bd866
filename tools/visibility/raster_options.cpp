// SPDX-License-Identifier: MIT
#include "tools/visibility/raster_options.h"

#include <array>
#include <string>

namespace alidade {
namespace {

Bounds parse_area(const std::string& text) {
  std::array<double, 4> numbers{};
  std::size_t begin = 0;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const bool last = i + 1 == numbers.size();
    const std::size_t end = last ? text.size() : text.find(',', begin);
    if (end == std::string::npos)
      throw CLI::ValidationError("expected XMIN,YMIN,XMAX,YMAX, found '" + text + "'");
    numbers[i] = parse_number(text.substr(begin, end - begin));
    begin = end + 1;
  }
  const Bounds area{{numbers[0], numbers[1], 0.0}, {numbers[2], numbers[3], 0.0}};
  if (area.empty())
    throw CLI::ValidationError("expected XMIN,YMIN,XMAX,YMAX with min <= max, found '" + text + "'");
  return area;
}

void add_map(CLI::App& raster, RasterCommand& command) {
  const char* const group = "Map";
  raster.add_option("-o,--output", command.output, "map to write: cloud-optimised GeoTIFF")
      ->option_text("FILE.tif")
      ->required()
      ->group(group);
  raster.add_option("--preview", command.preview, "also draw it: relief, observers, scale bar, legend")
      ->option_text("FILE.png")
      ->group(group);
  add_value(raster, "--resolution", "LENGTH",
            "side of a cell (default: 1, 2 or 5 times a power of ten, for at most 1000 cells along a side)",
            [&command](const std::string& text) { command.resolution = parse_number(text, 1e-6, 1e9); })
      ->group(group);
  add_value(raster, "--area", "XMIN,YMIN,XMAX,YMAX",
            "only this part of the cloud (default: all of it, as far as --max-distance reaches)",
            [&command](const std::string& text) { command.area = parse_area(text); })
      ->group(group);
  raster.add_flag("--overwrite", command.overwrite, "replace existing files")->group(group);
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
              command.places_across = static_cast<int>(parse_count(text, 1, 100));
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
  add_value(
      raster, "--curvature,--cc", "C",
      "how much of the Earth's curvature counts: 0 flat, 1 without air, 0.85714 for light, 0.75 for radio",
      [&command](const std::string& text) { command.curvature = parse_number(text, 0.0, 10.0); })
      ->group(group);
}

void add_ground(CLI::App& raster, RasterCommand& command) {
  const char* const group = "Ground";
  add_choice<GroundSource>(
      raster, "--ground",
      "what cells stand on: points of class 2, or the lowest points (default: auto, class 2 if there is any)",
      command.ground_source,
      {{"auto", GroundSource::automatic},
       {"class", GroundSource::classified},
       {"lowest", GroundSource::lowest}})
      ->group(group);
  add_value(
      raster, "--ground-cell", "LENGTH",
      "side of the cells whose ground is found (default: the mean distance of the points of class 2, or "
      "four times that of all points)",
      [&command](const std::string& text) { command.ground.cell_size = parse_number(text, 1e-6, 1e9); })
      ->group(group);
  add_value(raster, "--ground-reach", "LENGTH",
            "no ground farther than this from the cloud's points (default: 10)",
            [&command](const std::string& text) { command.ground.reach = parse_number(text, 0.0, 1e9); })
      ->group(group);
}

}  // namespace

std::shared_ptr<RasterCommand> add_raster_options(CLI::App& raster) {
  auto command = std::make_shared<RasterCommand>();
  raster
      .add_option("cloud", command->files, "cloud files, taken together as one, or an index file (.alidade)")
      ->option_text("CLOUD...")
      ->required();
  add_map(raster, *command);
  add_values(raster, *command);
  add_observer_options(raster, command->observers);
  add_target_height(raster, command->target_height);
  add_sight(raster, *command);
  add_occluder_options(raster, command->occluders);
  add_ground(raster, *command);
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
