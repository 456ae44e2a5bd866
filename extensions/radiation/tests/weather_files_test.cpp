// SPDX-License-Identifier: MIT
// Whole weather files as their publishers write them: full heads, all columns, months of different years.
// Sources: EnergyPlus, Auxiliary Programs, EPW data dictionary; Wilcox and Marion, Users Manual for TMY3 Data
// Sets, 2008; European Commission, PVGIS user manual, typical meteorological year.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <string>

#include "base/error.h"
#include "extensions/radiation/irradiance.h"
#include "tests/cloud/cloud_test_support.h"

namespace alidade::test {

using namespace visibility;

namespace {

constexpr std::array k_days = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
/// A typical year takes its months from these; 2004, 2008 and 2012 are leap years.
constexpr std::array k_years = {2007, 2004, 2012, 2008, 2009, 2013, 2005, 2011, 2006, 2010, 2008, 2012};

/// An hour of the file's clock.
struct Hour {
  int year, month, day, hour;  ///< hour from 0
  int direct, diffuse;         ///< W/m2
};

/// Light from 9:00 to 15:00, different on every day.
Hour hour_of(int year, int month, int day, int hour) {
  const bool is_light = hour >= 9 && hour < 15;
  return {year,
          month,
          day,
          hour,
          is_light ? 37 * month + 11 * day + hour : 0,
          is_light ? 5 * month + 3 * day + 2 * hour : 0};
}

struct Sums {
  long direct = 0, diffuse = 0;
  bool operator==(const Sums&) const = default;
};

/// Visits every hour of a typical year, or of one leap year.
void for_each_hour(bool is_leap, const std::function<void(const Hour&)>& visit) {
  for (int month = 1; month <= 12; ++month) {
    const auto index = static_cast<std::size_t>(month - 1);
    const int days = k_days[index] + (is_leap && month == 2 ? 1 : 0);
    for (int day = 1; day <= days; ++day)
      for (int hour = 0; hour < 24; ++hour) visit(hour_of(is_leap ? 2004 : k_years[index], month, day, hour));
  }
}

std::string rows(bool is_leap, const std::function<std::string(const Hour&)>& line) {
  std::string text;
  for_each_hour(is_leap, [&](const Hour& hour) { text += line(hour); });
  return text;
}

Sums sums_of_file(bool is_leap) {
  Sums sums;
  for_each_hour(is_leap, [&](const Hour& hour) { sums.direct += hour.direct, sums.diffuse += hour.diffuse; });
  return sums;
}

/// How an EPW file is written.
struct Epw {
  int records = 1;  ///< per hour
  int minute = 60;  ///< of the only record
  bool is_leap = false;
  std::string saving = "HOLIDAYS/DAYLIGHT SAVINGS";
};

std::string epw_head(const Epw& form) {
  return fmt::format(
      "LOCATION,MUENCHEN,-,DEU,IWEC Data,108660,48.13,11.70,1.0,529.0\n"
      "DESIGN CONDITIONS,1,Climate Design Data 2009 ASHRAE "
      "Handbook,,Heating,1,-12.7,-9.9,-15.6,1,Cooling,7,10.7,"
      "29.1,18.7,Extremes,10.8,9.4,8.3\n"
      "TYPICAL/EXTREME PERIODS,6,Summer - Week Nearest Max Temperature For Period,Extreme,7/20,7/26,"
      "No Dry Season - Week Near Average Annual,Typical,10/29,11/4\n"
      "GROUND "
      "TEMPERATURES,2,.5,,,,-0.98,-0.25,2.66,5.98,13.2,17.6,19.4,18.2,14.5,9.3,4.2,0.6,2,,,,2.3,2.0,3.2,"
      "5.1,10.2,14.1,16.5,16.7,14.7,11.3,7.3,4.2\n"
      "{},{},0,0,0\n"
      "COMMENTS 1,\"IWEC- WMO#108660 - Europe -- Original Source Data (c) 2001 ASHRAE\"\n"
      "COMMENTS 2, -- Ground temps produced with a standard soil diffusivity of 2.3225760E-03 {{m**2/day}}\n"
      "DATA PERIODS,1,{},Data,Sunday, 1/ 1,12/31\n",
      form.saving, form.is_leap ? "Yes" : "No", form.records);
}

/// All 35 columns.
std::string epw_row(const Hour& hour, int minute, int direct, int diffuse) {
  return fmt::format(
      "{},{},{},{},{},?9?9?9?9E0?9?9?9?9?9?9?9*9?9?9?9?9?9*_*9*9*9*9*9,-3.0,-4.1,92,95500,0,1415,275,{},{},{}"
      ","
      "9999,999999,999999,9999,240,3.1,10,10,10.0,1500,9,999999999,10,0.0840,0,88,999.000,999.0,99.0\n",
      hour.year, hour.month, hour.day, hour.hour + 1, minute, hour.direct / 2 + hour.diffuse, direct,
      diffuse);
}

std::string epw(const Epw& form) {
  return epw_head(form) + rows(form.is_leap, [&](const Hour& hour) {
           std::string lines;
           // Records that differ, with the hour as their mean.
           for (int record = 0; record < form.records; ++record) {
             const int more = hour.direct > 9 ? 2 * record - (form.records - 1) : 0;
             lines += epw_row(hour, form.records == 1 ? form.minute : 60 / form.records * (record + 1),
                              hour.direct + more, hour.diffuse - more);
           }
           return lines;
         });
}

/// The columns of light; a name with a comma between quotes.
std::string tmy3() {
  return "703165,\"SAND POINT, POPOF ISLAND\",AK,-9.0,55.317,-160.517,7\n"
         "Date (MM/DD/YYYY),Time (HH:MM),ETR (W/m^2),ETRN (W/m^2),GHI (W/m^2),GHI source,GHI uncert (%),"
         "DNI (W/m^2),DNI source,DNI uncert (%),DHI (W/m^2),DHI source,DHI uncert (%),GH illum (lx),"
         "GH illum source,Global illum uncert (%),DN illum (lx),DN illum source,DN illum uncert (%),DH illum "
         "(lx),"
         "DH illum source,DH illum uncert (%),Zenith lum (cd/m^2),Zenith lum source,Zenith lum uncert (%)\n" +
         rows(false, [](const Hour& hour) {
           return fmt::format(
               "{:02}/{:02}/{},{:02}:00,0,1415,{},1,0,{},2,13,{},1,13,-9900,1,0,0,1,0,0,1,0,0,1,0\n",
               hour.month, hour.day, hour.year, hour.hour + 1, hour.direct / 2 + hour.diffuse, hour.direct,
               hour.diffuse);
         });
}

std::string pvgis() {
  std::string text =
      "Latitude (decimal degrees): 45.000\nLongitude (decimal degrees): 8.000\nElevation (m): 250.0\n"
      "Irradiance Time Offset (h): 0.1761\nmonth,year\n";
  for (std::size_t month = 0; month < k_years.size(); ++month)
    text += fmt::format("{},{}\n", month + 1, k_years[month]);
  text += "time(UTC),T2m,RH,G(h),Gb(n),Gd(h),IR(h),WS10m,WD10m,SP\n" + rows(false, [](const Hour& hour) {
            return fmt::format("{}{:02}{:02}:{:02}00,0.98,96.02,{}.0,{},{}.0,266.98,1.65,263.0,98779.0\n",
                               hour.year, hour.month, hour.day, hour.hour, hour.direct / 2 + hour.diffuse,
                               hour.direct > 0 ? fmt::format("{}.0", hour.direct) : "-0.0", hour.diffuse);
          });
  return text +
         "\nT2m: 2-m air temperature (degree Celsius)\nRH: relative humidity (%)\n"
         "G(h): Global irradiance on the horizontal plane (W/m2)\n"
         "Gb(n): Beam/direct irradiance on a plane always normal to sun rays (W/m2)\n"
         "Gd(h): Diffuse irradiance on the horizontal plane (W/m2)\n\nPVGIS (c) European Union, 2001-2023\n";
}

Weather read(const std::string& text) {
  InputFile file(std::as_bytes(std::span(text)), "weather.csv");
  return Weather(file);
}

/// Every hour that a file has, by the clock of the file.
Sums sums_over_year(const Weather& weather, bool is_leap) {
  Sums sums;
  for_each_hour(is_leap, [&](const Hour& hour) {
    Moment moment =
        parse_date_time(fmt::format("2004-{:02}-{:02}T{:02}:00Z", hour.month, hour.day, hour.hour));
    moment.seconds += 600.0 - 3600.0 * weather.time_zone();
    const HourlyIrradiance& found = weather.at(moment);
    EXPECT_EQ(found.direct_normal, hour.direct) << hour.month << "/" << hour.day << " " << hour.hour;
    EXPECT_EQ(found.diffuse_horizontal, hour.diffuse) << hour.month << "/" << hour.day << " " << hour.hour;
    sums.direct += static_cast<long>(found.direct_normal);
    sums.diffuse += static_cast<long>(found.diffuse_horizontal);
  });
  return sums;
}

std::string with_crlf(const std::string& text) {
  std::string with;
  for (const char character : text) {
    if (character == '\n') with += '\r';
    with += character;
  }
  return with;
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), with);
}

