// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <map>

#include "jobs/visibility/row_output.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"
#include "tools/image_module.h"
#include "tools/visibility/visibility_request.h"
#include "visibility/points/placement.h"

namespace alidade::tools {
namespace {

struct PlaceCommand : VisibilityRequest {
  ObserverRequest candidates;
  std::optional<double> target_height;
  double target_spacing = 1.0;
  std::optional<std::bitset<256>> target_classes;
  std::map<int, double> class_weights;
  std::size_t count = 0;
  CheckpointRequest checkpoint;
  std::filesystem::path curve;
};

/// "2=1,6=5".
std::map<int, double> parse_weights(const std::string& text) {
  std::map<int, double> weights;
  for (const std::string& word : split_list(text)) {
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos)
      throw UsageError("invalid value; expected CLASS=WEIGHT, such as 6=2.5, found '" + word + "'");
    const auto number = static_cast<int>(parse_count(word.substr(0, equals), 0, 255));
    if (!weights.emplace(number, parse_number(word.substr(equals + 1), 0.0, 1e9)).second)
      throw UsageError(fmt::format("duplicate weight of class {}", number));
  }
  return weights;
}

/// Errors that need no cloud.
void check_options(const PlaceCommand& command) {
  load_row_writer(command.output);
  const std::vector<std::filesystem::path> inputs = command.inputs({command.candidates.file});
  const std::filesystem::path outputs[] = {command.output, command.curve};
  if (!command.curve.empty() && image::image_format(command.curve) != image::ImageFormat::png)
    throw file_error(command.curve, "unknown output format", "the extension .png");
  check_outputs(outputs, command.overwrite, inputs);
  check_checkpoint(command.checkpoint, command.overwrite, outputs, inputs);
}

std::vector<visibility::PlacementTarget> targets_of(const PlaceCommand& command,
                                                    const VisibilityCloud& cloud) {
  const std::span<const std::uint8_t> classes = cloud.columns.classifications;
  const std::filesystem::path& file = command.files.first_name();
  if (classes.empty() && (command.target_classes || !command.class_weights.empty()))
    throw file_error(file, "the cloud has no classification for targets");
  // Points that block nothing are not targets either, unless they are requested.
  const std::bitset<256> wanted = command.target_classes.value_or(~command.occluders.ignored_classes);
  std::function<bool(std::uint64_t)> counts;
  if (!classes.empty()) counts = [classes, wanted](std::uint64_t id) { return wanted.test(classes[id]); };
  std::vector<visibility::PlacementTarget> targets =
      with_progress("choosing targets", "points", command.verbosity, [&](const Progress& progress) {
        return visibility::thin_points(cloud.octree(), command.target_spacing, counts, progress);
      });
  if (targets.empty()) throw file_error(file, "the cloud has no points of the target classes");
  return targets;
}

std::vector<double> weights_of(const PlaceCommand& command, const VisibilityCloud& cloud,
                               const std::vector<visibility::PlacementTarget>& targets) {
  std::vector<double> weights;
  if (command.class_weights.empty()) return weights;
  for (const visibility::PlacementTarget& target : targets) {
    const auto found = command.class_weights.find(cloud.columns.classifications[target.point_id]);
    weights.push_back(found == command.class_weights.end() ? 1.0 : found->second);
  }
  return weights;
}

void say_result(const PlaceCommand& command, const visibility::Placement& placement) {
  if (command.verbosity == Verbosity::quiet) return;
  const double covered = placement.positions.back().covered;
  say_note(fmt::format("{} positions see {:.2f} % of the targets; no choice of {} sees more than {:.2f} %",
                       placement.positions.size(), 100.0 * covered / placement.total, command.count,
                       100.0 * placement.best_possible / placement.total));
  if (placement.positions.size() < command.count) say_note("more positions add nothing");
}

ExitCode run(const PlaceCommand& command) {
  check_options(command);
  const Verbosity verbosity = command.verbosity;
  Console console(verbosity);
  load_row_writer(command.output);
  if (!command.curve.empty()) image_module();
  const auto cloud = load_cloud_alone(command, {}, AcceptedInput::points, console);
  const std::vector<visibility::Observer> candidates = load_observers(command.candidates, *cloud, console);
  const std::vector<visibility::PlacementTarget> targets = targets_of(command, *cloud);
  visibility::check_coverage(candidates.size(), targets.size());
  measure_occluders(*cloud, command.occluders, console);
  say_observer_remarks(candidates, *cloud, console);
  say_note(command.verbosity, fmt::format("{} candidates, {} targets", candidates.size(), targets.size()));
  LongRun long_run(
      command.checkpoint, [&] { return run_fingerprint(command.checkpoint, *cloud, candidates); }, console);
  const visibility::Coverage coverage = long_run.work(
      "testing visibility", "lines of sight", [&](const Progress& progress, PartCheckpoint* parts) {
        return visibility::see_targets(*cloud->occluders, candidates, targets,
                                       command.target_height.value_or(0.0), progress, parts);
      });
  const visibility::Placement placement =
      visibility::choose_places(coverage, command.count, weights_of(command, *cloud, targets));
  if (placement.positions.empty()) {
    say_warning("no candidate sees any target with a positive weight; writing nothing");
    long_run.finish();
    return ExitCode::no;
  }
  write_rows(
      command, cloud->cloud.cloud,
      [&](auto form, const auto& head, const auto& to_lon_lat) {
        return visibility::write_placement(placement, candidates, form, head, to_lon_lat, command.output,
                                           command.overwrite);
      },
      console);
  if (!command.curve.empty())
    image_module().write_coverage_image(placement, command.curve, command.overwrite);
  long_run.finish();
  say_result(command, placement);
  return ExitCode::done;
}

void add_targets(const Fields& place, PlaceCommand& command) {
  const Fields group = place.group("Targets");
  group.number("--target-spacing", "LENGTH",
               "thin the targets to one point per cube of this edge length (default: 1)",
               command.target_spacing, 1e-6, 1e9);
  group.number("--target-height", "LENGTH",
               "height of the targets above these points: 1.7 for people on the ground (default: 0)",
               command.target_height, 0.0, 1e6);
  group.value("--target-classes", "LIST",
              "points of these classes only, such as 2,11 (default: all except --ignore-classes)",
              command.target_classes, parse_classes);
  group.value("--class-weights", "LIST", "weights of targets by class, such as 6=5,2=0.5 (default: 1)",
              command.class_weights, parse_weights);
}

void add_answers(const Fields& place, PlaceCommand& command) {
  const Fields group = place.group("Answers");
  group.required().count("--count", "K", "number of positions to choose", command.count, 1, 1'000'000'000);
  group.required().file(
      "-o,--output", "FILE",
      "output file: .csv, .json or .geojson; one row per position, with what it and the previous ones "
      "cover",
      command.output);
  group.file("--curve", "FILE.png", "image of what each further position adds", command.curve);
  group.flag("--overwrite", "replace existing files", command.overwrite);
}

}  // namespace

Command add_visibility_place(const Options& visibility) {
  auto command = std::make_shared<PlaceCommand>();
  const Options place = visibility.command("place", "Choose the few observer positions that see most");
  add_cloud(place, command->files, {"--ignore-classes"});
  add_observer_fields(place, command->candidates);
  add_targets(place, *command);
  add_occluder_fields(place, command->occluders);
  add_answers(place, *command);
  add_checkpoint_fields(place.group("Long runs"), command->checkpoint);
  add_scratch_memory(place, command->memory);
  add_run_options(place, *command);
  return command_of(place, command, run);
}

}  // namespace alidade::tools
