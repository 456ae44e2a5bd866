// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "base/error.h"
#include "octree/build.h"
#include "octree/spacing.h"
#include "surface/brute_force_surface.h"
#include "surface/surface_cloud.h"
#include "tests/support/point_families.h"
#include "tests/support/spacings.h"

namespace alidade {
namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();
const double k_nan = std::nan("");

PointCloud two_points() {
  return test::make_cloud({{0, 0, 0}, {1, 0, 0}}, {glm::dvec3(0.5), glm::dvec3(0)});
}

Octree spaced() {
  return with_spacings(build(two_points()), 1);
}

Ray good_ray() {
  return make_ray({0, -5, 0}, {0, 1, 0});
}

template <class Run>
void expect_error(const Run& run, const std::string& why) {
  try {
    run();
    ADD_FAILURE() << "not rejected: " << why;
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
  }
}

/// Expects every function of a cloud to throw.
void expect_rejected_by(const SurfaceCloud& cloud, const Ray& ray, const SurfaceQuery& query,
                        const std::string& why) {
  const std::vector<Ray> rays{ray};
  std::vector<std::optional<SurfaceHit>> hits(1);
  std::vector<std::uint8_t> blocked(1);
  expect_error([&] { (void)closest(cloud, ray, query); }, why);
  expect_error([&] { (void)occluded(cloud, ray, query); }, why);
  expect_error([&] { closest(cloud, rays, query, hits); }, why);
  expect_error([&] { occluded(cloud, rays, query, blocked); }, why);
}

/// The same of clouds of spheres, of discs and of nothing, and of brute force.
void expect_rejected(const Ray& ray, const SurfaceQuery& query, const std::string& why) {
  const Octree octree = with_surfaces(spaced());
  for (const SurfaceCloud& cloud :
       {SurfaceCloud::of_spheres(octree), SurfaceCloud::of_discs(octree), SurfaceCloud()})
    expect_rejected_by(cloud, ray, query, why);
  const std::vector<double> spacings = test::spacings_by_id(octree);
  const auto by_brute_force = [&](const auto& function) {
    expect_error([&] { (void)function(two_points(), ray, query, spacings, octree.layers()); }, why);
  };
  by_brute_force([](const auto&... of) { return brute_force::find(of...); });
  by_brute_force([](const auto&... of) { return brute_force::closest(of...); });
}

TEST(BadSurfaceQuery, good_ones_are_answered) {
  const Octree octree = with_surfaces(spaced());
  const SurfaceQuery query{.radius = 1.0};
  EXPECT_TRUE(closest(SurfaceCloud::of_spheres(octree), good_ray(), query));
  EXPECT_TRUE(occluded(SurfaceCloud::of_spheres(octree), good_ray(), query));
  EXPECT_TRUE(closest(SurfaceCloud::of_spheres(octree), good_ray(), {.measure = Measure::t}));
  EXPECT_NO_THROW((void)closest(SurfaceCloud::of_discs(octree), good_ray(), query));
  SurfaceQuery discs = query;
  discs.discs.emplace().edge_shift = -0.5;
  EXPECT_NO_THROW((void)closest(SurfaceCloud::of_discs(octree), good_ray(), discs));
}

TEST(BadSurfaceQuery, what_rays_of_one_radius_reject_is_an_error) {
  for (const double bad : {-1.0, -1e-300, k_nan, -k_infinity})
    expect_rejected(good_ray(), {.radius = bad}, "radius out of range");
  expect_rejected(good_ray(), {}, "measure entry requires a radius");
  expect_rejected(good_ray(), {.radius = 1.0, .entry_min = k_nan}, "entry_min is NaN");
}

TEST(BadSurfaceQuery, measure_distance_is_an_error) {
  expect_rejected(good_ray(), {.radius = 1.0, .measure = Measure::distance}, "measure distance");
  expect_rejected(good_ray(), {.radius = 1.0, .measure = Measure::distance, .discs = DiscQuery{}},
                  "measure distance");
}

TEST(BadSurfaceQuery, a_spacing_factor_that_is_not_above_0_or_not_finite_is_an_error) {
  for (const double bad : {0.0, -1.0, k_nan, k_infinity})
    expect_rejected(good_ray(), {.radius = 1.0, .spacing_factor = bad}, "spacing_factor out of range");
}

TEST(BadSurfaceQuery, discs_without_a_radius_are_an_error) {
  expect_rejected(good_ray(), {.measure = Measure::t, .discs = DiscQuery{}}, "discs require a radius");
}

TEST(BadSurfaceQuery, lengths_of_discs_out_of_range_are_errors) {
  const auto expect = [](const DiscQuery& discs, const std::string& why) {
    expect_rejected(good_ray(), {.radius = 1.0, .discs = discs}, why);
  };
  for (const double bad : {-1.0, k_nan, k_infinity}) expect({.lone_factor = bad}, "lone_factor out of range");
  for (const double bad : {-1.0, k_nan}) expect({.lone_radius = bad}, "lone_radius out of range");
  for (const double bad : {k_nan, k_infinity, -k_infinity})
    expect({.edge_shift = bad}, "edge_shift out of range");
}

TEST(BadSurfaceQuery, sheets_that_are_not_as_many_as_the_rays_are_an_error) {
  const std::vector<SheetOrigin> begins(2);
  const SurfaceQuery query{.radius = 1.0, .discs = DiscQuery{.begins = begins}};
  const std::string why = "the sheets that rays begin on do not match the rays";
  expect_rejected(good_ray(), query, why);
  const SurfaceCloud discs = SurfaceCloud::of_discs(spaced());
  const std::vector<Ray> rays(3, good_ray());
  std::vector<std::optional<SurfaceHit>> hits(3);
  std::vector<std::uint8_t> blocked(3);
  expect_error([&] { closest(discs, rays, query, hits); }, why);
  expect_error([&] { occluded(discs, rays, query, blocked); }, why);
  expect_error([&] { check(query, 3); }, why);
  EXPECT_NO_THROW(closest(discs, std::span(rays).first(2), query, std::span(hits).first(2)));
}

TEST(BadSurfaceQuery, discs_of_a_cloud_of_spheres_are_an_error) {
  const SurfaceQuery query{.radius = 1.0, .discs = DiscQuery{}};
  expect_rejected_by(SurfaceCloud::of_spheres(with_surfaces(spaced())), good_ray(), query,
                     "discs require a cloud that has them");
}

TEST(BadSurfaceQuery, brute_force_without_what_it_needs_is_an_error) {
  const std::vector<double> spacings = test::spacings_by_id(spaced());
  const SurfaceQuery spheres{.radius = 1.0}, discs{.radius = 1.0, .discs = DiscQuery{}};
  expect_error([&] { (void)brute_force::closest(two_points(), good_ray(), spheres, {}); },
               "spacings do not match the points");
  expect_error([&] { (void)brute_force::closest(two_points(), good_ray(), discs, spacings); },
               "discs require the surfaces of the points");
}

TEST(BadSurfaceQuery, what_is_no_ray_is_an_error_that_names_its_number) {
  const SurfaceQuery query{.radius = 1.0};
  expect_rejected({{0, 0, 0}, {0, 2, 0}}, query, "direction is not normalized");
  expect_rejected({{0, k_nan, 0}, {0, 1, 0}}, query, "origin is not finite");
  expect_rejected({{0, 0, 0}, {0, 1, 0}, k_nan, 1.0}, query, "a limit of the interval is NaN");
  const SurfaceCloud spheres = SurfaceCloud::of_spheres(spaced());
  const std::vector<Ray> rays{good_ray(), {{0, 0, 0}, {0, 2, 0}}};
  std::vector<std::optional<SurfaceHit>> hits(2);
  std::vector<std::uint8_t> blocked(2);
  expect_error([&] { closest(spheres, rays, query, hits); }, "ray 1: ");
  expect_error([&] { occluded(spheres, rays, query, blocked); }, "ray 1: ");
}

TEST(BadSurfaceQuery, a_batch_whose_answers_have_no_room_is_an_error) {
  const SurfaceCloud spheres = SurfaceCloud::of_spheres(spaced());
  const std::vector<Ray> rays(3, good_ray());
  std::vector<std::optional<SurfaceHit>> hits(2);
  std::vector<std::uint8_t> blocked(4);
  const std::string why = "the span of answers does not match the targets";
  expect_error([&] { closest(spheres, rays, {.radius = 1.0}, hits); }, why);
  expect_error([&] { occluded(spheres, rays, {.radius = 1.0}, blocked); }, why);
}

TEST(BadSurfaceQuery, an_octree_without_spacings_is_an_error_unless_it_is_empty) {
  const Octree octree = build(two_points());
  const std::string why = "radii of the points' own require an octree with spacings";
  expect_error([&] { SurfaceCloud::of_spheres(octree); }, why);
  expect_error([&] { SurfaceCloud::of_discs(octree); }, why);
  const Octree empty = build(PointCloud());
  EXPECT_EQ(SurfaceCloud::of_spheres(empty).size(), 0u);
  EXPECT_EQ(SurfaceCloud::of_discs(empty).size(), 0u);
}

}  // namespace
}  // namespace alidade
