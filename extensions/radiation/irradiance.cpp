// SPDX-License-Identifier: MIT
#include "extensions/radiation/irradiance.h"

#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "base/error.h"
#include "base/exact_math.h"
#include "geo/sun.h"

namespace alidade::visibility {
namespace {

void require(const char* what, double value, double least, double most) {
  check_that(value >= least && value <= most, fmt::format("{} out of range", what),
             fmt::format("a number from {} to {}", least, most), fmt::format("{}", value));
}

/// 1 is the beginning of 1 January.
double day_of_year(const Moment& moment) {
  const std::chrono::year_month_day date(moment.day);
  const std::chrono::sys_days first(date.year() / std::chrono::January / 1);
  return static_cast<double>((moment.day - first).count()) + 1.0 + moment.seconds / 86400.0;
}

/// Gives a step the light of its moment.
void set_irradiance(const LightSource& source, const Moment& moment, LitStep& step) {
  const double day = day_of_year(moment);
  step.extraterrestrial = extraterrestrial_irradiance(day);
  if (source.weather != nullptr) {
    const HourlyIrradiance& hour = source.weather->at(moment);
    step.irradiance = hour.direct_normal;
    step.diffuse = hour.diffuse_horizontal;
    return;
  }
  ClearAir air = source.air;
  if (source.monthly_turbidity) {
    const auto month = static_cast<unsigned>(std::chrono::year_month_day(moment.day).month());
    air.linke_turbidity = (*source.monthly_turbidity)[month - 1];
  }
  step.irradiance = beam_irradiance(step.elevation, day, air);
  step.diffuse = diffuse_irradiance(step.elevation, day, air);
}

/// Gives the steps with sun of an hour of a weather file the energy of all steps of that hour.
class WholeHours {
 public:
  /// Both must outlive the object. `weather` may be null: then the object does nothing.
  WholeHours(const Weather* weather, std::vector<LitStep>& steps) : weather_(weather), steps_(steps) {}

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
  std::vector<LitStep>& steps_;
  std::int64_t number_ = 0;
  std::size_t first_ = 0;        ///< step of the hour
  double all_ = 0.0, up_ = 0.0;  ///< hours
};

/// Optical thickness of clean dry air, per air mass. Source: Kasten 1996, as in Rigollier et al.
/// 2000, equations 11 and 12.
double rayleigh_thickness(double mass) {
  constexpr double k_low_sun = 20.0;
  if (mass > k_low_sun) return 1.0 / (10.4 + 0.718 * mass);
  return 1.0 / (6.6296 + mass * (1.7513 + mass * (-0.1202 + mass * (0.0065 - 0.00013 * mass))));
}

double rounded_irradiance(double irradiance) {
  return std::round(irradiance * 1e4) / 1e4;
}

}  // namespace

double extraterrestrial_irradiance(double day_of_year) {
  constexpr double k_solar_constant = 1367.0, k_days = 365.25;
  constexpr double k_eccentricity = 0.03344, k_perihelion = 0.048869;
  const double turn = 2.0 * std::numbers::pi * day_of_year / k_days;
  return k_solar_constant * (1.0 + k_eccentricity * std::cos(turn - k_perihelion));
}

double beam_irradiance(double elevation, double day_of_year, const ClearAir& air) {
  if (!(elevation > 0.0)) return 0.0;
  const double mass = geo::air_mass(elevation) * std::exp(-air.height / 8434.5);
  return rounded_irradiance(extraterrestrial_irradiance(day_of_year) *
                            std::exp(-0.8662 * air.linke_turbidity * mass * rayleigh_thickness(mass)));
}

double diffuse_irradiance(double elevation, double day_of_year, const ClearAir& air) {
  if (!(elevation > 0.0)) return 0.0;
  constexpr double k_least = 0.0022;  // of the sky's transmission where the sun is at the horizon
  const double t = air.linke_turbidity, sine = sine_cosine_of_degrees(elevation).sine;
  const double transmission = -0.015843 + t * (0.030543 + t * 0.0003797);
  const double constant = std::max(0.26463 + t * (-0.061581 + t * 0.0031408), k_least / transmission),
               linear = 2.04020 + t * (0.018945 - t * 0.011161),
               square = -1.3025 + t * (0.039231 + t * 0.0085079);
  return rounded_irradiance(extraterrestrial_irradiance(day_of_year) * transmission *
                            (constant + sine * (linear + sine * square)));
}

std::vector<LitStep> lit_steps(const SunSchedule& schedule, std::span<const SunStep> steps,
                               const LightSource& source) {
  require("turbidity", source.air.linke_turbidity, 1.0, 20.0);
  if (source.monthly_turbidity)
    for (const double turbidity : *source.monthly_turbidity) require("turbidity", turbidity, 1.0, 20.0);
  require("height above sea level", source.air.height, -1000.0, 10000.0);
  std::vector<LitStep> lit;
  WholeHours whole_hours(source.weather, lit);
  const auto enter = [&](std::size_t number, bool is_up) {
    const StepTime time = step_time(schedule, number);
    whole_hours.enter(time.middle, time.hours, is_up);
  };
  std::size_t next = 0;  // step that was not entered
  for (const SunStep& step : steps) {
    for (; next < step.number; ++next) enter(next, false);
    enter(next++, true);
    lit.push_back(
        {.azimuth = step.azimuth, .elevation = step.elevation, .hours = step.hours, .period = step.period});
    set_irradiance(source, step_time(schedule, step.number).middle, lit.back());
  }
  for (const std::size_t count = step_count(schedule); next < count; ++next) enter(next, false);
  whole_hours.finish();
  return lit;
}

}  // namespace alidade::visibility
