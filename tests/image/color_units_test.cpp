// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cstdint>

#include "image/color_points.h"

namespace alidade {

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

}  // namespace
}  // namespace alidade
