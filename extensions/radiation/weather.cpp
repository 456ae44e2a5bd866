// SPDX-License-Identifier: MIT
#include "extensions/radiation/weather.h"

#include <fmt/format.h>
#include <array>
#include <chrono>
#include <cmath>
#include <string_view>

#include "base/error.h"
#include "base/fingerprint.h"
#include "base/text_scanner.h"
#include "base/words.h"

namespace alidade::visibility {
namespace {

constexpr int k_leap_year = 2000;  // any
constexpr std::size_t k_hours_per_day = 24, k_leap_hours = 366 * k_hours_per_day,
                      k_leap_day = (31 + 28) * k_hours_per_day;  // its first hour

/// Number of an hour in a leap year; empty: no such day or hour.
std::optional<std::size_t> slot_of(unsigned month, unsigned day, unsigned hour) {
  const std::chrono::year year(k_leap_year);
  const std::chrono::year_month_day date(year, std::chrono::month(month), std::chrono::day(day));
  if (!date.ok() || hour >= k_hours_per_day) return {};
  const auto days = std::chrono::sys_days(date) - std::chrono::sys_days(year / std::chrono::January / 1);
  return static_cast<std::size_t>(days.count()) * k_hours_per_day + hour;
}

std::string text_of_slot(std::size_t slot) {
  const std::chrono::year_month_day date(
      std::chrono::sys_days(std::chrono::year(k_leap_year) / std::chrono::January / 1) +
      std::chrono::days(static_cast<int>(slot / k_hours_per_day)));
  return fmt::format("the hour from {}:00 of month {}, day {}", slot % k_hours_per_day,
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()));
}

}  // namespace

/// Reads the lines of a file one after another.
class Weather::Reader {
 public:
  Reader(InputFile& file, Weather& weather) : scanner_(file), weather_(weather) {}

  void read() {
    read_head();
    weather_.hours_.assign(k_leap_hours, {});
    std::optional<std::size_t> before;
    std::size_t hours = 0;
    while (next_cells()) {
      // A blank line ends the rows; PVGIS explains its columns below.
      if (cells_.size() == 1 && cells_.front().empty()) break;
      const std::size_t slot = read_slot();
      require_order(before, slot);
      weather_.hours_[slot] = read_hour(slot);
      has_leap_day_ = has_leap_day_ || slot == k_leap_day;
      before = slot;
      ++hours;
    }
    if (!before || *before + 1 != k_leap_hours)
      scanner_.fail("the weather ends early", "a year of 8760 or 8784 hours", fmt::format("{} hours", hours));
    if (weather_.missing_hours_ == hours)
      scanner_.fail("the weather has no irradiances", "hours without missing values (9999)");
    for (std::size_t hour = 0; !has_leap_day_ && hour < k_hours_per_day; ++hour)
      weather_.hours_[k_leap_day + hour] = weather_.hours_[k_leap_day - k_hours_per_day + hour];
  }

 private:
  enum class Form { epw, tmy3, pvgis };

  static constexpr double k_most = 2000.0;  // W/m2

  bool next_cells() {
    const std::optional<std::string_view> line = scanner_.next_line();
    if (!line) return false;
    split_cells(*line, ',', cells_);
    return true;
  }

  void next_line_of(const char* what) {
    if (!next_cells()) scanner_.fail("the file ends early", what, "no more lines");
  }

  double number(std::size_t column, const char* what, double least, double most) const {
    if (column >= cells_.size()) {
      scanner_.fail("too few columns", fmt::format("{} in column {}", what, column + 1),
                    std::to_string(cells_.size()));
    }
    const std::optional<double> value = parse_number(cells_[column]);
    if (!value || !(*value >= least && *value <= most)) {
      scanner_.fail(fmt::format("invalid {} in column {}", what, column + 1),
                    fmt::format("a number from {} to {}", least, most), quote(cells_[column]));
    }
    return *value;
  }

  /// An irradiance of a row; a missing one of an EPW file is 0, as in EnergyPlus.
  double irradiance(std::size_t column, const char* what, bool& is_missing) const {
    constexpr double k_missing = 9999.0;
    if (form_ == Form::epw && column < cells_.size()) {
      const std::optional<double> value = parse_number(cells_[column]);
      if (value && *value >= k_missing) {
        is_missing = true;
        return 0.0;
      }
    }
    return number(column, what, 0.0, k_most);
  }

