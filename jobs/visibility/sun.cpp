// SPDX-License-Identifier: MIT
#include "jobs/visibility/sun.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/remote_map.h"
#include "base/words.h"
#include "cloud/axis_units.h"
#include "image/image_file.h"
#include "jobs/outputs.h"
#include "jobs/visibility/long_run.h"
#include "jobs/visibility/row_output.h"
#include "jobs/write_points.h"
#include "visibility/horizon/skyline.h"
#include "visibility/horizon/skyline_image.h"
#include "visibility/sky/sky_of_cloud.h"
#include "visibility/sky/sun_path.h"

namespace alidade::jobs {
namespace {

/// "SunHours_2026-06" of a period with a name.
std::string name_of(const SunQuantity& quantity, const std::string& period) {
  return period.empty() ? quantity.name : fmt::format("{}_{}", quantity.name, period);
}

/// Radiation, and a summary for people.
struct SunAnswers {
  SunResult result;
  std::string summary;
};

SunAnswers map_sun(const SunRequest& request, const SkySite& site, const SunSky& sun, LongRun& long_run) {
  std::vector<geo::Raster<visibility::Radiation>> maps =
      long_run.work("testing the sun", "cells", [&](const Progress& progress, PartCheckpoint* parts) {
        return visibility::ground_sun_hours(
            *site.cloud->occluders, *site.ground, site.grid, request.map.target_height.value_or(0.0),
            sun.light, request.hours_options(visibility::SkyReceiver::horizontal), {progress, parts});
      });
  std::vector<geo::Raster<float>> values;
  std::vector<SkyBand> bands;
  values.reserve(maps.size() * sun_quantities(request).size());
  for (std::size_t period = 0; period < maps.size(); ++period) {
    for (const SunQuantity& quantity : sun_quantities(request)) {
      geo::Raster<float>& band = values.emplace_back(site.grid, std::numeric_limits<float>::quiet_NaN());
      std::ranges::transform(maps[period].values, band.values.begin(), [&](const visibility::Radiation& one) {
        return std::isnan(one.hours) ? one.hours : quantity.value(one);
      });
      bands.push_back({band, name_of(quantity, sun.periods[period]), quantity.unit});
    }
  }
  const auto& first = values.front().values;
  std::string summary = range_and_mean([&](std::size_t i) { return first[i]; }, first.size());
  const visibility::SunSchedule& schedule = sun.schedule;
  MapMetadata metadata = write_sky_map(
      request, site, bands, sun_metadata(request, sun),
      {.title = "Hours of direct sun",
       .values = {},
       .scale =
           visibility::MapScale{
               image::ColorMap::inferno, {0.0, std::max(sun.light.open.front().hours, 1.0)}, "hours"},
       .notes = {sun.periods.front().empty()
                     ? fmt::format("{} to {}", date_time_text(schedule.from), date_time_text(schedule.to))
                     : sun.periods.front()}});
  return {{.periods = sun.periods,
           .maps = std::move(maps),
           .radiation = {},
           .observers = {},
           .crs = site.cloud->cloud.cloud.crs,
           .metadata = std::move(metadata)},
          std::move(summary)};
}

void write_columns(const SunRequest& request, const VisibilityCloud& cloud, const SunSky& sun,
                   std::span<const visibility::Radiation> answers, Listener& listener) {
  const std::size_t periods = sun.periods.size();
  std::vector<ResultColumn> columns;
  for (std::size_t period = 0; period < periods; ++period) {
    for (const SunQuantity& quantity : sun_quantities(request)) {
      columns.push_back(result_column<float>(name_of(quantity, sun.periods[period]), quantity.text,
                                             ScalarType::float32,
                                             [answers, &quantity, period, periods](std::size_t id) {
                                               return quantity.value(answers[id * periods + period]);
                                             }));
    }
  }
  write_points(request.output, cloud.cloud, columns, request.overwrite, request.memory, listener);
}

SunAnswers point_sun(const SunRequest& request, const VisibilityCloud& cloud, const SunSky& sun,
                     LongRun& long_run, Listener& listener) {
  std::vector<visibility::Radiation> answers =
      long_run.work("testing the sun", "points", [&](const Progress& progress, PartCheckpoint* parts) {
        return visibility::point_sun_hours(*cloud.occluders, cloud.columns.normals, sun.light,
                                           request.hours_options(visibility::SkyReceiver::surface),
                                           {progress, parts});
      });
  const std::size_t periods = sun.periods.size();
  if (!request.output.empty()) write_columns(request, cloud, sun, answers, listener);
  std::string summary =
      range_and_mean([&](std::size_t id) { return answers[id * periods].hours; }, answers.size() / periods);
  return {{.periods = sun.periods,
           .maps = {},
           .radiation = std::move(answers),
           .observers = {},
           .crs = cloud.cloud.cloud.crs,
           .metadata = sun_metadata(request, sun)},
          std::move(summary)};
}

/// Errors that need no cloud.
void check_observer_fields(const SunRequest& request) {
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
  const std::filesystem::path outputs[] = {request.output, request.diagram};
  check_outputs(outputs, request.overwrite, request.inputs({request.observers.file, request.weather}));
  if (!request.diagram.empty()) image::load_library();
}

/// A row for each observer and period.
visibility::PositionTable table_of(const SunRequest& request, const SunSky& sun,
                                   std::span<const visibility::Observer> observers,
                                   std::span<const visibility::Radiation> answers) {
  visibility::PositionTable table{.list = "observers", .rows = {}, .positions = {}};
  std::size_t next = 0;
  for (const visibility::Observer& observer : observers) {
    for (const std::string& period : sun.periods) {
      const glm::dvec3& position = observer.position;
      visibility::Row row{
          {"observer", observer.name}, {"x", position.x}, {"y", position.y}, {"z", position.z}};
      if (!period.empty()) row["period"] = period;
      const visibility::Radiation& answer = answers[next++];
      for (const SunQuantity& quantity : sun_quantities(request))
        row[quantity.name] = std::round(1e4 * static_cast<double>(quantity.value(answer))) / 1e4;
      table.rows.push_back(std::move(row));
      table.positions.push_back(position);
    }
  }
  return table;
}

void write_table(const SunRequest& request, const VisibilityCloud& cloud,
                 const visibility::PositionTable& table, const MapMetadata& metadata, Listener& listener) {
  visibility::Row members = visibility::Row::object();
  for (const auto& [key, text] : metadata) members[key] = text;
  write_rows(
      request, cloud.cloud.cloud,
      [&](auto form, const auto& head, const auto& to_lon_lat) {
        return visibility::write_positions(table, members, form, head, to_lon_lat, request.output,
                                           request.overwrite);
      },
      listener);
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
  const std::unique_ptr<SunSky> sun = sun_of(request, *cloud, listener, observers.size());
  say_sun(request, *sun, listener);
  measure_occluders(*cloud, request.occluders, listener);
  say_observer_remarks(observers, *cloud, listener);
  std::vector<visibility::SkyTarget> targets;
  for (const visibility::Observer& observer : observers)
    targets.push_back(
        visibility::target_in_open(visibility::end_near_surface(*cloud->occluders, observer.position)));
  std::vector<visibility::Radiation> answers(targets.size() * sun->periods.size());
  visibility::sun_hours(*cloud->occluders, targets, sun->light,
                        request.hours_options(visibility::SkyReceiver::horizontal), answers);
  MapMetadata metadata = sun_metadata(request, *sun);
  if (!request.output.empty())
    write_table(request, *cloud, table_of(request, *sun, observers, answers), metadata, listener);
  if (!request.diagram.empty()) write_diagram(request, *cloud, *sun, observers.front(), listener);
  RemoteMap::check_all();  // as OutputFile does, for answers that are only returned
  if (!request.output.empty())
    listener.note(fmt::format("wrote {} rows to {}", answers.size(), request.output.string()));
  return {.periods = sun->periods,
          .maps = {},
          .radiation = std::move(answers),
          .observers = std::move(observers),
          .crs = cloud->cloud.cloud.crs,
          .metadata = std::move(metadata)};
}

}  // namespace

SunPlan plan(const SunRequest& request) {
  if (request.beam_only && request.bounces > 0)
    throw input_error("--bounces 1 does not apply with --beam-only", "one of the two");
  if (request.has_observers()) {
    check_observer_fields(request);
    check_given(request.observers);
  } else {
    if (!request.diagram.empty()) throw input_error("--diagram requires an observer", "--observer X,Y,Z");
    check_sky_site(request);
  }
  return SunPlan(request);
}

SunResult run(const SunPlan& plan, Listener& listener) {
  const SunRequest& request = plan.request();
  if (request.has_observers()) return run_observers(request, listener);
  const SkySite site = load_sky_site(request, static_cast<int>(sun_quantities(request).size()), listener);
  const std::unique_ptr<SunSky> sun = sun_of(request, *site.cloud, listener);
  say_sun(request, *sun, listener);
  LongRun long_run(
      request.checkpoint,
      [&] {
        Fingerprint fingerprint = sky_fingerprint(request, site);
        add_to_fingerprint(*sun, fingerprint);
        return fingerprint;
      },
      listener);
  measure_occluders(*site.cloud, request.occluders, listener);
  SunAnswers answers = request.is_map() ? map_sun(request, site, *sun, long_run)
                                        : point_sun(request, *site.cloud, *sun, long_run, listener);
  RemoteMap::check_all();  // as OutputFile does, for answers that are only returned
  long_run.finish();
  listener.note(fmt::format("hours of sun {}{}{}", answers.summary, request.output.empty() ? "" : "; wrote ",
                            request.output.string()));
  return std::move(answers.result);
}

}  // namespace alidade::jobs
