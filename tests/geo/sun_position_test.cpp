// SPDX-License-Identifier: MIT
#include "geo/sun.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"

// Published positions and times of the sun, none of them computed by this project.

namespace alidade {

using namespace geo;

namespace {

SunPosition at(const char* date_time, const SunObserver& observer) {
  return sun_position(parse_date_time(date_time), observer);
}

/// Without air, to compare with geometry.
SunObserver observer(double latitude, double longitude) {
  return {.latitude = latitude, .longitude = longitude, .pressure = 0.0};
}

/// The highest position of the sun on a day of UTC, to the minute.
SunPosition highest(const char* day, const SunObserver& observer) {
  Moment moment = parse_date_time(std::string(day) + "T00:00Z");
  SunPosition best{.elevation = -91.0};
  for (; moment.seconds < 86400.0; moment.seconds += 60.0) {
    const SunPosition position = sun_position(moment, observer);
    if (position.elevation > best.elevation) best = position;
  }
  return best;
}

TEST(SunPosition, is_that_of_the_published_example) {
  // Reda and Andreas 2003, appendix A.5: azimuth 194.340241, zenith 50.111622, elevation without refraction
  // 39.872046.
  const SunObserver golden{.latitude = 39.742476,
                           .longitude = -105.1786,
                           .height = 1830.14,
                           .pressure = 820.0,
                           .temperature = 11.0};
  const SunPosition position = sun_position(parse_date_time("2003-10-17T12:30:30-07:00"), golden, 67.0);
  EXPECT_NEAR(position.azimuth, 194.340241, 1e-4);
  EXPECT_NEAR(90.0 - position.elevation, 50.111622, 1e-4);
  EXPECT_NEAR(position.geometric_elevation, 39.872046, 1e-4);
  const SunPosition with_own_delta_t = at("2003-10-17T12:30:30-07:00", golden);
  EXPECT_NEAR(with_own_delta_t.azimuth, 194.340241, 1e-3);
  EXPECT_NEAR(90.0 - with_own_delta_t.elevation, 50.111622, 1e-3);
}

/// The latitude with the sun in the zenith: seen from the poles its elevation is the declination.
double declination(const char* date_time) {
  // Parallax lifts the sun as seen from the south pole and lowers it from the north pole, by up to 0.0025.
  return 0.5 * (at(date_time, observer(90, 0)).geometric_elevation -
                at(date_time, observer(-90, 0)).geometric_elevation);
}

TEST(SunPosition, crosses_the_equator_at_the_published_equinoxes) {
  // US Naval Observatory and Meeus' tables, to the minute; the sun's declination changes by 0.00027 degrees
  // in one. The years reach before 1970 and beyond 2050.
  for (const char* const equinox :
       {"1900-03-21T01:39Z", "1950-03-21T04:35Z", "1962-09-23T12:35Z", "2000-03-20T07:35Z",
        "2024-03-20T03:06Z", "2024-09-22T12:44Z", "2050-03-20T10:19Z", "2100-03-20T13:04Z"})
    EXPECT_NEAR(declination(equinox), 0.0, 6e-4) << equinox;
}

TEST(SunPosition, is_farthest_from_the_equator_at_the_published_solstices) {
  // Mean obliquity: 23.43929 degrees in 2000, 0.01300 less each century (IAU 1980); nutation adds up to
  // 0.0026.
  EXPECT_NEAR(declination("2024-06-20T20:51Z"), 23.43611, 3e-3);
  EXPECT_NEAR(declination("2024-12-21T09:21Z"), -23.43611, 3e-3);
  EXPECT_NEAR(declination("1962-06-21T21:24Z"), 23.44417, 3e-3);
  for (const char* const solstice : {"1962-06-21T21:24:07Z", "2024-06-20T20:51Z"}) {
    Moment before = parse_date_time(solstice), after = before;
    before.day -= std::chrono::days(20);
    after.day += std::chrono::days(20);
    const SunObserver pole = observer(90, 0);
    EXPECT_LT(sun_position(before, pole).elevation, declination(solstice) - 1.0);
    EXPECT_LT(sun_position(after, pole).elevation, declination(solstice) - 1.0);
  }
}

TEST(SunPosition, at_noon_is_as_high_as_latitude_and_declination_give) {
  EXPECT_NEAR(highest("2024-03-20", observer(48.0, 11.5)).elevation, 90.0 - 48.0, 0.2);
  EXPECT_NEAR(highest("2024-06-20", observer(48.0, 11.5)).elevation, 90.0 - 48.0 + 23.4385, 0.005);
  EXPECT_NEAR(highest("2024-12-21", observer(48.0, 11.5)).elevation, 90.0 - 48.0 - 23.4385, 0.006);
  // On the tropic the sun of midsummer is overhead.
  EXPECT_GT(highest("2024-06-20", observer(23.4385, 0.0)).elevation, 89.8);
}

TEST(SunPosition, at_noon_is_in_the_south_north_of_the_tropics_and_in_the_north_south_of_them) {
  EXPECT_NEAR(highest("2024-06-20", observer(48.0, 11.5)).azimuth, 180.0, 1.0);
  const double in_sydney = highest("2024-06-20", observer(-33.87, 151.21)).azimuth;
  EXPECT_NEAR(std::min(in_sydney, 360.0 - in_sydney), 0.0, 1.0);
  // Mornings are in the east and evenings in the west everywhere.
  EXPECT_NEAR(at("2024-03-20T06:00+10:00", observer(-33.87, 151.21)).azimuth, 90.0, 3.0);
  EXPECT_NEAR(at("2024-03-20T18:00+10:00", observer(-33.87, 151.21)).azimuth, 270.0, 3.0);
  EXPECT_NEAR(at("2024-03-20T06:20+01:00", observer(48.0, 11.5)).azimuth, 90.0, 3.0);
}

TEST(SunPosition, does_not_rise_in_the_polar_night_nor_set_at_midsummer) {
  // Longyearbyen.
  const SunObserver svalbard{.latitude = 78.22, .longitude = 15.63};
  EXPECT_LT(highest("2024-12-21", svalbard).elevation, -11.0);
  Moment moment = parse_date_time("2024-06-20T00:00Z");
  for (; moment.seconds < 86400.0; moment.seconds += 600.0)
    EXPECT_GT(sun_position(moment, svalbard).elevation, 11.0);
}

TEST(SunPosition, air_lifts_the_setting_sun_by_its_own_size) {
  // At the horizon refraction is 34 arc minutes (0.567 degrees) in standard air; overhead it is zero.
  SunObserver equator{.latitude = 0.0, .longitude = 0.0, .pressure = 1010.0, .temperature = 10.0};
  Moment moment = parse_date_time("2024-03-20T17:00Z");
  SunPosition sunset;
  for (; moment.seconds < 86400.0; moment.seconds += 1.0) {
    sunset = sun_position(moment, equator);
    if (sunset.elevation < 0.0) break;
  }
  EXPECT_NEAR(sunset.elevation - sunset.geometric_elevation, 0.567, 0.05);
  equator.pressure = 0.0;
  const SunPosition airless = sun_position(moment, equator);
  EXPECT_EQ(airless.elevation, airless.geometric_elevation);
  equator.pressure = 1010.0;
  const SunPosition noon = at("2024-03-20T12:07Z", equator);
  EXPECT_NEAR(noon.elevation, noon.geometric_elevation, 2e-3);
}

TEST(SunPosition, refraction_goes_with_the_density_of_the_air) {
  // Density goes with 1 / absolute temperature; 0.1 % are for formulas that round 273.15 K to 273.
  SunObserver cold{.latitude = 48.0, .longitude = 11.5, .temperature = -30.0}, mild = cold, hot = cold;
  mild.temperature = 10.0;
  hot.temperature = 40.0;
  const auto lift = [](const SunObserver& observer) {
    const SunPosition position = at("2024-03-20T06:30Z", observer);
    return position.elevation - position.geometric_elevation;
  };
  EXPECT_NEAR(lift(cold) / lift(mild), 283.15 / 243.15, 1e-3);
  EXPECT_NEAR(lift(hot) / lift(mild), 283.15 / 313.15, 1e-3);
}

TEST(SunPosition, a_minute_of_delta_t_moves_the_sun_by_two_arc_seconds) {
  const Moment moment = parse_date_time("2024-03-20T12:00Z");
  const double difference = std::fabs(sun_position(moment, observer(90, 0), 0.0).elevation -
                                      sun_position(moment, observer(90, 0), 60.0).elevation);
  EXPECT_NEAR(difference, 60.0 * 0.9856 / 86400.0 * std::sin(23.44 * 3.14159265 / 180.0), 2e-5);
}

TEST(DeltaT, is_that_of_the_published_tables) {
  // Espenak and Meeus 2006, table 1; forecasts behind 2005.
  const std::pair<double, double> published[] = {{1600, 120},  {1700, 9},    {1800, 14},   {1900, -3},
                                                 {1950, 29},   {1955, 31.1}, {1970, 40.2}, {1975, 45.5},
                                                 {1980, 50.5}, {1990, 56.9}, {2000, 63.8}, {2005, 64.7},
                                                 {2050, 93},   {2100, 203},  {2500, 1460}};
  for (const auto& [year, seconds] : published)
    EXPECT_NEAR(delta_t(year), seconds, std::max(0.6, 0.005 * seconds)) << year;
}

TEST(DeltaT, has_no_steps_between_its_pieces) {
  for (const double year : {1700, 1800, 1860, 1900, 1920, 1941, 1961, 1986, 2005, 2050, 2150})
    EXPECT_NEAR(delta_t(year - 1e-6), delta_t(year), 0.9) << year;
}

TEST(DateTime, is_the_same_moment_in_every_zone) {
  const Moment moment = parse_date_time("2003-10-17T19:30:30Z");
  for (const char* const text : {"2003-10-17T12:30:30-07:00", "2003-10-18T04:30:30+09:00",
                                 "2003-10-17T19:30:30.000+00:00", "2003-10-18T01:15:30+05:45"})
    EXPECT_EQ(parse_date_time(text), moment) << text;
  EXPECT_DOUBLE_EQ(julian_day(moment), 2452930.312847222);
  EXPECT_DOUBLE_EQ(julian_day(parse_date_time("2000-01-01T12:00Z")), 2451545.0);
  EXPECT_EQ(date_time_text(moment), "2003-10-17T19:30:30Z");
  EXPECT_EQ(date_time_text(parse_date_time("1999-12-31T23:59:59.25-01:00")), "2000-01-01T00:59:59.25Z");
  EXPECT_EQ(date_time_text(parse_date_time("2024-03-01T00:30+01:00")), "2024-02-29T23:30:00Z");
  EXPECT_DOUBLE_EQ(decimal_year(parse_date_time("2003-07-02T12:00Z")), 2003.5);
}

TEST(DateTime, what_is_no_moment_is_an_error_that_explains) {
  const auto message = [](const std::string& text) -> std::string {
    try {
      parse_date_time(text);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_TRUE(message("2026-06-21T12:00:00").starts_with("missing time zone; expected Z"))
      << message("2026-06-21T12:00:00");
  EXPECT_TRUE(message("2026-02-29T12:00Z").starts_with("invalid date"));
  EXPECT_TRUE(message("2026-13-01T12:00Z").starts_with("invalid date"));
  EXPECT_TRUE(message("2026-06-21T24:00Z").starts_with("invalid time"));
  EXPECT_TRUE(message("2026-06-21T12:60Z").starts_with("invalid time"));
  EXPECT_TRUE(message("2026-06-21T12:00:60Z").starts_with("invalid time"));
  EXPECT_TRUE(message("2026-06-21T12:00+24:00").starts_with("invalid time zone"));
  for (const char* const text :
       {"", "2026", "2026-06-21", "2026-06-21 12:00Z", "21.06.2026T12:00Z", "2026-6-21T12:00Z",
        "2026-06-21T12Z", "2026-06-21T12:00:00.Z", "2026-06-21T12:00:00.0000000001Z", "2026-06-21T12:00z",
        "2026-06-21T12:00+2", "2026-06-21T12:00+0200", "2026-06-21T12:00Zulu", "1599-12-31T12:00Z",
        "3000-01-01T00:00Z", "-200-01-01T00:00Z",
        "2026-06-21T12:00\xE2\x88\x92"
        "07:00"})
    EXPECT_TRUE(message(text).starts_with("invalid date and time; expected one like")) << text;
  EXPECT_LT(message(std::string(1'000'000, '2')).size(), 300u);
}

TEST(ClearSky, dims_and_reddens_the_sun_towards_the_horizon) {
  // Kasten and Young 1989, table II: relative optical air mass by elevation, which their formula meets within
  // 0.5 %.
  EXPECT_NEAR(air_mass(90.0), 1.0, 1e-3);
  EXPECT_NEAR(air_mass(30.0), 1.9939, 2e-3);
  EXPECT_NEAR(air_mass(10.0), 5.5803, 6e-3);
  EXPECT_NEAR(air_mass(0.0), 38.0868, 0.2);
  Rgb above = clear_sky_irradiance(90.0, 1013.25);
  for (const double elevation : {60.0, 40.0, 20.0, 10.0, 5.0, 1.0, 0.0}) {
    const Rgb here = clear_sky_irradiance(elevation, 1013.25);
    EXPECT_LT(here.r, above.r) << elevation;
    EXPECT_LE(here.b / here.r, above.b / above.r) << elevation;
    above = here;
  }
  EXPECT_EQ(clear_sky_irradiance(-0.001, 1013.25), Rgb(0.0f));
  EXPECT_EQ(clear_sky_irradiance(30.0, 0.0), Rgb(4.0f));
  EXPECT_GT(clear_sky_irradiance(30.0, 500.0).b, clear_sky_irradiance(30.0, 1013.25).b);
}

}  // namespace
}  // namespace alidade