  /// Means over the rows of an hour. The current row is the first of them.
  HourlyIrradiance read_hour(std::size_t slot) {
    HourlyIrradiance sum;
    bool is_missing = false;
    for (unsigned record = 0; record < records_; ++record) {
      if (record > 0) {
        next_line_of("another record of the same hour");
        if (const std::size_t found = read_slot(); found != slot)
          scanner_.fail(fmt::format("the hour has not {} records", records_), text_of_slot(slot),
                        text_of_slot(found));
      }
      sum.direct_normal += irradiance(direct_, "direct normal irradiance", is_missing);
      sum.diffuse_horizontal += irradiance(diffuse_, "diffuse horizontal irradiance", is_missing);
    }
    if (is_missing) ++weather_.missing_hours_;
    return {sum.direct_normal / records_, sum.diffuse_horizontal / records_};
  }

  unsigned whole(std::string_view word, const char* what, unsigned least, unsigned most) const {
    const std::optional<unsigned> value = parse_count<unsigned>(trim(word));
    if (!value || *value < least || *value > most) {
      scanner_.fail(fmt::format("invalid {}", what), fmt::format("a whole number from {} to {}", least, most),
                    quote(word));
    }
    return *value;
  }

  void read_position(std::size_t latitude, std::size_t longitude, std::size_t height,
                     std::optional<std::size_t> zone) {
    weather_.latitude_ = number(latitude, "latitude", -90.0, 90.0);
    weather_.longitude_ = number(longitude, "longitude", -180.0, 180.0);
    weather_.height_ = number(height, "height", -1000.0, 10000.0);
    if (zone) weather_.time_zone_ = number(*zone, "time zone", -14.0, 14.0);
  }

  std::size_t column_of(std::string_view name) const {
    const auto found = std::ranges::find(cells_, name);
    if (found == cells_.end()) scanner_.fail("missing column", fmt::format("{}", name));
    return static_cast<std::size_t>(found - cells_.begin());
  }

  void read_head() {
    next_line_of("an EPW, TMY3 or PVGIS file");
    if (lower_case(cells_.front()) == "location") {
      form_ = Form::epw;
      read_epw_head();
    } else if (cells_.front().starts_with("Latitude (decimal degrees)")) {
      form_ = Form::pvgis;
      read_pvgis_head();
    } else if (cells_.size() == 7 && parse_count(cells_.front())) {
      form_ = Form::tmy3;
      read_position(4, 5, 6, 3);
      next_line_of("the line of column names");
      direct_ = column_of("DNI (W/m^2)");
      diffuse_ = column_of("DHI (W/m^2)");
    } else {
      scanner_.fail(
          "unknown weather file",
          "EPW (LOCATION,...), TMY3 (station,name,state,zone,latitude,longitude,height) or PVGIS CSV "
          "(Latitude (decimal degrees): ...)",
          quote(cells_.front()));
    }
    constexpr std::array k_names = {"EPW", "TMY3", "PVGIS"};
    weather_.format_ = k_names[static_cast<std::size_t>(form_)];
  }

  void read_epw_head() {
    read_position(6, 7, 9, 8);
    // The dictionary of the format writes DAYLIGHT SAVING, most files DAYLIGHT SAVINGS.
    constexpr std::array k_lines = {"DESIGN CONDITIONS",   "TYPICAL/EXTREME PERIODS",
                                    "GROUND TEMPERATURES", "HOLIDAYS/DAYLIGHT SAVING",
                                    "COMMENTS 1",          "COMMENTS 2",
                                    "DATA PERIODS"};
    for (const std::string_view line : k_lines) {
      next_line_of(line.data());
      if (!lower_case(cells_.front()).starts_with(lower_case(line)))
        scanner_.fail("wrong line of the EPW head", std::string(line), quote(cells_.front()));
    }
    if (cells_.size() < 3) scanner_.fail("too few columns", "the number of records per hour in column 3");
    records_ = whole(cells_[2], "number of records per hour", 1, 60);
    direct_ = 14;
    diffuse_ = 15;
  }

