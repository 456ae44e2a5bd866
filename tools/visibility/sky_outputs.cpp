// SPDX-License-Identifier: MIT
#include "tools/visibility/sky_outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "octree/error.h"
#include "renderer/color/height_unit.h"
#include "tools/visibility/map_writer.h"
#include "tools/visibility/observer_options.h"

namespace alidade {
namespace {

constexpr const char* k_group = "Answers";

std::string lower_ending(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
  return ending;
}

}  // namespace

bool SkyRequest::is_map() const {
  const std::string ending = lower_ending(output);
  return ending == ".tif" || ending == ".tiff";
}

void add_sky_request(CLI::App& command, SkyRequest& request) {
  command
      .add_option("cloud", request.files, "cloud files, taken together as one, or an index file (.alidade)")
      ->option_text("CLOUD...")
      ->required();
  add_occluder_options(command, request.occluders);
  command
      .add_option("-o,--output", request.output,
                  "LAS 1.4 or PLY: the cloud with a value for every point; GeoTIFF: a map of the ground")
      ->option_text("FILE.las|FILE.ply|FILE.tif")
      ->required()
      ->group(k_group);
  add_choice<SkyReceiver>(command, "--receiver",
                          "what the light falls on at each point: its surface (default), or a horizontal one",
                          request.receiver,
                          {{"surface", SkyReceiver::surface}, {"horizontal", SkyReceiver::horizontal}})
      ->group(k_group);
  add_value(command, "--resolution", "LENGTH", "side of a map's cells (default: that of the ground's grid)",
            [&request](const std::string& text) { request.cell_size = parse_number(text, 1e-9, 1e9); })
      ->group(k_group);
  add_value(command, "--target-height", "LENGTH", "of a map's places above the ground (default: 0)",
            [&request](const std::string& text) { request.height = parse_number(text, 0.0, 1e6); })
      ->group(k_group);
  add_value(command, "--max-distance", "LENGTH", "nothing farther blocks (default: inf)",
            [&request](const std::string& text) {
              request.max_distance =
                  parse_length_limit(text).value_or(std::numeric_limits<double>::infinity());
            })
      ->group(k_group);
  command
      .add_option("--preview", request.preview,
                  "also draw a map over the shaded ground, with scale bar and legend")
      ->option_text("FILE.png")
      ->group(k_group);
  command.add_flag("--overwrite", request.overwrite, "replace an existing file")->group(k_group);
}

void check_sky_request(const SkyRequest& request) {
  const auto refuse = [](const std::string& option, const std::string& kind) {
    throw Error({.problem = "option " + option + " means nothing for this output", .expected = kind});
  };
  if (request.is_map()) {
    if (request.receiver) refuse("--receiver", "points (.las, .ply); cells of a map lie horizontally");
  } else {
    const std::string ending = lower_ending(request.output);
    if (ending != ".las" && ending != ".ply") {
      throw Error({.file = request.output.string(),
                   .problem = "the name tells no format",
                   .expected = "a name ending in .las, .ply or .tif"});
    }
    if (request.cell_size) refuse("--resolution", "a map (.tif)");
    if (request.height) refuse("--target-height", "a map (.tif)");
    if (!request.preview.empty()) refuse("--preview", "a map (.tif)");
  }
  check_writable(request.output, request.overwrite, request.files);
  if (request.preview.empty()) return;
  if (lower_ending(request.preview) != ".png") {
    throw Error({.file = request.preview.string(),
                 .problem = "previews are written as PNG",
                 .expected = "a name ending in .png"});
  }
  std::vector<std::filesystem::path> taken = request.files;
  taken.push_back(request.output);
  check_writable(request.preview, request.overwrite, taken);
}

void load_sky_writers(const SkyRequest& request) {
  if (request.is_map()) load_raster_writer();
  if (!request.preview.empty()) load_map_drawer();
}

SkyGround load_sky_ground(const SkyRequest& request, const VisibilityCloud& cloud) {
  ProgressLine line("finding the ground", "points", request.verbosity.verbosity());
  GroundOptions options;
  options.progress = line.callback();
  Ground ground = make_ground(cloud.octree(), cloud.columns.classifications, options);
  line.finish();
  const double cell_size = request.cell_size.value_or(ground.heights().grid.cell_size);
  const RasterGrid grid = grid_over(cloud.octree().bounds(), cell_size);
  return {std::move(ground), grid};
}

ResultColumn float_column(const std::string& name, const std::string& description,
                          std::function<float(std::size_t id)> value) {
  ResultColumn column;
  column.description.name = name;
  column.description.description = description;
  column.description.type = ScalarType::float32;
  column.description.byte_count = scalar_size(ScalarType::float32);
  column.fill = [value = std::move(value)](std::size_t first, std::size_t count, std::uint8_t* values) {
    for (std::size_t i = 0; i < count; ++i) {
      const float number = value(first + i);
      std::memcpy(values + i * sizeof(float), &number, sizeof(float));
    }
  };
  return column;
}

void write_sky_map(const SkyRequest& request, const VisibilityCloud& cloud, const RasterGrid& grid,
                   std::span<const SkyBand> bands,
                   std::vector<std::pair<std::string, std::string>> metadata) {
  RasterContents contents;
  contents.grid = grid;
  for (const SkyBand& band : bands)
    contents.bands.push_back({band.values, std::nan(""), band.description, band.unit});
  contents.crs = cloud.cloud.cloud.crs;
  contents.metadata = std::move(metadata);
  load_raster_writer()(request.output, contents, request.overwrite);
}

void write_sky_preview(const SkyRequest& request, const VisibilityCloud& cloud, const Ground& ground,
                       const Raster<float>& values, const SkyPicture& picture) {
  if (request.preview.empty()) return;
  MapPicture map;
  map.title = picture.title;
  map.values = values;
  map.scale = MapScale{picture.colors, {0.0, picture.highest}, picture.label};
  map.unit = height_unit(cloud.cloud.cloud.crs);
  map.notes = picture.notes;
  load_map_drawer()(map, ground, request.preview, request.overwrite);
}

std::string range_and_mean(const std::function<float(std::size_t)>& value, std::size_t count) {
  double low = std::numeric_limits<double>::infinity(), high = -low, sum = 0.0;
  std::size_t numbers = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double number = value(i);
    if (std::isnan(number)) continue;
    low = std::min(low, number);
    high = std::max(high, number);
    sum += number;
    ++numbers;
  }
  if (numbers == 0) return "nowhere";
  return fmt::format("{:.4g} to {:.4g}, mean {:.4g}", low, high, sum / static_cast<double>(numbers));
}

}  // namespace alidade
