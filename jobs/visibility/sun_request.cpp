// SPDX-License-Identifier: MIT
#include "jobs/visibility/sun_request.h"

#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "base/error.h"
#include "base/fingerprint.h"
#include "base/words.h"
#include "jobs/cloud_fields.h"
#include "jobs/visibility/run_fingerprint.h"

namespace alidade::jobs {
namespace {

constexpr double k_seconds_per_day = 86400.0;

Moment midnight(const Moment& utc, double longitude) {
  const double seconds = utc.seconds - std::round(longitude / 360.0 * k_seconds_per_day);
  const double days = std::floor(seconds / k_seconds_per_day);
  return {utc.day + std::chrono::days(static_cast<int>(days)), seconds - days * k_seconds_per_day};
}

/// Reads "2026-06-21", a day, or "2026-06-21T10:00Z", a moment with its zone (a blank may replace the T).
/// Errors: UsageError for anything else.
SunDate parse_sun_date(const std::string& text) {
  constexpr std::size_t k_date_length = 10;
  if (text.size() != k_date_length) return {parse_moment(text), false};
  try {
    return {parse_date_time(text + "T00:00Z"), true};
  } catch (const Error&) {
    // The message of the parser would contain the time that was appended here.
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

/// "LAT,LON".
glm::dvec2 parse_location(const std::string& text) {
  const std::vector<std::string> words = split_list(text, 2, "two numbers separated by a comma");
  return {parse_number(words[0], -90.0, 90.0), parse_number(std::string(trim(words[1])), -360.0, 360.0)};
}

void add_time(const Fields& fields, SunRequest& request) {
  const Fields group = fields.group("Sun");
  group.required().value(
      "--from", "DATE",
      "first day, such as 2026-06-21, or start with a zone, such as 2026-06-21T10:00+02:00. Days "
      "begin and end at local midnight",
      request.from, parse_sun_date);
  group.value("--to", "DATE", "last day, included, or end (default: the day of --from)", request.to,
              parse_sun_date);
  group.number("--step", "MINUTES",
               "minutes between positions of the sun, each in the middle of its step (default: 10)",
               request.step_minutes, 0.1, 1440.0);
  group.choice("--per", "sum the whole time (default), or every year, month or day apart", request.period,
               {{"whole", visibility::SunPeriod::whole},
                {"year", visibility::SunPeriod::year},
                {"month", visibility::SunPeriod::month},
                {"day", visibility::SunPeriod::day}});
  group.value("--place", "LAT,LON",
              "location in degrees, WGS 84 (default: the centre of the cloud by its reference system)",
              request.location, parse_location);
  group.value(
      "--bin", "DEGREES|exact",
      "group sun positions into bins of this size (default: exact for up to 1000 positions; for more, 1 "
      "degree of azimuth over an elevation raster, else 3 degrees)",
      request.bin,
      [](const std::string& text) { return text == "exact" ? 0.0 : parse_number(text, 0.01, 30.0); });
}

void add_receiver(const Fields& fields, SunRequest& request) {
  const Fields group = fields.group("Sun");
  group.number("--tilt", "DEGREES", "tilt every receiver from the horizontal, 0 to 90, instead of --receiver",
               request.tilt, 0.0, 90.0);
  group.number("--aspect", "DEGREES",
               "azimuth that tilted receivers face, clockwise from north (default: 180)", request.aspect,
               -360.0, 360.0);
}

/// Whether light is computed from horizons: a raster alone blocks.
bool by_horizons(const SunRequest& request, const VisibilityCloud& cloud) {
  return !cloud.has_points() && cloud.mesh.tree == nullptr && std::isinf(request.max_distance);
}

}  // namespace

visibility::SunHoursOptions SunRequest::hours_options(visibility::SkyReceiver usual) const {
  visibility::SunHoursOptions options{.receiver = receiver.value_or(usual), .max_distance = max_distance};
  if (tilt || aspect) options.normal = visibility::tilted_normal(tilt.value_or(0.0), aspect.value_or(180.0));
  return options;
}

std::span<const SunQuantity> sun_quantities(const SunRequest& request) {
  return request.measures.empty() ? quantity_of_hours() : request.measures.front()->quantities();
}

SunSky sun_of(const SunRequest& request, const VisibilityCloud& cloud, Listener& listener,
              std::optional<std::size_t> targets) {
  // With fewer steps bins would save little time.
  constexpr std::size_t k_most_exact_steps = 1000, k_most_exact_lines = 10'000'000;
  constexpr double k_usual_bin = 3.0, k_usual_fan = 1.0;
  SunSky sun;
  sun.shine = request.measures.empty() ? shine_of_hours() : request.measures.front()->shine();
  visibility::SunSchedule& schedule = sun.schedule;
  const Crs& crs = cloud.cloud.cloud.crs;
  std::optional<glm::dvec2> location = request.location, unmapped = location;
  sun.shine->begin(schedule, unmapped);
  if (crs.empty()) location = unmapped;
  sun.is_map_known = visibility::place_schedule(crs, glm::dvec2(cloud.area().center()), location, schedule);
  schedule.from = begin_of(*request.from, schedule.longitude);
  schedule.to = end_of(request.to.value_or(*request.from), schedule.longitude);
  schedule.step_minutes = request.step_minutes;
  schedule.period = request.period;
  const std::vector<visibility::SunStep> steps =
      in_stage(listener, "computing sun positions", "steps",
               [&](const Progress& progress) { return visibility::sun_steps(schedule, progress); });
  sun.periods = visibility::sun_periods(schedule);
  sun.steps = steps.size();
  for (const visibility::SunStep& step : steps) {
    sun.hours += step.hours;
    if (step.period == 0) sun.first_hours += step.hours;
  }
  sun.by_horizons = by_horizons(request, cloud);
  const std::size_t most_steps =
      targets ? std::max(k_most_exact_steps, k_most_exact_lines / std::max<std::size_t>(*targets, 1))
              : k_most_exact_steps;
  const double usual = steps.size() <= most_steps ? 0.0 : sun.by_horizons ? k_usual_fan : k_usual_bin;
  sun.bin = request.bin.value_or(usual);
  sun.shine->set_path(schedule, steps, static_cast<int>(sun.periods.size()),
                      {.bin = sun.bin, .by_horizons = sun.by_horizons});
  return sun;
}

void add_to_fingerprint(const SunSky& sun, Fingerprint& fingerprint) {
  add_to_fingerprint("path of the sun", sun.shine->fingerprint(), fingerprint);
}

void say_sun(const SunSky& sun, Listener& listener) {
  if (!listener.is_listening()) return;
  const visibility::SunSchedule& schedule = sun.schedule;
  listener.note(
      fmt::format("sun from {} to {} at latitude {:.5f}, longitude {:.5f}; {}", date_time_text(schedule.from),
                  date_time_text(schedule.to), schedule.latitude, schedule.longitude,
                  sun.is_map_known ? fmt::format("grid north is {:.4f} degrees off", schedule.grid_north)
                                   : "+y taken for true north"));
  listener.note(
      fmt::format("up for {:.2f} hours, {} steps, {} {}{}", sun.hours, sun.steps, sun.shine->directions(),
                  sun.by_horizons && sun.shine->directions() > 0 ? "azimuths of horizons" : "directions",
                  sun.bin > 0.0 ? fmt::format(" (bins of {:g} degrees)", sun.bin) : ""));
  sun.shine->note(listener);
  if (sun.steps == 0) listener.warn("the sun is always below the horizon");
  sun.shine->warn(schedule, listener);
}

MapMetadata sun_metadata(const SunRequest& request, const SunSky& sun) {
  const visibility::SunSchedule& schedule = sun.schedule;
  std::string receiver =
      request.receiver == visibility::SkyReceiver::surface ? "slope of the ground" : "horizontal";
  if (request.tilt || request.aspect)
    receiver =
        fmt::format("tilt {:g}, aspect {:g}", request.tilt.value_or(0.0), request.aspect.value_or(180.0));
  MapMetadata metadata{
      {"alidade_sun_from", date_time_text(schedule.from)},
      {"alidade_sun_to", date_time_text(schedule.to)},
      {"alidade_sun_step_minutes", fmt::format("{:g}", schedule.step_minutes)},
      {"alidade_sun_directions", std::to_string(sun.shine->directions())},
      {"alidade_sun_bin_degrees", sun.bin > 0.0 ? fmt::format("{:g}", sun.bin) : "exact"},
      {"alidade_sun_receiver", receiver},
      {"alidade_place", fmt::format("latitude {:.6f}, longitude {:.6f}, grid north {:.6f}", schedule.latitude,
                                    schedule.longitude, schedule.grid_north)}};
  sun.shine->add_metadata(metadata);
  return metadata;
}

void add_sun_fields(const Fields& fields, SunRequest& request) {
  add_cloud(fields, request.files, {"--ignore-classes"});
  add_sky_site_fields(fields, request);
  add_time(fields, request);
  for (const auto& added : request.measures) added->add_fields(fields);
  add_receiver(fields, request);
  add_observer_positions(fields, request.observers);
  fields.group(k_observer_group)
      .file("--diagram", "FILE.png", "also draw the paths of the sun over the skyline of a single observer",
            request.diagram);
  add_partial(fields, request.partial);
}

}  // namespace alidade::jobs
