// SPDX-License-Identifier: MIT
#include "jobs/visibility/sun.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/words.h"
#include "cloud/axis_units.h"
#include "image/image_file.h"
#include "jobs/outputs.h"
#include "jobs/visibility/row_output.h"
#include "jobs/visibility/run_fingerprint.h"
#include "jobs/write_points.h"
#include "visibility/horizon/skyline.h"
#include "visibility/horizon/skyline_image.h"
#include "visibility/sky/sun_path.h"

namespace alidade::jobs {
namespace {

/// "SunHours_2026-06" of a period with a name.
std::string name_of(const SunQuantity& quantity, const std::string& period) {
  return period.empty() ? quantity.name : fmt::format("{}_{}", quantity.name, period);
}

/// What is computed of receivers; `usual`: unless the request says more.
std::unique_ptr<visibility::SunMeasure> measure_of(const SunRequest& request, const SunSky& sun,
                                                   const visibility::Occluders& occluders,
                                                   visibility::SkyReceiver usual, double cell) {
  return sun.shine->measure(occluders, request.hours_options(usual), cell);
}

SunResult map_sun(const SunRequest& request, const SkySite& site, const SunSky& sun, LongRun& long_run,
                  std::string& range) {
  SunResult result;
  result.periods = sun.periods;
  result.crs = site.cloud->cloud.cloud.crs;
  result.grid = site.grid;
  const auto measure = measure_of(request, sun, *site.cloud->occluders, visibility::SkyReceiver::horizontal,
                                  site.grid.cell_size);
  result.per_period = measure->numbers();
  result.numbers =
      long_run.work("testing the sun", "cells", [&](const Progress& progress, PartCheckpoint* parts) {
        return visibility::ground_sun(*site.cloud->occluders, *site.ground, site.grid,
                                      request.map.target_height.value_or(0.0), *measure, {progress, parts});
      });
  std::vector<SunBand> values = bands_of(request, result);
  std::vector<SkyBand> bands;
  for (SunBand& band : values) bands.push_back({band.values, band.name, band.unit});
  const auto& first = values.front().values.values;
  range = range_and_mean([&](std::size_t i) { return first[i]; }, first.size());
  const visibility::SunSchedule& schedule = sun.schedule;
  result.metadata = write_sky_map(
      request, site, bands, sun_metadata(request, sun),
      {.title = "Hours of direct sun",
       .values = {},
       .scale =
           visibility::MapScale{image::ColorMap::inferno, {0.0, std::max(sun.first_hours, 1.0)}, "hours"},
       .notes = {sun.periods.front().empty()
                     ? fmt::format("{} to {}", date_time_text(schedule.from), date_time_text(schedule.to))
                     : sun.periods.front()}});
  return result;
}

SunResult point_sun(const SunRequest& request, const VisibilityCloud& cloud, const SunSky& sun,
                    LongRun& long_run, std::string& range, Listener& listener) {
  SunResult result;
  result.periods = sun.periods;
  result.crs = cloud.cloud.cloud.crs;
  result.metadata = sun_metadata(request, sun);
  const auto measure = measure_of(request, sun, *cloud.occluders, visibility::SkyReceiver::surface, 0.0);
  result.per_period = measure->numbers();
  result.numbers =
      long_run.work("testing the sun", "points", [&](const Progress& progress, PartCheckpoint* parts) {
        return visibility::point_sun(*cloud.occluders, cloud.columns.normals, *measure, {progress, parts});
      });
  if (!request.output.empty())
    write_points(request.output, cloud.cloud, columns_of(request, result), request.overwrite, request.memory,
                 listener);
  range = range_and_mean([&](std::size_t id) { return *result.of(id, 0); }, result.receivers());
  return result;
}

/// Empty: nothing is.
std::filesystem::path read_by_measure(const SunRequest& request) {
  return request.measures.empty() ? std::filesystem::path() : request.measures.front()->input();
}

/// What is read and written for observers. Errors that need no cloud.
PlannedWork plan_observers(const SunRequest& request) {
  const auto reject = [](const std::string& option) {
    throw input_error(option + " does not apply to --observer", "a map (.tif) or points (.las, .laz, .ply)");
  };
  if (const std::string option = given_map_field(request.map); !option.empty()) reject(option);
  if (request.receiver == visibility::SkyReceiver::surface)
    throw input_error("--receiver surface does not apply to --observer", "--tilt and --aspect");
  if (!request.checkpoint.file.empty()) reject("--checkpoint");
  if (!request.output.empty()) load_row_writer(request.output);
  if (!request.diagram.empty() && !has_extension(request.diagram, {".png"}))
    throw file_error(request.diagram, "unknown output format", "the extension .png");
  PlannedWork work = request.work({request.observers.file, read_by_measure(request)}, {request.diagram});
  check_outputs(work, request.overwrite);
  if (!request.diagram.empty()) image::load_library();
  check_given(request.observers);
  return work;
}

void write_diagram(const SunRequest& request, const VisibilityCloud& cloud, const SunSky& sun,
                   const visibility::Observer& observer, Listener& listener) {
  const visibility::Occluders& occluders = *cloud.occluders;
  const visibility::SightEnd eye = visibility::end_near_surface(occluders, observer.position);
  const std::vector<visibility::HorizonDirection> line =
      in_stage(listener, "computing the horizon", "azimuths", [&](const Progress& progress) {
        return visibility::horizon(occluders, eye, {.max_distance = request.max_distance}, progress);
      });
  visibility::SkylineTexts texts{.title = fmt::format("Path of the sun over {}", observer.name),
                                 .note = {},
                                 .unit = height_unit_label(cloud.cloud.cloud.crs),
                                 .curves = visibility::sun_curves(sun.schedule)};
  const double offset = sun.schedule.longitude / 15.0;
  const auto minutes = static_cast<int>(std::lround(std::fabs(offset) * 60.0));
  texts.note = fmt::format("{:.2f}, {:.2f}, {:.2f}; hours of mean solar time, UTC {}{}:{:02}",
                           observer.position.x, observer.position.y, observer.position.z,
                           offset < 0.0 ? "-" : "+", minutes / 60, minutes % 60);
  double highest = 0.0;
  for (const visibility::SkylineCurve& curve : texts.curves)
    for (const glm::dvec2& position : curve.positions) highest = std::max(highest, position.y);
  constexpr double k_room_of_labels = 5.0;  // degrees
  visibility::DepthStrip strip =
      visibility::strip_around(line, 0.0, 360.0, std::min(highest + k_room_of_labels, 90.0));
  in_stage(listener, "drawing the skyline", "lines of sight", [&](const Progress& progress) {
    visibility::fill_strip(occluders, eye, request.max_distance, strip, progress);
  });
  visibility::write_skyline(strip, line, texts, request.diagram, request.overwrite);
}

/// The job for observers: rows and the diagram.
SunResult run_observers(const SunRequest& request, Listener& listener) {
  const auto cloud =
      load_cloud_alone(request, Attribute::classification, AcceptedInput::points_or_raster, listener);
  std::vector<visibility::Observer> observers = load_observers(request.observers, *cloud, listener);
  if (!request.diagram.empty() && observers.size() != 1)
    throw input_error("--diagram requires a single observer", "one observer",
                      std::to_string(observers.size()));
  const SunSky sun = sun_of(request, *cloud, listener, observers.size());
  say_sun(sun, listener);
  measure_occluders(*cloud, request.occluders, listener);
  say_observer_remarks(observers, *cloud, listener);
  std::vector<visibility::SkyTarget> targets;
  for (const visibility::Observer& observer : observers)
    targets.push_back(
        visibility::target_in_open(visibility::end_near_surface(*cloud->occluders, observer.position)));
  SunResult result;
  result.periods = sun.periods;
  result.crs = cloud->cloud.cloud.crs;
  result.metadata = sun_metadata(request, sun);
  const auto measure = measure_of(request, sun, *cloud->occluders, visibility::SkyReceiver::horizontal, 0.0);
  result.per_period = measure->numbers();
  result.numbers.resize(targets.size() * result.periods.size() * result.per_period);
  measure->answer(targets, {}, result.numbers);
  result.observers = std::move(observers);
  visibility::Row members = visibility::Row::object();
  for (const auto& [key, text] : result.metadata) members[key] = text;
  write_rows(
      request, cloud->cloud.cloud,
      [&](const auto&... to) {
        return visibility::write_positions(table_of(request, result), members, to...);
      },
      listener);
  if (!request.diagram.empty()) write_diagram(request, *cloud, sun, result.observers.front(), listener);
  if (!request.output.empty())
    listener.note(fmt::format("wrote {} rows to {}", result.receivers() * result.periods.size(),
                              request.output.string()));
  return result;
}

}  // namespace

std::vector<SunBand> bands_of(const SunRequest& request, const SunResult& result) {
  std::vector<SunBand> bands;
  if (!result.grid) return bands;
  for (std::size_t period = 0; period < result.periods.size(); ++period) {
    for (const SunQuantity& quantity : sun_quantities(request)) {
      bands.push_back({name_of(quantity, result.periods[period]), quantity.unit,
                       geo::Raster<float>(*result.grid, std::numeric_limits<float>::quiet_NaN())});
      HugeVector<float>& values = bands.back().values.values;
      for (std::size_t cell = 0; cell < values.size(); ++cell) {
        const float* const numbers = result.of(cell, period);
        if (!std::isnan(*numbers)) values[cell] = quantity.value(numbers);
      }
    }
  }
  return bands;
}

std::vector<ResultColumn> columns_of(const SunRequest& request, const SunResult& result) {
  std::vector<ResultColumn> columns;
  for (std::size_t period = 0; period < result.periods.size(); ++period) {
    for (const SunQuantity& quantity : sun_quantities(request)) {
      columns.push_back(result_column<float>(
          name_of(quantity, result.periods[period]), quantity.text, ScalarType::float32,
          [&result, &quantity, period](std::size_t id) { return quantity.value(result.of(id, period)); }));
    }
  }
  return columns;
}

visibility::PositionTable table_of(const SunRequest& request, const SunResult& result) {
  visibility::PositionTable table{.list = "observers", .rows = {}, .positions = {}};
  for (std::size_t i = 0; i < result.observers.size(); ++i) {
    const glm::dvec3& position = result.observers[i].position;
    for (std::size_t period = 0; period < result.periods.size(); ++period) {
      visibility::Row row{
          {"observer", result.observers[i].name}, {"x", position.x}, {"y", position.y}, {"z", position.z}};
      if (!result.periods[period].empty()) row["period"] = result.periods[period];
      for (const SunQuantity& quantity : sun_quantities(request))
        row[quantity.name] =
            std::round(1e4 * static_cast<double>(quantity.value(result.of(i, period)))) / 1e4;
      table.rows.push_back(std::move(row));
      table.positions.push_back(position);
    }
  }
  return table;
}

SunPlan plan(const SunRequest& request) {
  if (!request.measures.empty()) request.measures.front()->check();
  if (request.has_observers()) return SunPlan(request, plan_observers(request));
  if (!request.diagram.empty()) throw input_error("--diagram requires an observer", "--observer X,Y,Z");
  return SunPlan(request, plan_sky_site(request, {read_by_measure(request)}));
}

SunResult run(const SunPlan& plan, Listener& listener) {
  const SunRequest& request = plan.request();
  if (request.has_observers()) return run_observers(request, listener);
  const SkySite site = load_sky_site(request, static_cast<int>(sun_quantities(request).size()), listener);
  const SunSky sun = sun_of(request, *site.cloud, listener);
  say_sun(sun, listener);
  LongRun long_run(
      request.checkpoint,
      [&] {
        Fingerprint fingerprint = sky_fingerprint(request, site);
        add_to_fingerprint(sun, fingerprint);
        return fingerprint;
      },
      listener);
  measure_occluders(*site.cloud, request.occluders, listener);
  std::string range;
  SunResult result = request.is_map() ? map_sun(request, site, sun, long_run, range)
                                      : point_sun(request, *site.cloud, sun, long_run, range, listener);
  long_run.finish();
  listener.note(fmt::format("hours of sun {}{}", range, wrote_text(request)));
  return result;
}

}  // namespace alidade::jobs
