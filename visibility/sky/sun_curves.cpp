// SPDX-License-Identifier: MIT
#include "visibility/sky/sun_path.h"

#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <string>

#include "visibility/horizon/skyline.h"

namespace alidade::visibility {
namespace {

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
  constexpr double k_seconds_per_hour = 3600.0, k_seconds_per_day = 86400.0;
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
  part.weather = nullptr;
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
