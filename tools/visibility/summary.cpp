// SPDX-License-Identifier: MIT
#include "visibility/points/summary.h"

#include <fmt/format.h>

#include "jobs/visibility/row_output.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"
#include "tools/visibility/visibility_request.h"
#include "visibility/points/point_visibility.h"

namespace alidade::tools {
namespace {

struct SummaryCommand : VisibilityRequest {
  ObserverRequest observers;
  visibility::SummaryOptions summary;  ///< without classes
  CheckpointRequest checkpoint;
};

/// "10,100".
std::vector<double> parse_bands(const std::string& text) {
  std::vector<double> bands;
  for (const std::string& word : split_list(text)) {
    bands.push_back(parse_number(word, 1e-6, 1e9));
    if (bands.size() > 1 && !(bands[bands.size() - 2] < bands.back()))
      throw UsageError("limits out of order; expected ascending distances, found '" + text + "'");
  }
  return bands;
}

/// Errors that need no cloud.
void check_options(const SummaryCommand& command) {
  visibility::azimuths_per_turn(command.summary.step);
  load_row_writer(command.output);
  const std::vector<std::filesystem::path> inputs = command.inputs({command.observers.file});
  check_writable(command.output, command.overwrite, inputs);
  check_checkpoint(command.checkpoint, command.overwrite, {{command.output}}, inputs);
}

ExitCode run(const SummaryCommand& command) {
  check_options(command);
  const Verbosity verbosity = command.verbosity;
  Console console(verbosity);
  load_row_writer(command.output);
  check_given(command.observers);
  const auto cloud = load_cloud_alone(command, Attribute::classification, AcceptedInput::points, console);
  const std::vector<visibility::Observer> observers = load_observers(command.observers, *cloud, console);
  visibility::check_point_visibility(cloud->octree().size(), observers.size(), {});
  measure_occluders(*cloud, command.occluders, console);
  say_observer_remarks(observers, *cloud, console);
  LongRun long_run(
      command.checkpoint, [&] { return run_fingerprint(command.checkpoint, *cloud, observers); }, console);
  visibility::SummaryOptions options = command.summary;
  options.classes = cloud->columns.classifications;
  const std::vector<visibility::ObserverSummary> summaries = long_run.work(
      "testing visibility", "lines of sight", [&](const Progress& progress, PartCheckpoint* parts) {
        options.progress = progress;
        options.parts = parts;
        return visibility::summarize(*cloud->occluders, observers, options);
      });
  write_rows(
      command, cloud->cloud.cloud,
      [&](auto form, const auto& head, const auto& to_lon_lat) {
        return visibility::write_summaries(summaries, observers, options, form, head, to_lon_lat,
                                           command.output, command.overwrite);
      },
      console);
  long_run.finish();
  say_note(verbosity, fmt::format("{} observer{}; wrote {}", observers.size(),
                                  observers.size() == 1 ? "" : "s", command.output.string()));
  return ExitCode::done;
}

void add_answers(const Fields& summary, SummaryCommand& command) {
  const Fields group = summary.group("Answers");
  group.required().file("-o,--output", "FILE", "output file: .csv, .json or .geojson; one row per observer",
                        command.output);
  group.value("--bands", "LIST", "limits of the bands of distance, ascending (default: 10,100,1000)",
              command.summary.bands, parse_bands);
  group.number("--step", "DEGREES",
               "azimuth step of isovist and horizon in degrees; divides 360 (default: 1)",
               command.summary.step, 0.001, 120.0);
  group.count(
      "--directions", "N",
      "lines to the sky for the sky-view factor, and twice as many to all sides for the volume (default: "
      "4096)",
      command.summary.directions, 1, visibility::k_most_sky_directions);
  group.flag("--overwrite", "replace an existing file", command.overwrite);
}

}  // namespace

Command add_visibility_summary(const Options& visibility) {
  auto command = std::make_shared<SummaryCommand>();
  const Options summary = visibility.command("summary", "Summarize what each observer sees in one row");
  add_cloud(summary, command->files, {"--ignore-classes"});
  add_observer_fields(summary, command->observers);
  add_occluder_fields(summary, command->occluders);
  add_answers(summary, *command);
  add_checkpoint_fields(summary.group("Long runs"), command->checkpoint);
  add_scratch_memory(summary, command->memory);
  add_run_options(summary, *command);
  return command_of(summary, command, run);
}

}  // namespace alidade::tools
