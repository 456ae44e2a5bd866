// SPDX-License-Identifier: MIT
#include "visibility/observers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/error.h"

namespace alidade::test {

using namespace visibility;

namespace {

std::optional<double> flat_ground(const glm::dvec2& position) {
  if (std::fabs(position.x) > 100.0) return {};
  return 5.0;
}

glm::dvec3 direction(double azimuth, double elevation) {
  const double a = azimuth * std::numbers::pi / 180.0, e = elevation * std::numbers::pi / 180.0;
  return {std::cos(e) * std::sin(a), std::cos(e) * std::cos(a), std::sin(e)};
}

std::string problem_of(const GivenObserver& given) {
  try {
    place_observers(std::span(&given, 1), {}, flat_ground);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Observers, position_from_the_command_line_has_two_or_three_numbers) {
  EXPECT_EQ(parse_observer("1,2.5,-3").position, glm::dvec2(1.0, 2.5));
  EXPECT_EQ(parse_observer("1,2.5,-3").z, -3.0);
  EXPECT_EQ(parse_observer(" 690000.25 , 5325000").position, glm::dvec2(690000.25, 5325000.0));
  EXPECT_FALSE(parse_observer("1,2").z);
  for (const char* const wrong : {"", "1", "1,", "1,2,3,4", "a,2,3", "1,2,nan", "inf,2,3", "1;2;3", "1,2,3x"})
    EXPECT_THROW(parse_observer(wrong), Error) << wrong;
}

TEST(Observers, observer_with_z_is_there_and_height_is_added) {
  const std::vector<GivenObserver> given = {
      {.source = "a", .position = {1, 2}, .z = 3.0},
      {.source = "b", .name = "mast", .position = {1, 2}, .z = 3.0, .height = 10.0}};
  const std::vector<Observer> observers = place_observers(given, {}, flat_ground);
  EXPECT_EQ(observers[0].position, glm::dvec3(1, 2, 3));
  EXPECT_FALSE(observers[0].stands_on_ground);
  EXPECT_EQ(observers[0].name, "observer 1");
  EXPECT_EQ(observers[1].position, glm::dvec3(1, 2, 13));
  EXPECT_EQ(observers[1].height, 10.0);
  EXPECT_EQ(observers[1].name, "mast");
}

TEST(Observers, observer_without_z_is_two_metres_above_the_ground) {
  const std::vector<GivenObserver> given = {{.source = "a", .position = {1, 2}}};
  EXPECT_EQ(place_observers(given, {}, flat_ground)[0].position, glm::dvec3(1, 2, 7));
  EXPECT_TRUE(place_observers(given, {}, flat_ground)[0].stands_on_ground);
  EXPECT_EQ(place_observers(given, {.height = 0.5}, flat_ground)[0].position, glm::dvec3(1, 2, 5.5));
}

TEST(Observers, observer_without_ground_below_is_an_error) {
  EXPECT_NE(problem_of({.source = "poles.csv:3", .position = {101, 0}}).find("poles.csv:3: "),
            std::string::npos);
  EXPECT_EQ(problem_of({.source = "poles.csv:3", .position = {101, 0}, .z = 1.0}), "");
}

TEST(Observers, values_of_an_observer_override_the_defaults) {
  const std::vector<GivenObserver> given = {
      {.source = "a", .position = {0, 0}, .z = 0.0, .azimuth_min = 10.0, .max_distance = 7.0}};
  const ObserverDefaults defaults{
      .height = 1.5, .azimuth_min = 20.0, .azimuth_max = 30.0, .max_distance = 9.0};
  const Observer observer = place_observers(given, defaults, flat_ground)[0];
  EXPECT_EQ(observer.azimuth_min, 10.0);
  EXPECT_EQ(observer.azimuth_max, 30.0);
  EXPECT_EQ(observer.max_distance, 7.0);
  EXPECT_EQ(observer.position.z, 1.5);
}

TEST(Observers, values_out_of_range_are_errors_naming_the_source) {
  const GivenObserver good{.source = "f.csv:2", .position = {0, 0}, .z = 0.0};
  EXPECT_EQ(problem_of(good), "");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<GivenObserver> wrong(12, good);
  wrong[0].height = -1.0;
  wrong[1].max_distance = -1.0;
  wrong[2].azimuth_min = nan;
  wrong[3].azimuth_max = 721.0;
  wrong[4].elevation_min = -91.0;
  wrong[5].elevation_max = nan;
  wrong[6].azimuth_min = 40.0, wrong[6].azimuth_max = 40.0;
  wrong[7].elevation_min = 2.0, wrong[7].elevation_max = 1.0;
  wrong[8].z = nan;
  wrong[9].position.y = nan;
  wrong[10].position.x = 1e13;
  wrong[11].z = -1e300;
  for (const GivenObserver& one : wrong)
    EXPECT_EQ(problem_of(one).rfind("f.csv:2: ", 0), 0u) << &one - wrong.data() << problem_of(one);
}

TEST(FieldOfView, default_is_everything) {
  const FieldOfView view{Observer{}};
  EXPECT_TRUE(view.is_everything());
  for (int azimuth = 0; azimuth < 360; azimuth += 7)
    EXPECT_TRUE(view.contains(direction(azimuth, azimuth / 4 - 45)));
}

TEST(FieldOfView, azimuths_run_clockwise_from_north_and_across_it) {
  const std::vector<std::pair<double, double>> ranges = {{0, 90},    {350, 10}, {-10, 10},  {90, 270},
                                                         {270, 90},  {10, 350}, {180, 540}, {45, 46},
                                                         {200, 170}, {0, 180.5}};
  for (const auto& [from, to] : ranges) {
    Observer observer;
    observer.azimuth_min = from;
    observer.azimuth_max = to;
    const FieldOfView view(observer);
    double width = to - from;
    if (width < 0.0) width += 360.0;
    for (double azimuth = 0.25; azimuth < 360.0; azimuth += 0.5) {
      const double behind = std::fmod(azimuth - from + 720.0, 360.0);
      EXPECT_EQ(view.contains(100.0 * direction(azimuth, 20.0)), behind <= width)
          << from << " " << to << " " << azimuth;
    }
    EXPECT_TRUE(view.contains({0, 0, 3})) << "straight up has every azimuth";
  }
}

TEST(FieldOfView, limits_are_inside) {
  Observer observer;
  observer.azimuth_min = 0.0;
  observer.azimuth_max = 90.0;
  observer.elevation_min = 0.0;
  observer.elevation_max = 45.0;
  const FieldOfView view(observer);
  EXPECT_TRUE(view.contains({0, 5, 0}));
  EXPECT_TRUE(view.contains({5, 0, 0}));
  EXPECT_FALSE(view.contains({-1e-9, 5, 0}));
  EXPECT_FALSE(view.contains({5, -1e-9, 0}));
  EXPECT_FALSE(view.contains({3, 4, -1e-9}));
  EXPECT_TRUE(view.contains({3, 4, 4.999999999}));
  EXPECT_FALSE(view.contains({3, 4, 5.000000001}));
}

TEST(FieldOfView, elevations_reach_from_nadir_to_zenith) {
  Observer observer;
  observer.elevation_min = -90.0;
  observer.elevation_max = -30.0;
  const FieldOfView down(observer);
  EXPECT_TRUE(down.contains({0, 0, -1}));
  EXPECT_FALSE(down.contains({0, 0, 1}));
  for (double elevation = -89.75; elevation < 90.0; elevation += 0.5)
    EXPECT_EQ(down.contains(direction(77.0, elevation)), elevation <= -30.0) << elevation;
}

}  // namespace
}  // namespace alidade::test
