// SPDX-License-Identifier: MIT
#include "tools/visibility/sun_date.h"

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>

#include "base/error.h"

namespace alidade {
namespace {

constexpr double k_seconds_per_day = 86400.0;

Moment midnight(const Moment& utc, double longitude) {
  const double seconds = utc.seconds - std::round(longitude / 360.0 * k_seconds_per_day);
  const double days = std::floor(seconds / k_seconds_per_day);
  return {utc.day + std::chrono::days(static_cast<int>(days)), seconds - days * k_seconds_per_day};
}

}  // namespace

SunDate parse_sun_date(const std::string& text) {
  constexpr std::size_t k_date_length = 10;
  SunDate date;
  date.is_day = text.size() == k_date_length;
  std::string full = text;
  if (date.is_day) full += "T00:00Z";
  if (full.size() > k_date_length && full[k_date_length] == ' ') full[k_date_length] = 'T';
  try {
    date.moment = parse_date_time(full);
  } catch (const Error& error) {
    // What was added to a day is nothing that the user wrote.
    if (!date.is_day) throw CLI::ValidationError(error.what());
    throw CLI::ValidationError("expected a day such as 2026-06-21, found '" + text + "'");
  }
  return date;
}

Moment begin_of(const SunDate& date, double longitude) {
  return date.is_day ? midnight(date.moment, longitude) : date.moment;
}

Moment end_of(const SunDate& date, double longitude) {
  if (!date.is_day) return date.moment;
  Moment next = date.moment;
  next.day += std::chrono::days(1);
  return midnight(next, longitude);
}

}  // namespace alidade
