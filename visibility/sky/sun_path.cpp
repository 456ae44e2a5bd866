// SPDX-License-Identifier: MIT
#include "visibility/sky/sun_path.h"

#include <fmt/format.h>
#include <cmath>
#include <cstdint>

#include "base/error.h"
#include "geo/earth.h"
#include "geo/sun.h"

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

/// 1 is the beginning of 1 January.
double day_of_year(const Moment& moment) {
  const std::chrono::year_month_day date(moment.day);
  const std::chrono::sys_days first(date.year() / std::chrono::January / 1);
  return static_cast<double>((moment.day - first).count()) + 1.0 + moment.seconds / k_seconds_per_day;
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

/// Gives a step the light of its moment.
void set_irradiance(const SunSchedule& schedule, const Moment& moment, SunStep& step) {
  const double day = day_of_year(moment);
  step.extraterrestrial = extraterrestrial_irradiance(day);
  if (schedule.weather != nullptr) {
    const HourlyIrradiance& hour = schedule.weather->at(moment);
    step.irradiance = hour.direct_normal;
    step.diffuse = hour.diffuse_horizontal;
    return;
  }
  ClearAir air = schedule.air;
  if (schedule.monthly_turbidity) {
    const auto month = static_cast<unsigned>(std::chrono::year_month_day(moment.day).month());
    air.linke_turbidity = (*schedule.monthly_turbidity)[month - 1];
  }
  step.irradiance = beam_irradiance(step.elevation, day, air);
  step.diffuse = diffuse_irradiance(step.elevation, day, air);
}

/// Gives the steps with sun of an hour of a weather file the energy of all steps of that hour.
class WholeHours {
 public:
  /// Both must outlive the object. `weather` may be null: then the object does nothing.
  WholeHours(const Weather* weather, std::vector<SunStep>& steps) : weather_(weather), steps_(steps) {}

  /// To be called with each step before it is added to the steps, also if the sun is not up.
  void enter(const Moment& middle, double hours, bool is_up) {
    if (weather_ == nullptr) return;
    if (const std::int64_t number = weather_->hour_number(middle); number != number_) {
      finish();
      number_ = number;
    }
    all_ += hours;
    if (is_up) up_ += hours;
  }
  void finish() {
    for (; first_ < steps_.size() && weather_ != nullptr; ++first_) {
      steps_[first_].irradiance *= all_ / up_;
      steps_[first_].diffuse *= all_ / up_;
    }
    all_ = up_ = 0.0;
  }

 private:
  const Weather* weather_;
  std::vector<SunStep>& steps_;
  std::int64_t number_ = 0;
  std::size_t first_ = 0;        ///< step of the hour
  double all_ = 0.0, up_ = 0.0;  ///< hours
};

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

std::vector<SunStep> sun_steps(const SunSchedule& schedule, const Progress& progress) {
  require("time step", schedule.step_minutes, 0.1, 1440.0);
  require("latitude", schedule.latitude, -90.0, 90.0);
  require("longitude", schedule.longitude, -360.0, 360.0);
  require("turbidity", schedule.air.linke_turbidity, 1.0, 20.0);
  if (schedule.monthly_turbidity)
    for (const double turbidity : *schedule.monthly_turbidity) require("turbidity", turbidity, 1.0, 20.0);
  require("height above sea level", schedule.air.height, -1000.0, 10000.0);
  const double duration = seconds_between(schedule.from, schedule.to), step = 60.0 * schedule.step_minutes;
  check_that(duration > 0.0, "empty time range", "an end after " + date_time_text(schedule.from),
             date_time_text(schedule.to));
  const double count = std::ceil(duration / step);
  check_that(count <= static_cast<double>(k_most_sun_steps), "too many time steps",
             fmt::format("at most {}: use longer steps or a shorter time", k_most_sun_steps),
             fmt::format("{:.0f}", count));
  constexpr double k_sea_pressure = 1013.25, k_scale_height = 8434.5;
  const geo::SunObserver observer{
      .latitude = schedule.latitude,
      .longitude = schedule.longitude,
      .height = schedule.air.height,
      .pressure = k_sea_pressure * std::exp(-schedule.air.height / k_scale_height)};
  const int first_period = period_number(schedule, schedule.from);
  std::vector<SunStep> steps;
  WholeHours whole_hours(schedule.weather, steps);
  const auto total = static_cast<std::size_t>(count);
  for (std::size_t i = 0; i < total; ++i) {
    constexpr std::size_t k_report_interval = 256;
    if (i % k_report_interval == 0) report(progress, i, total);
    const double begin = static_cast<double>(i) * step, end = std::fmin(begin + step, duration);
    const Moment middle = later(schedule.from, 0.5 * (begin + end));
    const geo::SunPosition sun = geo::sun_position(middle, observer);
    const double elevation = geo::rounded_degrees(sun.elevation);
    whole_hours.enter(middle, (end - begin) / 3600.0, elevation > 0.0);
    if (!(elevation > 0.0)) continue;
    SunStep one{.azimuth = geo::wrapped_degrees(geo::rounded_degrees(sun.azimuth - schedule.grid_north)),
                .elevation = elevation,
                .hours = (end - begin) / 3600.0,
                .period = period_number(schedule, middle) - first_period};
    set_irradiance(schedule, middle, one);
    steps.push_back(one);
  }
  whole_hours.finish();
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

}  // namespace alidade::visibility
