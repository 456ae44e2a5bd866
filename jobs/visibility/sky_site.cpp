// SPDX-License-Identifier: MIT
#include "jobs/visibility/sky_site.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/words.h"
#include "geo/raster_file.h"
#include "jobs/large_clouds.h"
#include "jobs/load_cloud.h"
#include "jobs/outputs.h"
#include "jobs/visibility/observer_request.h"
#include "jobs/visibility/run_fingerprint.h"

namespace alidade::jobs {

bool SkySiteRequest::is_map() const {
  return output.empty() ? !given_map_field(map).empty() : has_extension(output, {".tif", ".tiff"});
}

void add_sky_site_fields(const Fields& fields, SkySiteRequest& request) {
  const Fields group = fields.group("Answers");
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
  add_map_fields(fields, request.map);
  add_target_height(fields.group(k_map_group), request.map.target_height);
  add_occluder_fields(fields, request.occluders);
  add_checkpoint_fields(fields.group("Long runs"), request.checkpoint);
  add_scratch_memory(fields, request.memory);
}

PlannedWork plan_sky_site(const SkySiteRequest& request, std::initializer_list<std::filesystem::path> reads) {
  const auto reject = [](const std::string& option, const std::string& kind) {
    throw input_error(option + " does not apply to this output", kind);
  };
  if (!request.is_map()) {
    if (!request.output.empty() && !has_extension(request.output, {".las", ".laz", ".ply"}))
      throw file_error(request.output, "unknown output format", "the extension .las, .laz, .ply or .tif");
    if (const std::string option = given_map_field(request.map); !option.empty())
      reject(option, "a map (.tif)");
  }
  if (request.is_map()) load_map_writer(request.map);
  PlannedWork work = request.work(reads, {request.map.preview});
  check_outputs(work, request.overwrite);
  check_checkpoint(request.checkpoint, request.overwrite, work);
  return work;
}

SkySite load_sky_site(const SkySiteRequest& request, int bands, Listener& listener) {
  const AttributeSet attributes = request.is_map() ? Attribute::classification : AttributeSet::all();
  const AcceptedInput accepted = request.is_map() ? AcceptedInput::points_or_raster : AcceptedInput::points;
  SkySite site{load_cloud_alone(request, attributes, accepted, listener), {}, {}, {}};
  if (!request.is_map()) return site;
  site.ground = find_map_ground(request.map, *site.cloud, listener);
  site.unit = cloud_unit(site.cloud->cloud.cloud.crs).name;
  site.grid =
      map_grid(request.map, map_area(request.map, *site.cloud), *site.ground, bands, site.unit, listener);
  return site;
}

Fingerprint sky_fingerprint(const SkySiteRequest& request, const SkySite& site) {
  Fingerprint fingerprint = run_fingerprint(request.checkpoint, *site.cloud);
  if (site.ground) add_to_fingerprint(site.grid, fingerprint);
  const std::span<const glm::vec3> normals = site.cloud->columns.normals;
  fingerprint.push_back({"normals", fmt::format("{:016x}", checksum(std::as_bytes(normals)))});
  return fingerprint;
}

MapMetadata write_sky_map(const SkySiteRequest& request, const SkySite& site, std::span<const SkyBand> bands,
                          const MapMetadata& metadata, visibility::MapImage image) {
  const Crs& crs = site.cloud->cloud.cloud.crs;
  if (!request.map.preview.empty()) {
    image.values = bands.front().values;
    image.unit = site.unit;
    visibility::write_map_image(image, *site.ground, request.map.preview, request.overwrite);
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
  if (!request.output.empty()) geo::write_raster(request.output, contents, request.overwrite);
  return contents.metadata;
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

}  // namespace alidade::jobs