std::string error_in(const std::string& text) {
  return test::error_of([&] { read(text); });
}

TEST(WeatherFile, of_every_published_form_has_the_sums_of_its_rows) {
  const Sums expected = sums_of_file(false);
  ASSERT_GT(expected.direct, 0);
  for (const std::string& text : {epw({}), tmy3(), pvgis()}) {
    for (const std::string& written : {text, with_crlf(text), "\xef\xbb\xbf" + text}) {
      const Weather weather = read(written);
      EXPECT_EQ(sums_over_year(weather, false), expected) << weather.format();
      EXPECT_EQ(weather.missing_hours(), 0u);
      EXPECT_EQ(weather.checksum(), read(text).checksum());
    }
  }
  EXPECT_EQ(read(tmy3()).longitude(), -160.517) << "a comma between quotes is no separator";
}

TEST(WeatherFile, of_epw_may_have_minute_0_or_60_a_leap_day_and_either_spelling_of_its_head) {
  const Weather usual = read(epw({}));
  EXPECT_EQ(read(epw({.minute = 0})).checksum(), usual.checksum());
  EXPECT_EQ(read(epw({.saving = "HOLIDAYS/DAYLIGHT SAVING"})).checksum(), usual.checksum());
  EXPECT_EQ(read(replaced(epw({}), "LOCATION", "Location")).checksum(), usual.checksum());
  const Weather leap = read(epw({.is_leap = true}));
  EXPECT_EQ(sums_over_year(leap, true), sums_of_file(true));
}

