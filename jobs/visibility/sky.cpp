// SPDX-License-Identifier: MIT
#include "jobs/visibility/sky.h"

#include <fmt/format.h>
#include <span>
#include <string>
#include <utility>

#include "jobs/cloud_fields.h"
#include "jobs/long_run.h"
#include "jobs/write_points.h"
#include "visibility/sky/sky_of_cloud.h"

namespace alidade::jobs {
namespace {

visibility::SkyViewOptions sky_options(const SkyRequest& request) {
  return {.directions = request.directions,
          .receiver = request.receiver.value_or(request.is_map() ? visibility::SkyReceiver::horizontal
                                                                 : visibility::SkyReceiver::surface),
          .max_distance = request.max_distance};
}

/// Factors, and a summary for people.
struct SkyViews {
  SkyResult result;
  std::string summary;
};

SkyViews map_sky(const SkyRequest& request, const SkySite& site, LongRun& long_run) {
  geo::Raster<float> views =
      long_run.work("testing the sky", "cells", [&](const Progress& progress, PartCheckpoint* parts) {
        return visibility::ground_sky_views(*site.cloud->occluders, *site.ground, site.grid,
                                            request.map.target_height.value_or(0.0), sky_options(request),
                                            {progress, parts});
      });
  std::string summary = range_and_mean([&](std::size_t i) { return views.values[i]; }, views.values.size());
  const SkyBand band{views, "SkyView", ""};
  MapMetadata metadata = write_sky_map(
      request, site, std::span(&band, 1),
      {{"alidade_sky",
        fmt::format("sky-view factor on the {}, {} directions",
                    sky_options(request).receiver == visibility::SkyReceiver::surface ? "slope of the ground"
                                                                                      : "horizontal",
                    request.directions)}},
      {.title = "Sky-view factor",
       .values = {},
       .scale = visibility::MapScale{image::ColorMap::viridis, {0.0, 1.0}, "sky-view factor"}});
  return {{std::move(views), site.cloud->cloud.cloud.crs, std::move(metadata)}, std::move(summary)};
}

SkyViews point_sky(const SkyRequest& request, const VisibilityCloud& cloud, LongRun& long_run,
                   Listener& listener) {
  std::vector<float> views =
      long_run.work("testing the sky", "points", [&](const Progress& progress, PartCheckpoint* parts) {
        return visibility::point_sky_views(*cloud.occluders, cloud.columns.normals, sky_options(request),
                                           {progress, parts});
      });
  if (!request.output.empty())
    write_points(request.output, cloud.cloud, columns_of(views), request.overwrite, request.memory, listener);
  std::string summary = range_and_mean([&views](std::size_t id) { return views[id]; }, views.size());
  return {{std::move(views), cloud.cloud.cloud.crs, {}}, std::move(summary)};
}

}  // namespace

void add_sky_fields(const Fields& fields, SkyRequest& request) {
  add_cloud(fields, request.files, {"--ignore-classes"});
  add_sky_site_fields(fields, request);
  fields.group("Answers").count("--directions", "N",
                                "lines of sight per point or cell (default: 128, for an error of about 0.01)",
                                request.directions, 1, visibility::k_most_sky_directions);
  add_partial(fields, request.partial);
}

std::vector<ResultColumn> columns_of(const std::vector<float>& views) {
  return {result_column<float>("SkyView", "sky-view factor, 0 to 1", ScalarType::float32,
                               [&views](std::size_t id) { return views[id]; })};
}

SkyPlan plan(const SkyRequest& request) {
  return SkyPlan(request, plan_sky_site(request));
}

SkyResult run(const SkyPlan& plan, Listener& listener) {
  const SkyRequest& request = plan.request();
  const SkySite site = load_sky_site(request, 1, listener);
  LongRun long_run(
      request.checkpoint, [&] { return sky_fingerprint(request, site); }, listener);
  measure_occluders(*site.cloud, request.occluders, listener);
  SkyViews views = request.is_map() ? map_sky(request, site, long_run)
                                    : point_sky(request, *site.cloud, long_run, listener);
  long_run.finish();
  listener.note(fmt::format("sky-view factors {}{}", views.summary, wrote_text(request)));
  return std::move(views.result);
}

}  // namespace alidade::jobs
