// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "tools/command.h"
#include "tools/console.h"
#include "tools/image_module.h"
#include "tools/options.h"
#include "tools/visibility/blocking_cloud.h"
#include "tools/visibility/line_pairs.h"
#include "tools/visibility/long_run.h"
#include "tools/visibility/observer_options.h"
#include "tools/visibility/row_output.h"
#include "visibility/lines/fresnel.h"
#include "visibility/lines/line_files.h"

namespace alidade::tools {
namespace {

constexpr double k_radio_factor = 4.0 / 3.0;

struct LinesCommand : CloudRequest {
  CommandLine command_line;
  PairRequest pairs;
  std::optional<double> frequency;                    ///< Hz
  std::optional<std::optional<double>> earth_factor;  ///< empty inside: off
  double end_margin = 0.0;
  OccluderRequest occluders;
  CheckpointRequest checkpoint;
  std::filesystem::path output;
  bool overwrite = false;
};

/// Metres of the cloud's unit, which wavelengths and the Earth are measured by.
double unit_of(const VisibilityCloud& cloud, const std::filesystem::path& file) {
  if (cloud.cloud.cloud.crs.empty()) return 1.0;
  if (const std::optional<double> metres = image_module().metres_per_unit(cloud.cloud.cloud.crs))
    return *metres;
  throw Error({.file = file.string(),
               .problem = "has coordinates in degrees or an unknown unit, which wavelengths and the Earth's "
                          "radius cannot be told in",
               .expected = "a cloud in a projected reference system"});
}

visibility::LineReportOptions report_options(const LinesCommand& command, const VisibilityCloud& cloud) {
  visibility::LineReportOptions options;
  options.line.end_margin = command.end_margin;
  std::optional<double> factor = command.frequency ? std::optional(k_radio_factor) : std::nullopt;
  if (command.earth_factor) factor = *command.earth_factor;
  if (!command.frequency && !factor) return options;
  const double unit = unit_of(cloud, command.files.first_name());
  if (factor) options.line.earth_radius = *factor * geo::k_earth_radius / unit;
  if (command.frequency) options.wavelength = visibility::k_speed_of_light / *command.frequency / unit;
  return options;
}

void say_result(const LinesCommand& command, const visibility::LineTable& table) {
  if (command.verbosity.quiet) return;
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
  chosen_row_form(command.output);
  check_pair_request(command.pairs);
  std::vector<std::filesystem::path> inputs = command.files.names();
  for (const std::filesystem::path& input : {command.pairs.pairs, command.pairs.places}) {
    if (!input.empty()) inputs.push_back(input);
  }
  check_writable(command.output, command.overwrite, inputs);
  check_checkpoint(command.checkpoint, command.overwrite, {&command.output, 1}, inputs);
}

Identity identity_of(const Options& words, const VisibilityCloud& cloud,
                     std::span<const visibility::LinePair> pairs) {
  Identity identity = run_identity(words, cloud);
  std::vector<double> numbers;
  for (const visibility::LinePair& pair : pairs) {
    for (const glm::dvec3& end : {pair.from.position, pair.to.position})
      numbers.insert(numbers.end(), {end.x, end.y, end.z});
  }
  identity.push_back({"number of lines", std::to_string(pairs.size())});
  add_to_identity("ends of the lines", numbers, identity);
  return identity;
}

ExitCode run_lines(const LinesCommand& command, const Options& words) {
  check_options(command);
  const Verbosity verbosity = command.verbosity.verbosity();
  load_row_writer(command.output);
  const auto cloud = load_cloud_alone(command, {});
  const visibility::LineReportOptions options = report_options(command, *cloud);
  visibility::check_line_report(options, command.occluders.transparency);
  const LineEnds ends = load_line_ends(command.pairs, *cloud, verbosity);
  check_report_memory(ends, command.frequency ? LineZones::fresnel : LineZones::none);
  check_margin(ends, command.end_margin);
  measure_occluders(*cloud, command.occluders, verbosity);
  say_observer_remarks(ends.places, *cloud, verbosity);
  visibility::LineTable table;
  table.pairs = pairs_of(ends, *cloud->occluders);
  table.classifications = cloud->columns.classifications;
  LongRun long_run(
      command.checkpoint, [&] { return identity_of(words, *cloud, table.pairs); }, verbosity);
  ProgressLine line("looking along lines", "lines", verbosity);
  table.reports = visibility::report_lines(*cloud->occluders, table.pairs, options, long_run.progress(line),
                                           long_run.parts());
  line.finish();
  const PointCloud& facts = cloud->cloud.cloud;
  const bool is_done = visibility::write_lines(table, chosen_row_form(command.output),
                                               row_file_head(command.command_line, facts),
                                               to_lon_lat_of(facts.crs), command.output, command.overwrite);
  long_run.finish();
  if (!is_done && !command.verbosity.quiet) warn_of_cloud_coordinates(command.output);
  say_result(command, table);
  return ExitCode::done;
}

void add_margin(const Options& lines, LinesCommand& command) {
  lines.group("Lines").number(
      "--end-margin", "LENGTH",
      "so much of a line at either end is not looked at: scanned masts and tripods (default: 0)",
      command.end_margin, 0.0, 1e9);
}

void add_radio(const Options& lines, LinesCommand& command) {
  const Options group = lines.group("Radio");
  group.value("--frequency", "F[GHz|MHz]",
              "report on the first Fresnel zone of this frequency, 5.8GHz or 868MHz; GHz without a unit",
              [&command](const std::string& text) {
                command.frequency = visibility::parse_frequency(text);
                if (!command.frequency) throw UsageError("expected 1MHz to 1000GHz, found '" + text + "'");
              });
  group.value(
      "--earth-radius-factor", "K|off",
      "lines bend down over the ground of a round Earth with K times its radius; K takes in how air bends "
      "rays (default: 1.3333 with --frequency, otherwise off)",
      [&command](const std::string& text) {
        command.earth_factor.emplace();
        if (text != "off") *command.earth_factor = parse_number(text, 1e-3, 1e3);
      });
}

}  // namespace

Command add_visibility_lines(const Options& visibility, const CommandLine& command_line) {
  auto command = std::make_shared<LinesCommand>();
  command->command_line = command_line;
  const Options lines = visibility.command(
      "lines", "Report on sight lines between pairs of places, and on their Fresnel zones");
  add_cloud(lines, *command);
  add_pair_options(lines, command->pairs);
  add_margin(lines, *command);
  add_radio(lines, *command);
  add_occluder_options(lines, command->occluders);
  lines.file("-o,--output", "FILE", "file to write: .csv, .json or .geojson", command->output).required();
  lines.flag("--overwrite", "replace an existing file", command->overwrite);
  add_checkpoint_options(lines, command->checkpoint);
  add_run_options(lines, *command);
  return {lines, [command, lines] {
            return with_threads(command->threads, [&] { return run_lines(*command, lines); });
          }};
}

}  // namespace alidade::tools