  void read_pvgis_head() {
    struct Line {
      std::string_view name;
      double least, most;
      double& value;
    };
    bool is_first = true;
    for (const Line& line : {Line{"Latitude (decimal degrees):", -90.0, 90.0, weather_.latitude_},
                             Line{"Longitude (decimal degrees):", -180.0, 180.0, weather_.longitude_},
                             Line{"Elevation (m):", -1000.0, 10000.0, weather_.height_}}) {
      if (!is_first) next_line_of(line.name.data());
      is_first = false;
      if (!cells_.front().starts_with(line.name))
        scanner_.fail("wrong line of the PVGIS head", std::string(line.name), quote(cells_.front()));
      cells_ = {trim(cells_.front().substr(line.name.size()))};
      line.value = number(0, "position", line.least, line.most);
    }
    constexpr std::string_view k_offset = "Irradiance Time Offset (h):";
    do {
      next_line_of("the line of column names: time(UTC),...");
      if (!cells_.front().starts_with(k_offset)) continue;
      cells_ = {trim(cells_.front().substr(k_offset.size()))};
      weather_.shift_ = 0.5 - number(0, "time offset", -1.0, 1.0);
    } while (cells_.front() != "time(UTC)");
    direct_ = column_of("Gb(n)");
    diffuse_ = column_of("Gd(h)");
  }

  /// The hour of the row, as slot_of().
  std::size_t read_slot() const {
    const auto slot = [this](std::string_view month, std::string_view day, unsigned hour) {
      const auto found = slot_of(whole(month, "month", 1, 12), whole(day, "day", 1, 31), hour);
      if (!found) scanner_.fail("no such day", "a day of its month", quote(day));
      return *found;
    };
    const std::string_view first = cells_.front();
    if (form_ == Form::epw) {
      if (cells_.size() < 4) scanner_.fail("too few columns", "35", std::to_string(cells_.size()));
      return slot(cells_[1], cells_[2], whole(cells_[3], "hour", 1, 24) - 1);
    }
    if (form_ == Form::tmy3) {
      const std::string_view time = cells_.size() > 1 ? cells_[1] : std::string_view{};
      if (first.size() != 10 || first[2] != '/' || first[5] != '/')
        scanner_.fail("invalid date", "MM/DD/YYYY", quote(first));
      if (time.size() != 5 || !time.ends_with(":00")) scanner_.fail("invalid time", "HH:00", quote(time));
      return slot(first.substr(0, 2), first.substr(3, 2), whole(time.substr(0, 2), "hour", 1, 24) - 1);
    }
    if (first.size() != 13 || first[8] != ':') scanner_.fail("invalid time", "YYYYMMDD:HHMM", quote(first));
    return slot(first.substr(4, 2), first.substr(6, 2), whole(first.substr(9, 2), "hour", 0, 23));
  }

  void require_order(const std::optional<std::size_t>& before, std::size_t slot) const {
    const std::size_t expected = before ? *before + 1 : 0;
    const bool skips_leap_day = expected == k_leap_day && slot == k_leap_day + k_hours_per_day;
    if (slot == expected || skips_leap_day) return;
    scanner_.fail("the hours do not follow each other",
                  expected < k_leap_hours ? text_of_slot(expected) : "the end after one year",
                  text_of_slot(slot));
  }

  TextScanner scanner_;
  Weather& weather_;
  Form form_ = Form::epw;
  std::vector<std::string_view> cells_;
  std::size_t direct_ = 0, diffuse_ = 0;
  unsigned records_ = 1;  ///< of each hour
  bool has_leap_day_ = false;
};

Weather::Weather(InputFile& file) {
  Reader(file, *this).read();
}

const HourlyIrradiance& Weather::at(const Moment& moment) const {
  constexpr std::int64_t k_hours = k_hours_per_day;
  const std::int64_t number = hour_number(moment), hour = (number % k_hours + k_hours) % k_hours;
  const std::chrono::year_month_day date(
      std::chrono::sys_days(std::chrono::days(static_cast<int>((number - hour) / k_hours))));
  return hours_[*slot_of(static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                         static_cast<unsigned>(hour))];
}

std::int64_t Weather::hour_number(const Moment& moment) const {
  constexpr std::int64_t k_hours = k_hours_per_day;
  const double hours = std::floor(moment.seconds / 3600.0 + time_zone_ + shift_);
  return moment.day.time_since_epoch().count() * k_hours + static_cast<std::int64_t>(hours);
}

std::uint64_t Weather::checksum() const {
  std::vector<double> numbers{time_zone_ + shift_};
  for (const HourlyIrradiance& hour : hours_)
    numbers.insert(numbers.end(), {hour.direct_normal, hour.diffuse_horizontal});
  return alidade::checksum(std::as_bytes(std::span(numbers)));
}

}  // namespace alidade::visibility
