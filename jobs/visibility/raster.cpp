// SPDX-License-Identifier: MIT
#include "jobs/visibility/raster.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "base/error.h"
#include "base/shown_text.h"
#include "geo/raster_file.h"
#include "jobs/cloud_fields.h"
#include "jobs/large_clouds.h"
#include "jobs/load_cloud.h"
#include "jobs/outputs.h"
#include "jobs/visibility/run_fingerprint.h"
#include "visibility/objects.h"
#include "visibility/raster/map_image.h"
#include "visibility/raster/map_targets.h"
#include "visibility/read_observers.h"

namespace alidade::jobs {
namespace {

void add_values(const Fields& raster, RasterRequest& request) {
  const Fields group = raster.group("Values");
  group.choice(
      "--mode",
      "value of the cells, see below; size and solid-angle require objects (default: visible, with objects "
      "fraction)",
      request.given_mode,
      {{"visible", visibility::ViewshedMode::visible},
       {"count", visibility::ViewshedMode::count},
       {"height", visibility::ViewshedMode::height},
       {"fraction", visibility::ViewshedMode::fraction},
       {"size", visibility::ViewshedMode::size},
       {"solid-angle", visibility::ViewshedMode::angle}});
  const auto add_byte = [&](const char* names, const char* help, std::optional<std::uint8_t>& target) {
    group.count(names, "0..255", help, target, 0, 255);
  };
  add_byte("--visible-value,--vv", "for --mode visible: value of visible cells (default: gdal 255, grass 1)",
           request.visible_value);
  add_byte("--invisible-value,--iv", "value of invisible cells (default: 0)", request.invisible_value);
  add_byte("--out-of-range-value,--ov",
           "value of cells too far away or outside the field of view (default: gdal 0, grass nodata)",
           request.out_of_range_value);
  group.number(
      "--highest", "LENGTH",
      "for --mode height: largest height, also the value of cells not visible up to it (default: 200)",
      request.highest, 1e-6, 1e6);
  group.count("--places", "N",
              "for --mode fraction: N x N positions in every cell (default: 3, with objects 1)",
              request.positions_across, 1, visibility::k_most_positions_across);
}

void add_objects(const Fields& fields, ObjectRequest& options) {
  const Fields group = fields.group("Objects");
  group.values(
      "--object", "X,Y,Z0,Z1",
      "instead of observers: how much of a vertical object (mast, wind turbine) from height Z0 to Z1 is "
      "visible from each cell; repeatable",
      [&options](const std::string& text) { options.segments.push_back(visibility::parse_object(text)); });
  group.file(
      "--objects", "FILE",
      "objects from a file: points (vertical objects), lines (walls) and polygons (outer walls of "
      "buildings) of GeoJSON, GeoPackage or Shapefile with the attribute height and optionally z (of the "
      "foot) and name; or CSV with the header x,y[,z],height[,name]",
      options.file);
  group.text(
      "--objects-crs", "SYSTEM|cloud",
      "reference system of the objects, such as EPSG:4326 (x is east), overriding their file; cloud: the "
      "cloud's (default: the file's, for CSV and --object the cloud's)",
      options.reference);
  group.number("--object-spacing", "LENGTH",
               "distance of the samples on an object, vertical and along walls (default: 1)", options.spacing,
               1e-3, 1e9);
  group.number("--object-width", "LENGTH",
               "width of vertical objects, which --mode solid-angle requires (default: 0)", options.width,
               0.0, 1e6);
}

void add_sight(const Fields& raster, RasterRequest& request) {
  const Fields group = raster.group("Sight");
  group.choice("--like",
               "source of the defaults. gdal (gdal_viewshed): observers 2 above the ground, curvature "
               "0.85714 if the cloud's unit is known; grass (r.viewshed): observers 1.75 above the ground, "
               "curvature 0, values 1 and 0, nodata out of range (default: gdal)",
               request.like, {{"gdal", DefaultSet::gdal}, {"grass", DefaultSet::grass}});
  const Field curvature =
      group.number("--curvature,--cc", "C",
                   "share of the Earth's curvature: 0 flat, 1 without air, 0.85714 for light, 0.75 for radio",
                   request.curvature, 0.0, 10.0);
  group.excludes(curvature).value(
      "--refraction_coeff", "R", "the same as -c and -r of r.viewshed: curvature 1 - R",
      [&request](const std::string& text) { request.curvature = 1.0 - parse_number(text, 0.0, 1.0); });
}

/// The given values, others from the chosen set of defaults.
visibility::SeenValues seen_values_of(const RasterRequest& request) {
  visibility::SeenValues values;
  if (request.like == DefaultSet::grass) values = {.visible = 1, .invisible = 0, .out_of_range = {}};
  values.visible = request.visible_value.value_or(values.visible);
  values.invisible = request.invisible_value.value_or(values.invisible);
  if (request.out_of_range_value) values.out_of_range = request.out_of_range_value;
  return values;
}

constexpr const char* k_mode_words[] = {"visible", "count", "height", "fraction", "size", "solid-angle"};

/// Errors: fields that do not apply to the mode, or exclude each other.
void check_values(const RasterRequest& request) {
  const visibility::ViewshedMode mode = request.mode();
  const auto check = [mode](bool is_given, const std::string& option, visibility::ViewshedMode of) {
    if (!is_given || mode == of) return;
    throw input_error(option + " does not apply to this map",
                      fmt::format("--mode {}", k_mode_words[static_cast<std::size_t>(of)]));
  };
  check(request.visible_value.has_value(), "--visible-value", visibility::ViewshedMode::visible);
  check(request.invisible_value.has_value(), "--invisible-value", visibility::ViewshedMode::visible);
  check(request.out_of_range_value.has_value(), "--out-of-range-value", visibility::ViewshedMode::visible);
  check(request.highest.has_value(), "--highest", visibility::ViewshedMode::height);
  check(request.positions_across.has_value(), "--places", visibility::ViewshedMode::fraction);
  const visibility::SeenValues values = seen_values_of(request);
  if (values.visible == values.invisible) {
    throw input_error("visible and invisible cells have the same value",
                      "different values for --visible-value and --invisible-value",
                      std::to_string(values.visible) + " for both");
  }
  const double highest = request.highest.value_or(visibility::ViewshedOptions().highest);
  if (mode == visibility::ViewshedMode::height && highest <= request.map.target_height.value_or(0.0))
    throw Error({.problem = "--highest does not exceed --target-height"});
}

/// Errors: both observers and objects; fields or a mode that require the other of these.
void check_objects(const RasterRequest& request) {
  const ObserverRequest& observers = request.observers;
  const visibility::ViewshedMode mode = request.mode();
  if (!request.objects.any()) {
    if (const std::string given = request.objects.given(); !given.empty())
      throw input_error(given + " requires objects", "--object or --objects");
    if (mode == visibility::ViewshedMode::size || mode == visibility::ViewshedMode::angle) {
      throw input_error(
          fmt::format("--mode {} requires objects", k_mode_words[static_cast<std::size_t>(mode)]),
          "--object or --objects");
    }
    return;
  }
  if (!observers.positions.empty() || !observers.file.empty() || observers.grid)
    throw input_error("observers and objects in one map", "either of them");
  if (mode == visibility::ViewshedMode::height)
    throw input_error("--mode height does not apply to objects", "another mode");
  const visibility::ObserverDefaults all_round, &view = observers.defaults;
  if (view.azimuth_min != all_round.azimuth_min || view.azimuth_max != all_round.azimuth_max ||
      view.elevation_min != all_round.elevation_min || view.elevation_max != all_round.elevation_max)
    throw input_error("a field of view does not apply to objects", "no --horizontal-fov and --vertical-fov");
  if (request.map.target_height) {
    throw input_error("--target-height does not apply to objects",
                      "--observer-height for the height of the eye above each cell");
  }
}

visibility::ViewshedOptions options_of(const RasterRequest& request, const CloudUnit& unit) {
  visibility::ViewshedOptions options;
  options.mode = request.mode();
  const visibility::ObserverDefaults& defaults = request.observers.defaults;
  // With objects the eyes are above the cells.
  options.target_height = request.objects.any() ? defaults.height.value_or(defaults.height_on_ground)
                                                : request.map.target_height.value_or(0.0);
  // The given curvature, else that of the chosen defaults if the cloud's unit is known.
  const bool usual = request.like == DefaultSet::gdal && unit.metres;
  options.curve = visibility::SightCurve(
      request.curvature.value_or(usual ? visibility::k_usual_curvature : 0.0), unit.metres.value_or(1.0));
  options.positions_across =
      request.positions_across.value_or(request.objects.any() ? 1 : options.positions_across);
  options.highest = request.highest.value_or(options.highest);
  return options;
}

/// The settings of sight, for people and for the map's metadata.
std::string sight_text(const RasterRequest& request, const visibility::ViewshedOptions& options) {
  const visibility::ObserverDefaults& defaults = request.observers.defaults;
  std::string text =
      fmt::format("defaults like {}; ", request.like == DefaultSet::gdal ? "gdal_viewshed" : "r.viewshed");
  if (request.objects.any()) {
    text += fmt::format("eyes {:g} above the ground; curvature {:g}; maximum distance {:g}",
                        options.target_height, options.curve.coefficient(), defaults.max_distance);
  } else {
    text += fmt::format(
        "observers {:g} above the ground, {:g} above a z of their own; targets {:g} above the ground; "
        "curvature {:g}; maximum distance {:g}; azimuth {:g} to {:g}, elevation {:g} to {:g}",
        defaults.height.value_or(defaults.height_on_ground), defaults.height.value_or(0.0),
        options.target_height, options.curve.coefficient(), defaults.max_distance, defaults.azimuth_min,
        defaults.azimuth_max, defaults.elevation_min, defaults.elevation_max);
  }
  if (options.mode == visibility::ViewshedMode::visible) {
    const visibility::SeenValues values = seen_values_of(request);
    text +=
        fmt::format("; values {} visible, {} invisible, {} out of range", values.visible, values.invisible,
                    values.out_of_range ? std::to_string(*values.out_of_range) : "nodata");
  }
  if (options.mode == visibility::ViewshedMode::height) text += fmt::format("; up to {:g}", options.highest);
  if (options.mode == visibility::ViewshedMode::fraction)
    text += fmt::format("; {0} x {0} positions per cell", options.positions_across);
  return text;
}

/// Adds the observers, or objects, to the metadata of all maps.
void add_observers(std::span<const visibility::Observer> observers, const std::string& kind,
                   MapMetadata& metadata) {
  constexpr std::size_t k_most_observers = 100;
  std::string positions;
  for (const visibility::Observer& one : observers.first(std::min(observers.size(), k_most_observers))) {
    positions += fmt::format("{}{}: {:.17g} {:.17g} {:.17g}", positions.empty() ? "" : "\n", one.name,
                             one.position.x, one.position.y, one.position.z);
  }
  metadata.emplace_back(fmt::format("alidade_{}_count", kind), std::to_string(observers.size()));
  metadata.emplace_back(fmt::format("alidade_{}s", kind), positions);
}

/// All that the values depend on.
Fingerprint fingerprint_of(const CheckpointRequest& request, const VisibilityCloud& cloud,
                           std::span<const visibility::Observer> observers, const geo::RasterGrid& grid,
                           const visibility::ViewshedOptions& options) {
  Fingerprint fingerprint = run_fingerprint(request, cloud, observers);
  add_to_fingerprint(grid, fingerprint);
  fingerprint.push_back({"curvature", fmt::format("{:.17g}", options.curve.drop(1.0))});
  if (options.pieces.empty()) return fingerprint;
  std::vector<double> numbers;
  for (const visibility::ObjectPiece& piece : options.pieces) {
    numbers.insert(numbers.end(), {static_cast<double>(piece.object), piece.width, piece.height,
                                   piece.normal.x, piece.normal.y});
  }
  add_to_fingerprint("objects", numbers, fingerprint);
  return fingerprint;
}

/// Reads the objects, in the cloud's reference system, those that were given themselves first, and divides
/// them into samples; notes their numbers. Errors: those of read_objects() and sample_objects().
visibility::SampledObjects load_objects(const ObjectRequest& options, double max_distance, const Crs& crs,
                                        const visibility::GroundHeight& ground, Listener& listener) {
  const geo::ObserverReference reference{
      .given = options.reference, .cloud = crs, .option = "--objects-crs", .whose = "objects"};
  visibility::GivenObjects given;
  if (!options.file.empty()) given = visibility::read_objects(options.file, reference);
  visibility::GivenObjects all;
  std::vector<visibility::GivenObserver> segments = options.segments;
  if (!options.reference.empty() && !segments.empty())
    visibility::to_cloud_reference(segments, "", reference);
  for (const visibility::GivenObserver& segment : segments) all.add_segment(segment);
  const std::size_t objects = all.count(), corners = all.corners.size();
  for (visibility::ObjectPart part : given.parts) {
    part.object += objects;
    part.begin += corners;
    part.end += corners;
    all.parts.push_back(part);
  }
  all.corners.insert(all.corners.end(), given.corners.begin(), given.corners.end());
  visibility::SampleOptions sampling{.max_distance = max_distance};
  sampling.spacing = options.spacing.value_or(sampling.spacing);
  sampling.width = options.width.value_or(sampling.width);
  visibility::SampledObjects sampled = visibility::sample_objects(all, sampling, ground);
  listener.note(fmt::format("{} object{} with {} samples, at most {:g} apart", sampled.objects.size(),
                            sampled.objects.size() == 1 ? "" : "s", sampled.samples.size(),
                            sampling.spacing));
  return sampled;
}

/// The observers, or the samples of the objects.
struct Viewpoints {
  std::vector<visibility::Observer> observers;
  std::vector<visibility::ObjectPiece> pieces;  ///< empty: observers
  std::vector<visibility::Observer> named;      ///< the observers, or one for each object
};

Viewpoints load_viewpoints(const RasterRequest& request, const VisibilityCloud& cloud,
                           const visibility::Ground& ground, Listener& listener) {
  const visibility::GroundHeight height_at = [&](const glm::dvec2& position) { return ground.at(position); };
  if (request.objects.any()) {
    visibility::SampledObjects objects = load_objects(
        request.objects, request.observers.defaults.max_distance, cloud.cloud.cloud.crs, height_at, listener);
    const auto is_line = [](const visibility::ObjectPiece& piece) { return !(piece.width > 0.0); };
    if (request.mode() == visibility::ViewshedMode::angle && std::ranges::any_of(objects.pieces, is_line))
      throw input_error("--mode solid-angle requires objects with a width", "--object-width");
    return {std::move(objects.samples), std::move(objects.pieces), std::move(objects.objects)};
  }
  std::vector<visibility::Observer> observers = load_observers(request.observers, cloud, listener, height_at);
  return {observers, {}, observers};
}

/// How many lines of sight were tested, how fast, and what was found.
std::string result_text(const RasterRequest& request, const visibility::ViewshedOptions& options,
                        const visibility::Viewshed& seen, double seconds) {
  const visibility::SeenShare share = visibility::seen_share(seen, options);
  std::string where = request.objects.any() ? "from " : "";
  if (options.mode == visibility::ViewshedMode::height)
    where = fmt::format("at {:g} above the ground ", options.target_height);
  return fmt::format(
      "{} lines of sight in {:.1f} s ({}/s); visible {}{:.1f} % of the cells in range, {} cells without a "
      "value{}",
      short_count(static_cast<double>(seen.line_count)), seconds,
      short_count(static_cast<double>(seen.line_count) / seconds), where, share.percent, share.without,
      wrote_text(request));
}

}  // namespace

std::string ObjectRequest::given() const {
  if (!segments.empty()) return "--object";
  if (!file.empty()) return "--objects";
  if (!reference.empty()) return "--objects-crs";
  if (spacing) return "--object-spacing";
  return width ? "--object-width" : "";
}

void add_raster_fields(const Fields& fields, RasterRequest& request) {
  add_cloud(fields, request.files, {"--ignore-classes"});
  const Fields map = fields.group(k_map_group);
  map.required().file("-o,--output", "FILE.tif", "output map: cloud-optimised GeoTIFF", request.output);
  map.flag("--overwrite", "replace existing files", request.overwrite);
  add_map_fields(fields, request.map);
  add_values(fields, request);
  add_observer_fields(fields, request.observers);
  add_objects(fields, request.objects);
  add_target_height(fields.group(k_observer_group), request.map.target_height);
  add_sight(fields, request);
  add_occluder_fields(fields, request.occluders);
  add_checkpoint_fields(fields.group("Long runs"), request.checkpoint);
  add_scratch_memory(fields, request.memory);
  add_partial(fields, request.partial);
}

RasterPlan plan(const RasterRequest& request) {
  constexpr double k_grass_observer = 1.75;
  check_values(request);
  check_objects(request);
  if (!request.output.empty()) geo::check_raster_name(request.output);
  load_map_writer(request.map);
  PlannedWork work = request.work({request.observers.file, request.objects.file}, {request.map.preview});
  check_outputs(work, request.overwrite);
  check_checkpoint(request.checkpoint, request.overwrite, work);
  if (!request.objects.any()) check_given(request.observers);
  RasterRequest checked = request;
  if (request.like == DefaultSet::grass) checked.observers.defaults.height_on_ground = k_grass_observer;
  return RasterPlan(std::move(checked), std::move(work));
}

RasterResult run(const RasterPlan& plan, Listener& listener) {
  const RasterRequest& request = plan.request();
  const auto cloud = load_cloud_alone(request, AttributeSet(), AcceptedInput::points_or_raster, listener);
  const Crs& crs = cloud->cloud.cloud.crs;
  const CloudUnit unit = cloud_unit(crs);
  visibility::ViewshedOptions options = options_of(request, unit);
  const visibility::Ground ground = find_map_ground(request.map, *cloud, listener);
  const Viewpoints viewpoints = load_viewpoints(request, *cloud, ground, listener);
  const std::vector<visibility::Observer>& observers = viewpoints.observers;
  const std::string kind = request.objects.any() ? "object" : "observer";
  options.pieces = viewpoints.pieces;
  const geo::RasterGrid grid =
      map_grid(request.map, visibility::area_in_reach(map_area(request.map, *cloud), observers, kind), ground,
               1, unit.name, listener);
  const std::string sight = sight_text(request, options);
  listener.note("sight: " + sight);
  LongRun long_run(
      request.checkpoint,
      [&] { return fingerprint_of(request.checkpoint, *cloud, observers, grid, options); }, listener);
  measure_occluders(*cloud, request.occluders, listener);
  say_observer_remarks(viewpoints.named, *cloud, listener);

  const auto start = std::chrono::steady_clock::now();
  const visibility::Viewshed seen = long_run.test_visibility(options, [&](const auto& all) {
    return visibility::viewshed(*cloud->occluders, ground, observers, grid, all);
  });
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  RasterResult result{
      grid, crs,
      visibility::viewshed_band(seen, options, seen_values_of(request), viewpoints.named.size(), unit.name),
      map_metadata(request, *cloud, ground)};
  result.metadata.emplace_back("alidade_mode", k_mode_words[static_cast<std::size_t>(options.mode)]);
  result.metadata.emplace_back("alidade_sight", sight);
  add_observers(viewpoints.named, kind, result.metadata);
  if (!request.output.empty()) {
    const geo::RasterContents contents{
        .grid = grid, .bands = {result.band.band()}, .crs = crs, .metadata = result.metadata};
    geo::write_raster(request.output, contents, request.overwrite);
  }
  if (!request.map.preview.empty()) {
    visibility::write_map_image(visibility::viewshed_image(seen, options, viewpoints.named, unit.name),
                                ground, request.map.preview, request.overwrite);
  }
  long_run.finish();
  listener.note(result_text(request, options, seen, seconds));
  return result;
}

}  // namespace alidade::jobs