TEST(WeatherFile, of_epw_with_several_records_per_hour_has_their_means) {
  for (const int records : {2, 4})
    EXPECT_EQ(read(epw({.records = records})).checksum(), read(epw({})).checksum()) << records;
  const std::string text = epw({.records = 2});
  const std::string first = epw_row(hour_of(2007, 1, 1, 0), 60, 0, 0);
  EXPECT_NE(error_in(replaced(text, first, "")).find("line 10: the hour has not 2 records"),
            std::string::npos);
  const std::string last = epw_row(hour_of(2012, 12, 31, 23), 60, 0, 0);
  EXPECT_NE(
      error_in(text.substr(0, text.size() - last.size())).find("expected another record of the same hour"),
      std::string::npos);
}

TEST(WeatherFile, of_epw_has_no_light_where_it_is_missing_and_counts_these_hours) {
  const Hour noon = hour_of(2013, 6, 21, 12), next = hour_of(2013, 6, 21, 13);
  std::string text =
      replaced(epw({}), epw_row(noon, 60, noon.direct, noon.diffuse), epw_row(noon, 60, 9999, noon.diffuse));
  text = replaced(text, epw_row(next, 60, next.direct, next.diffuse), epw_row(next, 60, 9999, 99999));
  const Weather weather = read(text);
  EXPECT_EQ(weather.missing_hours(), 2u);
  const HourlyIrradiance& found = weather.at(parse_date_time("2026-06-21T12:30+01:00"));
  EXPECT_EQ(found.direct_normal, 0.0);
  EXPECT_EQ(found.diffuse_horizontal, noon.diffuse);
  EXPECT_EQ(weather.at(parse_date_time("2026-06-21T13:30+01:00")).diffuse_horizontal, 0.0);
  const std::string dark =
      epw_head({}) + rows(false, [](const Hour& hour) { return epw_row(hour, 60, 9999, 9999); });
  EXPECT_NE(error_in(dark).find("the weather has no irradiances"), std::string::npos) << error_in(dark);
}

TEST(WeatherFile, without_a_value_of_another_form_is_an_error) {
  const Hour noon = hour_of(2013, 6, 21, 12);
  const std::string values = fmt::format("{},2,13,{},1", noon.direct, noon.diffuse),
                    row = fmt::format("06/21/2013,13:00,0,1415,{},1,0,", noon.direct / 2 + noon.diffuse);
  const std::string message =
      error_in(replaced(tmy3(), row + values, row + fmt::format("-9900,2,13,{},1", noon.diffuse)));
  EXPECT_NE(message.find("invalid direct normal irradiance in column 8"), std::string::npos) << message;
}

TEST(WeatherFile, gives_steps_of_the_sun_all_of_its_energy) {
  // The file has light from 9:00 to 15:00, when the sun is up all year.
  const Sums expected = sums_of_file(false);
  for (const std::string& text : {epw({}), replaced(pvgis(), "Offset (h): 0.1761", "Offset (h): 0.5")}) {
    const Weather weather = read(text);
    SunSchedule schedule;
    schedule.latitude = weather.latitude();
    schedule.longitude = weather.longitude();
    schedule.step_minutes = 60.0;
    schedule.from = parse_date_time("2026-01-01T00:00Z");
    schedule.to = parse_date_time("2027-01-01T00:00Z");
    double direct = 0.0, diffuse = 0.0;
    for (const LitStep& step : lit_steps(schedule, sun_steps(schedule), {.weather = &weather})) {
      direct += step.hours * step.irradiance;
      diffuse += step.hours * step.diffuse;
    }
    EXPECT_NEAR(direct, static_cast<double>(expected.direct), 1e-3) << weather.format();
    EXPECT_NEAR(diffuse, static_cast<double>(expected.diffuse), 1e-3) << weather.format();
  }
}

}  // namespace
}  // namespace alidade::test
