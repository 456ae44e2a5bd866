// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <cmath>

#include "base/date_time.h"
#include "base/error.h"
#include "tools/command.h"
#include "tools/image_module.h"
#include "tools/visibility/sky.h"
#include "visibility/sky/sky_of_cloud.h"

namespace alidade::tools {
namespace {

/// A date as people give it for sunshine: a whole day, or a moment.
struct SunDate {
  Moment moment;  ///< of a day: its begin in UTC, whatever the position
  bool is_day = false;
};

constexpr double k_seconds_per_day = 86400.0;

Moment midnight(const Moment& utc, double longitude) {
  const double seconds = utc.seconds - std::round(longitude / 360.0 * k_seconds_per_day);
  const double days = std::floor(seconds / k_seconds_per_day);
  return {utc.day + std::chrono::days(static_cast<int>(days)), seconds - days * k_seconds_per_day};
}

/// Reads "2026-06-21", a day, or "2026-06-21T10:00Z", a moment with its zone (a blank may represent the T).
/// Errors: UsageError for anything else.
SunDate parse_sun_date(const std::string& text) {
  constexpr std::size_t k_date_length = 10;
  if (text.size() != k_date_length) return {parse_moment(text), false};
  try {
    return {parse_date_time(text + "T00:00Z"), true};
  } catch (const Error&) {
    // What was added to a day is nothing that the user wrote.
    throw UsageError("invalid date; expected a date such as 2026-06-21, found '" + text + "'");
  }
}

/// When a range that begins with the date begins, and when one that ends with it ends. Days begin and end at
/// the middle of the night: midnight of mean solar time, 4 minutes earlier per degree to the east.
Moment begin_of(const SunDate& date, double longitude) {
  return date.is_day ? midnight(date.moment, longitude) : date.moment;
}

Moment end_of(const SunDate& date, double longitude) {
  if (!date.is_day) return date.moment;
  Moment next = date.moment;
  next.day += std::chrono::days(1);
  return midnight(next, longitude);
}

struct SunCommand : SkyRequest {
  std::optional<SunDate> from, to;
  double step_minutes = 10.0;
  std::optional<glm::dvec2> position;  ///< latitude, longitude
  visibility::ClearAir air;
  std::optional<double> bin;  ///< degrees; 0: none; empty: by the number of steps
};

/// Where the sun stands, and how that came about.
struct SunSky {
  visibility::SunSchedule schedule;
  bool is_map_known = false;
  double hours = 0.0;     ///< the sun is up
  std::size_t steps = 0;  ///< in which it is up
  double bin = 0.0;       ///< degrees
  std::vector<visibility::SunBin> bins;
};

SunSky sun_of(const SunCommand& command, const VisibilityCloud& cloud) {
  // With fewer steps bins would save little time.
  constexpr std::size_t k_most_exact_steps = 1000;
  constexpr double k_usual_bin = 3.0;
  SunSky sun;
  visibility::SunSchedule& schedule = sun.schedule;
  sun.is_map_known = image_module().place_schedule(cloud.cloud.cloud.crs, glm::dvec2(cloud.area().center()),
                                                   command.position, schedule);
  schedule.from = begin_of(*command.from, schedule.longitude);
  schedule.to = end_of(command.to.value_or(*command.from), schedule.longitude);
  schedule.step_minutes = command.step_minutes;
  schedule.air = command.air;
  const std::vector<visibility::SunStep> steps =
      with_progress("computing sun positions", "steps", command.verbosity,
                    [&](const Progress& progress) { return image_module().sun_steps(schedule, progress); });
  sun.steps = steps.size();
  for (const visibility::SunStep& step : steps) sun.hours += step.hours;
  sun.bin = command.bin.value_or(steps.size() > k_most_exact_steps ? k_usual_bin : 0.0);
  sun.bins = visibility::sun_bins(steps, sun.bin);
  return sun;
}

/// On open level ground, kWh/m2.
double open_energy(const SunSky& sun) {
  double energy = 0.0;
  for (const visibility::SunBin& bin : sun.bins) energy += bin.energy.z / 1000.0;
  return energy;
}

/// All that the answers depend on.
Fingerprint fingerprint_of(const SunCommand& command, const SkySite& site, const SunSky& sun) {
  Fingerprint fingerprint = sky_fingerprint(command, site);
  std::vector<double> numbers;
  for (const visibility::SunBin& bin : sun.bins) {
    numbers.insert(numbers.end(), {bin.direction.x, bin.direction.y, bin.direction.z, bin.hours, bin.energy.x,
                                   bin.energy.y, bin.energy.z});
  }
  add_to_fingerprint("path of the sun", numbers, fingerprint);
  return fingerprint;
}

std::string model_text(const SunSky& sun) {
  return fmt::format(
      "clear sky of the European Solar Radiation Atlas, Linke turbidity {:g}, {:g} m above the sea",
      sun.schedule.air.linke_turbidity, sun.schedule.air.height);
}

void say_sun(const SunCommand& command, const SunSky& sun) {
  if (command.verbosity == Verbosity::quiet) return;
  const visibility::SunSchedule& schedule = sun.schedule;
  say_note(fmt::format("sun from {} to {} at latitude {:.5f}, longitude {:.5f}; {}",
                       date_time_text(schedule.from), date_time_text(schedule.to), schedule.latitude,
                       schedule.longitude,
                       sun.is_map_known ? fmt::format("grid north is {:.4f} degrees off", schedule.grid_north)
                                        : "+y taken for true north"));
  say_note(fmt::format(
      "up for {:.2f} hours, {} steps, {} directions{}; open ground receives {:.3f} kWh/m2 of direct sun ({})",
      sun.hours, sun.steps, sun.bins.size(),
      sun.bin > 0.0 ? fmt::format(" (bins of {:g} degrees)", sun.bin) : "", open_energy(sun),
      model_text(sun)));
  if (sun.bins.empty()) say_warning("the sun is always below the horizon");
}

/// How the sun was followed, for a map's metadata.
MapMetadata sun_metadata(const SunSky& sun) {
  const visibility::SunSchedule& schedule = sun.schedule;
  return {{"alidade_sun_from", date_time_text(schedule.from)},
          {"alidade_sun_to", date_time_text(schedule.to)},
          {"alidade_sun_step_minutes", fmt::format("{:g}", schedule.step_minutes)},
          {"alidade_sun_directions", std::to_string(sun.bins.size())},
          {"alidade_sun_bin_degrees", sun.bin > 0.0 ? fmt::format("{:g}", sun.bin) : "exact"},
          {"alidade_place", fmt::format("latitude {:.6f}, longitude {:.6f}, grid north {:.6f}",
                                        schedule.latitude, schedule.longitude, schedule.grid_north)},
          {"alidade_clear_sky", model_text(sun)}};
}

std::string map_sun(const SunCommand& command, const SkySite& site, const SunSky& sun, LongRun& long_run) {
  visibility::SunMaps maps =
      long_run.work("testing the sun", "cells", [&](const Progress& progress, PartCheckpoint* parts) {
        return visibility::ground_sun_hours(*site.cloud->occluders, *site.ground, site.grid,
                                            command.map.target_height.value_or(0.0), sun.bins,
                                            {.max_distance = command.max_distance}, {progress, parts});
      });
  const std::string found =
      range_and_mean([&](std::size_t i) { return maps.hours.values[i]; }, maps.hours.values.size());
  const SkyBand bands[] = {{maps.hours, "SunHours", "h"}, {maps.kilowatt_hours, "SunEnergy", "kWh/m2"}};
  write_sky_map(
      command, site, bands, sun_metadata(sun),
      {.title = "Hours of direct sun",
       .values = {},
       .scale = visibility::MapScale{image::ColorMap::inferno, {0.0, std::max(sun.hours, 1.0)}, "hours"},
       .notes = {
           fmt::format("{} to {}", date_time_text(sun.schedule.from), date_time_text(sun.schedule.to))}});
  return found;
}

std::string point_sun(const SunCommand& command, const VisibilityCloud& cloud, const SunSky& sun,
                      LongRun& long_run) {
  const std::vector<visibility::SunHours> hours =
      long_run.work("testing the sun", "points", [&](const Progress& progress, PartCheckpoint* parts) {
        return visibility::point_sun_hours(
            *cloud.occluders, cloud.columns.normals, sun.bins,
            {command.receiver.value_or(visibility::SkyReceiver::surface), command.max_distance},
            {progress, parts});
      });
  write_points(command.output, cloud.cloud,
               {result_column<float>("SunHours", "hours of direct sun", ScalarType::float32,
                                     [&](std::size_t id) { return hours[id].hours; }),
                result_column<float>("SunEnergy", "direct sun, kWh/m2", ScalarType::float32,
                                     [&](std::size_t id) { return hours[id].kilowatt_hours; })},
               command.overwrite, command.verbosity);
  return range_and_mean([&](std::size_t id) { return hours[id].hours; }, hours.size());
}

ExitCode run(const SunCommand& command) {
  const SkySite site = load_sky_site(command, 2);
  const SunSky sun = sun_of(command, *site.cloud);
  say_sun(command, sun);
  LongRun long_run(
      command.checkpoint, [&] { return fingerprint_of(command, site, sun); }, command.verbosity);
  measure_occluders(*site.cloud, command.occluders, command.verbosity);
  const std::string found = command.is_map() ? map_sun(command, site, sun, long_run)
                                             : point_sun(command, *site.cloud, sun, long_run);
  long_run.finish();
  say_note(command.verbosity, fmt::format("hours of sun {}; wrote {}", found, command.output.string()));
  return ExitCode::done;
}

/// "LAT,LON".
glm::dvec2 parse_position(const std::string& text) {
  const std::size_t comma = text.find(',');
  if (comma == std::string::npos)
    throw UsageError("invalid value; expected two numbers separated by a comma, found '" + text + "'");
  const std::size_t second = std::min(text.find_first_not_of(' ', comma + 1), text.size());
  return {parse_number(text.substr(0, comma), -90.0, 90.0), parse_number(text.substr(second), -360.0, 360.0)};
}

void add_time(const Options& sun, SunCommand& command) {
  const Options group = sun.group("Sun");
  group.required().value(
      "--from", "DATE",
      "first day, such as 2026-06-21, or start with a zone, such as 2026-06-21T10:00+02:00. Days "
      "begin and end at local midnight",
      command.from, parse_sun_date);
  group.value("--to", "DATE", "last day, included, or end (default: the day of --from)", command.to,
              parse_sun_date);
  group.number("--step", "MINUTES",
               "minutes between positions of the sun, each in the middle of its step (default: 10)",
               command.step_minutes, 0.1, 1440.0);
  group.value("--place", "LAT,LON",
              "location in degrees, WGS 84 (default: the centre of the cloud by its reference system)",
              command.position, parse_position);
  group.number("--height", "METRES", "height above sea level, which thins the air (default: 0)",
               command.air.height, -1000.0, 10000.0);
  group.number("--turbidity", "T",
               "Linke turbidity of the clear sky: 2 very clear, 3 usual (default), 5 humid, 7 polluted",
               command.air.linke_turbidity, 1.0, 20.0);
  group.value("--bin", "DEGREES|exact",
              "group sun positions into bins of this size (default: exact for up to 1000 positions, 3 "
              "degrees for more)",
              command.bin,
              [](const std::string& text) { return text == "exact" ? 0.0 : parse_number(text, 0.01, 30.0); });
}

}  // namespace

Command add_visibility_sun(const Options& visibility) {
  auto command = std::make_shared<SunCommand>();
  const Options sun =
      visibility.command("sun", "Compute hours and energy of direct sun on points or on the ground");
  add_sky_request(sun, *command);
  add_time(sun, *command);
  return command_of(sun, command, run);
}

}  // namespace alidade::tools
