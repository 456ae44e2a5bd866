// SPDX-License-Identifier: MIT
#include "jobs/visibility/summary.h"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "jobs/cloud_fields.h"
#include "jobs/large_clouds.h"
#include "jobs/load_cloud.h"
#include "jobs/outputs.h"
#include "jobs/visibility/row_output.h"
#include "jobs/visibility/run_fingerprint.h"
#include "visibility/points/point_visibility.h"

namespace alidade::jobs {
namespace {

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

void add_answers(const Fields& summary, SummaryRequest& request) {
  const Fields group = summary.group("Answers");
  group.required().file("-o,--output", "FILE", "output file: .csv, .json or .geojson; one row per observer",
                        request.output);
  group.value("--bands", "LIST", "limits of the bands of distance, ascending (default: 10,100,1000)",
              request.summary.bands, parse_bands);
  group.number("--step", "DEGREES",
               "azimuth step of isovist and horizon in degrees; divides 360 (default: 1)",
               request.summary.step, 0.001, 120.0);
  group.count(
      "--directions", "N",
      "lines to the sky for the sky-view factor, and twice as many to all sides for the volume (default: "
      "4096)",
      request.summary.directions, 1, visibility::k_most_sky_directions);
  group.flag("--overwrite", "replace an existing file", request.overwrite);
}

}  // namespace

void add_summary_fields(const Fields& fields, SummaryRequest& request) {
  add_cloud(fields, request.files, {"--ignore-classes"});
  add_observer_fields(fields, request.observers);
  add_occluder_fields(fields, request.occluders);
  add_answers(fields, request);
  add_checkpoint_fields(fields.group("Long runs"), request.checkpoint);
  add_scratch_memory(fields, request.memory);
  add_partial(fields, request.partial);
}

SummaryPlan plan(const SummaryRequest& request) {
  visibility::azimuths_per_turn(request.summary.step);
  if (!request.output.empty()) load_row_writer(request.output);
  PlannedWork work = request.work({request.observers.file});
  check_outputs(work, request.overwrite);
  check_checkpoint(request.checkpoint, request.overwrite, work);
  check_given(request.observers);
  return SummaryPlan(request, std::move(work));
}

SummaryResult run(const SummaryPlan& plan, Listener& listener) {
  const SummaryRequest& request = plan.request();
  const auto cloud = load_cloud_alone(request, Attribute::classification, AcceptedInput::points, listener);
  std::vector<visibility::Observer> observers = load_observers(request.observers, *cloud, listener);
  visibility::check_point_visibility(cloud->octree().size(), observers.size(), {});
  measure_occluders(*cloud, request.occluders, listener);
  say_observer_remarks(observers, *cloud, listener);
  VisibilityRun long_run(request.checkpoint, *cloud, observers, listener);
  visibility::SummaryOptions options = request.summary;
  options.classes = cloud->columns.classifications;
  std::vector<visibility::ObserverSummary> summaries = long_run.test_visibility(
      options, [&](const auto& all) { return visibility::summarize(*cloud->occluders, observers, all); });
  write_rows(
      request, cloud->cloud.cloud,
      [&](const auto&... to) { return visibility::write_summaries(summaries, observers, options, to...); },
      listener);
  long_run.finish();
  listener.note(fmt::format("{} observer{}{}", observers.size(), observers.size() == 1 ? "" : "s",
                            wrote_text(request)));
  std::bitset<256> classes;
  for (const std::uint8_t number : options.classes) classes.set(number);
  return {std::move(observers), cloud->cloud.cloud.crs, std::move(summaries), classes};
}

}  // namespace alidade::jobs
