// SPDX-License-Identifier: MIT
#include "visibility/observers.h"

#include <gtest/gtest.h>

#include "tests/support/random.h"
#include "tests/visibility/wall_cloud.h"

namespace alidade::test {

using namespace visibility;

namespace {

/// Ground, and a bush of points without a surface.
WallCloud garden() {
  Random random("garden");
  WallCloud cloud;
  cloud.add({0, 0, 0}, {20, 0, 0}, {0, 20, 0}, 0.25);
  for (int i = 0; i < 500; ++i) cloud.add(glm::dvec3(10, 10, 2) + random.in_cube());
  return cloud;
}

std::string remark_on(const Occluders& occluders, const glm::dvec3& position,
                      double max_distance = HUGE_VAL) {
  Observer observer;
  observer.name = "mast";
  observer.position = position;
  observer.max_distance = max_distance;
  const auto remarks = observer_remarks(occluders, std::span(&observer, 1));
  return remarks.empty() ? "" : remarks[0];
}

TEST(ObserverRemarks, say_nothing_of_usual_observers) {
  const Occluders occluders = garden().occluders();
  EXPECT_EQ(remark_on(occluders, {5, 5, 1.7}), "");
  EXPECT_EQ(remark_on(occluders, {-15, 5, 10}, 30.0), "");
  EXPECT_EQ(remark_on(occluders, {5, 5, 0.05}), "") << "just above the ground";
}

TEST(ObserverRemarks, name_observers_far_outside_and_those_who_cannot_reach_the_cloud) {
  const Occluders occluders = garden().occluders();
  EXPECT_NE(remark_on(occluders, {5, 500, 2}).find("mast is 480 outside the cloud"), std::string::npos)
      << remark_on(occluders, {5, 500, 2});
  EXPECT_NE(remark_on(occluders, {5, 25, 2}, 4.0).find("mast sees nothing"), std::string::npos);
  EXPECT_EQ(remark_on(occluders, {5, 25, 2}, 5.5), "");
}

TEST(ObserverRemarks, name_observers_below_the_ground) {
  const Occluders occluders = garden().occluders();
  EXPECT_NE(remark_on(occluders, {5, 5, -0.3}).find("is below all points near it"), std::string::npos);
  EXPECT_EQ(remark_on(occluders, {50, 5, -0.3}, 100.0).find("is below all points near it"), std::string::npos)
      << "nothing is near";
}

TEST(ObserverRemarks, leave_alone_observers_put_on_ground_below_a_roof) {
  Observer observer;
  observer.name = "mast";
  observer.position = {5, 5, -0.3};
  observer.stands_on_ground = true;
  EXPECT_TRUE(observer_remarks(garden().occluders(), std::span(&observer, 1)).empty());
}

TEST(ObserverRemarks, name_observers_inside_the_sphere_of_a_point) {
  const WallCloud cloud = garden();
  const glm::dvec3 leaf = cloud.positions().back() + glm::dvec3(0.01, 0, 0);
  EXPECT_NE(remark_on(cloud.occluders(), leaf).find("mast is inside point "), std::string::npos);
  EXPECT_EQ(remark_on(cloud.occluders({.shape = OccluderShape::disc}), leaf), "");
  EXPECT_NE(
      remark_on(cloud.occluders({.shape = OccluderShape::sphere, .radius = 0.5}), {5, 5, 0.4}).find("inside"),
      std::string::npos);
  EXPECT_EQ(remark_on(cloud.occluders({.shape = OccluderShape::sphere, .radius = 0.5}), {5, 5, 0.7}), "");
}

TEST(ObserverRemarks, name_observers_close_to_a_wide_disc) {
  WallCloud cloud;
  cloud.add({0, 0, 0}, {0, 20, 0}, {0, 0, 20}, 1.5);
  const Occluders occluders = cloud.occluders();
  const std::string remark = remark_on(occluders, {0.005, 10.2, 10.1});
  EXPECT_NE(remark.find("mast is 0.005 from the disc of point "), std::string::npos) << remark;
  EXPECT_EQ(remark_on(occluders, {0.4, 10.2, 10.1}), "");
}

TEST(ObserverRemarks, name_observers_below_a_terrain_and_far_outside_of_it) {
  OccluderOptions options;
  options.terrain =
      std::make_shared<const geo::TerrainSurface>(geo::Raster<float>({{-500, 500}, 10.0, 100, 100}, 7.0f));
  const Occluders alone(build(PointCloud()), options), beside = garden().occluders(options);
  for (const Occluders& occluders : {alone, beside}) {
    EXPECT_EQ(remark_on(occluders, {-400, 0, 6.9}), "mast is below the surface of the raster");
    EXPECT_EQ(remark_on(occluders, {-400, 0, 6.9995}), "") << "on it";
    EXPECT_EQ(remark_on(occluders, {-400, 0, 9}, 10.0), "");
  }
  EXPECT_EQ(remark_on(alone, {9000, 0, 9}), "mast is 8505 outside the raster; check its reference system");
  EXPECT_EQ(remark_on(alone, {600, 0, 9}, 50.0),
            "mast sees nothing: the raster is 105.019 away, beyond the maximum distance 50");
}

}  // namespace
}  // namespace alidade::test
