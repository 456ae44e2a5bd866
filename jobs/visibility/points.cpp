// SPDX-License-Identifier: MIT
#include "jobs/visibility/points.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <span>
#include <string>
#include <utility>

#include "base/error.h"
#include "base/output_file.h"
#include "base/words.h"
#include "jobs/cloud_fields.h"
#include "jobs/large_clouds.h"
#include "jobs/load_cloud.h"
#include "jobs/outputs.h"
#include "jobs/visibility/run_fingerprint.h"
#include "jobs/write_points.h"

namespace alidade::jobs {
namespace {

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

/// Error if the bits of VisibleBy do not fit into the numbers of the output.
void check_observer_count(const PointsRequest& request, std::size_t observers) {
  constexpr std::size_t k_most_in_double = 53;
  if (file_extension(request.output) != ".ply" || observers <= k_most_in_double ||
      observers > visibility::k_most_mask_observers)
    return;
  throw file_error(request.output, "PLY cannot store VisibleBy for this number of observers",
                   fmt::format("the extension .las or .laz, or at most {} observers", k_most_in_double),
                   std::to_string(observers));
}

/// Whether blockers are reported: by default those of a single observer. Errors: too many columns.
bool with_blockers(const PointsRequest& request, std::size_t observers) {
  const bool wanted = request.blockers.value_or(observers == 1 ? BlockerColumns::all
                                                               : BlockerColumns::none) == BlockerColumns::all;
  if (wanted && observers > visibility::k_most_mask_observers) {
    throw input_error("too many observers for a column of blockers each",
                      fmt::format("at most {}, or --blockers none", visibility::k_most_mask_observers),
                      std::to_string(observers));
  }
  return wanted;
}

/// The options of point_visibility(). Errors: too many columns, or not enough memory for them.
visibility::PointVisibilityOptions visibility_options(const PointsRequest& request, std::uint64_t points,
                                                      std::size_t observers) {
  const visibility::PointVisibilityOptions options{.sub_rays = request.sub_rays,
                                                   .with_blockers = with_blockers(request, observers)};
  visibility::check_point_visibility(points, observers, options);
  return options;
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

/// How many points are visible.
std::string result_text(const PointsRequest& request, const visibility::PointVisibility& seen) {
  const auto count = static_cast<std::size_t>(
      std::ranges::count_if(seen.counts, [](std::uint32_t observers_of_it) { return observers_of_it > 0; }));
  return fmt::format("{} of {} points are visible ({:.1f} %){}", count, seen.counts.size(),
                     100.0 * static_cast<double>(count) / static_cast<double>(seen.counts.size()),
                     wrote_text(request));
}

void add_answers(const Fields& points, PointsRequest& request) {
  const Fields group = points.group("Answers");
  group.required().file("-o,--output", "FILE.las|FILE.laz|FILE.ply",
                        "output cloud: LAS 1.4, LAZ or PLY, by the extension", request.output);
  group.count("--fraction", "N",
              "also test N positions on the disc of each point, 2 to 255: VisibleFraction is the share of "
              "visible ones (default: off)",
              request.sub_rays, 2, visibility::k_most_sub_rays);
  group.choice("--blockers",
               "report the blocking point (default: all for one observer, else none); none is faster",
               request.blockers, {{"all", BlockerColumns::all}, {"none", BlockerColumns::none}});
  group.file("--lists", "FILE.csv",
             "also write all pairs of observer and visible point: CSV observer,point_id, for any number of "
             "observers",
             request.lists);
  group.flag("--overwrite", "replace an existing file", request.overwrite);
}

}  // namespace

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

void add_points_fields(const Fields& fields, PointsRequest& request) {
  add_cloud(fields, request.files, {"--ignore-classes"});
  add_observer_fields(fields, request.observers);
  add_occluder_fields(fields, request.occluders);
  add_answers(fields, request);
  add_checkpoint_fields(fields.group("Long runs"), request.checkpoint);
  add_scratch_memory(fields, request.memory);
  add_partial(fields, request.partial);
}

PointsPlan plan(const PointsRequest& request) {
  if (!request.output.empty()) check_points_name(request.output);
  PlannedWork work = request.work({request.observers.file}, {request.lists});
  check_outputs(work, request.overwrite);
  check_checkpoint(request.checkpoint, request.overwrite, work);
  check_given(request.observers);
  return PointsPlan(request, std::move(work));
}

PointsResult run(const PointsPlan& plan, Listener& listener) {
  const PointsRequest& request = plan.request();
  const auto cloud = load_cloud_alone(request, request.output.empty() ? AttributeSet() : AttributeSet::all(),
                                      AcceptedInput::points, listener);
  std::vector<visibility::Observer> observers = load_observers(request.observers, *cloud, listener);
  check_observer_count(request, observers.size());
  visibility::PointVisibilityOptions options =
      visibility_options(request, cloud->octree().size(), observers.size());
  measure_occluders(*cloud, request.occluders, listener);
  say_observer_remarks(observers, *cloud, listener);
  if (observers.size() > visibility::k_most_mask_observers && request.lists.empty()) {
    listener.note(fmt::format("{} observers exceed the {} bits of VisibleBy; use --lists FILE",
                              observers.size(), visibility::k_most_mask_observers));
  }
  VisibilityRun long_run(request.checkpoint, *cloud, observers, listener);
  std::optional<SeenList> list;
  if (!request.lists.empty()) {
    list.emplace(request.lists, request.overwrite);
    options.each_observer = [&](std::size_t number, std::span<const std::uint8_t> seen) {
      list->add(number + 1, seen);
    };
  }
  visibility::PointVisibility seen = long_run.test_visibility(options, [&](const auto& all) {
    return visibility::point_visibility(*cloud->occluders, observers, all);
  });
  if (!request.output.empty())
    write_points(request.output, cloud->cloud, columns_of(seen), request.overwrite, request.memory, listener);
  if (list) list->finish();
  long_run.finish();
  listener.note(result_text(request, seen));
  if (const std::string text = blocking_text(seen, *cloud->occluders); !text.empty()) listener.note(text);
  return {std::move(observers), cloud->cloud.cloud.crs, std::move(seen)};
}

}  // namespace alidade::jobs
