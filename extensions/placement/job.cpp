// SPDX-License-Identifier: MIT
#include "extensions/placement/job.h"

#include <fmt/format.h>

#include <functional>
#include <span>
#include <string>
#include <utility>

#include "base/error.h"
#include "extensions/placement/coverage_image.h"
#include "image/image_file.h"
#include "jobs/cloud_fields.h"
#include "jobs/large_clouds.h"
#include "jobs/load_cloud.h"
#include "jobs/outputs.h"
#include "jobs/visibility/row_output.h"
#include "jobs/visibility/run_fingerprint.h"

namespace alidade::jobs {
namespace {

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

std::vector<visibility::PlacementTarget> targets_of(const PlaceRequest& request, const VisibilityCloud& cloud,
                                                    Listener& listener) {
  const std::span<const std::uint8_t> classes = cloud.columns.classifications;
  const std::filesystem::path& file = request.files.first_name();
  if (classes.empty() && (request.target_classes || !request.class_weights.empty()))
    throw file_error(file, "the cloud has no classification for targets");
  // Points that block nothing are not targets either, unless they are requested.
  const std::bitset<256> wanted = request.target_classes.value_or(~request.occluders.ignored_classes);
  std::function<bool(std::uint64_t)> counts;
  if (!classes.empty()) counts = [classes, wanted](std::uint64_t id) { return wanted.test(classes[id]); };
  std::vector<visibility::PlacementTarget> targets =
      in_stage(listener, "choosing targets", "points", [&](const Progress& progress) {
        return visibility::thin_points(cloud.octree(), request.target_spacing, counts, progress);
      });
  if (targets.empty()) throw file_error(file, "the cloud has no points of the target classes");
  return targets;
}

std::vector<double> weights_of(const PlaceRequest& request, const VisibilityCloud& cloud,
                               const std::vector<visibility::PlacementTarget>& targets) {
  std::vector<double> weights;
  if (request.class_weights.empty()) return weights;
  for (const visibility::PlacementTarget& target : targets) {
    const auto found = request.class_weights.find(cloud.columns.classifications[target.point_id]);
    weights.push_back(found == request.class_weights.end() ? 1.0 : found->second);
  }
  return weights;
}

/// Requires a position.
void write(const PlaceRequest& request, const VisibilityCloud& cloud, const visibility::Placement& placement,
           std::span<const visibility::Observer> candidates, Listener& listener) {
  write_rows(
      request, cloud.cloud.cloud,
      [&](const auto&... to) { return visibility::write_placement(placement, candidates, to...); }, listener);
  if (!request.curve.empty()) visibility::write_coverage_image(placement, request.curve, request.overwrite);
}

/// Requires a position.
void say_result(const PlaceRequest& request, const visibility::Placement& placement, Listener& listener) {
  const double covered = placement.positions.back().covered;
  listener.note(
      fmt::format("{} positions see {:.2f} % of the targets; no choice of {} sees more than {:.2f} %",
                  placement.positions.size(), 100.0 * covered / placement.total, request.count,
                  100.0 * placement.best_possible / placement.total));
  if (placement.positions.size() < request.count) listener.note("more positions add nothing");
}

void add_targets(const Fields& place, PlaceRequest& request) {
  const Fields group = place.group("Targets");
  group.number("--target-spacing", "LENGTH",
               "thin the targets to one point per cube of this edge length (default: 1)",
               request.target_spacing, 1e-6, 1e9);
  group.number("--target-height", "LENGTH",
               "height of the targets above these points: 1.7 for people on the ground (default: 0)",
               request.target_height, 0.0, 1e6);
  group.value("--target-classes", "LIST",
              "points of these classes only, such as 2,11 (default: all except --ignore-classes)",
              request.target_classes, parse_classes);
  group.value("--class-weights", "LIST", "weights of targets by class, such as 6=5,2=0.5 (default: 1)",
              request.class_weights, parse_weights);
}

void add_answers(const Fields& place, PlaceRequest& request) {
  const Fields group = place.group("Answers");
  group.required().count("--count", "K", "number of positions to choose", request.count, 1, 1'000'000'000);
  group.required().file(
      "-o,--output", "FILE",
      "output file: .csv, .json or .geojson; one row per position, with what it and the previous ones "
      "cover",
      request.output);
  group.file("--curve", "FILE.png", "image of what each further position adds", request.curve);
  group.flag("--overwrite", "replace existing files", request.overwrite);
}

}  // namespace

void add_place_fields(const Fields& fields, PlaceRequest& request) {
  add_cloud(fields, request.files, {"--ignore-classes"});
  add_observer_fields(fields, request.candidates);
  add_targets(fields, request);
  add_occluder_fields(fields, request.occluders);
  add_answers(fields, request);
  add_checkpoint_fields(fields.group("Long runs"), request.checkpoint);
  add_scratch_memory(fields, request.memory);
  add_partial(fields, request.partial);
}

PlacePlan plan(const PlaceRequest& request) {
  if (!request.output.empty()) load_row_writer(request.output);
  if (!request.curve.empty() && image::image_format(request.curve) != image::ImageFormat::png)
    throw file_error(request.curve, "unknown output format", "the extension .png");
  PlannedWork work = request.work({request.candidates.file}, {request.curve});
  check_outputs(work, request.overwrite);
  check_checkpoint(request.checkpoint, request.overwrite, work);
  if (!request.curve.empty()) image::load_library();
  return PlacePlan(request, std::move(work));
}

PlaceResult run(const PlacePlan& plan, Listener& listener) {
  const PlaceRequest& request = plan.request();
  const auto cloud = load_cloud_alone(request, {}, AcceptedInput::points, listener);
  std::vector<visibility::Observer> candidates = load_observers(request.candidates, *cloud, listener);
  std::vector<visibility::PlacementTarget> targets = targets_of(request, *cloud, listener);
  visibility::check_coverage(candidates.size(), targets.size());
  measure_occluders(*cloud, request.occluders, listener);
  say_observer_remarks(candidates, *cloud, listener);
  listener.note(fmt::format("{} candidates, {} targets", candidates.size(), targets.size()));
  VisibilityRun long_run(request.checkpoint, *cloud, candidates, listener);
  const double height = request.target_height.value_or(0.0);
  const visibility::Coverage coverage =
      long_run.work("testing visibility", "lines of sight", [&](const auto& progress, PartCheckpoint* parts) {
        return visibility::see_targets(*cloud->occluders, candidates, targets, height, progress, parts);
      });
  visibility::Placement placement =
      visibility::choose_places(coverage, request.count, weights_of(request, *cloud, targets));
  if (placement.positions.empty()) {
    listener.warn_always("no candidate sees any target with a positive weight; writing nothing");
  } else {
    write(request, *cloud, placement, candidates, listener);
  }
  long_run.finish();
  if (!placement.positions.empty()) say_result(request, placement, listener);
  return {std::move(candidates), cloud->cloud.cloud.crs, std::move(targets), std::move(placement)};
}

}  // namespace alidade::jobs
