// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/date_time.h"
#include "base/input_file.h"

namespace alidade::visibility {

/// Irradiances by sun and sky in an hour: means, W/m2.
struct HourlyIrradiance {
  double direct_normal = 0.0;       ///< of a surface that faces the sun, by its disc
  double diffuse_horizontal = 0.0;  ///< of the horizontal, by the sky
};

/// The irradiances of a year, hour by hour, including clouds. Typical years are composed of months of
/// different years; so the year of a moment is ignored.
class Weather {
 public:
  /// Reads an EPW file of EnergyPlus, a TMY3 file of NREL (CSV), or a typical year of PVGIS (CSV), whichever
  /// the first line shows. Meaning of their rows:
  /// - EPW, TMY3: hours 1 to 24 of local standard time, each the mean of the hour that ends there. Source:
  ///   Crawley, Hand, Lawrie, Improving the Weather Information Available to Simulation Programs, 1999;
  ///   Wilcox and Marion, Users Manual for TMY3 Data Sets, 2008, table 3-1. Minutes are ignored: files have 0
  ///   or 60 for the same hour. Several records per hour of an EPW file are averaged. A missing irradiance of
  ///   an EPW file (9999 or more) is 0, as its data dictionary states: EnergyPlus, Auxiliary Programs, EPW
  ///   data dictionary; see missing_hours().
  /// - PVGIS: UTC; a row is for the hour that begins at its time, minutes are ignored, or if the head has an
  ///   irradiance time offset, for the hour around its time plus that.
  /// Memory: 140 kB. Errors, with the line, what was found and what is expected: none of these files; a line
  /// of the head, a column or a cell missing; an invalid number or one out of range; irradiances missing in
  /// all hours; hours that do not follow each other, or have another number of rows than the head states; a
  /// year that does not begin with its first hour or ends early.
  explicit Weather(InputFile& file);

  /// The hour that a moment is in. 29 February is 28 February if the file lacks it.
  const HourlyIrradiance& at(const Moment& moment) const;

  /// Counts the hours of the file's clock: moments of one hour have one number.
  std::int64_t hour_number(const Moment& moment) const;

  const std::string& format() const { return format_; }  ///< "EPW", "TMY3" or "PVGIS"
  double latitude() const { return latitude_; }          ///< degrees north
  double longitude() const { return longitude_; }        ///< degrees east
  double height() const { return height_; }              ///< metres above the sea
  double time_zone() const { return time_zone_; }        ///< hours that the file's clock is ahead of UTC
  std::size_t missing_hours() const { return missing_hours_; }  ///< hours with irradiances taken as 0
  std::uint64_t checksum() const;                               ///< of the irradiances and the clock

 private:
  class Reader;

  std::string format_;
  double latitude_ = 0.0, longitude_ = 0.0, height_ = 0.0, time_zone_ = 0.0;
  double shift_ = 0.0;  ///< hours by which the hours of the rows begin before their times
  std::size_t missing_hours_ = 0;
  std::vector<HourlyIrradiance> hours_;  ///< of a leap year
};

}  // namespace alidade::visibility
