// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <string>
#include <string_view>

namespace alidade {

/// A moment in UTC. Leap seconds are not counted.
struct Moment {
  std::chrono::sys_days day{};
  double seconds = 0.0;  ///< since midnight, [0, 86400)

  bool operator==(const Moment&) const = default;
};

/// Years that parse_date_time() accepts, both inclusive.
inline constexpr int k_first_year = 1600, k_last_year = 2999;

/// Reads a date and time with its zone, as ISO 8601 and RFC 3339 write it: "2003-10-17T12:30:30-07:00",
/// "2026-06-21T10:00Z", "2026-06-21T10:00:12.5Z". Seconds may be left out or have up to nine decimals; the
/// calendar is the Gregorian. Errors (without a file): any other text; no such day or time; a year out of
/// range; no zone, since the same clock reading is another moment elsewhere.
Moment parse_date_time(std::string_view text);

/// "2003-10-17T19:30:30Z"; seconds have as many decimals as they need, at most nine.
std::string date_time_text(const Moment& moment);

/// Days since noon of 1 January 4713 BC (Julian calendar).
double julian_day(const Moment& moment);

/// 2003.5 is the middle of the year 2003.
double decimal_year(const Moment& moment);

}  // namespace alidade
