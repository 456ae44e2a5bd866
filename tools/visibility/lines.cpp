// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <map>

#include "base/error.h"
#include "base/huge_memory.h"
#include "geo/earth.h"
#include "jobs/visibility/row_output.h"
#include "octree/distance.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"
#include "tools/visibility/visibility_request.h"
#include "visibility/lines/fresnel.h"
#include "visibility/lines/line_files.h"
#include "visibility/raster/curved_sight.h"

namespace alidade::tools {
namespace {

constexpr double k_radio_factor = 4.0 / 3.0;
/// For light, the default of maps.
constexpr double k_light_factor = 1.0 / visibility::k_usual_curvature;

/// The options of sight lines.
struct PairRequest {
  std::filesystem::path pairs, places;  ///< --pairs, --places; empty: none
  std::string places_crs;
  visibility::ObserverDefaults defaults;  ///< --end-height
};

struct LinesCommand : VisibilityRequest {
  PairRequest pairs;
  std::optional<double> frequency;                    ///< Hz
  std::optional<std::optional<double>> earth_factor;  ///< empty inside: off
  double end_margin = 0.0;
  CheckpointRequest checkpoint;
};

/// Lines by their ends.
struct LineSet {
  std::vector<visibility::Observer> ends;
  std::vector<visibility::Observer> named;  ///< each once
  bool are_pairs = false;  ///< first and second end of each line in turn; otherwise every pair is a line
};

/// The position with the name of an end. Errors: no position has it.
const visibility::Observer& position_called(const std::map<std::string, const visibility::Observer*>& by_name,
                                            const visibility::GivenObserver& end) {
  const auto found = by_name.find(end.name);
  if (found != by_name.end()) return *found->second;
  throw file_error(
      end.source, fmt::format("unknown position '{}'", end.name),
      by_name.empty() ? "named positions (--places), or pairs with coordinates" : "a name of --places");
}

/// The ends of pairs with coordinates, first and second of each in turn.
ObserverRequest ends_with_coordinates(const std::vector<visibility::GivenPair>& pairs) {
  ObserverRequest ends;
  for (const visibility::GivenPair& pair : pairs) {
    // Ends without a name get the number of their pair.
    const std::size_t number = ends.positions.size() / 2 + 1;
    ends.positions.push_back(pair.from);
    if (pair.from.name.empty()) ends.positions.back().name = fmt::format("from {}", number);
    ends.positions.push_back(pair.to);
    if (pair.to.name.empty()) ends.positions.back().name = fmt::format("to {}", number);
  }
  return ends;
}

/// The ends of pairs with names, in turn. `named`: the positions of `file`.
std::vector<visibility::Observer> ends_with_names(const std::filesystem::path& file,
                                                  std::span<const visibility::Observer> named,
                                                  const std::vector<visibility::GivenPair>& pairs) {
  std::map<std::string, const visibility::Observer*> by_name;
  for (const visibility::Observer& one : named) {
    if (!by_name.emplace(one.name, &one).second)
      throw file_error(file, fmt::format("duplicate position '{}'", one.name), "unique names");
  }
  std::vector<visibility::Observer> ends;
  for (const visibility::GivenPair& pair : pairs) {
    ends.push_back(position_called(by_name, pair.from));
    ends.push_back(position_called(by_name, pair.to));
  }
  return ends;
}

/// Calls visit(first end, second end) for every line, in order.
void for_each_pair(const LineSet& lines, const std::function<void(std::size_t, std::size_t)>& visit) {
  const std::size_t count = lines.ends.size();
  if (lines.are_pairs) {
    for (std::size_t i = 0; i + 1 < count; i += 2) visit(i, i + 1);
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = i + 1; j < count; ++j) visit(i, j);
  }
}

void add_pair_options(const Fields& command, PairRequest& request) {
  const Fields group = command.group("Lines");
  group.file(
      "--pairs", "FILE",
      "CSV with one pair per row: names of --places in the columns from and to, or coordinates (see below)",
      request.pairs);
  group.file("--places", "FILE",
             "CSV, GeoJSON, GeoPackage or Shapefile with positions, like observers; without --pairs all "
             "pairs are tested",
             request.places);
  group.text("--places-crs", "CRS",
             "reference system of the positions, such as EPSG:4326 (default: that of their file, for CSV the "
             "cloud's)",
             request.places_crs);
  group.number("--end-height", "LENGTH",
               "of ends above their foot (default: 0 for ends with a z, 2 for those on the ground)",
               request.defaults.height, 0.0, 1e6);
}

/// Errors that need no cloud: no lines, --places-crs alone.
void check_pair_request(const PairRequest& request) {
  if (request.pairs.empty() && request.places.empty())
    throw input_error("missing lines of sight", "--pairs FILE or --places FILE");
  if (request.places.empty() && !request.places_crs.empty())
    throw input_error("--places-crs requires --places", "--places FILE");
}

/// Reads positions and pairs, and computes the ends of the lines over the cloud. Surfaces need not be
/// measured. Errors: those of read_pair_table() and load_observers(); names of no position, or of two;
/// coordinates beside --places; a single position.
LineSet load_lines(const PairRequest& request, const VisibilityCloud& cloud, Console& console) {
  std::vector<visibility::GivenPair> given;
  if (!request.pairs.empty()) given = visibility::read_pair_table(request.pairs);
  const bool has_coordinates = !given.empty() && given.front().has_positions;
  if (has_coordinates && !request.places.empty())
    throw file_error(request.pairs, "pairs given as coordinates, but --places requires names",
                     "names of positions, or no --places");
  ObserverRequest options;
  if (has_coordinates) options = ends_with_coordinates(given);
  options.file = request.places;
  options.anywhere = true;  // masts and mountains may be far away
  options.reference = request.places_crs;
  options.reference_option = "--places-crs";
  options.defaults = request.defaults;
  LineSet lines;
  lines.are_pairs = !given.empty();
  if (has_coordinates || !request.places.empty()) lines.ends = load_observers(options, cloud, console);
  lines.named = lines.ends;
  if (lines.are_pairs) {
    if (!has_coordinates) lines.ends = ends_with_names(request.places, lines.named, given);
    return lines;
  }
  if (lines.ends.size() < 2) throw file_error(request.places, "contains a single position", "at least two");
  return lines;
}

/// Errors: more lines than fit into memory, each with all obstructions that it can have.
void check_report_memory(const LineSet& lines, bool has_zones) {
  std::uint64_t bytes_per_line = sizeof(visibility::LinePair) + sizeof(visibility::LineReport);
  if (has_zones) bytes_per_line += visibility::k_most_obstructions * sizeof(visibility::Obstruction);
  const std::uint64_t count = lines.ends.size();
  const std::uint64_t line_count = lines.are_pairs ? count / 2 : count * (count - 1) / 2;
  std::uint64_t bytes = 0;
  if (__builtin_mul_overflow(line_count, bytes_per_line, &bytes))
    bytes = std::numeric_limits<std::uint64_t>::max();
  check_memory(bytes, "the reports of all lines");
}

/// Errors: a margin at either end that leaves nothing of a line.
void check_margin(const LineSet& lines, double margin) {
  if (margin == 0.0) return;
  for_each_pair(lines, [&](std::size_t from, std::size_t to) {
    const double length = distance(lines.ends[from].position, lines.ends[to].position);
    if (2.0 * margin < length) return;
    throw input_error(fmt::format("--end-margin exceeds the line from '{}' to '{}'", lines.ends[from].name,
                                  lines.ends[to].name),
                      fmt::format("less than half of its length {:.6g}", length),
                      fmt::format("{:.6g}", margin));
  });
}

/// The lines: the pairs of a file, or every end with every other.
std::vector<visibility::LinePair> pairs_of(const LineSet& lines, const visibility::Occluders& occluders) {
  std::vector<visibility::SightEnd> sight_ends;
  for (const visibility::Observer& end : lines.ends)
    sight_ends.push_back(visibility::end_near_surface(occluders, end.position));
  std::vector<visibility::LinePair> pairs;
  for_each_pair(lines, [&](std::size_t from, std::size_t to) {
    pairs.push_back({lines.ends[from].name, sight_ends[from], lines.ends[to].name, sight_ends[to]});
  });
  return pairs;
}

/// Metres of the cloud's unit; empty if it is not known.
std::optional<double> known_unit(const VisibilityCloud& cloud) {
  const Crs& crs = cloud.cloud.cloud.crs;
  return crs.empty() ? std::nullopt : geo::metres_per_unit(crs);
}

/// Metres of the cloud's unit, 1 without a reference system. Errors: a reference system without a linear
/// unit.
double unit_of(const VisibilityCloud& cloud, const std::filesystem::path& file) {
  if (cloud.cloud.cloud.crs.empty()) return 1.0;
  if (const std::optional<double> metres = known_unit(cloud)) return *metres;
  throw file_error(file, "wavelengths and the Earth radius require a known linear unit",
                   "a projected reference system: reproject the cloud");
}

/// Whether light bent by the Earth is off the chord of any line by more than maps allow for.
bool is_bent(const LineSet& lines, double unit) {
  const visibility::SightCurve light(visibility::k_usual_curvature, unit);
  bool is_bent = false;
  for_each_pair(lines, [&](std::size_t from, std::size_t to) {
    const double length = distance(lines.ends[from].position, lines.ends[to].position);
    is_bent = is_bent || light.chord_count(length) > 1;
  });
  return is_bent;
}

/// The factor of the Earth's radius that bends the lines; empty: the Earth is flat.
std::optional<double> earth_factor(const LinesCommand& command, const VisibilityCloud& cloud,
                                   const LineSet& lines) {
  if (command.earth_factor) return *command.earth_factor;
  if (command.frequency) return k_radio_factor;
  const std::optional<double> unit = known_unit(cloud);
  const bool is_opaque = command.occluders.options.transparency <= 1;
  return unit && is_opaque && is_bent(lines, *unit) ? std::optional(k_light_factor) : std::nullopt;
}

visibility::LineReportOptions report_options(const LinesCommand& command, const VisibilityCloud& cloud,
                                             const LineSet& lines) {
  visibility::LineReportOptions options;
  options.line.end_margin = command.end_margin;
  const std::optional<double> factor = earth_factor(command, cloud, lines);
  if (!command.frequency && !factor) return options;
  const double unit = unit_of(cloud, command.files.first_name());
  if (factor) options.line.earth_radius = *factor * geo::k_earth_radius / unit;
  if (command.frequency) options.wavelength = visibility::k_speed_of_light / *command.frequency / unit;
  return options;
}

void say_result(const LinesCommand& command, const visibility::LineTable& table) {
  if (command.verbosity == Verbosity::quiet) return;
  const auto visible =
      std::ranges::count_if(table.reports, [](const visibility::LineReport& line) { return !line.blocker; });
  std::string text = fmt::format("{} of {} lines are free", visible, table.reports.size());
  if (command.frequency) {
    const auto clear = std::ranges::count_if(
        table.reports, [](const visibility::LineReport& line) { return line.fresnel->is_clear; });
    text += fmt::format("; {} have the inner 60 % of their first Fresnel zone free", clear);
  }
  say_note(text);
}

/// Errors that need no cloud.
void check_options(const LinesCommand& command) {
  load_row_writer(command.output);
  check_pair_request(command.pairs);
  const std::vector<std::filesystem::path> inputs =
      command.inputs({command.pairs.pairs, command.pairs.places});
  check_writable(command.output, command.overwrite, inputs);
  check_checkpoint(command.checkpoint, command.overwrite, {&command.output, 1}, inputs);
}

Fingerprint fingerprint_of(const LinesCommand& command, const VisibilityCloud& cloud,
                           std::span<const visibility::LinePair> pairs) {
  Fingerprint fingerprint = run_fingerprint(command.checkpoint, cloud);
  std::vector<double> numbers;
  for (const visibility::LinePair& pair : pairs) {
    for (const glm::dvec3& end : {pair.from.position, pair.to.position})
      numbers.insert(numbers.end(), {end.x, end.y, end.z});
  }
  fingerprint.push_back({"number of lines", std::to_string(pairs.size())});
  add_to_fingerprint("ends of the lines", numbers, fingerprint);
  return fingerprint;
}

ExitCode run_lines(const LinesCommand& command) {
  check_options(command);
  load_row_writer(command.output);
  Console console(command.verbosity);
  const auto cloud = load_cloud_alone(command, {}, AcceptedInput::points_or_raster, console);
  const LineSet lines = load_lines(command.pairs, *cloud, console);
  check_report_memory(lines, command.frequency.has_value());
  const visibility::LineReportOptions options = report_options(command, *cloud, lines);
  visibility::check_line_report(options, command.occluders.options.transparency);
  check_margin(lines, command.end_margin);
  measure_occluders(*cloud, command.occluders, console);
  say_observer_remarks(lines.named, *cloud, console);
  visibility::LineTable table;
  table.pairs = pairs_of(lines, *cloud->occluders);
  table.classifications = cloud->columns.classifications;
  LongRun long_run(
      command.checkpoint, [&] { return fingerprint_of(command, *cloud, table.pairs); }, console);
  table.reports =
      long_run.work("testing lines of sight", "lines", [&](const Progress& progress, PartCheckpoint* parts) {
        return visibility::report_lines(*cloud->occluders, table.pairs, options, progress, parts);
      });
  Console quiet(Verbosity::quiet);
  const visibility::Ground ground = find_ground(*cloud, {}, quiet);
  for (const visibility::LinePair& pair : table.pairs)
    table.unscanned.push_back(
        visibility::unscanned_length(ground, glm::dvec2(pair.from.position), glm::dvec2(pair.to.position)));
  write_rows(
      command, cloud->cloud.cloud,
      [&](auto form, const auto& head, const auto& to_lon_lat) {
        return visibility::write_lines(table, form, head, to_lon_lat, command.output, command.overwrite);
      },
      console);
  long_run.finish();
  say_result(command, table);
  return ExitCode::done;
}

void add_radio(const Fields& lines, LinesCommand& command) {
  lines.group("Radio").value(
      "--frequency", "F[GHz|MHz]",
      "report the first Fresnel zone of this frequency, 5.8GHz or 868MHz; GHz without a unit",
      [&command](const std::string& text) {
        command.frequency = visibility::parse_frequency(text);
        if (!command.frequency)
          throw UsageError("invalid value; expected 1MHz to 1000GHz, found '" + text + "'");
      });
}

void add_bending(const Fields& lines, LinesCommand& command) {
  lines.group("Lines").value(
      "--earth-radius-factor", "K|off",
      "bend lines for an Earth of K times its radius, which includes refraction (default: 1.3333 with "
      "--frequency, otherwise 1.1667 if the unit of the cloud is known, --transparency is 1 and a line is "
      "longer than half a kilometre, else off)",
      [&command](const std::string& text) {
        command.earth_factor.emplace();
        if (text != "off") *command.earth_factor = parse_number(text, 1e-3, 1e3);
      });
}

}  // namespace

Command add_visibility_lines(const Options& visibility) {
  auto command = std::make_shared<LinesCommand>();
  const Options lines =
      visibility.command("lines", "Test lines of sight between pairs of positions, and their Fresnel zones");
  add_cloud(lines, command->files, {"--ignore-classes"});
  add_pair_options(lines, command->pairs);
  lines.group("Lines").number("--end-margin", "LENGTH",
                              "excluded length at either end, for scanned masts and tripods (default: 0)",
                              command->end_margin, 0.0, 1e9);
  add_bending(lines, *command);
  add_radio(lines, *command);
  add_occluder_fields(lines, command->occluders);
  lines.required().file("-o,--output", "FILE", "output file: .csv, .json or .geojson", command->output);
  lines.flag("--overwrite", "replace an existing file", command->overwrite);
  add_checkpoint_fields(lines.group("Long runs"), command->checkpoint);
  add_scratch_memory(lines, command->memory);
  add_run_options(lines, *command);
  return command_of(lines, command, run_lines);
}

}  // namespace alidade::tools
