// SPDX-License-Identifier: MIT
#include "tools/visibility/sky.h"

#include <fmt/format.h>
#include <cmath>

#include "base/words.h"
#include "geo/raster_file.h"
#include "tools/cloud/load_cloud.h"
#include "tools/image_module.h"
#include "tools/visibility/visibility_request.h"
#include "visibility/sky/sky_of_cloud.h"

namespace alidade::tools {
namespace {

/// Errors that need no cloud: an output of another format, or that cannot be written; options that do not
/// apply to this kind of output.
void check_sky_request(const SkyRequest& request) {
  const auto reject = [](const std::string& option, const std::string& kind) {
    throw input_error(option + " does not apply to this output", kind);
  };
  if (!request.is_map()) {
    if (!has_extension(request.output, {".las", ".laz", ".ply"}))
      throw file_error(request.output, "unknown output format", "the extension .las, .laz, .ply or .tif");
    if (const std::string option = given_map_field(request.map); !option.empty())
      reject(option, "a map (.tif)");
  }
  check_writable(request.output, request.overwrite, request.inputs());
  check_checkpoint(request.checkpoint, request.overwrite, {{request.output, request.map.preview}},
                   request.inputs());
  if (request.is_map()) check_map_writing(request.map, request.overwrite, request.inputs({request.output}));
}

struct SkyCommand : SkyRequest {
  int directions = 128;
};

visibility::SkyViewOptions sky_options(const SkyCommand& command) {
  return {.directions = command.directions,
          .receiver = command.receiver.value_or(command.is_map() ? visibility::SkyReceiver::horizontal
                                                                 : visibility::SkyReceiver::surface),
          .max_distance = command.max_distance};
}

/// Writes the map. Returns the result as text for people.
std::string map_sky(const SkyCommand& command, const SkySite& site, LongRun& long_run) {
  geo::Raster<float> views =
      long_run.work("testing the sky", "cells", [&](const Progress& progress, PartCheckpoint* parts) {
        return visibility::ground_sky_views(*site.cloud->occluders, *site.ground, site.grid,
                                            command.map.target_height.value_or(0.0), sky_options(command),
                                            {progress, parts});
      });
  const std::string found =
      range_and_mean([&](std::size_t i) { return views.values[i]; }, views.values.size());
  const SkyBand band{views, "SkyView", ""};
  write_sky_map(command, site, std::span(&band, 1),
                {{"alidade_sky", fmt::format("sky-view factor on the {}, {} directions",
                                             sky_options(command).receiver == visibility::SkyReceiver::surface
                                                 ? "slope of the ground"
                                                 : "horizontal",
                                             command.directions)}},
                {.title = "Sky-view factor",
                 .values = {},
                 .scale = visibility::MapScale{image::ColorMap::viridis, {0.0, 1.0}, "sky-view factor"}});
  return found;
}

std::string point_sky(const SkyCommand& command, const VisibilityCloud& cloud, LongRun& long_run) {
  const std::vector<float> views =
      long_run.work("testing the sky", "points", [&](const Progress& progress, PartCheckpoint* parts) {
        return visibility::point_sky_views(*cloud.occluders, cloud.columns.normals, sky_options(command),
                                           {progress, parts});
      });
  const auto value = [&views](std::size_t id) { return views[id]; };
  Console console(command.verbosity);
  write_points(command.output, cloud.cloud,
               {result_column<float>("SkyView", "sky-view factor, 0 to 1", ScalarType::float32, value)},
               command.overwrite, command.memory, console);
  return range_and_mean(value, views.size());
}

ExitCode run(const SkyCommand& command) {
  Console console(command.verbosity);
  const SkySite site = load_sky_site(command, 1, console);
  LongRun long_run(
      command.checkpoint, [&] { return sky_fingerprint(command, site); }, console);
  measure_occluders(*site.cloud, command.occluders, console);
  const std::string found =
      command.is_map() ? map_sky(command, site, long_run) : point_sky(command, *site.cloud, long_run);
  long_run.finish();
  say_note(command.verbosity, fmt::format("sky-view factors {}; wrote {}", found, command.output.string()));
  return ExitCode::done;
}

}  // namespace

bool SkyRequest::is_map() const {
  return has_extension(output, {".tif", ".tiff"});
}

void add_sky_request(const Fields& command, SkyRequest& request) {
  add_cloud(command, request.files, {"--ignore-classes"});
  const Fields group = command.group("Answers");
  group.required().file(
      "-o,--output", "FILE.las|FILE.laz|FILE.ply|FILE.tif",
      "output: LAS 1.4 or PLY with a value for every point; GeoTIFF with a map of the ground",
      request.output);
  group.flag("--overwrite", "replace existing files", request.overwrite);
  group.choice(
      "--receiver",
      "receiver: the surface of a point (default of points), the slope of the ground of a cell, or the "
      "horizontal "
      "(default of maps)",
      request.receiver,
      {{"surface", visibility::SkyReceiver::surface}, {"horizontal", visibility::SkyReceiver::horizontal}});
  group.value("--max-distance", "LENGTH", "largest distance of blocking points (default: inf)",
              request.max_distance, parse_distance_limit);
  add_map_fields(command, request.map);
  add_target_height(command.group(k_map_group), request.map.target_height);
  add_occluder_fields(command, request.occluders);
  add_checkpoint_fields(command.group("Long runs"), request.checkpoint);
  add_scratch_memory(command, request.memory);
  add_run_options(command, request);
}

SkySite load_sky_site(const SkyRequest& request, int bands, Console& console) {
  check_sky_request(request);
  const AttributeSet attributes = request.is_map() ? Attribute::classification : AttributeSet::all();
  const AcceptedInput accepted = request.is_map() ? AcceptedInput::points_or_raster : AcceptedInput::points;
  SkySite site{load_cloud_alone(request, attributes, accepted, console), {}, {}, {}};
  if (!request.is_map()) return site;
  site.ground = find_map_ground(request.map, *site.cloud, console);
  site.unit = cloud_unit(site.cloud->cloud.cloud.crs).name;
  site.grid =
      map_grid(request.map, map_area(request.map, *site.cloud), *site.ground, bands, site.unit, console);
  return site;
}

Fingerprint sky_fingerprint(const SkyRequest& request, const SkySite& site) {
  Fingerprint fingerprint = run_fingerprint(request.checkpoint, *site.cloud);
  if (site.ground) add_to_fingerprint(site.grid, fingerprint);
  const std::span<const glm::vec3> normals = site.cloud->columns.normals;
  fingerprint.push_back({"normals", fmt::format("{:016x}", checksum(std::as_bytes(normals)))});
  return fingerprint;
}

void write_sky_map(const SkyRequest& request, const SkySite& site, std::span<const SkyBand> bands,
                   const MapMetadata& metadata, visibility::MapImage image) {
  const Crs& crs = site.cloud->cloud.cloud.crs;
  if (!request.map.preview.empty()) {
    image.values = bands.front().values;
    image.unit = site.unit;
    image_module().write_map_image(image, *site.ground, request.map.preview, request.overwrite);
  }
  geo::RasterContents contents;
  contents.grid = site.grid;
  for (const SkyBand& band : bands) {
    std::ranges::replace_if(
        band.values.values, [](float value) { return std::isnan(value); }, static_cast<float>(k_no_float));
    contents.bands.push_back(
        {std::span<const float>(band.values.values), k_no_float, band.description, band.unit});
  }
  contents.crs = crs;
  contents.metadata = map_metadata(request, *site.cloud, *site.ground);
  contents.metadata.insert(contents.metadata.end(), metadata.begin(), metadata.end());
  contents.metadata.emplace_back("alidade_target_height",
                                 fmt::format("{:g}", request.map.target_height.value_or(0.0)));
  contents.metadata.emplace_back("alidade_max_distance", fmt::format("{:g}", request.max_distance));
  geo::write_raster(request.output, contents, request.overwrite);
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

Command add_visibility_sky(const Options& visibility) {
  auto command = std::make_shared<SkyCommand>();
  const Options sky = visibility.command("sky", "Compute sky-view factors of points or of the ground");
  add_sky_request(sky, *command);
  sky.group("Answers").count("--directions", "N",
                             "lines of sight per point or cell (default: 128, for an error of about 0.01)",
                             command->directions, 1, visibility::k_most_sky_directions);
  return command_of(sky, command, run);
}

}  // namespace alidade::tools
