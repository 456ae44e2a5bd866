// SPDX-License-Identifier: MIT
#include "base/date_time.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace alidade {
namespace {

constexpr double k_seconds_per_day = 86400.0;
constexpr std::size_t k_most_quoted = 60;

/// A text and its unread rest.
class Reading {
 public:
  explicit Reading(std::string_view text) : text_(text), rest_(text) {}

  bool at_end() const { return rest_.empty(); }

  bool take(char character) {
    if (!rest_.starts_with(character)) return false;
    rest_.remove_prefix(1);
    return true;
  }

  /// A number of exactly so many digits, and the character behind it unless that is 0.
  int number(std::size_t digits, char behind = 0) {
    if (rest_.size() < digits) fail_form();
    int number = 0;
    for (const char character : rest_.substr(0, digits)) {
      if (character < '0' || character > '9') fail_form();
      number = 10 * number + (character - '0');
    }
    rest_.remove_prefix(digits);
    if (behind != 0 && !take(behind)) fail_form();
    return number;
  }

  /// The digits behind a decimal point, one to nine of them, as a share of 1.
  double decimals() {
    double value = 0.0, scale = 1.0;
    std::size_t count = 0;
    for (; count < rest_.size() && rest_[count] >= '0' && rest_[count] <= '9'; ++count) {
      value = 10.0 * value + (rest_[count] - '0');
      scale *= 10.0;
    }
    if (count < 1 || count > 9) fail_form();
    rest_.remove_prefix(count);
    return value / scale;
  }

  [[noreturn]] void fail(const std::string& problem, const std::string& expected) const {
    const bool fits = text_.size() <= k_most_quoted;
    throw Error({.problem = problem,
                 .expected = expected,
                 .found = fmt::format("\"{}{}\"", text_.substr(0, k_most_quoted), fits ? "" : "...")});
  }

  [[noreturn]] void fail_form() const {
    fail("invalid date and time",
         "one like \"2003-10-17T12:30:30-07:00\" or \"2003-10-17T19:30:30Z\", in the years 1600 to 2999");
  }

 private:
  std::string_view text_, rest_;
};

/// Minutes that the zone's clocks are ahead of UTC.
int read_zone(Reading& reading) {
  if (reading.at_end()) {
    reading.fail("missing time zone", "Z for UTC or an offset such as -07:00 at the end");
  }
  if (reading.take('Z')) return 0;
  const bool ahead = reading.take('+');
  if (!ahead && !reading.take('-')) reading.fail_form();
  const int hours = reading.number(2, ':'), minutes = reading.number(2);
  if (hours > 23 || minutes > 59)
    reading.fail("invalid time zone", "an offset from UTC below 24 hours as hours:minutes");
  const int offset = 60 * hours + minutes;
  return ahead ? offset : -offset;
}

}  // namespace

Moment parse_date_time(std::string_view text) {
  Reading reading(text);
  const int year = reading.number(4, '-');
  const int month = reading.number(2, '-');
  const int day = reading.number(2, 'T');
  const int hour = reading.number(2, ':');
  const int minute = reading.number(2);
  double seconds = 0.0;
  if (reading.take(':')) {
    seconds = reading.number(2);
    if (reading.take('.')) seconds += reading.decimals();
  }
  const int ahead = read_zone(reading);
  if (!reading.at_end()) reading.fail_form();
  if (year < k_first_year || year > k_last_year) reading.fail_form();
  const std::chrono::year_month_day date{std::chrono::year(year),
                                         std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok()) reading.fail("invalid date", "a calendar date");
  if (hour > 23 || minute > 59 || seconds >= 60.0)
    reading.fail("invalid time", "00:00 to 23:59:59.999999999");

  const int minutes = 60 * hour + minute - ahead;
  Moment moment{std::chrono::sys_days(date), 60.0 * minutes + seconds};
  if (moment.seconds < 0.0) {
    moment.day -= std::chrono::days(1);
    moment.seconds += k_seconds_per_day;
  } else if (moment.seconds >= k_seconds_per_day) {
    moment.day += std::chrono::days(1);
    moment.seconds -= k_seconds_per_day;
  }
  return moment;
}

std::string date_time_text(const Moment& moment) {
  const std::chrono::year_month_day date(moment.day);
  const int whole = static_cast<int>(moment.seconds);
  std::string text = fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}", static_cast<int>(date.year()),
                                 static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                                 whole / 3600, whole / 60 % 60, whole % 60);
  const long billionths = std::min(std::lround((moment.seconds - whole) * 1e9), 999999999L);
  if (billionths > 0) {
    text += fmt::format(".{:09}", billionths);
    text.erase(text.find_last_not_of('0') + 1);
  }
  return text + "Z";
}

double julian_day(const Moment& moment) {
  constexpr double k_unix_epoch = 2440587.5;
  return k_unix_epoch + static_cast<double>(moment.day.time_since_epoch().count()) +
         moment.seconds / k_seconds_per_day;
}

double decimal_year(const Moment& moment) {
  const std::chrono::year year = std::chrono::year_month_day(moment.day).year();
  const std::chrono::sys_days begin(year / std::chrono::January / 1),
      end((year + std::chrono::years(1)) / std::chrono::January / 1);
  const double days = static_cast<double>((moment.day - begin).count()) + moment.seconds / k_seconds_per_day;
  return static_cast<int>(year) + days / static_cast<double>((end - begin).count());
}

}  // namespace alidade
