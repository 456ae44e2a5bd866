// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <chrono>

#include "base/error.h"
#include "geo/raster_file.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"
#include "tools/image_module.h"
#include "tools/visibility/blocking_cloud.h"
#include "tools/visibility/long_run.h"
#include "tools/visibility/map_options.h"
#include "tools/visibility/observer_options.h"
#include "visibility/objects.h"
#include "visibility/raster/map_targets.h"
#include "visibility/raster/viewshed.h"
#include "visibility/raster/viewshed_file.h"
#include "visibility/read_observers.h"

namespace alidade::tools {
namespace {

/// The program whose defaults apply.
enum class DefaultSet { gdal, grass };

/// The options of objects whose visibility a map shows.
struct ObjectOptions {
  std::vector<visibility::GivenObserver> segments;  ///< --object
  std::filesystem::path file;                       ///< --objects; empty: none
  std::string reference;                            ///< --objects-crs
  std::optional<double> spacing, width;             ///< --object-spacing, --object-width

  bool any() const { return !segments.empty() || !file.empty(); }
  /// Name of the first option that was given; empty: none.
  std::string given() const;
};

std::string ObjectOptions::given() const {
  if (!segments.empty()) return "--object";
  if (!file.empty()) return "--objects";
  if (!reference.empty()) return "--objects-crs";
  if (spacing) return "--object-spacing";
  return width ? "--object-width" : "";
}

/// The command line of `alidade visibility raster`.
struct RasterCommand : VisibilityRequest {
  ObserverOptions observers;
  ObjectOptions objects;
  MapOptions map;
  CheckpointRequest checkpoint;
  DefaultSet like = DefaultSet::gdal;
  std::optional<visibility::ViewshedMode> given_mode;
  std::optional<double> curvature;
  std::optional<double> highest;
  std::optional<int> positions_across;
  std::optional<std::uint8_t> visible_value, invisible_value, out_of_range_value;

