// SPDX-License-Identifier: MIT
#include "tools/visibility/sun.h"

#include <fmt/format.h>

#include "base/error.h"
#include "tools/command.h"
#include "visibility/sky/sky_of_cloud.h"

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
  write_points(command.output, cloud.cloud, columns, command.overwrite, command.memory, command.verbosity);
  return range_and_mean([&](std::size_t id) { return answers[id * periods].hours; },
                        answers.size() / periods);
}

ExitCode run(const SunCommand& command) {
  if (command.beam_only && command.bounces > 0)
    throw input_error("--bounces 1 does not apply with --beam-only", "one of the two");
  if (command.has_observers()) return run_sun_observers(command);
  if (!command.diagram.empty()) throw input_error("--diagram requires an observer", "--observer X,Y,Z");
  const SkySite site = load_sky_site(command, static_cast<int>(sun_quantities(command).size()));
  const std::unique_ptr<SunSky> sun = sun_of(command, *site.cloud);
  say_sun(command, *sun);
  LongRun long_run(
      command.checkpoint,
      [&] {
        Fingerprint fingerprint = sky_fingerprint(command, site);
        add_to_fingerprint(*sun, fingerprint);
        return fingerprint;
      },
      command.verbosity);
  measure_occluders(*site.cloud, command.occluders, command.verbosity);
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
  add_sky_request(sun, *command);
  add_sun_request(sun, *command);
  add_observer_positions(sun, command->observers);
  sun.group(k_observer_group)
      .file("--diagram", "FILE.png", "also draw the paths of the sun over the skyline of a single observer",
            command->diagram);
  return command_of(sun, command, run);
}

}  // namespace alidade::tools
