// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace alidade {

/// Date and time of day of an adjusted standard GPS time (LAS 1.4: GPS seconds minus 10^9), whole seconds:
/// "2022-09-06 10:12:33". It is GPS time, ahead of UTC by the leap seconds since 1980 (18 s since 2017).
/// Empty outside the years 1 to 9999.
std::optional<std::string> gps_date(std::int64_t adjusted_seconds);

/// Day and time of a GPS week time: "Tuesday 10:12:33"; weeks begin on Sunday. Empty outside [0, 604800).
std::optional<std::string> gps_weekday(std::int64_t week_seconds);

}  // namespace alidade
