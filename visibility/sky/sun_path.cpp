// SPDX-License-Identifier: MIT
#include "visibility/sky/sun_path.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <string>

#include "base/error.h"
#include "geo/earth.h"
#include "geo/sun.h"
#include "visibility/horizon/skyline_image.h"

namespace alidade::visibility {
namespace {

constexpr double k_seconds_per_day = 86400.0;

void require(const char* what, double value, double least, double most) {
  check_that(value >= least && value <= most, fmt::format("{} out of range", what),
             fmt::format("a number from {} to {}", least, most), fmt::format("{}", value));
}

double seconds_between(const Moment& from, const Moment& to) {
  return static_cast<double>((to.day - from.day).count()) * k_seconds_per_day + (to.seconds - from.seconds);
}

Moment later(const Moment& from, double seconds) {
  const double total = from.seconds + seconds, days = std::floor(total / k_seconds_per_day);
  return {from.day + std::chrono::days(static_cast<int>(days)), total - days * k_seconds_per_day};
}

/// Number of a period; consecutive periods have consecutive numbers.
int period_number(const SunSchedule& schedule, const Moment& moment) {
  const Moment local = later(moment, std::round(schedule.longitude / 360.0 * k_seconds_per_day));
  const std::chrono::year_month_day date(local.day);
  const int year = static_cast<int>(date.year());
  switch (schedule.period) {
    case SunPeriod::whole:
      return 0;
    case SunPeriod::year:
      return year;
    case SunPeriod::month:
      return 12 * year + static_cast<int>(static_cast<unsigned>(date.month())) - 1;
    case SunPeriod::day:
      return static_cast<int>(local.day.time_since_epoch().count());
  }
  return 0;
}

struct DayPath {
  unsigned month, day;
  const char* label;
  image::Rgb8 color;
  bool has_hours;  ///< named
};

/// The days of the solstices and an equinox, the highest path of the north first.
constexpr std::array<DayPath, 3> k_days{{{6, 21, "21 June", {214, 96, 0}, true},
                                         {3, 20, "20 March, 23 September", {20, 120, 70}, false},
                                         {12, 21, "21 December", {30, 80, 190}, true}}};

/// A part of a day, from local midnight on, in one step or several; times in hours.
std::vector<SunStep> steps_of_day(const SunSchedule& schedule, std::chrono::year_month_day date, double begin,
                                  double end, double step_hours) {
  constexpr double k_seconds_per_hour = 3600.0;
  const auto moment = [&](double hours) {
    const double seconds = hours * k_seconds_per_hour - schedule.longitude / 360.0 * k_seconds_per_day;
    const double days = std::floor(seconds / k_seconds_per_day);
    return Moment{std::chrono::sys_days(date) + std::chrono::days(static_cast<int>(days)),
                  seconds - days * k_seconds_per_day};
  };
  SunSchedule part = schedule;
  part.from = moment(begin);
  part.to = moment(end);
  part.step_minutes = 60.0 * step_hours;
  part.period = SunPeriod::whole;
  return sun_steps(part);
}

glm::dvec2 position_of(const SunStep& step) {
  return {step.azimuth, step.elevation};
}

/// Azimuth and elevation of the sun at an hour, if it is up.
std::optional<glm::dvec2> position_at(const SunSchedule& schedule, const std::chrono::year_month_day& date,
                                      int hour) {
  constexpr double k_around = 0.05;  // hours; the step is longer than that, so that there is one
  const std::vector<SunStep> steps = steps_of_day(schedule, date, hour - k_around, hour + k_around, 1.0);
  if (steps.empty()) return {};
  return position_of(steps.front());
}

}  // namespace

std::vector<std::string> sun_periods(const SunSchedule& schedule) {
  const int first = period_number(schedule, schedule.from),
            count = period_number(schedule, later(schedule.to, -1e-3)) - first + 1;
  check_that(count <= k_most_sun_periods, "too many periods",
             fmt::format("at most {}: months or years, or a shorter time", k_most_sun_periods),
             std::to_string(count));
  std::vector<std::string> names;
  for (int number = first; number < first + count; ++number) {
    switch (schedule.period) {
      case SunPeriod::whole:
        names.emplace_back();
        break;
      case SunPeriod::year:
        names.push_back(fmt::format("{:04}", number));
        break;
      case SunPeriod::month:
        names.push_back(fmt::format("{:04}-{:02}", number / 12, number % 12 + 1));
        break;
      case SunPeriod::day:
        names.push_back(
            date_time_text({std::chrono::sys_days(std::chrono::days(number)), 0.0}).substr(0, 10));
        break;
    }
  }
  return names;
}

std::size_t step_count(const SunSchedule& schedule) {
  require("time step", schedule.step_minutes, 0.1, 1440.0);
  require("latitude", schedule.latitude, -90.0, 90.0);
  require("longitude", schedule.longitude, -360.0, 360.0);
  const double duration = seconds_between(schedule.from, schedule.to);
  check_that(duration > 0.0, "empty time range", "an end after " + date_time_text(schedule.from),
             date_time_text(schedule.to));
  const double count = std::ceil(duration / (60.0 * schedule.step_minutes));
  check_that(count <= static_cast<double>(k_most_sun_steps), "too many time steps",
             fmt::format("at most {}: use longer steps or a shorter time", k_most_sun_steps),
             fmt::format("{:.0f}", count));
  return static_cast<std::size_t>(count);
}

StepTime step_time(const SunSchedule& schedule, std::size_t number) {
  const double step = 60.0 * schedule.step_minutes, begin = static_cast<double>(number) * step,
               end = std::fmin(begin + step, seconds_between(schedule.from, schedule.to));
  return {later(schedule.from, 0.5 * (begin + end)), (end - begin) / 3600.0};
}

std::vector<SunStep> sun_steps(const SunSchedule& schedule, const Progress& progress) {
  require("height above sea level", schedule.height, -1000.0, 10000.0);
  const std::size_t total = step_count(schedule);
  constexpr double k_sea_pressure = 1013.25, k_scale_height = 8434.5;
  const geo::SunObserver observer{.latitude = schedule.latitude,
                                  .longitude = schedule.longitude,
                                  .height = schedule.height,
                                  .pressure = k_sea_pressure * std::exp(-schedule.height / k_scale_height)};
  const int first_period = period_number(schedule, schedule.from);
  std::vector<SunStep> steps;
  for (std::size_t i = 0; i < total; ++i) {
    constexpr std::size_t k_report_interval = 256;
    if (i % k_report_interval == 0) report(progress, i, total);
    const StepTime time = step_time(schedule, i);
    const geo::SunPosition sun = geo::sun_position(time.middle, observer);
    const double elevation = geo::rounded_degrees(sun.elevation);
    if (!(elevation > 0.0)) continue;
    steps.push_back({.azimuth = geo::wrapped_degrees(geo::rounded_degrees(sun.azimuth - schedule.grid_north)),
                     .elevation = elevation,
                     .hours = time.hours,
                     .period = period_number(schedule, time.middle) - first_period,
                     .number = i});
  }
  report(progress, total, total);
  return steps;
}

bool place_schedule(const Crs& crs, const glm::dvec2& center,
                    const std::optional<glm::dvec2>& latitude_longitude, SunSchedule& schedule) {
  std::optional<geo::GroundPosition> ground;
  if (!crs.empty()) ground = geo::ground_position(crs, center);
  check_that(
      ground || latitude_longitude, "the sun position requires latitude and longitude",
      "--place LAT,LON, or a cloud with a reference system",
      crs.empty() ? "a cloud without a reference system" : "a reference system without a location on Earth");
  schedule.latitude = latitude_longitude ? latitude_longitude->x : ground->latitude;
  schedule.longitude = latitude_longitude ? latitude_longitude->y : ground->longitude;
  schedule.grid_north = ground ? geo::rounded_degrees(ground->grid_north) : 0.0;
  return ground.has_value();
}

std::vector<SkylineCurve> sun_curves(const SunSchedule& schedule) {
  using std::chrono::day, std::chrono::month;
  constexpr double k_step = 1.0 / 12.0;  // hours
  constexpr int k_days_apart = 7;        // 26 times from solstice to solstice
  constexpr image::Rgb8 k_faint{150, 160, 175};
  const std::chrono::year year = std::chrono::year_month_day(schedule.from.day).year();
  const std::chrono::sys_days first = (year - std::chrono::years(1)) / month(12) / day(21),
                              last = year / month(6) / day(21);
  std::vector<SkylineCurve> curves;
  for (int hour = 0; hour < 24; ++hour) {
    SkylineCurve curve{.positions = {}, .color = k_faint, .width = 1.0};
    for (std::chrono::sys_days at = first; at <= last; at += std::chrono::days(k_days_apart)) {
      const std::optional<glm::dvec2> position = position_at(schedule, at, hour);
      if (position) curve.positions.push_back(*position);
    }
    if (!curve.positions.empty()) curves.push_back(std::move(curve));
  }
  for (const DayPath& path : k_days) {
    const std::chrono::year_month_day date = year / month(path.month) / day(path.day);
    SkylineCurve curve{.positions = {}, .color = path.color, .label = path.label};
    for (const SunStep& step : steps_of_day(schedule, date, 0.0, 24.0, k_step))
      curve.positions.push_back(position_of(step));
    for (int hour = 0; hour < 24; ++hour) {
      const std::optional<glm::dvec2> position = position_at(schedule, date, hour);
      if (position) curve.marks.push_back({*position, path.has_hours ? std::to_string(hour) : ""});
    }
    curves.push_back(std::move(curve));
  }
  return curves;
}

}  // namespace alidade::visibility
