// SPDX-License-Identifier: MIT
#include "extensions/radiation/weather.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "base/error.h"
#include "tests/cloud/cloud_test_support.h"

namespace alidade::test {

using namespace visibility;

namespace {

constexpr int k_days[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};

/// A line for every hour of a year: line(month, day, hour from 0, number of the hour).
std::string rows(const std::function<std::string(int, int, int, int)>& line, bool is_leap = false) {
  std::string text;
  int number = 0;
  for (int month = 1; month <= 12; ++month)
    for (int day = 1; day <= k_days[month - 1] + (is_leap && month == 2 ? 1 : 0); ++day)
      for (int hour = 0; hour < 24; ++hour) text += line(month, day, hour, number++) + "\n";
  return text;
}

constexpr const char* k_epw_head =
    "LOCATION,Munich,BY,DEU,IWEC,108660,48.13,11.70,1.0,529.0\n"
    "DESIGN CONDITIONS,0\nTYPICAL/EXTREME PERIODS,0\nGROUND TEMPERATURES,0\n"
    "HOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0\nCOMMENTS 1,a\nCOMMENTS 2,b\n"
    "DATA PERIODS,1,1,Data,Sunday,1/1,12/31\n";

std::string epw_row(int month, int day, int hour, double direct, double diffuse) {
  return fmt::format("1983,{},{},{},60,C9,1.0,0.5,90,96000,0,0,300,0,{},{},0,0,0,0", month, day, hour + 1,
                     direct, diffuse);
}

/// Direct: the number of the hour modulo 1000; diffuse: the hour of the day.
std::string epw(bool is_leap = false) {
  return k_epw_head + rows([](int month, int day, int hour,
                              int number) { return epw_row(month, day, hour, number % 1000, hour); },
                           is_leap);
}

Weather read(const std::string& text) {
  InputFile file(std::as_bytes(std::span(text)), "weather.epw");
  return Weather(file);
}

std::string error_in(const std::string& text) {
  return test::error_of([&] { read(text); });
}

void expect_error(const std::string& text, const std::string& part) {
  const std::string message = error_in(text);
  EXPECT_NE(message.find(part), std::string::npos) << part << " is not in: " << message;
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), with);
}

TEST(Weather, of_epw_is_in_local_standard_time_and_hours_end_at_their_number) {
  const Weather weather = read(epw());
  EXPECT_EQ(weather.format(), "EPW");
  EXPECT_EQ(weather.latitude(), 48.13);
  EXPECT_EQ(weather.longitude(), 11.70);
  EXPECT_EQ(weather.height(), 529.0);
  // Hour 1 of 1 January is from 0:00 to 1:00 in UTC +1, so from 23:00 of the day before.
  EXPECT_EQ(weather.at(parse_date_time("2025-12-31T23:00Z")).direct_normal, 0.0);
  EXPECT_EQ(weather.at(parse_date_time("2025-12-31T23:59:59Z")).direct_normal, 0.0);
  EXPECT_EQ(weather.at(parse_date_time("2026-01-01T00:00Z")).direct_normal, 1.0);
  EXPECT_EQ(weather.at(parse_date_time("2026-06-21T11:30+01:00")).diffuse_horizontal, 11.0);
  EXPECT_EQ(weather.at(parse_date_time("2026-12-31T22:59Z")).direct_normal, 8759 % 1000);
}

TEST(Weather, of_a_leap_day_is_that_of_the_day_before_unless_the_file_has_it) {
  const Weather usual = read(epw()), leap = read(epw(true));
  const Moment noon = parse_date_time("2028-02-29T12:30+01:00"),
               before = parse_date_time("2028-02-28T12:30+01:00"),
               after = parse_date_time("2028-03-01T12:30+01:00");
  EXPECT_EQ(usual.at(noon).direct_normal, usual.at(before).direct_normal);
  EXPECT_EQ(usual.at(after).direct_normal, usual.at(before).direct_normal + 24.0);
  EXPECT_EQ(leap.at(noon).direct_normal, leap.at(before).direct_normal + 24.0);
  EXPECT_EQ(leap.at(after).direct_normal, leap.at(before).direct_normal + 48.0);
  EXPECT_NE(usual.checksum(), leap.checksum());
}

TEST(Weather, of_tmy3_is_found_by_the_names_of_its_columns) {
  const std::string text =
      "723815,\"DAGGETT BARSTOW-DAGGETT AP\",CA,-8.0,34.850,-116.800,586\n"
      "Date (MM/DD/YYYY),Time (HH:MM),GHI (W/m^2),DHI (W/m^2),DNI (W/m^2)\n" +
      rows([](int month, int day, int hour, int number) {
        return fmt::format("{:02}/{:02}/1988,{:02}:00,9,{},{}", month, day, hour + 1, hour, number % 1000);
      });
  const Weather weather = read(text);
  EXPECT_EQ(weather.format(), "TMY3");
  EXPECT_EQ(weather.time_zone(), -8.0);
  EXPECT_EQ(weather.longitude(), -116.8);
  EXPECT_EQ(weather.at(parse_date_time("2026-01-01T08:30Z")).direct_normal, 0.0);
  EXPECT_EQ(weather.at(parse_date_time("2026-06-21T11:30-08:00")).diffuse_horizontal, 11.0);
  expect_error(replaced(text, "DNI (W/m^2)", "DNI"), "line 2: missing column; expected DNI (W/m^2)");
  expect_error(replaced(text, "01/01/1988,02:00", "01/01/1988,02:30"),
               "line 4: invalid time; expected HH:00");
  expect_error(replaced(text, "01/01/1988,02:00", "1/1/1988,02:00"),
               "line 4: invalid date; expected MM/DD/YYYY");
}

