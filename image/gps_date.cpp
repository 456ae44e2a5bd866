// SPDX-License-Identifier: MIT
#include "image/gps_date.h"

#include <fmt/format.h>

#include <array>
#include <chrono>

namespace alidade {
namespace {

constexpr std::int64_t k_day = 24 * 60 * 60;
constexpr std::int64_t k_adjustment = 1'000'000'000;
/// Within some millions of years on either side nothing overflows.
constexpr std::int64_t k_most_seconds = std::int64_t{1} << 46;

std::string time_of_day(std::int64_t second) {
  return fmt::format("{:02}:{:02}:{:02}", second / 3600, second / 60 % 60, second % 60);
}

}  // namespace

std::optional<std::string> gps_date(std::int64_t adjusted_seconds) {
  using namespace std::chrono;
  if (adjusted_seconds < -k_most_seconds || adjusted_seconds > k_most_seconds) return std::nullopt;
  constexpr sys_days k_epoch = year(1980) / January / 6;
  const std::int64_t since_1970 =
      duration_cast<seconds>(k_epoch.time_since_epoch()).count() + k_adjustment + adjusted_seconds;
  const std::int64_t day_count = since_1970 >= 0 ? since_1970 / k_day : (since_1970 - k_day + 1) / k_day;
  constexpr sys_days k_first = year(1) / January / 1, k_last = year(9999) / December / 31;
  if (day_count < k_first.time_since_epoch().count() || day_count > k_last.time_since_epoch().count())
    return std::nullopt;
  const year_month_day date{sys_days(days(day_count))};
  return fmt::format("{:04}-{:02}-{:02} {}", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                     time_of_day(since_1970 - day_count * k_day));
}

std::optional<std::string> gps_weekday(std::int64_t week_seconds) {
  constexpr std::array<const char*, 7> k_days = {"Sunday",   "Monday", "Tuesday", "Wednesday",
                                                 "Thursday", "Friday", "Saturday"};
  if (week_seconds < 0 || week_seconds >= 7 * k_day) return std::nullopt;
  return fmt::format("{} {}", k_days[static_cast<std::size_t>(week_seconds / k_day)],
                     time_of_day(week_seconds % k_day));
}

}  // namespace alidade
