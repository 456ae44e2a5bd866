// SPDX-License-Identifier: MIT
#include "tests/octree/as_brute_force.h"
#include "tests/octree/explain.h"

namespace alidade {
namespace {

using namespace test;

constexpr double k_infinity = std::numeric_limits<double>::infinity();
const double k_nan = std::nan("");

/// Expects every query function to throw, those of the index and those of brute force.
template <class Target, class Query>
void expect_rejected(const Target& target, const Query& query, const std::string& why) {
  const PointCloud cloud = three_points();
  const Octree octree = build(cloud);
  const auto rejected = [&](const auto& run) {
    try {
      run();
      ADD_FAILURE() << "not rejected: " << why;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    }
  };
  const std::vector<Target> batch{target};
  std::vector<std::size_t> counts(1);
  rejected([&] { (void)find(octree, target, query); });
  rejected([&] { (void)count(octree, target, query); });
  rejected([&] { (void)find(octree, std::span<const Target>(batch), query); });
  rejected([&] { count(octree, std::span<const Target>(batch), query, counts); });
  rejected([&] { (void)find(Octree{}, target, query); });
  rejected([&] { (void)brute_force::find(cloud, target, query); });
  rejected([&] { (void)brute_force::count(cloud, target, query); });
  if constexpr (requires { closest(octree, target, query); }) {
    rejected([&] { (void)closest(octree, target, query); });
    rejected([&] { (void)occluded(octree, target, query); });
    rejected([&] { (void)brute_force::closest(cloud, target, query); });
    rejected([&] { (void)brute_force::occluded(cloud, target, query); });
  }
  if constexpr (std::is_same_v<Target, Ray>) {
    std::vector<std::optional<Hit>> hits(1);
    std::vector<std::uint8_t> answers(1);
    rejected([&] { closest(octree, batch, query, hits); });
    rejected([&] { occluded(octree, batch, query, answers); });
  }
}

Ray good_ray() {
  return make_ray({0, 0, 0}, {1, 0, 0});
}

TEST(BadQuery, a_direction_of_length_zero_is_an_error) {
  EXPECT_THROW(make_ray({0, 0, 0}, {0, 0, 0}), Error);
  expect_rejected(Ray{{0, 0, 0}, {0, 0, 0}}, RayQuery{.radius = 1.0}, "direction is not normalized");
}

TEST(BadQuery, a_direction_that_is_not_finite_is_an_error) {
  for (const double bad : {k_nan, k_infinity, -k_infinity}) {
    EXPECT_THROW(make_ray({0, 0, 0}, {0, bad, 1}), Error);
    expect_rejected(Ray{{0, 0, 0}, {0, bad, 1}}, RayQuery{.radius = 1.0}, "direction is not normalized");
  }
}

TEST(BadQuery, a_direction_whose_length_is_not_1_within_1e_6_is_an_error) {
  for (const double length : {2.0, 0.5, 1.0 + 2e-6, 1.0 - 2e-6}) {
    expect_rejected(Ray{{0, 0, 0}, {0, length, 0}}, RayQuery{.radius = 1.0}, "direction is not normalized");
    expect_rejected(Cone{.axis = {{0, 0, 0}, {0, length, 0}}, .slope = 1.0}, ConeQuery{},
                    "direction is not normalized");
    expect_rejected(HalfSpaces{{Plane{{0, 0, 0}, {0, length, 0}}}}, PointQuery{},
                    "normal of a plane is not normalized");
  }
  EXPECT_NO_THROW((void)find(build(three_points()), Ray{{0, 0, 0}, {0, 1.0 + 9e-7, 0}}, {.radius = 1.0}));
}

TEST(BadQuery, an_origin_that_is_not_finite_is_an_error) {
  for (const double bad : {k_nan, k_infinity, -k_infinity}) {
    EXPECT_THROW(make_ray({0, bad, 0}, {0, 0, 1}), Error);
    expect_rejected(Ray{{0, bad, 0}, {0, 0, 1}}, RayQuery{.radius = 1.0}, "origin is not finite");
    expect_rejected(glm::dvec3(0, bad, 0), PointQuery{}, "point is not finite");
    expect_rejected(HalfSpaces{{Plane{{0, 0, bad}, {0, 0, 1}}}}, PointQuery{},
                    "point of a plane is not finite");
  }
}

TEST(BadQuery, limits_that_are_not_numbers_are_errors) {
  EXPECT_THROW(make_ray({0, 0, 0}, {0, 0, 1}, k_nan), Error);
  EXPECT_THROW(make_ray({0, 0, 0}, {0, 0, 1}, 0, k_nan), Error);
  expect_rejected(Ray{{0, 0, 0}, {0, 0, 1}, k_nan, 1}, RayQuery{.radius = 1.0},
                  "a limit of the interval is NaN");
  expect_rejected(Ray{{0, 0, 0}, {0, 0, 1}, 0, k_nan}, RayQuery{.radius = 1.0},
                  "a limit of the interval is NaN");
}

TEST(BadQuery, t_min_above_t_max_is_an_empty_interval_and_no_error) {
  const Octree octree = build(three_points());
  const Ray ray = make_ray({0, 0, 0}, {1, 0, 0}, 1.0, -1.0);
  EXPECT_TRUE(find(octree, ray, {.radius = 1e9}).empty());
  EXPECT_EQ(count(octree, ray, {.radius = 1e9}), 0u);
  EXPECT_FALSE(closest(octree, ray, {.radius = 1e9}));
  EXPECT_FALSE(occluded(octree, ray, {.radius = 1e9}));
  Path path = make_path({{0, 0, 0}, {20, 0, 0}}, 1.0, -1.0);
  EXPECT_TRUE(find(octree, path, {}).empty());
  EXPECT_TRUE(find(octree, Cone{ray, 1e9, 0.0}).empty());
}

TEST(BadQuery, a_radius_that_is_negative_or_not_a_number_is_an_error) {
  for (const double bad : {-1.0, -1e-300, k_nan, -k_infinity}) {
    expect_rejected(good_ray(), RayQuery{.radius = bad}, "radius out of range");
    expect_rejected(make_path({{0, 0, 0}, {1, 0, 0}}), PathQuery{.radius = bad}, "radius out of range");
    expect_rejected(glm::dvec3(0), PointQuery{.radius = bad}, "radius out of range");
  }
}

TEST(BadQuery, k_of_0_is_an_error) {
  expect_rejected(good_ray(), RayQuery{.radius = 1.0, .k = 0}, "k is 0");
  expect_rejected(Cone{good_ray(), 1.0, 0.0}, ConeQuery{.k = 0}, "k is 0");
  expect_rejected(make_path({{0, 0, 0}, {1, 0, 0}}), PathQuery{.k = 0}, "k is 0");
  expect_rejected(HalfSpaces{}, PointQuery{.k = 0}, "k is 0");
  expect_rejected(Bounds{}, PointQuery{.k = 0}, "k is 0");
  expect_rejected(glm::dvec3(0), PointQuery{.k = 0}, "k is 0");
}

TEST(BadQuery, entry_without_a_radius_and_of_paths_is_an_error) {
  expect_rejected(good_ray(), RayQuery{}, "measure entry requires a radius");
  expect_rejected(make_path({{0, 0, 0}, {1, 0, 0}}), PathQuery{.measure = Measure::entry},
                  "paths do not support measure entry");
}

TEST(BadQuery, an_entry_min_that_is_not_a_number_is_an_error) {
  expect_rejected(good_ray(), RayQuery{.radius = 1.0, .entry_min = k_nan}, "entry_min");
}

TEST(BadQuery, a_radius_of_boxes_and_half_spaces_is_an_error) {
  expect_rejected(Bounds{{0, 0, 0}, {1, 1, 1}}, PointQuery{.radius = 1.0},
                  "box and half-space queries do not support a radius");
  expect_rejected(HalfSpaces{}, PointQuery{.radius = 1.0},
                  "box and half-space queries do not support a radius");
}

TEST(BadQuery, max_level_is_an_error_where_there_are_no_levels) {
  const RayQuery coarse{.radius = 1.0, .max_level = 2};
  std::vector<std::size_t> counts(1);
  const std::vector<Ray> rays{good_ray()};
  for (const Organisation organisation : {Organisation::adaptive, Organisation::fixed}) {
    const Octree octree = build(three_points(), {.organisation = organisation});
    EXPECT_THROW((void)find(octree, good_ray(), coarse), Error);
    EXPECT_THROW((void)find(octree, good_ray(), {.radius = 1.0, .max_level = k_all_levels - 1}), Error);
    EXPECT_THROW((void)closest(octree, good_ray(), coarse), Error);
    EXPECT_THROW((void)occluded(octree, good_ray(), coarse), Error);
    EXPECT_THROW((void)find(octree, rays, coarse), Error);
    EXPECT_THROW(count(octree, rays, coarse, counts), Error);
  }
  EXPECT_THROW((void)brute_force::find(three_points(), good_ray(), coarse), Error);
  expect_rejected(good_ray(), RayQuery{.radius = 1.0, .max_level = -1}, "max_level is negative");
  BuildOptions layered;
  layered.organisation = Organisation::layered;
  EXPECT_THROW((void)count(build(three_points(), layered), good_ray(), {.radius = 1.0, .max_level = -1}),
               Error);
  EXPECT_EQ(count(build(three_points(), layered), good_ray(), {.radius = 1.0, .max_level = 0}), 3u);
}

TEST(BadQuery, cones_that_no_make_cone_made_are_errors) {
  for (const double bad : {-1.0, k_nan, k_infinity}) {
    expect_rejected(Cone{good_ray(), bad, 0.0}, ConeQuery{}, "cone radius out of range");
    expect_rejected(Cone{good_ray(), 0.0, bad}, ConeQuery{}, "cone slope out of range");
  }
}

TEST(BadQuery, paths_that_no_make_path_made_are_errors) {
  const Path good = make_path({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}});
  Path bad = good;
  bad.vertices[1].y = k_nan;
  expect_rejected(bad, PathQuery{}, "vertex is not finite");
  bad = good;
  bad.vertex_t[1] = 0.5;
  expect_rejected(bad, PathQuery{}, "vertex_t is not the length");
  bad = good;
  bad.vertices[1] = bad.vertices[0];
  expect_rejected(bad, PathQuery{}, "vertex_t is not the length");
  bad.vertex_t = {0.0, 0.0, length_of(bad.vertices[2] - bad.vertices[1])};
  expect_rejected(bad, PathQuery{}, "vertex_t is not the length");
  bad = good;
  bad.vertex_t.pop_back();
  expect_rejected(bad, PathQuery{}, "wrong number of t values in the path");
  expect_rejected(Path{}, PathQuery{}, "too few path vertices");
  bad = good;
  bad.t_min = k_nan;
  expect_rejected(bad, PathQuery{}, "a limit of the interval is NaN");
}

TEST(BadQuery, a_box_with_a_face_that_is_not_a_number_is_an_error) {
  for (int axis = 0; axis < 3; ++axis) {
    Bounds low{{0, 0, 0}, {1, 1, 1}}, high = low;
    low.min[axis] = high.max[axis] = k_nan;
    expect_rejected(low, PointQuery{}, "a face of the box is NaN");
    expect_rejected(high, PointQuery{}, "a face of the box is NaN");
  }
}

TEST(BadQuery, an_empty_cloud_answers_nothing) {
  for (const Octree& octree : {Octree{}, build(PointCloud{})}) {
    EXPECT_TRUE(find(octree, good_ray(), {.radius = 1.0}).empty());
    EXPECT_TRUE(find(octree, Cone{good_ray(), 1.0, 1.0}).empty());
    EXPECT_TRUE(find(octree, make_path({{0, 0, 0}, {1, 0, 0}}), {}).empty());
    EXPECT_TRUE(find(octree, HalfSpaces{}).empty());
    EXPECT_TRUE(find(octree, Bounds{{-1, -1, -1}, {1, 1, 1}}).empty());
    EXPECT_TRUE(find(octree, glm::dvec3(0), {.k = 3}).empty());
    EXPECT_EQ(count(octree, glm::dvec3(0), {}), 0u);
    EXPECT_FALSE(closest(octree, Cone{good_ray(), 1.0, 1.0}));
    EXPECT_FALSE(occluded(octree, Cone{good_ray(), 1.0, 1.0}));
    const std::vector<Ray> rays(3, good_ray());
    EXPECT_EQ(find(octree, rays, {.radius = 1.0}).size(), 3u);
    EXPECT_EQ(explain(octree, good_ray(), {.radius = 1.0}).statistics, QueryStatistics{});
  }
}

TEST(BadQuery, a_batch_names_the_first_bad_ray) {
  const Octree octree = build(three_points());
  std::vector<Ray> rays(2000, good_ray());
  rays[1017].direction = {0, 0, 2};
  rays[1900].origin.x = k_nan;
  std::vector<std::optional<Hit>> hits(rays.size());
  std::vector<std::uint8_t> answers(rays.size());
  std::vector<std::size_t> counts(rays.size());
  const auto message = [](const auto& run) -> std::string {
    try {
      run();
      return "no error";
    } catch (const Error& error) {
      return error.what();
    }
  };
  const std::string expected = "ray 1017: the direction is not normalized";
  EXPECT_EQ(message([&] { closest(octree, rays, {.radius = 1.0}, hits); }).find(expected), 0u);
  EXPECT_EQ(message([&] { occluded(octree, rays, {.radius = 1.0}, answers); }).find(expected), 0u);
  EXPECT_EQ(message([&] { count(octree, rays, {.radius = 1.0}, counts); }).find(expected), 0u);
  EXPECT_EQ(message([&] { (void)find(octree, rays, {.radius = 1.0}); }).find(expected), 0u);
  EXPECT_EQ(message([&] { closest(build(PointCloud{}), rays, {.radius = 1.0}, hits); }).find(expected), 0u);
}

TEST(BadQuery, a_batch_names_bad_targets_of_every_family) {
  const Octree octree = build(three_points());
  const auto message = [&](const auto& targets, const auto& query) -> std::string {
    try {
      (void)find(octree, targets, query);
      return "no error";
    } catch (const Error& error) {
      return error.what();
    }
  };
  EXPECT_EQ(message(std::vector<Cone>{{good_ray(), 1, 0}, {good_ray(), -1, 0}}, ConeQuery{}).find("cone 1: "),
            0u);
  EXPECT_EQ(message(std::vector<Path>{Path{}}, PathQuery{}).find("path 0: "), 0u);
  EXPECT_EQ(message(std::vector<HalfSpaces>{{}, {}, {{Plane{{0, 0, k_nan}, {0, 0, 1}}}}}, PointQuery{})
                .find("region 2: "),
            0u);
  EXPECT_EQ(message(std::vector<Bounds>{{}, {{k_nan, 0, 0}, {1, 1, 1}}}, PointQuery{}).find("box 1: "), 0u);
  EXPECT_EQ(message(std::vector<glm::dvec3>{{0, 0, 0}, {k_infinity, 0, 0}}, PointQuery{}).find("point 1: "),
            0u);
}

TEST(BadQuery, room_that_is_not_as_long_as_the_targets_is_an_error) {
  const Octree octree = build(three_points());
  const std::vector<Ray> rays(3, good_ray());
  const std::vector<glm::dvec3> points(3);
  std::vector<std::size_t> counts(2);
  std::vector<std::optional<Hit>> hits(4);
  std::vector<std::uint8_t> answers(4);
  EXPECT_THROW(count(octree, rays, {.radius = 1.0}, counts), Error);
  EXPECT_THROW(count(octree, points, {.radius = 1.0}, counts), Error);
  EXPECT_THROW(closest(octree, rays, {.radius = 1.0}, hits), Error);
  EXPECT_THROW(occluded(octree, rays, {.radius = 1.0}, answers), Error);
}

}  // namespace
}  // namespace alidade
