// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/words.h"
#include "cloud/axis_units.h"
#include "jobs/visibility/row_output.h"
#include "jobs/write_points.h"
#include "tools/command.h"
#include "tools/image_module.h"
#include "tools/visibility/sun_request.h"
#include "visibility/horizon/skyline.h"
#include "visibility/sky/sky_of_cloud.h"
#include "visibility/sky/sun_path.h"

namespace alidade::tools {
namespace {

/// "SunHours_2026-06" of a period with a name.
std::string name_of(const SunQuantity& quantity, const std::string& period) {
  return period.empty() ? quantity.name : fmt::format("{}_{}", quantity.name, period);
}

std::string map_sun(const SunCommand& command, const SkySite& site, const SunSky& sun, LongRun& long_run) {
  const std::vector<geo::Raster<visibility::Radiation>> maps =
      long_run.work("testing the sun", "cells", [&](const Progress& progress, PartCheckpoint* parts) {
        return visibility::ground_sun_hours(
            *site.cloud->occluders, *site.ground, site.grid, command.map.target_height.value_or(0.0),
            sun.light, command.hours_options(visibility::SkyReceiver::horizontal), {progress, parts});
      });
  std::vector<geo::Raster<float>> values;
  std::vector<SkyBand> bands;
  values.reserve(maps.size() * sun_quantities(command).size());
  for (std::size_t period = 0; period < maps.size(); ++period) {
    for (const SunQuantity& quantity : sun_quantities(command)) {
      geo::Raster<float>& band = values.emplace_back(site.grid, std::numeric_limits<float>::quiet_NaN());
      std::ranges::transform(maps[period].values, band.values.begin(), [&](const visibility::Radiation& one) {
        return std::isnan(one.hours) ? one.hours : quantity.value(one);
      });
      bands.push_back({band, name_of(quantity, sun.periods[period]), quantity.unit});
    }
  }
  const auto& first = values.front().values;
  const std::string found = range_and_mean([&](std::size_t i) { return first[i]; }, first.size());
  const visibility::SunSchedule& schedule = sun.schedule;
  write_sky_map(
      command, site, bands, sun_metadata(command, sun),
      {.title = "Hours of direct sun",
       .values = {},
       .scale =
           visibility::MapScale{
               image::ColorMap::inferno, {0.0, std::max(sun.light.open.front().hours, 1.0)}, "hours"},
       .notes = {sun.periods.front().empty()
                     ? fmt::format("{} to {}", date_time_text(schedule.from), date_time_text(schedule.to))
                     : sun.periods.front()}});
  return found;
}

std::string point_sun(const SunCommand& command, const VisibilityCloud& cloud, const SunSky& sun,
                      LongRun& long_run) {
  const std::vector<visibility::Radiation> answers =
      long_run.work("testing the sun", "points", [&](const Progress& progress, PartCheckpoint* parts) {
        return visibility::point_sun_hours(*cloud.occluders, cloud.columns.normals, sun.light,
                                           command.hours_options(visibility::SkyReceiver::surface),
                                           {progress, parts});
      });
  const std::size_t periods = sun.periods.size();
  std::vector<ResultColumn> columns;
  for (std::size_t period = 0; period < periods; ++period) {
    for (const SunQuantity& quantity : sun_quantities(command)) {
      columns.push_back(result_column<float>(name_of(quantity, sun.periods[period]), quantity.text,
                                             ScalarType::float32,
                                             [&answers, &quantity, period, periods](std::size_t id) {
                                               return quantity.value(answers[id * periods + period]);
                                             }));
    }
  }
  Console console(command.verbosity);
  write_points(command.output, cloud.cloud, columns, command.overwrite, command.memory, console);
  return range_and_mean([&](std::size_t id) { return answers[id * periods].hours; },
                        answers.size() / periods);
}

/// Errors that need no cloud.
void check_observer_options(const SunCommand& command) {
  const auto reject = [](const std::string& option) {
    throw input_error(option + " does not apply to --observer", "a map (.tif) or points (.las, .laz, .ply)");
  };
  if (const std::string option = given_map_field(command.map); !option.empty()) reject(option);
  if (command.receiver == visibility::SkyReceiver::surface)
    throw input_error("--receiver surface does not apply to --observer", "--tilt and --aspect");
  if (!command.checkpoint.file.empty()) reject("--checkpoint");
  load_row_writer(command.output);
  if (!command.diagram.empty() && !has_extension(command.diagram, {".png"}))
    throw file_error(command.diagram, "unknown output format", "the extension .png");
  const std::filesystem::path outputs[] = {command.output, command.diagram};
  check_outputs(outputs, command.overwrite, command.inputs({command.observers.file, command.weather}));
}

/// A row for each observer and period.
visibility::PositionTable table_of(const SunCommand& command, const SunSky& sun,
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
      for (const SunQuantity& quantity : sun_quantities(command))
        row[quantity.name] = std::round(1e4 * static_cast<double>(quantity.value(answer))) / 1e4;
      table.rows.push_back(std::move(row));
      table.positions.push_back(position);
    }
  }
  return table;
}

