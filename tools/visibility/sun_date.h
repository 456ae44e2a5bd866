// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "base/date_time.h"

namespace alidade {

/// A date as people give it for sunshine: a whole day, or a moment.
struct SunDate {
  Moment moment;  ///< of a day: its begin in UTC, whatever the place
  bool is_day = false;
};

/// Reads "2026-06-21", a day, or "2026-06-21T10:00Z", a moment with its zone (a blank may stand for the T).
/// Errors: CLI::ValidationError for anything else.
SunDate parse_sun_date(const std::string& text);

/// When a range that begins with the date begins, and when one that ends with it ends. Days begin and end at
/// the middle of the night: midnight of mean solar time, 4 minutes earlier per degree to the east.
Moment begin_of(const SunDate& date, double longitude);
Moment end_of(const SunDate& date, double longitude);

}  // namespace alidade
