// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cstdint>

#include "geo/map_unit.h"
#include "image/color_points.h"
#include "tests/cloud/crs_of_keys.h"

namespace alidade {

using namespace geo;
using namespace image;

namespace {

TEST(GpsDateTest, adjusted_time_counts_from_a_billion_seconds_after_the_beginning_of_1980s_gps) {
  EXPECT_EQ(gps_date(-1'000'000'000), "1980-01-06 00:00:00");
  EXPECT_EQ(gps_date(0), "2011-09-14 01:46:40");
  EXPECT_EQ(gps_date(-1'000'000'001), "1980-01-05 23:59:59");
  EXPECT_EQ(gps_date(172'799 - 100'000'000), "2008-07-15 15:59:59");
  // Before 1970, from which days are counted.
  EXPECT_EQ(gps_date(-1'315'964'801), "1969-12-31 23:59:59");
  EXPECT_EQ(gps_date(-1'373'982'400), "1968-02-29 12:00:00");
  EXPECT_EQ(gps_date(1'000'000'000'000), std::nullopt);
  EXPECT_EQ(gps_date(INT64_MIN), std::nullopt);
  EXPECT_EQ(gps_date(INT64_MAX), std::nullopt);
}

TEST(GpsDateTest, weeks_begin_on_sunday) {
  EXPECT_EQ(gps_weekday(0), "Sunday 00:00:00");
  EXPECT_EQ(gps_weekday(604799), "Saturday 23:59:59");
  EXPECT_EQ(gps_weekday(86400 + 3661), "Monday 01:01:01");
  EXPECT_EQ(gps_weekday(-1), std::nullopt);
  EXPECT_EQ(gps_weekday(604800), std::nullopt);
}

TEST(HeightUnitTest, the_vertical_system_counts_else_the_horizontal_one) {
  const auto of_wkt = [](const char* wkt) { return height_unit(crs_of_wkt(wkt)); };
  EXPECT_EQ(height_unit(Crs()), "m");
  EXPECT_EQ(of_wkt(R"(PROJCS["x",GEOGCS["y",UNIT["degree",0.0174]],UNIT["metre",1]])"), "m");
  EXPECT_EQ(of_wkt(R"(PROJCS["x",GEOGCS["y",UNIT["degree",0.0174]],UNIT["US survey foot",0.3048]])"), "ft");
  EXPECT_EQ(
      of_wkt(
          R"(COMPD_CS["a",PROJCS["x",UNIT["US survey foot",0.304800609601219]],VERT_CS["h",UNIT["metre",1]]])"),
      "m");
  EXPECT_EQ(
      of_wkt(R"(COMPOUNDCRS["a",PROJCRS["x",LENGTHUNIT["metre",1]],VERTCRS["h",LENGTHUNIT["foot",0.3048]]])"),
      "ft");
  EXPECT_EQ(of_wkt(R"(GEOGCS["y",UNIT["degree",0.0174]])"), "m");
  EXPECT_EQ(of_wkt(R"(LOCAL_CS["y",UNIT["furlong",201.168]])"), "");
  EXPECT_EQ(of_wkt("UNIT[\"met"), "");
  // A vertical part without a known unit does not take that of x and y.
  EXPECT_EQ(of_wkt(R"(COMPD_CS["a",PROJCS["x",UNIT["metre",1]],VERT_CS["h",UNIT["furlong",201.168]]])"), "");
  EXPECT_EQ(of_wkt(R"(COMPD_CS["a",PROJCS["x",UNIT["metre",1]],VERT_CS["h",VERT_DATUM["d",2005]]])"), "");
  EXPECT_EQ(height_unit(test::crs_of_keys({3076, 9003})), "ft");
  EXPECT_EQ(height_unit(test::crs_of_keys({3076, 9003, 4099, 9001})), "m");
  for (const std::uint16_t unknown : {9005, 32767})
    EXPECT_EQ(height_unit(test::crs_of_keys({3076, 9001, 4099, unknown})), "") << unknown;
  EXPECT_EQ(height_unit(test::crs_of_keys({3076, 9001, 4096, 32767})), "");
  EXPECT_EQ(height_unit(test::crs_of_keys({3072, 2229})), "");
}

}  // namespace
}  // namespace alidade
