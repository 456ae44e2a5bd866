// SPDX-License-Identifier: MIT
#include "visibility/horizon/horizon.h"

#include <fmt/format.h>

#include "base/output_file.h"
#include "base/words.h"
#include "camera/camera.h"
#include "cloud/axis_units.h"
#include "geo/earth.h"
#include "geo/gdal_library.h"
#include "image/image_file.h"
#include "jobs/visibility/row_output.h"
#include "renderer/image_metadata.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"
#include "tools/visibility/visibility_request.h"
#include "visibility/horizon/skyline.h"
#include "visibility/horizon/skyline_image.h"
#include "visibility/sky/sky_view.h"

namespace alidade::tools {
namespace {

struct HorizonCommand : VisibilityRequest {
  ObserverRequest observers;
  double step = 0.5, resolution = 0.01;
  int sky_directions = 4096;
  std::filesystem::path skyline, depth;
  ImageSize depth_size{2048, 1024};
};

/// An observer and its horizon.
struct View {
  visibility::Observer observer;
  visibility::SightEnd eye;
  std::vector<visibility::HorizonDirection> line;
  visibility::HorizonFacts facts;
};

bool is_geojson(const std::filesystem::path& file) {
  return has_extension(file, {".geojson", ".json"});
}

/// Errors that need no cloud.
void check_options(const HorizonCommand& command) {
  const auto require = [](const std::filesystem::path& file, bool right, const char* expected) {
    if (file.empty() || right) return;
    throw file_error(file, "unknown output format", expected);
  };
  require(command.output, is_geojson(command.output) || has_extension(command.output, {".csv"}),
          "the extension .csv or .geojson");
  require(command.skyline, has_extension(command.skyline, {".png"}), "the extension .png");
  require(command.depth, has_extension(command.depth, {".exr"}), "the extension .exr");
  const std::filesystem::path outputs[] = {command.output, command.skyline, command.depth};
  check_outputs(outputs, command.overwrite, command.inputs({command.observers.file}));
}

visibility::Observer only_observer(const HorizonCommand& command, const VisibilityCloud& cloud,
                                   Console& console) {
  const std::vector<visibility::Observer> observers = load_observers(command.observers, cloud, console);
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

View look_around(const HorizonCommand& command, const VisibilityCloud& cloud,
                 const visibility::Observer& observer) {
  const visibility::Occluders& occluders = *cloud.occluders;
  View view;
  view.observer = observer;
  view.eye = visibility::end_near_surface(occluders, view.observer.position);
  visibility::HorizonOptions options;
  options.step = command.step;
  options.resolution = command.resolution;
  options.azimuth_min = view.observer.azimuth_min;
  options.azimuth_max = view.observer.azimuth_max;
  options.elevation_min = view.observer.elevation_min;
  options.elevation_max = view.observer.elevation_max;
  options.max_distance = view.observer.max_distance;
  view.line = with_progress(
      "computing the horizon", "azimuths", command.verbosity,
      [&](const Progress& progress) { return visibility::horizon(occluders, view.eye, options, progress); });
  if (view.line.empty()) {
    throw input_error("the field of view contains no azimuth",
                      "a smaller --step or a wider --horizontal-fov");
  }
  Console quiet(Verbosity::quiet);
  const visibility::Ground ground = find_ground(cloud, {}, quiet);
  for (visibility::HorizonDirection& one : view.line) {
    if (!one.blocker) continue;
    one.unscanned = visibility::unscanned_length(ground, glm::dvec2(view.eye.position),
                                                 glm::dvec2(one.blocker->position));
  }
  view.facts.eye = view.observer.position;
  const bool all_round =
      width_of_view(observer) >= 360.0 && observer.elevation_min <= 0.0 && observer.elevation_max >= 90.0;
  if (all_round) view.facts.above_line = visibility::sky_above(view.line);
  view.facts.sky = visibility::sky_shares(occluders, view.eye, command.sky_directions, options.max_distance);
  return view;
}

void write_line(const HorizonCommand& command, const VisibilityCloud& cloud, const View& view) {
  std::string text;
  if (is_geojson(command.output)) {
    const auto on_globe =
        geo::lon_lat(cloud.cloud.cloud.crs, visibility::horizon_positions(view.line, view.facts));
    Console console(command.verbosity);
    if (!on_globe) warn_of_cloud_coordinates(command.output, console);
    text = visibility::horizon_geojson(view.line, view.facts, on_globe);
  } else {
    text = visibility::horizon_csv(view.line);
  }
  if (command.output.empty()) return write_to_stdout(text);
  write_text_file(command.output, text, command.overwrite);
}

std::string sky_text(const visibility::SkyShares& sky) {
  return fmt::format("sky-view factor {:.3f}, {:.3f} of the solid angle", sky.cosine_weighted,
                     sky.solid_angle);
}

void write_image(const HorizonCommand& command, const VisibilityCloud& cloud, const View& view) {
  const double from = view.observer.azimuth_min;
  visibility::DepthStrip strip =
      visibility::strip_around(view.line, from, from + width_of_view(view.observer));
  with_progress("drawing the skyline", "lines of sight", command.verbosity, [&](const Progress& progress) {
    visibility::fill_strip(*cloud.occluders, view.eye, view.observer.max_distance, strip, progress);
  });
  const glm::dvec3& eye = view.observer.position;
  const visibility::SkylineTexts texts{
      fmt::format("Skyline from {:.2f}, {:.2f}, {:.2f}", eye.x, eye.y, eye.z), sky_text(view.facts.sky),
      height_unit_label(cloud.cloud.cloud.crs)};
  visibility::write_skyline(strip, view.line, texts, command.skyline, command.overwrite);
}

void write_depth(const HorizonCommand& command, const VisibilityCloud& cloud, const View& view) {
  const int width = command.depth_size.width, height = command.depth_size.height;
  const image::Film film = with_progress(
      "measuring the panorama", "lines of sight", command.verbosity, [&](const Progress& progress) {
        return visibility::depth_panorama(*cloud.occluders, view.eye, width, height,
                                          view.observer.max_distance, progress);
      });
  image::OutputSettings output;
  output.file = command.depth;
  output.layers = {image::Layer::depth, image::Layer::distance, image::Layer::id};
  renderer::ImageMetadata metadata;
  metadata.camera = camera::panorama_camera(view.observer.position, width, height);
  metadata.render.samples = 1;
  metadata.render.max_bounces = 0;
  metadata.command = metadata_command(command.words);
  for (const CloudFile& file : cloud.cloud.cloud.files) metadata.cloud_files.push_back(kept_name(file.path));
  metadata.cloud_offset = cloud.octree().lattice().offset;
  metadata.crs = cloud.cloud.cloud.crs;
  image::write_image(film, output, renderer::image_facts(metadata, output), command.overwrite);
}

void say_findings(const HorizonCommand& command, const View& view) {
  if (command.verbosity == Verbosity::quiet) return;
  const auto highest = std::ranges::max_element(
      view.line, {},
      [](const visibility::HorizonDirection& direction) { return direction.elevation.value_or(-100.0); });
  if (!highest->elevation) {
    say_note("nothing blocks the view in any azimuth");
  } else {
    say_note(fmt::format("the horizon is highest at azimuth {:g}: {:g} degrees, {:.2f} away",
                         highest->azimuth, *highest->elevation, highest->blocker->distance));
  }
  std::string text = sky_text(view.facts.sky);
  if (view.facts.above_line) {
    text += fmt::format("; {:.3f} and {:.3f} with everything below the horizon blocked",
                        view.facts.above_line->cosine_weighted, view.facts.above_line->solid_angle);
  }
  say_note(text);
}

ExitCode run(const HorizonCommand& command) {
  check_options(command);
  // Fails before the work if what writes the output is missing.
  if (!command.skyline.empty() || !command.depth.empty()) image::load_library();
  if (is_geojson(command.output)) geo::load_gdal();
  Console console(command.verbosity);
  check_given(command.observers);
  const auto cloud =
      load_cloud_alone(command, Attribute::classification, AcceptedInput::points_or_raster, console);
  const visibility::Observer observer = only_observer(command, *cloud, console);
  measure_occluders(*cloud, command.occluders, console);
  say_observer_remarks(std::span(&observer, 1), *cloud, console);
  const View view = look_around(command, *cloud, observer);
  if (!command.skyline.empty()) write_image(command, *cloud, view);
  if (!command.depth.empty()) write_depth(command, *cloud, view);
  write_line(command, *cloud, view);
  say_findings(command, view);
  return ExitCode::done;
}

void add_answers(const Fields& horizon, HorizonCommand& command) {
  const Fields group = horizon.group("Answers");
  group.file("-o,--output", "FILE.csv|FILE.geojson",
             "horizon as CSV or GeoJSON, by the extension (default: CSV to stdout)", command.output);
  group.file("--skyline", "FILE.png", "also draw the skyline, coloured by distance", command.skyline);
  group.file("--depth", "FILE.exr",
             "also write a panorama of distances (layers Z, distance and id), north in the middle",
             command.depth);
  group.value("--depth-size", "WxH", "pixels of the panorama (default: 2048x1024)", command.depth_size,
              parse_image_size);
  group.number("--step", "DEGREES", "azimuth step in degrees; divides 360 (default: 0.5)", command.step,
               0.001, 120.0);
  group.number("--resolution", "DEGREES", "elevation step in degrees; divides 90 (default: 0.01)",
               command.resolution, 0.0001, 10.0);
  group.count("--directions", "N", "lines to the sky for the sky-view factor (default: 4096)",
              command.sky_directions, 1, visibility::k_most_sky_directions);
  group.flag("--overwrite", "replace existing files", command.overwrite);
}

}  // namespace

Command add_visibility_horizon(const Options& visibility) {
  auto command = std::make_shared<HorizonCommand>();
  const Options horizon =
      visibility.command("horizon", "Compute the horizon, sky-view factors and a panorama at one position");
  add_cloud(horizon, command->files, {"--ignore-classes"});
  add_observer_fields(horizon, command->observers);
  add_occluder_fields(horizon, command->occluders);
  add_answers(horizon, *command);
  add_scratch_memory(horizon, command->memory);
  add_run_options(horizon, *command);
  return command_of(horizon, command, run);
}

}  // namespace alidade::tools