void write_diagram(const SunCommand& command, const VisibilityCloud& cloud, const SunSky& sun,
                   const visibility::Observer& observer) {
  const visibility::Occluders& occluders = *cloud.occluders;
  const visibility::SightEnd eye = visibility::end_near_surface(occluders, observer.position);
  const std::vector<visibility::HorizonDirection> line =
      with_progress("computing the horizon", "azimuths", command.verbosity, [&](const Progress& progress) {
        return visibility::horizon(occluders, eye, {.max_distance = command.max_distance}, progress);
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
  with_progress("drawing the skyline", "lines of sight", command.verbosity, [&](const Progress& progress) {
    visibility::fill_strip(occluders, eye, command.max_distance, strip, progress);
  });
  image_module().write_skyline(strip, line, texts, command.diagram, command.overwrite);
}

/// The command for observers: rows and the diagram.
ExitCode run_sun_observers(const SunCommand& command) {
  check_observer_options(command);
  check_given(command.observers);
  Console console(command.verbosity);
  const auto cloud =
      load_cloud_alone(command, Attribute::classification, AcceptedInput::points_or_raster, console);
  const std::vector<visibility::Observer> observers = load_observers(command.observers, *cloud, console);
  if (!command.diagram.empty() && observers.size() != 1)
    throw input_error("--diagram requires a single observer", "one observer",
                      std::to_string(observers.size()));
  const std::unique_ptr<SunSky> sun = sun_of(command, *cloud, observers.size());
  say_sun(command, *sun);
  measure_occluders(*cloud, command.occluders, console);
  say_observer_remarks(observers, *cloud, console);
  std::vector<visibility::SkyTarget> targets;
  for (const visibility::Observer& observer : observers)
    targets.push_back(
        visibility::target_in_open(visibility::end_near_surface(*cloud->occluders, observer.position)));
  std::vector<visibility::Radiation> answers(targets.size() * sun->periods.size());
  visibility::sun_hours(*cloud->occluders, targets, sun->light,
                        command.hours_options(visibility::SkyReceiver::horizontal), answers);
  const visibility::PositionTable table = table_of(command, *sun, observers, answers);
  visibility::Row members = visibility::Row::object();
  for (const auto& [key, text] : sun_metadata(command, *sun)) members[key] = text;
  write_rows(
      command, cloud->cloud.cloud,
      [&](auto form, const auto& head, const auto& to_lon_lat) {
        return visibility::write_positions(table, members, form, head, to_lon_lat, command.output,
                                           command.overwrite);
      },
      console);
  if (!command.diagram.empty()) write_diagram(command, *cloud, *sun, observers.front());
  say_note(command.verbosity, fmt::format("wrote {} rows to {}", table.rows.size(), command.output.string()));
  return ExitCode::done;
}

ExitCode run(const SunCommand& command) {
  if (command.beam_only && command.bounces > 0)
    throw input_error("--bounces 1 does not apply with --beam-only", "one of the two");
  if (command.has_observers()) return run_sun_observers(command);
  if (!command.diagram.empty()) throw input_error("--diagram requires an observer", "--observer X,Y,Z");
  check_sky_site(command);
  Console console(command.verbosity);
  const SkySite site = load_sky_site(command, static_cast<int>(sun_quantities(command).size()), console);
  const std::unique_ptr<SunSky> sun = sun_of(command, *site.cloud);
  say_sun(command, *sun);
  LongRun long_run(
      command.checkpoint,
      [&] {
        Fingerprint fingerprint = sky_fingerprint(command, site);
        add_to_fingerprint(*sun, fingerprint);
        return fingerprint;
      },
      console);
  measure_occluders(*site.cloud, command.occluders, console);
  const std::string found = command.is_map() ? map_sun(command, site, *sun, long_run)
                                             : point_sun(command, *site.cloud, *sun, long_run);
  long_run.finish();
  say_note(command.verbosity, fmt::format("hours of sun {}; wrote {}", found, command.output.string()));
  return ExitCode::done;
}

}  // namespace

Command add_visibility_sun(const Options& visibility) {
  auto command = std::make_shared<SunCommand>();
  const Options sun = visibility.command(
      "sun", "Compute hours of direct sun and radiation on points, on the ground or at positions");
  add_cloud(sun, command->files, {"--ignore-classes"});
  add_sky_site_fields(sun, *command);
  add_run_options(sun, *command);
  add_sun_request(sun, *command);
  add_observer_positions(sun, command->observers);
  sun.group(k_observer_group)
      .file("--diagram", "FILE.png", "also draw the paths of the sun over the skyline of a single observer",
            command->diagram);
  return command_of(sun, command, run);
}

}  // namespace alidade::tools