TEST(Weather, of_pvgis_is_in_utc_and_hours_begin_at_their_time) {
  const std::string text =
      "Latitude (decimal degrees): 45.000\nLongitude (decimal degrees): 8.000\nElevation (m): 250.0\n"
      "Irradiance Time Offset (h): 0.1761\nmonth,year\n1,2007\n"
      "time(UTC),T2m,RH,G(h),Gb(n),Gd(h),IR(h)\n" +
      rows([](int month, int day, int hour, int number) {
        return fmt::format("2007{:02}{:02}:{:02}00,1,90,9,{},{},300", month, day, hour, number % 1000, hour);
      }) +
      "\nT2m: 2-m air temperature (degree Celsius)\n";
  const Weather weather = read(text);
  EXPECT_EQ(weather.format(), "PVGIS");
  EXPECT_EQ(weather.latitude(), 45.0);
  EXPECT_EQ(weather.height(), 250.0);
  EXPECT_EQ(weather.at(parse_date_time("2026-01-01T00:30Z")).direct_normal, 0.0);
  EXPECT_EQ(weather.at(parse_date_time("2026-06-21T11:30Z")).diffuse_horizontal, 11.0);
  // Around ten minutes past the hour, or from the hour on.
  EXPECT_EQ(weather.at(parse_date_time("2026-06-21T11:45Z")).diffuse_horizontal, 12.0);
  EXPECT_EQ(weather.at(parse_date_time("2026-12-31T23:45Z")).diffuse_horizontal, 0.0);
  const Weather plain = read(replaced(text, "Irradiance Time Offset (h): 0.1761\n", ""));
  EXPECT_EQ(plain.at(parse_date_time("2026-06-21T11:45Z")).diffuse_horizontal, 11.0);
  EXPECT_NE(plain.checksum(), weather.checksum());
  expect_error(replaced(text, "0.1761", "x"), "line 4: invalid time offset");
  expect_error(replaced(text, "Gb(n)", "Gb(i)"), "line 7: missing column; expected Gb(n)");
  expect_error(replaced(text, "Longitude (dec", "Lon (dec"), "line 2: wrong line of the PVGIS head");
}

TEST(Weather, that_is_cut_or_out_of_order_is_an_error_with_its_line) {
  const std::string text = epw();
  const auto without = [&](const std::string& line) { return replaced(text, line + "\n", ""); };
  expect_error(without(epw_row(1, 1, 2, 2, 2)),
               "weather.epw:line 11: the hours do not follow each other; expected the hour from 2:00 of "
               "month 1, day 1, "
               "found the hour from 3:00 of month 1, day 1");
  expect_error(replaced(text, epw_row(1, 1, 2, 2, 2) + "\n" + epw_row(1, 1, 3, 3, 3),
                        epw_row(1, 1, 3, 3, 3) + "\n" + epw_row(1, 1, 2, 2, 2)),
               "line 11: the hours do not follow");
  expect_error(text.substr(0, text.find("1983,6,1,1,")),
               "the weather ends early; expected a year of 8760 or 8784 hours, "
               "found 3624 hours");
  expect_error(text + epw_row(1, 1, 0, 0, 0) + "\n", "expected the end after one year");
  expect_error(text.substr(0, text.find("COMMENTS 2")), "the file ends early; expected COMMENTS 2");
  expect_error(without("GROUND TEMPERATURES,0"),
               "line 4: wrong line of the EPW head; expected GROUND TEMPERATURES");
  // Cut within a row.
  expect_error(text.substr(0, text.size() - 25), "too few columns");
  for (std::size_t size = 0; size < 600; ++size) EXPECT_NE(error_in(text.substr(0, size)), "") << size;
}

TEST(Weather, with_wrong_numbers_is_an_error_that_names_them) {
  const std::string text = epw();
  const auto with = [&](const std::string& row) { return replaced(text, epw_row(1, 1, 3, 3, 3), row); };
  expect_error(with(epw_row(1, 1, 3, 2001, 3)),
               "line 12: invalid direct normal irradiance in column 15; expected a number from 0 to 2000, "
               "found \"2001\"");
  expect_error(with(epw_row(1, 1, 3, 3, -1)), "invalid diffuse horizontal irradiance in column 16");
  expect_error(with(epw_row(1, 1, 3, NAN, 3)), "found \"nan\"");
  expect_error(with("1983,1,1,25,60,a,0,0,0,0,0,0,0,0,1,1"),
               "invalid hour; expected a whole number from 1 to 24");
  expect_error(with("1983,13,1,4,60,a,0,0,0,0,0,0,0,0,1,1"), "invalid month");
  expect_error(with("1983,2,30,4,60,a,0,0,0,0,0,0,0,0,1,1"), "no such day");
  expect_error(replaced(text, "PERIODS,1,1,", "PERIODS,1,61,"), "line 8: invalid number of records per hour");
  expect_error(replaced(text, "PERIODS,1,1,", "PERIODS,1,4,"), "line 10: the hour has not 4 records");
  expect_error(replaced(text, "48.13", "148.13"), "line 1: invalid latitude in column 7");
  expect_error("", "the file ends early; expected an EPW, TMY3 or PVGIS file");
  expect_error("x,y\n1,2\n", "line 1: unknown weather file");
}

}  // namespace
}  // namespace alidade::test
