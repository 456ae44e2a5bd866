// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/output_file.h"
#include "base/words.h"
#include "jobs/write_points.h"
#include "tools/cloud/load_cloud.h"
#include "tools/command.h"
#include "tools/visibility/visibility_request.h"
#include "visibility/points/point_visibility.h"

namespace alidade::tools {
namespace {

enum class BlockerColumns { none, all };

struct PointsCommand : VisibilityRequest {
  ObserverRequest observers;
  CheckpointRequest checkpoint;
  int sub_rays = 1;
  std::optional<BlockerColumns> blockers;
  std::filesystem::path lists;
};

/// "observer,point_id" for every point that an observer sees.
class SeenList {
 public:
  SeenList(const std::filesystem::path& file, bool overwrite) : file_(file, overwrite) {
    file_.write("observer,point_id\n");
  }

  /// Adds the points that observer `number`, from 1, sees.
  void add(std::size_t number, std::span<const std::uint8_t> seen) {
    constexpr std::size_t k_enough = 1 << 20;
    const std::string prefix = fmt::format("{},", number);
    std::string text;
    for (std::size_t id = 0; id < seen.size(); ++id) {
      if (seen[id] == 0) continue;
      text += prefix;
      text += fmt::format_int(id).str();
      text += '\n';
      if (text.size() < k_enough) continue;
      file_.write(text);
      text.clear();
    }
    file_.write(text);
  }
  void finish() { file_.commit(); }