  visibility::ViewshedMode mode() const {
    return given_mode.value_or(objects.any() ? visibility::ViewshedMode::fraction
                                             : visibility::ViewshedMode::visible);
  }
};

void add_values(const Options& raster, RasterCommand& command) {
  const Options group = raster.group("Values");
  group.choice(
      "--mode",
      "value of the cells, see below; size and solid-angle require objects (default: visible, with objects "
      "fraction)",
      command.given_mode,
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
           command.visible_value);
  add_byte("--invisible-value,--iv", "value of invisible cells (default: 0)", command.invisible_value);
  add_byte("--out-of-range-value,--ov",
           "value of cells too far away or outside the field of view (default: gdal 0, grass nodata)",
           command.out_of_range_value);
  group.number(
      "--highest", "LENGTH",
      "for --mode height: largest height, also the value of cells not visible up to it (default: 200)",
      command.highest, 1e-6, 1e6);
  group.count("--places", "N",
              "for --mode fraction: N x N positions in every cell (default: 3, with objects 1)",
              command.positions_across, 1, visibility::k_most_positions_across);
}

/// Declares the options in a group of their own; they fill `options`.
void add_object_options(const Options& command, ObjectOptions& options) {
  const Options group = command.group("Objects");
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

void add_sight(const Options& raster, RasterCommand& command) {
  const Options group = raster.group("Sight");
  group.choice("--like",
               "source of the defaults. gdal (gdal_viewshed): observers 2 above the ground, curvature "
               "0.85714 if the cloud's unit is known; grass (r.viewshed): observers 1.75 above the ground, "
               "curvature 0, values 1 and 0, nodata out of range (default: gdal)",
               command.like, {{"gdal", DefaultSet::gdal}, {"grass", DefaultSet::grass}});
  const Option curvature =
      group.number("--curvature,--cc", "C",
                   "share of the Earth's curvature: 0 flat, 1 without air, 0.85714 for light, 0.75 for radio",
                   command.curvature, 0.0, 10.0);
  group.excludes(curvature).value(
      "--refraction_coeff", "R", "the same as -c and -r of r.viewshed: curvature 1 - R",
      [&command](const std::string& text) { command.curvature = 1.0 - parse_number(text, 0.0, 1.0); });
}

/// The given values, others from the chosen set of defaults.
visibility::SeenValues seen_values_of(const RasterCommand& command) {
  visibility::SeenValues values;
  if (command.like == DefaultSet::grass) values = {.visible = 1, .invisible = 0, .out_of_range = {}};
  values.visible = command.visible_value.value_or(values.visible);
  values.invisible = command.invisible_value.value_or(values.invisible);
  if (command.out_of_range_value) values.out_of_range = command.out_of_range_value;
  return values;
}

constexpr const char* k_mode_words[] = {"visible", "count", "height", "fraction", "size", "solid-angle"};

/// Errors: options that do not apply to the mode, or exclude each other.
void check_values(const RasterCommand& command) {
  const visibility::ViewshedMode mode = command.mode();
  const auto check = [mode](bool is_given, const std::string& option, visibility::ViewshedMode of) {
    if (!is_given || mode == of) return;
    throw input_error(option + " does not apply to this map",
                      fmt::format("--mode {}", k_mode_words[static_cast<std::size_t>(of)]));
  };
  check(command.visible_value.has_value(), "--visible-value", visibility::ViewshedMode::visible);
  check(command.invisible_value.has_value(), "--invisible-value", visibility::ViewshedMode::visible);
  check(command.out_of_range_value.has_value(), "--out-of-range-value", visibility::ViewshedMode::visible);
  check(command.highest.has_value(), "--highest", visibility::ViewshedMode::height);
  check(command.positions_across.has_value(), "--places", visibility::ViewshedMode::fraction);
  const visibility::SeenValues values = seen_values_of(command);
  if (values.visible == values.invisible) {
    throw input_error("visible and invisible cells have the same value",
                      "different values for --visible-value and --invisible-value",
                      std::to_string(values.visible) + " for both");
  }
  const double highest = command.highest.value_or(visibility::ViewshedOptions().highest);
  if (mode == visibility::ViewshedMode::height && highest <= command.map.target_height.value_or(0.0))
    throw Error({.problem = "--highest does not exceed --target-height"});
}

/// Errors: both observers and objects; options or a mode that require the other of these.
void check_objects(const RasterCommand& command) {
  const ObserverOptions& observers = command.observers;
  const visibility::ViewshedMode mode = command.mode();
  if (!command.objects.any()) {
    if (const std::string given = command.objects.given(); !given.empty())
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
  if (command.map.target_height) {
    throw input_error("--target-height does not apply to objects",
                      "--observer-height for the height of the eye above each cell");
  }
}

/// Errors that need no cloud.
void check_options(const RasterCommand& command) {
  check_values(command);
  check_objects(command);
  geo::check_raster_name(command.output);
  std::vector<std::filesystem::path> others = command.inputs({command.observers.file, command.objects.file});
  check_writable(command.output, command.overwrite, others);
  check_checkpoint(command.checkpoint, command.overwrite, {{command.output, command.map.preview}}, others);
  others.push_back(command.output);
  check_map_writing(command.map, command.overwrite, others);
}

visibility::ViewshedOptions options_of(const RasterCommand& command, const CloudUnit& unit) {
  visibility::ViewshedOptions options;
  options.mode = command.mode();
  const visibility::ObserverDefaults& defaults = command.observers.defaults;
  // With objects the eyes are above the cells.
  options.target_height = command.objects.any() ? defaults.height.value_or(defaults.height_on_ground)
                                                : command.map.target_height.value_or(0.0);
  // The given curvature, else that of the chosen defaults if the cloud's unit is known.
  const bool usual = command.like == DefaultSet::gdal && unit.metres;
  options.curve = visibility::SightCurve(
      command.curvature.value_or(usual ? visibility::k_usual_curvature : 0.0), unit.metres.value_or(1.0));
  options.positions_across =
      command.positions_across.value_or(command.objects.any() ? 1 : options.positions_across);
  options.highest = command.highest.value_or(options.highest);
  return options;
}

/// The settings of sight, for people and for the map's metadata.
std::string sight_text(const RasterCommand& command, const visibility::ViewshedOptions& options) {
  const visibility::ObserverDefaults& defaults = command.observers.defaults;
  std::string text =
      fmt::format("defaults like {}; ", command.like == DefaultSet::gdal ? "gdal_viewshed" : "r.viewshed");
  if (command.objects.any()) {
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
    const visibility::SeenValues values = seen_values_of(command);
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

visibility::Viewshed test_visibility(const VisibilityCloud& cloud, const visibility::Ground& ground,
                                     std::span<const visibility::Observer> observers,
                                     const geo::RasterGrid& grid, visibility::ViewshedOptions options,
                                     LongRun& long_run) {
  return long_run.work("testing visibility", "lines of sight",
                       [&](const Progress& progress, PartCheckpoint* parts) {
                         options.progress = progress;
                         options.parts = parts;
                         return visibility::viewshed(*cloud.occluders, ground, observers, grid, options);
                       });
}

/// Reads the objects, in the cloud's reference system, those of the command line first, and divides them into
/// samples; prints their numbers. Errors: those of read_objects() and sample_objects().
visibility::SampledObjects load_objects(const ObjectOptions& options, double max_distance, const Crs& crs,
                                        const visibility::GroundHeight& ground, Verbosity verbosity) {
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
  say_note(verbosity,
           fmt::format("{} object{} with {} samples, at most {:g} apart", sampled.objects.size(),
                       sampled.objects.size() == 1 ? "" : "s", sampled.samples.size(), sampling.spacing));
  return sampled;
}

/// The observers, or the samples of the objects.
struct Viewpoints {
  std::vector<visibility::Observer> observers;
  std::vector<visibility::ObjectPiece> pieces;  ///< empty: observers
  std::vector<visibility::Observer> named;      ///< the observers, or one for each object
};

Viewpoints load_viewpoints(const RasterCommand& command, const VisibilityCloud& cloud,
                           const visibility::Ground& ground) {
  const visibility::GroundHeight height_at = [&](const glm::dvec2& position) { return ground.at(position); };
  if (command.objects.any()) {
    visibility::SampledObjects objects =
        load_objects(command.objects, command.observers.defaults.max_distance, cloud.cloud.cloud.crs,
                     height_at, command.verbosity);
    const auto is_line = [](const visibility::ObjectPiece& piece) { return !(piece.width > 0.0); };
    if (command.mode() == visibility::ViewshedMode::angle && std::ranges::any_of(objects.pieces, is_line))
      throw input_error("--mode solid-angle requires objects with a width", "--object-width");
    return {std::move(objects.samples), std::move(objects.pieces), std::move(objects.objects)};
  }
  std::vector<visibility::Observer> observers =
      load_observers(command.observers, cloud, command.verbosity, height_at);
  return {observers, {}, observers};
}

ExitCode run(const RasterCommand& given) {
  constexpr double k_grass_observer = 1.75;
  check_options(given);
  RasterCommand command = given;
  const Verbosity verbosity = command.verbosity;
  if (command.like == DefaultSet::grass) command.observers.defaults.height_on_ground = k_grass_observer;
  if (!command.objects.any()) check_given(command.observers);
  const auto cloud = load_cloud_alone(command, AttributeSet(), AcceptedInput::points_or_raster);
  const Crs& crs = cloud->cloud.cloud.crs;
  const CloudUnit unit = cloud_unit(crs);
  visibility::ViewshedOptions options = options_of(command, unit);
  const visibility::Ground ground = find_map_ground(command.map, *cloud, verbosity);
  const Viewpoints viewpoints = load_viewpoints(command, *cloud, ground);
  const std::vector<visibility::Observer>& observers = viewpoints.observers;
  const std::string kind = command.objects.any() ? "object" : "observer";
  options.pieces = viewpoints.pieces;
  const geo::RasterGrid grid =
      map_grid(command.map, visibility::area_in_reach(map_area(command.map, *cloud), observers, kind), ground,
               1, unit.name, verbosity);
  const std::string sight = sight_text(command, options);
  say_note(verbosity, "sight: " + sight);
  LongRun long_run(
      command.checkpoint,
      [&] { return fingerprint_of(command.checkpoint, *cloud, observers, grid, options); }, verbosity);
  measure_occluders(*cloud, command.occluders, verbosity);
  say_observer_remarks(viewpoints.named, *cloud, verbosity);

  const auto start = std::chrono::steady_clock::now();
  const visibility::Viewshed seen = test_visibility(*cloud, ground, observers, grid, options, long_run);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const visibility::ViewshedBand band =
      visibility::viewshed_band(seen, options, seen_values_of(command), viewpoints.named.size(), unit.name);
  geo::RasterContents contents{
      .grid = grid, .bands = {band.band()}, .crs = crs, .metadata = map_metadata(command, *cloud, ground)};
  contents.metadata.emplace_back("alidade_mode", k_mode_words[static_cast<std::size_t>(options.mode)]);
  contents.metadata.emplace_back("alidade_sight", sight);
  add_observers(viewpoints.named, kind, contents.metadata);
  geo::write_raster(command.output, contents, command.overwrite);
  if (!command.map.preview.empty()) {
    image_module().write_map_image(visibility::viewshed_image(seen, options, viewpoints.named, unit.name),
                                   ground, command.map.preview, command.overwrite);
  }
  long_run.finish();
  const visibility::SeenShare share = visibility::seen_share(seen, options);
  std::string where = command.objects.any() ? "from " : "";
  if (options.mode == visibility::ViewshedMode::height)
    where = fmt::format("at {:g} above the ground ", options.target_height);
  say_note(verbosity, fmt::format("{} lines of sight in {:.1f} s ({}/s); visible {}{:.1f} % of the cells in "
                                  "range, {} cells without a value; wrote {}",
                                  short_count(static_cast<double>(seen.line_count)), seconds,
                                  short_count(static_cast<double>(seen.line_count) / seconds), where,
                                  share.percent, share.without, command.output.string()));
  return ExitCode::done;
}

}  // namespace

Command add_visibility_raster(const Options& visibility) {
  const Options raster =
      visibility.command("raster", "Compute a viewshed of the ground, or of objects from the ground")
          .also_called("viewshed");
  auto command = std::make_shared<RasterCommand>();
  const Options map = raster.group(k_map_group);
  add_cloud(raster, *command, {"--ignore-classes"});
  map.required().file("-o,--output", "FILE.tif", "output map: cloud-optimised GeoTIFF", command->output);
  map.flag("--overwrite", "replace existing files", command->overwrite);
  add_map_options(raster, command->map);
  add_values(raster, *command);
  add_observer_options(raster, command->observers);
  add_object_options(raster, command->objects);
  add_target_height(raster.group(k_observer_group), command->map.target_height);
  add_sight(raster, *command);
  add_occluder_options(raster, command->occluders);
  add_checkpoint_options(raster.group("Long runs"), command->checkpoint);
  add_scratch_memory(raster, command->memory);
  add_run_options(raster, *command);
  return command_of(raster, command, run);
}

}  // namespace alidade::tools
