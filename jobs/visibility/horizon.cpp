// SPDX-License-Identifier: MIT
#include "jobs/visibility/horizon.h"

#include <fmt/format.h>
#include <algorithm>
#include <string>
#include <utility>

#include "base/error.h"
#include "base/output_file.h"
#include "base/words.h"
#include "camera/camera.h"
#include "cloud/axis_units.h"
#include "geo/earth.h"
#include "geo/gdal_library.h"
#include "image/image_file.h"
#include "jobs/cloud_fields.h"
#include "jobs/large_clouds.h"
#include "jobs/load_cloud.h"
#include "jobs/outputs.h"
#include "jobs/visibility/row_output.h"
#include "renderer/image_metadata.h"
#include "visibility/horizon/skyline.h"
#include "visibility/horizon/skyline_image.h"
#include "visibility/raster/ground.h"
#include "visibility/sky/sky_view.h"

namespace alidade::jobs {
namespace {

/// An observer and its horizon.
struct View {
  visibility::Observer observer;
  visibility::SightEnd eye;
  std::vector<visibility::HorizonDirection> line;
  visibility::HorizonFacts facts;
};

/// Without an output the rows are CSV.
bool is_geojson(const HorizonRequest& request) {
  using visibility::RowForm;
  return visibility::row_form(request.output).value_or(RowForm::csv) != RowForm::csv;
}

void add_answers(const Fields& fields, HorizonRequest& request) {
  const Fields group = fields.group("Answers");
  group.file("-o,--output", "FILE.csv|FILE.geojson",
             "horizon as CSV or GeoJSON, by the extension (default: CSV to stdout)", request.output);
  group.file("--skyline", "FILE.png", "also draw the skyline, coloured by distance", request.skyline);
  group.file("--depth", "FILE.exr",
             "also write a panorama of distances (layers Z, distance and id), north in the middle",
             request.depth);
  group.value("--depth-size", "WxH", "pixels of the panorama (default: 2048x1024)", request.depth_size,
              parse_image_size);
  group.number("--step", "DEGREES", "azimuth step in degrees; divides 360 (default: 0.5)", request.step,
               0.001, 120.0);
  group.number("--resolution", "DEGREES", "elevation step in degrees; divides 90 (default: 0.01)",
               request.resolution, 0.0001, 10.0);
  group.count("--directions", "N", "lines to the sky for the sky-view factor (default: 4096)",
              request.sky_directions, 1, visibility::k_most_sky_directions);
  group.flag("--overwrite", "replace existing files", request.overwrite);
}

visibility::Observer only_observer(const HorizonRequest& request, const VisibilityCloud& cloud,
                                   Listener& listener) {
  const std::vector<visibility::Observer> observers = load_observers(request.observers, cloud, listener);
  if (observers.size() != 1) {
    throw input_error("a horizon requires a single observer", "one observer",
                      std::to_string(observers.size()));
  }
  return observers.front();
}

/// Degrees from the first azimuth of the field of view clockwise to the second.
double width_of_view(const visibility::Observer& observer) {
  const double width = observer.azimuth_max - observer.azimuth_min;
  return width > 0.0 ? std::min(width, 360.0) : width + 360.0;
}

/// The part of the horizon in the field of view. Errors: it contains no azimuth.
std::vector<visibility::HorizonDirection> horizon_line(const HorizonRequest& request,
                                                       const VisibilityCloud& cloud, const View& view,
                                                       Listener& listener) {
  visibility::HorizonOptions options;
  options.step = request.step;
  options.resolution = request.resolution;
  options.azimuth_min = view.observer.azimuth_min;
  options.azimuth_max = view.observer.azimuth_max;
  options.elevation_min = view.observer.elevation_min;
  options.elevation_max = view.observer.elevation_max;
  options.max_distance = view.observer.max_distance;
  std::vector<visibility::HorizonDirection> line =
      in_stage(listener, "computing the horizon", "azimuths", [&](const Progress& progress) {
        return visibility::horizon(*cloud.occluders, view.eye, options, progress);
      });
  if (line.empty()) {
    throw input_error("the field of view contains no azimuth",
                      "a smaller --step or a wider --horizontal-fov");
  }
  SilentListener quiet(listener);
  const visibility::Ground ground = find_ground(cloud, {}, quiet);
  for (visibility::HorizonDirection& one : line) {
    if (!one.blocker) continue;
    one.unscanned = visibility::unscanned_length(ground, glm::dvec2(view.eye.position),
                                                 glm::dvec2(one.blocker->position));
  }
  return line;
}

View look_around(const HorizonRequest& request, const VisibilityCloud& cloud,
                 const visibility::Observer& observer, Listener& listener) {
  View view;
  view.observer = observer;
  view.eye = visibility::end_near_surface(*cloud.occluders, observer.position);
  view.line = horizon_line(request, cloud, view, listener);
  view.facts.eye = observer.position;
  const bool all_round =
      width_of_view(observer) >= 360.0 && observer.elevation_min <= 0.0 && observer.elevation_max >= 90.0;
  if (all_round) view.facts.above_line = visibility::sky_above(view.line);
  view.facts.sky =
      visibility::sky_shares(*cloud.occluders, view.eye, request.sky_directions, observer.max_distance);
  return view;
}

void write_line(const HorizonRequest& request, const Crs& crs, const View& view, Listener& listener) {
  std::string text;
  if (is_geojson(request)) {
    const auto on_globe = geo::lon_lat(crs, visibility::horizon_positions(view.line, view.facts));
    if (!on_globe) warn_of_cloud_coordinates(request.output, listener);
    text = visibility::horizon_geojson(view.line, view.facts, on_globe);
  } else {
    text = visibility::horizon_csv(view.line);
  }
  write_text_file(request.output, text, request.overwrite);
}

std::string sky_text(const visibility::SkyShares& sky) {
  return fmt::format("sky-view factor {:.3f}, {:.3f} of the solid angle", sky.cosine_weighted,
                     sky.solid_angle);
}

void write_image(const HorizonRequest& request, const VisibilityCloud& cloud, const View& view,
                 Listener& listener) {
  const double from = view.observer.azimuth_min;
  visibility::DepthStrip strip =
      visibility::strip_around(view.line, from, from + width_of_view(view.observer));
  in_stage(listener, "drawing the skyline", "lines of sight", [&](const Progress& progress) {
    visibility::fill_strip(*cloud.occluders, view.eye, view.observer.max_distance, strip, progress);
  });
  const glm::dvec3& eye = view.observer.position;
  const visibility::SkylineTexts texts{
      fmt::format("Skyline from {:.2f}, {:.2f}, {:.2f}", eye.x, eye.y, eye.z), sky_text(view.facts.sky),
      height_unit_label(cloud.cloud.cloud.crs)};
  visibility::write_skyline(strip, view.line, texts, request.skyline, request.overwrite);
}

image::Film write_depth(const HorizonRequest& request, const VisibilityCloud& cloud, const View& view,
                        Listener& listener) {
  const int width = request.depth_size.width, height = request.depth_size.height;
  image::Film film =
      in_stage(listener, "measuring the panorama", "lines of sight", [&](const Progress& progress) {
        return visibility::depth_panorama(*cloud.occluders, view.eye, width, height,
                                          view.observer.max_distance, progress);
      });
  image::OutputSettings output;
  output.file = request.depth;
  output.layers = {image::Layer::depth, image::Layer::distance, image::Layer::id};
  renderer::ImageMetadata metadata;
  metadata.camera = camera::panorama_camera(view.observer.position, width, height);
  metadata.render.samples = 1;
  metadata.render.max_bounces = 0;
  metadata.command = request.command;
  for (const CloudFile& file : cloud.cloud.cloud.files) metadata.cloud_files.push_back(kept_name(file.path));
  metadata.cloud_offset = cloud.octree().lattice().offset;
  metadata.crs = cloud.cloud.cloud.crs;
  renderer::write_image(film, output, metadata, request.overwrite);
  return film;
}

void say_findings(const View& view, Listener& listener) {
  if (!listener.is_listening()) return;
  const auto highest = std::ranges::max_element(
      view.line, {},
      [](const visibility::HorizonDirection& direction) { return direction.elevation.value_or(-100.0); });
  if (!highest->elevation) {
    listener.note("nothing blocks the view in any azimuth");
  } else {
    listener.note(fmt::format("the horizon is highest at azimuth {:g}: {:g} degrees, {:.2f} away",
                              highest->azimuth, *highest->elevation, highest->blocker->distance));
  }
  std::string text = sky_text(view.facts.sky);
  if (view.facts.above_line) {
    text += fmt::format("; {:.3f} and {:.3f} with everything below the horizon blocked",
                        view.facts.above_line->cosine_weighted, view.facts.above_line->solid_angle);
  }
  listener.note(text);
}

}  // namespace

void add_horizon_fields(const Fields& fields, HorizonRequest& request) {
  add_cloud(fields, request.files, {"--ignore-classes"});
  add_observer_fields(fields, request.observers);
  add_occluder_fields(fields, request.occluders);
  add_answers(fields, request);
  add_scratch_memory(fields, request.memory);
  add_partial(fields, request.partial);
}

HorizonPlan plan(const HorizonRequest& request) {
  const auto require = [](const std::filesystem::path& file, bool right, const char* expected) {
    if (file.empty() || right) return;
    throw file_error(file, "unknown output format", expected);
  };
  require(request.output, visibility::row_form(request.output).has_value(), "the extension .csv or .geojson");
  require(request.skyline, has_extension(request.skyline, {".png"}), "the extension .png");
  require(request.depth, has_extension(request.depth, {".exr"}), "the extension .exr");
  PlannedWork work = request.work({request.observers.file}, {request.skyline, request.depth});
  check_outputs(work, request.overwrite);
  if (!request.skyline.empty() || !request.depth.empty()) image::load_library();
  if (is_geojson(request)) geo::load_gdal();
  check_given(request.observers);
  return HorizonPlan(request, std::move(work));
}

HorizonResult run(const HorizonPlan& plan, Listener& listener) {
  const HorizonRequest& request = plan.request();
  const auto cloud =
      load_cloud_alone(request, Attribute::classification, AcceptedInput::points_or_raster, listener);
  const visibility::Observer observer = only_observer(request, *cloud, listener);
  measure_occluders(*cloud, request.occluders, listener);
  say_observer_remarks(std::span(&observer, 1), *cloud, listener);
  View view = look_around(request, *cloud, observer, listener);
  const Crs& crs = cloud->cloud.cloud.crs;
  HorizonResult result;
  if (!request.skyline.empty()) write_image(request, *cloud, view, listener);
  if (!request.depth.empty()) result.panorama = write_depth(request, *cloud, view, listener);
  if (!request.output.empty()) write_line(request, crs, view, listener);
  say_findings(view, listener);
  result.observer = std::move(view.observer);
  result.line = std::move(view.line);
  result.facts = view.facts;
  result.crs = crs;
  return result;
}

}  // namespace alidade::jobs
