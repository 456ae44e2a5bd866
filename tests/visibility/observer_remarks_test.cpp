// SPDX-License-Identifier: MIT
#include "visibility/observers.h"

#include <gtest/gtest.h>

#include <atomic>
#include <vector>

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

/// Ground with a roof 5 above its middle part.
WallCloud roofed() {
  WallCloud cloud;
  cloud.add({0, 0, 0}, {20, 0, 0}, {0, 20, 0}, 0.25);
  cloud.add({5, 5, 5}, {10, 0, 0}, {0, 10, 0}, 0.25);
  return cloud;
}

std::string remark_on_placed(const Occluders& occluders, const GivenObserver& given, double ground = 0.0) {
  const std::vector<Observer> observers =
      place_observers(std::span(&given, 1), {}, [&](const glm::dvec2&) { return std::optional(ground); });
  const auto remarks = observer_remarks(occluders, observers);
  return remarks.empty() ? "" : remarks[0];
}

TEST(Clearance, is_what_is_straight_above_and_below_an_eye) {
  const Occluders occluders = roofed().occluders();
  const Clearance below_roof = clearance_of(occluders, {10, 10, 1.7}),
                  on_roof = clearance_of(occluders, {10, 10, 7}),
                  outside = clearance_of(occluders, {2, 2, 1.7}),
                  nowhere = clearance_of(occluders, {90, 2, 1.7});
  EXPECT_NEAR(below_roof.below.value(), 1.7, 1e-3);
  EXPECT_NEAR(below_roof.above.value(), 3.3, 1e-3);
  EXPECT_NEAR(on_roof.below.value(), 2.0, 1e-3);
  EXPECT_FALSE(on_roof.above);
  EXPECT_NEAR(outside.below.value(), 1.7, 1e-3);
  EXPECT_FALSE(outside.above);
  EXPECT_FALSE(nowhere.below || nowhere.above);
}

TEST(Clearance, leaves_out_the_surface_that_the_eye_is_on) {
  const Occluders occluders = roofed().occluders();
  for (const double height : {-0.001, 0.0, 0.001}) {
    const Clearance clearance = clearance_of(occluders, {2.1, 2.1, height});
    ASSERT_TRUE(clearance.below) << height;
    EXPECT_NEAR(*clearance.below, std::max(height, 0.0), 1e-3);
    EXPECT_FALSE(clearance.above) << height;
  }
}

TEST(Clearance, ends_at_the_first_crossing_whatever_the_transparency_and_at_points_that_count) {
  const WallCloud cloud = roofed();
  EXPECT_NEAR(clearance_of(cloud.occluders({.transparency = 3}), {10, 10, 7}).below.value(), 2.0, 1e-3);
  OccluderOptions ground_alone;
  ground_alone.counts = [roof = std::size_t{81 * 81}](std::uint64_t id) { return id < roof; };
  const Clearance clearance = clearance_of(cloud.occluders(ground_alone), {10, 10, 1.7});
  EXPECT_NEAR(clearance.below.value(), 1.7, 1e-3);
  EXPECT_FALSE(clearance.above);
}

TEST(Clearance, finds_crowns_whose_points_lines_pass_between) {
  // A point of foliage every 3 metres straight above the eye, and beside it less than a radius away.
  WallCloud cloud = garden();
  const Occluders occluders = cloud.add({4.1, 4.1, 9}).occluders();
  const double beside = 0.9 * occluders.typical_radius();
  EXPECT_NEAR(clearance_of(occluders, {4.1 + beside, 4.1, 2}).above.value(), 7.0, 0.3);
  EXPECT_FALSE(clearance_of(occluders, {4.1 + 3.0 * beside, 4.1, 2}).above);
}

TEST(Clearance, is_also_that_to_meshes_and_terrains) {
  OccluderOptions options;
  options.terrain =
      std::make_shared<const geo::TerrainSurface>(geo::Raster<float>({{-50, 50}, 10.0, 10, 10}, 7.0f));
  const Occluders occluders(build(PointCloud()), options);
  EXPECT_NEAR(clearance_of(occluders, {1, 1, 9}).below.value(), 2.0, 1e-6);
  EXPECT_NEAR(clearance_of(occluders, {1, 1, 7}).below.value(), 0.0, 1e-6);
  EXPECT_FALSE(clearance_of(occluders, {1, 1, 7}).above);
  EXPECT_NEAR(clearance_of(occluders, {1, 1, 4}).above.value(), 3.0, 1e-6);
}