 private:
  OutputFile file_;
};

std::int64_t blocker_number(std::uint32_t blocker) {
  if (blocker == visibility::k_no_blocker) return -1;
  return blocker == visibility::k_blocked_by_mesh ? -2 : std::int64_t{blocker};
}

/// `seen` must outlive the columns.
std::vector<ResultColumn> columns_of(const visibility::PointVisibility& seen) {
  std::vector<ResultColumn> columns;
  columns.push_back(
      result_column<std::uint8_t>("Visible", "1: visible from an observer", ScalarType::uint8,
                                  [&seen](std::size_t id) { return seen.counts[id] > 0 ? 1 : 0; }));
  columns.push_back(result_column<std::uint32_t>("VisibleCount", "observers that see the point",
                                                 ScalarType::uint32,
                                                 [&seen](std::size_t id) { return seen.counts[id]; }));
  if (!seen.masks.empty()) {
    columns.push_back(result_column<std::uint64_t>("VisibleBy", "bit i-1: observer i sees it",
                                                   ScalarType::uint64,
                                                   [&seen](std::size_t id) { return seen.masks[id]; }));
  }
  if (!seen.fractions.empty()) {
    columns.push_back(result_column<float>("VisibleFraction", "visible share of its disc",
                                           ScalarType::float32,
                                           [&seen](std::size_t id) { return seen.fractions[id]; }));
  }
  for (std::size_t i = 0; i < seen.blockers.size(); ++i) {
    const std::vector<std::uint32_t>& blockers = seen.blockers[i];
    columns.push_back(
        result_column<std::int64_t>(seen.blockers.size() == 1 ? "Blocker" : fmt::format("Blocker_{}", i + 1),
                                    "blocking point, -1 none, -2 mesh", ScalarType::int64,
                                    [&blockers](std::size_t id) { return blocker_number(blockers[id]); }));
  }
  return columns;
}

/// Errors that need no cloud.
void check_options(const PointsCommand& command) {
  check_points_name(command.output);
  const std::vector<std::filesystem::path> inputs = command.inputs({command.observers.file});
  const std::filesystem::path outputs[] = {command.output, command.lists};
  check_outputs(outputs, command.overwrite, inputs);
  check_checkpoint(command.checkpoint, command.overwrite, outputs, inputs);
}

/// Error if the bits of VisibleBy do not fit into the numbers of the output.
void check_observer_count(const PointsCommand& command, std::size_t observers) {
  constexpr std::size_t k_most_in_double = 53;
  if (file_extension(command.output) != ".ply" || observers <= k_most_in_double ||
      observers > visibility::k_most_mask_observers)
    return;
  throw file_error(command.output, "PLY cannot store VisibleBy for this number of observers",
                   fmt::format("the extension .las or .laz, or at most {} observers", k_most_in_double),
                   std::to_string(observers));
}

/// Whether blockers are reported: by default those of a single observer. Errors: too many columns.
bool with_blockers(const PointsCommand& command, std::size_t observers) {
  const bool wanted = command.blockers.value_or(observers == 1 ? BlockerColumns::all
                                                               : BlockerColumns::none) == BlockerColumns::all;
  if (wanted && observers > visibility::k_most_mask_observers) {
    throw input_error("too many observers for a column of blockers each",
                      fmt::format("at most {}, or --blockers none", visibility::k_most_mask_observers),
                      std::to_string(observers));
  }
  return wanted;
}

/// The options of point_visibility(). Errors: too many columns, or not enough memory for them.
visibility::PointVisibilityOptions visibility_options(const PointsCommand& command, std::uint64_t points,
                                                      std::size_t observers) {
  const visibility::PointVisibilityOptions options{.sub_rays = command.sub_rays,
                                                   .with_blockers = with_blockers(command, observers)};
  visibility::check_point_visibility(points, observers, options);
  return options;
}

visibility::PointVisibility test_visibility(const VisibilityCloud& cloud,
                                            std::span<const visibility::Observer> observers,
                                            visibility::PointVisibilityOptions options, LongRun& long_run,
                                            std::optional<SeenList>& list) {
  if (list) {
    options.each_observer = [&list](std::size_t number, std::span<const std::uint8_t> seen) {
      list->add(number + 1, seen);
    };
  }
  return long_run.work("testing visibility", "lines of sight",
                       [&](const Progress& progress, PartCheckpoint* parts) {
                         options.progress = progress;
                         options.parts = parts;
                         return visibility::point_visibility(*cloud.occluders, observers, options);
                       });
}

/// How many of the hidden points are hidden by points without a surface, and by the point that hides most.
std::string blocking_text(const visibility::PointVisibility& seen, const visibility::Occluders& occluders) {
  std::vector<std::uint32_t> blockers;
  for (const std::vector<std::uint32_t>& column : seen.blockers) {
    std::ranges::copy_if(column, std::back_inserter(blockers),
                         [](std::uint32_t blocker) { return blocker < visibility::k_blocked_by_mesh; });
  }
  if (blockers.empty()) return {};
  std::ranges::sort(blockers);
  std::size_t lone = 0, most = 0;
  std::uint32_t widest = 0;
  for (auto first = blockers.begin(); first != blockers.end();) {
    const auto last = std::upper_bound(first, blockers.end(), *first);
    const auto count = static_cast<std::size_t>(last - first);
    if (!occluders.surface(*first).exists) lone += count;
    if (count > most) widest = *first;
    most = std::max(most, count);
    first = last;
  }
  const auto percent = [&](std::size_t count) {
    return 100.0 * static_cast<double>(count) / static_cast<double>(blockers.size());
  };
  return fmt::format(
      "points without a surface block {:.1f} % of the lines that points block; point {} blocks most, {:.3g} "
      "%",
      percent(lone), widest, percent(most));
}

ExitCode run(const PointsCommand& command) {
  check_options(command);
  const Verbosity verbosity = command.verbosity;
  Console console(verbosity);
  check_given(command.observers);
  const auto cloud = load_cloud_alone(command, AttributeSet::all(), AcceptedInput::points, console);
  const std::vector<visibility::Observer> observers = load_observers(command.observers, *cloud, console);
  check_observer_count(command, observers.size());
  const visibility::PointVisibilityOptions options =
      visibility_options(command, cloud->octree().size(), observers.size());
  measure_occluders(*cloud, command.occluders, console);
  say_observer_remarks(observers, *cloud, console);
  if (observers.size() > visibility::k_most_mask_observers && command.lists.empty()) {
    say_note(verbosity, fmt::format("{} observers exceed the {} bits of VisibleBy; use --lists FILE",
                                    observers.size(), visibility::k_most_mask_observers));
  }
  LongRun long_run(
      command.checkpoint, [&] { return run_fingerprint(command.checkpoint, *cloud, observers); }, console);
  std::optional<SeenList> list;
  if (!command.lists.empty()) list.emplace(command.lists, command.overwrite);
  const visibility::PointVisibility seen = test_visibility(*cloud, observers, options, long_run, list);
  write_points(command.output, cloud->cloud, columns_of(seen), command.overwrite, command.memory, console);
  if (list) list->finish();
  long_run.finish();
  const auto count = static_cast<std::size_t>(
      std::ranges::count_if(seen.counts, [](std::uint32_t observers_of_it) { return observers_of_it > 0; }));
  say_note(verbosity,
           fmt::format("{} of {} points are visible ({:.1f} %); wrote {}", count, seen.counts.size(),
                       100.0 * static_cast<double>(count) / static_cast<double>(seen.counts.size()),
                       command.output.string()));
  if (const std::string text = blocking_text(seen, *cloud->occluders); !text.empty())
    say_note(verbosity, text);
  return ExitCode::done;
}

void add_answers(const Fields& points, PointsCommand& command) {
  const Fields group = points.group("Answers");
  group.required().file("-o,--output", "FILE.las|FILE.laz|FILE.ply",
                        "output cloud: LAS 1.4, LAZ or PLY, by the extension", command.output);
  group.count("--fraction", "N",
              "also test N positions on the disc of each point, 2 to 255: VisibleFraction is the share of "
              "visible ones (default: off)",
              command.sub_rays, 2, visibility::k_most_sub_rays);
  group.choice("--blockers",
               "report the blocking point (default: all for one observer, else none); none is faster",
               command.blockers, {{"all", BlockerColumns::all}, {"none", BlockerColumns::none}});
  group.file("--lists", "FILE.csv",
             "also write all pairs of observer and visible point: CSV observer,point_id, for any number of "
             "observers",
             command.lists);
  group.flag("--overwrite", "replace an existing file", command.overwrite);
}

}  // namespace

Command add_visibility_points(const Options& visibility) {
  auto command = std::make_shared<PointsCommand>();
  const Options points =
      visibility.command("points", "Compute the visibility of every point, and what blocks it");
  add_cloud(points, command->files, {"--ignore-classes"});
  add_observer_fields(points, command->observers);
  add_occluder_fields(points, command->occluders);
  add_answers(points, *command);
  add_checkpoint_fields(points.group("Long runs"), command->checkpoint);
  add_scratch_memory(points, command->memory);
  add_run_options(points, *command);
  return command_of(points, command, run);
}

}  // namespace alidade::tools
