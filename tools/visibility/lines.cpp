// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "octree/error.h"
#include "tools/command.h"
#include "tools/message.h"
#include "tools/options.h"
#include "tools/picture_command.h"
#include "tools/visibility/commands.h"
#include "tools/visibility/load_visibility_cloud.h"
#include "tools/visibility/map_reference.h"
#include "tools/visibility/observer_options.h"
#include "tools/visibility/row_output.h"
#include "visibility/frequency.h"
#include "visibility/line_files.h"
#include "visibility/pair_table.h"
#include "visibility/raster.h"

namespace alidade {
namespace {

constexpr double k_radio_factor = 4.0 / 3.0;

struct LinesCommand {
  CommandLine command_line;
  std::vector<std::filesystem::path> files;
  std::filesystem::path pairs, places, output;
  std::string places_crs;
  ObserverDefaults defaults;
  std::optional<double> frequency;                    ///< Hz
  std::optional<std::optional<double>> earth_factor;  ///< empty inside: off
  double end_margin = 0.0;
  OccluderRequest occluders;
  bool overwrite = false;
  std::optional<int> threads;
  VerbosityOptions verbosity;
};

/// Metres of the cloud's unit, which wavelengths and the Earth are measured by.
double unit_of(const VisibilityCloud& cloud, const std::filesystem::path& file) {
  if (cloud.cloud.cloud.crs.empty()) return 1.0;
  std::optional<double> metres;
  load_metres_per_unit()(cloud.cloud.cloud.crs, metres);
  if (metres) return *metres;
  throw Error({.file = file.string(),
               .problem = "has coordinates in degrees or an unknown unit, which wavelengths and the Earth's "
                          "radius cannot be told in",
               .expected = "a cloud in a projected reference system"});
}

LineReportOptions report_options(const LinesCommand& command, const VisibilityCloud& cloud) {
  LineReportOptions options;
  options.line.end_margin = command.end_margin;
  std::optional<double> factor = command.frequency ? std::optional(k_radio_factor) : std::nullopt;
  if (command.earth_factor) factor = *command.earth_factor;
  if (!command.frequency && !factor) return options;
  const double unit = unit_of(cloud, command.files.front());
  if (factor) options.line.earth_radius = *factor * k_earth_radius / unit;
  if (command.frequency) options.wavelength = k_speed_of_light / *command.frequency / unit;
  return options;
}

const Observer& place_called(const std::map<std::string, const Observer*>& places, const GivenObserver& end) {
  const auto found = places.find(end.name);
  if (found != places.end()) return *found->second;
  throw Error({.file = end.source,
               .problem = fmt::format("no place is called '{}'", end.name),
               .expected = places.empty() ? "places with names (--places), or pairs with coordinates"
                                          : "a name of --places"});
}

std::vector<Observer> load_ends(const LinesCommand& command, const VisibilityCloud& cloud,
                                ObserverOptions options) {
  options.defaults = command.defaults;
  return load_observers(options, cloud, command.verbosity.verbosity());
}

/// Ends of the pairs of a file that gives their coordinates, first and second of each after each other.
std::vector<Observer> ends_with_places(const LinesCommand& command, const VisibilityCloud& cloud,
                                       const std::vector<GivenPair>& pairs) {
  ObserverOptions ends;
  for (const GivenPair& pair : pairs) {
    // Who has no name is called by the pair's number.
    const std::size_t number = ends.places.size() / 2 + 1;
    ends.places.push_back(pair.from);
    if (pair.from.name.empty()) ends.places.back().name = fmt::format("from {}", number);
    ends.places.push_back(pair.to);
    if (pair.to.name.empty()) ends.places.back().name = fmt::format("to {}", number);
  }
  return load_ends(command, cloud, ends);
}

/// The same of a file that gives their names.
std::vector<Observer> ends_with_names(std::span<const Observer> places, const std::vector<GivenPair>& pairs) {
  std::map<std::string, const Observer*> by_name;
  for (const Observer& place : places) {
    if (!by_name.emplace(place.name, &place).second)
      throw Error({.problem = fmt::format("two places are called '{}'", place.name)});
  }
  std::vector<Observer> ends;
  for (const GivenPair& pair : pairs) {
    ends.push_back(place_called(by_name, pair.from));
    ends.push_back(place_called(by_name, pair.to));
  }
  return ends;
}

std::vector<LinePair> pairs_of(const LinesCommand& command, const VisibilityCloud& cloud) {
  std::vector<GivenPair> given;
  if (!command.pairs.empty()) given = read_pair_table(command.pairs);
  const bool has_places = !given.empty() && given.front().has_places;
  if (has_places && !command.places.empty()) {
    throw Error({.file = command.pairs.string(),
                 .problem = "has coordinates of its own",
                 .expected = "names of --places, or no --places"});
  }
  std::vector<Observer> ends;
  if (!command.places.empty()) {
    ObserverOptions places;
    places.file = command.places;
    places.reference = command.places_crs;
    ends = load_ends(command, cloud, places);
  }
  if (!given.empty())
    ends = has_places ? ends_with_places(command, cloud, given) : ends_with_names(ends, given);
  std::vector<std::string> names;
  std::vector<SightEnd> sight_ends;
  for (const Observer& end : ends) {
    names.push_back(end.name);
    sight_ends.push_back(end_near_surface(*cloud.occluders, end.position));
  }
  if (given.empty()) {
    if (ends.size() < 2) {
      throw Error({.file = command.places.string(),
                   .problem = "holds a single place",
                   .expected = "two or more, which are paired"});
    }
    const std::uint64_t count = std::uint64_t{ends.size()} * (ends.size() - 1) / 2;
    check_memory(count * (sizeof(LinePair) + sizeof(LineReport)), "the reports on all pairs");
    return all_pairs(names, sight_ends);
  }
  std::vector<LinePair> pairs;
  for (std::size_t i = 0; i + 1 < ends.size(); i += 2)
    pairs.push_back({names[i], sight_ends[i], names[i + 1], sight_ends[i + 1]});
  return pairs;
}

void say_result(const LinesCommand& command, const LineTable& table) {
  if (command.verbosity.quiet) return;
  const auto visible =
      std::ranges::count_if(table.reports, [](const LineReport& line) { return !line.blocker; });
  std::string text = fmt::format("{} of {} lines are free", visible, table.reports.size());
  if (command.frequency) {
    const auto clear =
        std::ranges::count_if(table.reports, [](const LineReport& line) { return line.fresnel->is_clear; });
    text += fmt::format("; {} have the inner 60 % of their first Fresnel zone free", clear);
  }
  say_note(text);
}

ExitCode run_lines(const LinesCommand& command) {
  const RowForm form = chosen_row_form(command.output);
  if (command.pairs.empty() && command.places.empty())
    throw Error({.problem = "no sight lines are given", .expected = "--pairs FILE or --places FILE"});
  if (command.places.empty() && !command.places_crs.empty())
    throw Error({.problem = "--places-crs is for --places", .expected = "--places FILE"});
  std::vector<std::filesystem::path> inputs = command.files;
  for (const std::filesystem::path& input : {command.pairs, command.places}) {
    if (!input.empty()) inputs.push_back(input);
  }
  check_writable(command.output, command.overwrite, inputs);
  const Verbosity verbosity = command.verbosity.verbosity();
  const auto cloud = load_visibility_cloud(command.files, command.occluders, {}, verbosity);
  const LineReportOptions options = report_options(command, *cloud);
  LineTable table;
  table.pairs = pairs_of(command, *cloud);
  table.classifications = cloud->columns.classifications;
  ProgressLine line("looking along lines", "lines", verbosity);
  table.reports = report_lines(*cloud->occluders, table.pairs, options, line.callback());
  line.finish();
  const PointCloud& facts = cloud->cloud.cloud;
  const bool is_done = write_lines(table, form, row_file_head(command.command_line, facts),
                                   to_lon_lat_of(facts.crs), command.output, command.overwrite);
  if (!is_done && !command.verbosity.quiet) warn_of_cloud_coordinates(command.output);
  say_result(command, table);
  return ExitCode::done;
}

void add_ends(CLI::App& lines, LinesCommand& command) {
  const char* const group = "Lines";
  lines
      .add_option(
          "--pairs", command.pairs,
          "CSV with a pair per row: names of --places in the columns from and to, or coordinates (see "
          "below)")
      ->option_text("FILE")
      ->group(group);
  lines
      .add_option(
          "--places", command.places,
          "CSV, GeoJSON, GeoPackage or Shapefile with places, as observers elsewhere; without --pairs "
          "every one is paired with every other")
      ->option_text("FILE")
      ->group(group);
  lines
      .add_option(
          "--places-crs", command.places_crs,
          "reference system of the places, such as EPSG:4326 (default: what their file says, of CSV the "
          "cloud's)")
      ->option_text("CRS")
      ->group(group);
  add_value(lines, "--end-height", "LENGTH",
            "of ends above their foot (default: 0 for ends with a z, 2 for those on the ground)",
            [&command](const std::string& text) { command.defaults.height = parse_number(text, 0.0, 1e6); })
      ->group(group);
  add_value(lines, "--end-margin", "LENGTH",
            "so much of a line at either end is not looked at: scanned masts and tripods (default: 0)",
            [&command](const std::string& text) { command.end_margin = parse_number(text, 0.0, 1e9); })
      ->group(group);
}

void add_radio(CLI::App& lines, LinesCommand& command) {
  const char* const group = "Radio";
  add_value(lines, "--frequency", "F[GHz|MHz]",
            "report on the first Fresnel zone of this frequency, 5.8GHz or 868MHz; GHz without a unit",
            [&command](const std::string& text) {
              command.frequency = parse_frequency(text);
              if (!command.frequency)
                throw CLI::ValidationError("expected 1MHz to 1000GHz, found '" + text + "'");
            })
      ->group(group);
  add_value(
      lines, "--earth-radius-factor", "K|off",
      "lines bend down over the ground of a round Earth with K times its radius; K takes in how air bends "
      "rays (default: 1.3333 with --frequency, otherwise off)",
      [&command](const std::string& text) {
        command.earth_factor.emplace();
        if (text != "off") *command.earth_factor = parse_number(text, 1e-3, 1e3);
      })
      ->group(group);
}

}  // namespace

Command add_visibility_lines(CLI::App& visibility, const CommandLine& command_line) {
  auto command = std::make_shared<LinesCommand>();
  command->command_line = command_line;
  CLI::App* const lines = visibility.add_subcommand(
      "lines", "Report on sight lines between pairs of places, and on their Fresnel zones");
  lines
      ->add_option("cloud", command->files, "cloud files, taken together as one, or an index file (.alidade)")
      ->option_text("CLOUD...")
      ->required();
  add_ends(*lines, *command);
  add_radio(*lines, *command);
  add_occluder_options(*lines, command->occluders);
  lines->add_option("-o,--output", command->output, "file to write: .csv, .json or .geojson")
      ->option_text("FILE")
      ->required();
  lines->add_flag("--overwrite", command->overwrite, "replace an existing file");
  add_threads(*lines, command->threads);
  add_verbosity(*lines, command->verbosity);
  lines->footer(
      "Forms:\n"
      "  alidade visibility lines CLOUD... --places FILE -o OUT [OPTIONS]\n"
      "  alidade visibility lines CLOUD... --pairs FILE [--places FILE] -o OUT [OPTIONS]\n"
      "\n"
      "Lengths and coordinates are in metres (the unit of the cloud's CRS).\n"
      "\n"
      "Pairs: from,to with names of places; or from_x,from_y,to_x,to_y in the cloud's coordinates, with "
      "from_z, to_z\n"
      "(without them an end stands on the ground), from_height, to_height, from, to if wanted.\n"
      "\n"
      "A row tells whether the line is visible, else the first point that blocks (blocker, its class and "
      "place, and\n"
      "blocker_at metres from the first end); the clearance, which is the smallest distance of any point "
      "beside the line,\n"
      "where and which; and with --frequency of the first Fresnel zone: its radius in the middle, the share "
      "that is\n"
      "obstructed, within 60 % of the radius (inner), in the worst cross-section, of the volume (cut_off), "
      "by "
      "which class\n"
      "most; whether nothing lies within 60 % (clear); the nearest point as a share of the radius. .json "
      "also "
      "lists\n"
      "which points and classes obstruct how much. .geojson has lines split where they are blocked, in "
      "longitude and\n"
      "latitude where the cloud's reference system is known.\n"
      "\n"
      "Examples:\n"
      "  alidade visibility lines site.las --places masts.geojson -o lines.geojson\n"
      "  alidade visibility lines site.las --pairs links.csv --frequency 5.8GHz --end-margin 1 -o "
      "links.json\n");
  return {lines, [command] {
            ExitCode code = ExitCode::failed;
            with_threads(command->threads, [&] { code = run_lines(*command); });
            return code;
          }};
}

}  // namespace alidade