TEST(Clearance, is_0_on_a_mesh_however_the_millimetre_around_an_eye_is_rounded) {
  for (double height = 0.3; height < 1000.0; height += 17.0) {
    TriangleMesh roof;
    roof.vertices = {{-5, -5, height}, {5, -5, height}, {0, 5, height}};
    roof.triangles = {{0, 1, 2}};
    OccluderOptions options;
    options.mesh = std::make_shared<const TriangleTree>(std::move(roof));
    const Clearance clearance = clearance_of(Occluders(build(PointCloud()), options), {0.3, 0.2, height});
    ASSERT_TRUE(clearance.below) << height;
    EXPECT_NEAR(*clearance.below, 0.0, 1e-9) << height;
    EXPECT_FALSE(clearance.above) << height;
  }
}

TEST(ObserverRemarks, of_many_observers_end_when_they_are_given_up) {
  std::atomic<int> asked = 0;
  OccluderOptions options;
  options.is_given_up = [&asked] { return ++asked > 100; };
  Observer observer;
  observer.position = {10, 10, 1.7};
  const std::vector<Observer> many(100'000, observer);
  EXPECT_THROW(observer_remarks(roofed().occluders(options), many), Cancelled);
  EXPECT_LT(asked, 1000);
}

TEST(ObserverRemarks, name_observers_below_something_and_what_to_type) {
  const Occluders occluders = roofed().occluders();
  EXPECT_EQ(remark_on_placed(occluders, {.name = "mast", .position = {10, 10}, .height = 1.5}),
            "mast has something 3.50 above its eye, which hides the sky; to look from its top, type "
            "--observer=10.000,10.000,5.000 --observer-height 1.5 (in a file: z, height)");
  EXPECT_EQ(remark_on_placed(occluders, {.name = "mast", .position = {10, 10}, .z = 5.0, .height = 1.5}), "");
  EXPECT_EQ(remark_on_placed(occluders, {.name = "mast", .position = {2, 2}, .height = 1.5}), "");
  Observer camera;
  camera.position = {10, 10, 1.5};
  EXPECT_TRUE(observer_remarks(occluders, std::span(&camera, 1)).empty()) << "photos are taken below roofs";
}

TEST(ObserverRemarks, name_observers_whose_foot_is_off_the_points_by_more_than_one) {
  const Occluders occluders = roofed().occluders();
  const auto on_ground = [&](double ground) {
    return remark_on_placed(occluders, {.name = "mast", .position = {2, 2}, .height = 2.0}, ground);
  };
  EXPECT_EQ(on_ground(0.98), "");
  EXPECT_EQ(
      on_ground(1.02),
      "the foot of mast is 1.02 above what is there; to stand on that, type --observer=2.000,2.000,0.000 "
      "--observer-height 2 (in a file: z, height)");
  EXPECT_EQ(on_ground(-0.98), "");
  EXPECT_EQ(on_ground(-1.02).substr(0, 45), "the foot of mast is 1.02 below what is there;");
  EXPECT_EQ(remark_on_placed(occluders, {.name = "drone", .position = {2, 2}, .z = 50.0}), "")
      << "has no foot";
  EXPECT_NE(remark_on_placed(occluders, {.name = "mast", .position = {2, 2}, .z = 11.0, .height = 2.0}), "");
  // Between roof and street it is both.
  const std::string between =
      remark_on_placed(occluders, {.name = "mast", .position = {10, 10}, .height = 2.0}, 2.0);
  EXPECT_NE(between.find("mast has something 1.00 above its eye"), std::string::npos) << between;
  EXPECT_NE(between.find("the foot of mast is 2.00 above what is there"), std::string::npos) << between;
}

}  // namespace
}  // namespace alidade::test
