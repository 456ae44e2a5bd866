// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "octree/build.h"
#include "octree/spacing.h"
#include "surface/brute_force_surface.h"
#include "surface/decide_point.h"
#include "surface/point_disc.h"
#include "surface/surface_cloud.h"
#include "tests/support/octrees.h"
#include "tests/support/point_families.h"
#include "tests/support/random.h"
#include "tests/support/ray_families.h"
#include "tests/support/same_hits.h"
#include "tests/surface/surface_cases.h"

namespace alidade {
namespace {

using test::disc_cases;
using test::disc_query;
using test::DiscCase;
using test::Random;
using test::same_hits;

SurfaceCloud discs_of(const DiscCase& disc_case, InstructionSet set) {
  return SurfaceCloud::of_discs(disc_case.with_all(build(disc_case.cloud, {.instruction_set = set})));
}

SurfaceCloud discs_of(const PointCloud& cloud, InstructionSet set = InstructionSet::best) {
  return discs_of({.name = "discs", .cloud = cloud}, set);
}

std::optional<Hit> by_brute_force(const DiscCase& disc_case, const SurfaceCloud& discs, const Ray& ray,
                                  const SurfaceQuery& query) {
  return brute_force::closest(disc_case.cloud, ray, query, disc_case.spacings, discs.octree().layers());
}

class CrossingVsBruteForce : public ::testing::TestWithParam<InstructionSet> {};

TEST_P(CrossingVsBruteForce, closest_and_occluded_are_the_same_bits_on_every_family) {
  std::size_t hit_count = 0, miss_count = 0;
  for (const DiscCase& disc_case : disc_cases()) {
    for (const test::NamedOctree& named : test::octrees_of(disc_case.cloud, GetParam())) {
      const SurfaceCloud discs = SurfaceCloud::of_discs(disc_case.with_all(named.octree));
      Random random(disc_case.name + "_crossing");
      for (const test::RayCase& c : test::ray_cases(disc_case.cloud, 20, random)) {
        const SurfaceQuery query = disc_query(c.query, random);
        SCOPED_TRACE(disc_case.name + " " + named.name + " factor " + std::to_string(query.spacing_factor));
        for (const Ray& ray : {c.ray, test::beside_lanes(c.ray)}) {
          const std::optional<Hit> expected = by_brute_force(disc_case, discs, ray, query);
          ASSERT_TRUE(same_hits(closest(discs, ray, query), expected));
          ASSERT_EQ(occluded(discs, ray, query), expected.has_value());
          ++(expected ? hit_count : miss_count);
        }
      }
    }
  }
  EXPECT_GT(hit_count, 600u);
  EXPECT_GT(miss_count, 600u);
}

/// Rays between points, which cross discs at all angles.
TEST_P(CrossingVsBruteForce, batches_are_the_same_bits_whatever_the_filter) {
  std::size_t hit_count = 0;
  for (const DiscCase& disc_case : disc_cases()) {
    if (disc_case.cloud.size() == 0) continue;
    const SurfaceCloud discs = discs_of(disc_case, GetParam());
    Random random(disc_case.name + "_crossing_batches");
    for (int turn = 0; turn < 6; ++turn) {
      const double radius = 2.0 * automatic_radius(discs.octree());
      SurfaceQuery query = disc_query({.radius = std::max(radius, 1e-3) * std::pow(8.0, turn % 3)}, random);
      if (turn % 2 == 1) {
        const auto leans_aside = [](const Candidate& candidate) {
          return candidate.disc == nullptr || candidate.disc->normal.x < 0.3;
        };
        (turn == 5 ? query.filter.of_point : query.filter.of_position) = leans_aside;
      }
      if (turn == 3)
        query.filter.of_point = [](const Candidate& candidate) { return candidate.point_id % 3 != 0; };
      std::vector<Ray> rays;
      for (int i = 0; i < 60; ++i) {
        const glm::dvec3 from = disc_case.cloud.world(random.below(disc_case.cloud.size()));
        const glm::dvec3 to = disc_case.cloud.world(random.below(disc_case.cloud.size()));
        const glm::dvec3 start = from + radius * random.in_cube(),
                         way = to + radius * random.in_cube() - start;
        if (!(glm::dot(way, way) > 0.0)) continue;
        // Of one start, side by side in one direction, and any.
        const bool follows = !rays.empty() && turn % 3 != 2;
        const glm::dvec3 beside = follows ? rays[0].origin + 0.01 * radius * random.in_cube() : start;
        rays.push_back(make_ray(turn % 3 == 0 && follows ? rays[0].origin : beside,
                                follows && turn % 3 == 1 ? rays[0].direction + 0.01 * random.in_cube() : way,
                                i % 4 == 0 ? random.between(-radius, radius) : 0.0));
      }
      std::vector<std::optional<SurfaceHit>> hits(rays.size());
      std::vector<std::uint8_t> blocked(rays.size());
      closest(discs, rays, query, hits);
      occluded(discs, rays, query, blocked);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        SCOPED_TRACE(disc_case.name + " turn " + std::to_string(turn) + " ray " + std::to_string(i));
        const std::optional<Hit> expected = by_brute_force(disc_case, discs, rays[i], query);
        ASSERT_TRUE(same_hits(hits[i], expected));
        ASSERT_TRUE(test::has_right_index(discs, hits[i]));
        ASSERT_EQ(blocked[i] != 0, expected.has_value());
        hit_count += expected.has_value();
      }
    }
  }
  EXPECT_GT(hit_count, 1000u);
}

/// Rays whose interval is the crossing alone, also of planes that many discs share: no rounding in a lane may
/// lose it.
TEST_P(CrossingVsBruteForce, an_interval_that_is_the_crossing_alone_holds_it) {
  std::size_t hit_count = 0;
  for (const DiscCase& disc_case : disc_cases()) {
    if (disc_case.cloud.size() == 0) continue;
    const SurfaceCloud discs = discs_of(disc_case, GetParam());
    Random random(disc_case.name + "_crossing_alone");
    SurfaceQuery query =
        disc_query({.radius = std::max(4.0 * automatic_radius(discs.octree()), 1e-3)}, random);
    query.spacing_factor = 3.0;
    std::vector<Ray> rays;
    std::vector<std::optional<Hit>> expected;
    for (int i = 0; i < 60; ++i) {
      const glm::dvec3 to = disc_case.cloud.world(random.below(disc_case.cloud.size()));
      const double away = std::pow(10.0, random.between(-3.0, 2.0));
      const Ray ray = make_ray(to + away * random.in_cube(), random.direction());
      for (const Hit& hit :
           brute_force::find(disc_case.cloud, ray, query, disc_case.spacings, discs.octree().layers())) {
        rays.push_back({ray.origin, ray.direction, hit.t, hit.t});
        expected.push_back(by_brute_force(disc_case, discs, rays.back(), query));
        ASSERT_TRUE(expected.back());
        if (rays.size() % 8 == 0) break;
      }
    }
    std::vector<std::optional<SurfaceHit>> hits(rays.size());
    std::vector<std::uint8_t> blocked(rays.size());
    closest(discs, rays, query, hits);
    occluded(discs, rays, query, blocked);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      SCOPED_TRACE(disc_case.name + " ray " + std::to_string(i));
      ASSERT_TRUE(same_hits(hits[i], expected[i]));
      ASSERT_TRUE(blocked[i] != 0);
      ASSERT_TRUE(same_hits(closest(discs, rays[i], query), expected[i]));
      ++hit_count;
    }
  }
  EXPECT_GT(hit_count, 500u);
}

/// A sheet on which a position lies, by the surfaces of random points or of the one that was met there: its
/// limits are as near to what they decide as floats can say.
SheetOrigin sheet_at(const glm::dvec3& position, const std::optional<Hit>& met, const DiscCase& disc_case,
                     const SurfaceCloud& discs, const SurfaceQuery& query, Random& random) {
  const auto random_disc = [&] {
    const std::uint64_t id =
        met && random.below(2) == 0 ? met->point_id : random.below(disc_case.cloud.size());
    PointSurface surface = surface_of(discs.octree().layers(), id);
    if (!surface.exists) surface.normal = random.direction();
    return point_disc(disc_case.cloud.world(id), surface, own_radius(query, disc_case.spacings[id]));
  };
  SheetOrigin begin;
  const PointDisc alike = random_disc(), near = random_disc(), through = random_disc();
  begin.normal = alike.normal;
  if (random.below(3) == 0) {
    // Turned to the limit.
    const glm::dvec3 aside = glm::cross(alike.normal, random.direction());
    const double sine = std::sqrt(1.0 - k_same_sheet_cosine * k_same_sheet_cosine);
    begin.normal = k_same_sheet_cosine * alike.normal + sine * glm::normalize(aside);
  }
  begin.reach = static_cast<float>(random.below(2) == 0 ? glm::length(position - near.point)
                                                        : query.radius * random.between(0.0, 2.0));
  const double height = std::fabs(glm::dot(position - through.center, through.normal));
  begin.thickness =
      static_cast<float>(random.below(2) == 0 ? height : random.between(0.0, 0.2) * query.radius);
  return begin;
}

TEST_P(CrossingVsBruteForce, the_sheet_that_a_ray_begins_on_is_not_met) {
  std::size_t hits_of_all = 0, left = 0;
  for (const DiscCase& disc_case : disc_cases()) {
    if (disc_case.cloud.size() == 0) continue;
    const SurfaceCloud discs = discs_of(disc_case, GetParam());
    Random random(disc_case.name + "_sheets_left");
    for (int turn = 0; turn < 6; ++turn) {
      const double radius = std::max(2.0 * automatic_radius(discs.octree()), 1e-3) * std::pow(8.0, turn % 3);
      SurfaceQuery query = disc_query({.radius = radius}, random);
      std::vector<Ray> rays;
      std::vector<SheetOrigin> begins;
      // Rays side by side, whose answers lie in lanes, too, and others.
      const glm::dvec3 middle = disc_case.cloud.world(random.below(disc_case.cloud.size()));
      const glm::dvec3 there = random.direction(), back = random.direction();
      for (int i = 0; i < 50; ++i) {
        const glm::dvec3 to = disc_case.cloud.world(random.below(disc_case.cloud.size()));
        const bool is_beside = turn % 2 == 1;
        const Ray first =
            is_beside ? make_ray(middle + 0.3 * radius * random.in_cube() - 3.0 * radius * there, there)
                      : make_ray(to + radius * random.in_cube(), random.direction());
        const std::optional<Hit> met = by_brute_force(disc_case, discs, first, query);
        const glm::dvec3 start = met ? first.position(met->t) : first.origin;
        rays.push_back(make_ray(start, is_beside ? back + 0.005 * random.in_cube() : random.direction(),
                                i % 4 == 0 ? -0.1 * radius : 0.0));
        begins.push_back(i % 5 == 0
                             ? SheetOrigin{.reach = -0.1f * static_cast<float>(i % 2), .thickness = 9.0f}
                             : sheet_at(start, met, disc_case, discs, query, random));
        if (i % 9 == 8) rays.back() = test::beside_lanes(rays.back());
      }
      std::vector<std::optional<SurfaceHit>> hits(rays.size()), of_all(rays.size());
      std::vector<std::uint8_t> blocked(rays.size());
      closest(discs, rays, query, of_all);
      query.discs->begins = begins;
      closest(discs, rays, query, hits);
      occluded(discs, rays, query, blocked);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        SCOPED_TRACE(disc_case.name + " turn " + std::to_string(turn) + " ray " + std::to_string(i));
        SurfaceQuery alone = query;
        alone.discs->begins = std::span(begins).subspan(i, 1);
        const std::optional<Hit> expected = by_brute_force(disc_case, discs, rays[i], alone);
        ASSERT_TRUE(same_hits(hits[i], expected));
        ASSERT_EQ(blocked[i] != 0, expected.has_value());
        ASSERT_TRUE(same_hits(closest(discs, rays[i], alone), expected));
        ASSERT_EQ(occluded(discs, rays[i], alone), expected.has_value());
        const Ray by_walk = test::beside_lanes(rays[i]);
        ASSERT_TRUE(
            same_hits(closest(discs, by_walk, alone), by_brute_force(disc_case, discs, by_walk, alone)));
        hits_of_all += expected.has_value();
        left += of_all[i].has_value() && !same_hits(of_all[i], expected);
      }
    }
  }
  EXPECT_GT(hits_of_all, 1000u);
  EXPECT_GT(left, 300u);
}

/// Rays that go through the tree in packets: side by side, and in nearly one direction, but for a few.
TEST(Crossing, rays_that_go_alike_have_the_same_bits_on_every_family) {
  std::size_t hit_count = 0, miss_count = 0;
  for (const DiscCase& disc_case : disc_cases()) {
    if (disc_case.cloud.size() == 0) continue;
    std::vector<SurfaceCloud> clouds;
    for (const InstructionSet set : available_instruction_sets()) {
      clouds.push_back(discs_of(disc_case, set));
      if (!disc_case.fitted) continue;
      const Octree octree = build(disc_case.cloud, {.instruction_set = set});
      clouds.push_back(SurfaceCloud::of_discs(with_spacings(octree, k_surface_neighbours)));
    }
    const SurfaceCloud& discs = clouds.front();
    const Bounds bounds = disc_case.cloud.bounds();
    const double size = glm::length(bounds.size()) + 1e-3;
    Random random(disc_case.name + "_crossing_alike");
    for (int turn = 0; turn < 8; ++turn) {
      const double radius = std::max(2.0 * automatic_radius(discs.octree()), 1e-3) * std::pow(8.0, turn % 3);
      SurfaceQuery query = disc_query({.radius = radius}, random);
      const auto target = [&] { return disc_case.cloud.world(random.below(disc_case.cloud.size())); };
      const glm::dvec3 along = unit_direction(target() + 1e-3 * random.in_cube() - bounds.center());
      const glm::dvec3 middle = turn % 2 == 0 ? target() : bounds.center();
      const bool leave_sheets = turn % 4 == 2;
      if (turn % 4 == 1) query.entry_min = random.between(0.0, 0.5) * size;
      if (turn == 7)
        query.filter.of_point = [](const Candidate& candidate) { return candidate.point_id % 3 != 0; };
      std::vector<Ray> rays;
      std::vector<SheetOrigin> begins;
      for (int i = 0; i < 100; ++i) {
        // From an eye, from beside one another outside, or from among the points.
        const glm::dvec3 beside = turn % 4 == 0 ? glm::dvec3(0.0) : 0.005 * size * random.in_cube();
        const glm::dvec3 direction =
            random.below(50) == 0 ? random.in_cube() : along + 0.01 * random.in_cube();
        glm::dvec3 origin = middle + beside - (leave_sheets ? 0.0 : 0.8 * size) * along;
        if (random.below(50) == 0) origin = target() - 1e4 * size * direction;
        const double t_min = random.below(4) == 0 ? size * random.between(-1.0, 1.0) : 0.0;
        double t_max = std::numeric_limits<double>::infinity();
        if (random.below(4) == 0) t_max = size * random.between(-0.2, 2.0);
        rays.push_back(make_ray(origin, direction, t_min, t_max));
        if (leave_sheets)
          begins.push_back(i % 5 == 0 ? SheetOrigin{}
                                      : sheet_at(origin, by_brute_force(disc_case, discs, rays.back(), query),
                                                 disc_case, discs, query, random));
      }
      query.discs->begins = begins;
      std::vector<std::optional<Hit>> expected;
      for (std::size_t i = 0; i < rays.size(); ++i) {
        SurfaceQuery alone = query;
        if (leave_sheets) alone.discs->begins = std::span(begins).subspan(i, 1);
        expected.push_back(by_brute_force(disc_case, discs, rays[i], alone));
        ++(expected.back() ? hit_count : miss_count);
      }
      for (const SurfaceCloud& cloud : clouds) {
        SCOPED_TRACE(disc_case.name + " turn " + std::to_string(turn));
        std::vector<std::optional<SurfaceHit>> hits(rays.size());
        std::vector<std::uint8_t> blocked(rays.size());
        closest(cloud, rays, query, hits);
        occluded(cloud, rays, query, blocked);
        for (std::size_t i = 0; i < rays.size(); ++i) {
          SCOPED_TRACE(i);
          ASSERT_TRUE(same_hits(hits[i], expected[i]));
          ASSERT_TRUE(test::has_right_index(cloud, hits[i]));
          ASSERT_EQ(blocked[i] != 0, expected[i].has_value());
        }
      }
    }
  }
  EXPECT_GT(hit_count, 5000u);
  EXPECT_GT(miss_count, 5000u);
}

INSTANTIATE_TEST_SUITE_P(, CrossingVsBruteForce, ::testing::ValuesIn(available_instruction_sets()),
                         [](const auto& set) { return std::string(name(set.param)); });

TEST(Crossing, of_a_plane_is_known_on_paper) {
  std::vector<glm::dvec3> points;
  for (int x = -20; x <= 20; ++x)
    for (int y = -20; y <= 20; ++y) points.emplace_back(0.1 * x, 0.1 * y, 0.0);
  points.emplace_back(0.0, 0.0, 40.0);  // a bird
  const PointCloud cloud = test::make_cloud(points, {glm::dvec3(1e-3), glm::dvec3(0)});
  const SurfaceCloud discs = discs_of(cloud);
  const SurfaceQuery query{.radius = 1.0, .spacing_factor = 0.92, .discs = DiscQuery{.lone_radius = 0.25}};
  const glm::dvec3 direction = glm::normalize(glm::dvec3(3.0, 0.0, -4.0));
  const auto on_plane = closest(discs, make_ray({-1.2, 0.43, 2.0}, direction), query);
  ASSERT_TRUE(on_plane);
  EXPECT_NEAR(on_plane->t, 2.5, 1e-9);
  EXPECT_NEAR(on_plane->position.x, 0.3, 0.13);
  // Steeply along the sheet, where spheres reach far before and beside it.
  const auto grazing = closest(discs, make_ray({-10.0, 0.43, 0.1}, {100.0, 0.0, -1.0}), query);
  ASSERT_TRUE(grazing);
  EXPECT_NEAR(grazing->t * 0.1 / std::hypot(10.0, 0.1), 0.1, 1e-6);
  EXPECT_FALSE(closest(discs, make_ray({-3.0, 0.0, 0.01}, {1.0, 0.0, 0.0}), query))
      << "passes above the sheet";
  EXPECT_FALSE(occluded(discs, make_ray({2.09, 0.0, 1.0}, {0.0, 0.0, -1.0}), query)) << "beyond the edge";
  const auto bird = closest(discs, make_ray({-3.0, 0.15, 40.0}, {1.0, 0.0, 0.0}), query);
  ASSERT_TRUE(bird);
  EXPECT_NEAR(bird->t, 2.8, 1e-9) << "a sphere of 25 cm, met 20 cm before its middle";
  EXPECT_TRUE(occluded(discs, make_ray({-3.0, 0.25, 40.0}, {1.0, 0.0, 0.0}), query));
  EXPECT_FALSE(occluded(discs, make_ray({-3.0, 0.26, 40.0}, {1.0, 0.0, 0.0}), query));
}

/// The limit is closed: numbers are such that nothing is rounded.
TEST(Crossing, a_ray_at_the_edge_of_a_disc_meets_it_and_one_beside_does_not) {
  std::vector<glm::dvec3> points;
  for (int x = -8; x <= 8; ++x)
    for (int y = -8; y <= 8; ++y) points.emplace_back(0.125 * x, 0.125 * y, 0.0);
  const PointCloud cloud = test::make_cloud(points, {glm::dvec3(0.125), glm::dvec3(0)});
  for (const InstructionSet set : available_instruction_sets()) {
    SCOPED_TRACE(name(set));
    const SurfaceCloud discs = discs_of(cloud, set);
    // Wider by their spacings, so that all have this radius, and no edge of the sheet cuts them.
    for (const double radius : {0.0625, 0.25}) {
      const SurfaceQuery query{.radius = radius, .spacing_factor = 100.0, .discs = DiscQuery{}};
      for (const double t_min : {0.0, 2.0}) {
        const auto down = [&](double beside) {
          return make_ray({1.0 + beside, 0.5, 2.0}, {0.0, 0.0, -1.0}, t_min, 2.0);
        };
        const auto met = closest(discs, down(radius), query);
        ASSERT_TRUE(met) << radius;
        EXPECT_EQ(met->t, 2.0);
        EXPECT_EQ(met->position, glm::dvec3(1.0, 0.5, 0.0));
        EXPECT_TRUE(occluded(discs, down(radius), query));
        const double beyond = std::nextafter(1.0 + radius, 2.0) - 1.0;
        EXPECT_FALSE(closest(discs, down(beyond), query)) << radius;
        EXPECT_FALSE(occluded(discs, down(beyond), query)) << radius;
      }
      // So is the limit on the entry into the sphere around the point.
      SurfaceQuery entered = query;
      entered.filter = [](const Candidate& candidate) {
        return candidate.position == glm::dvec3(1.0, 0.5, 0.0);
      };
      const Ray through = make_ray({1.0, 0.5, 2.0}, {0.0, 0.0, -1.0});
      entered.entry_min = 2.0 - radius;
      EXPECT_TRUE(closest(discs, through, entered));
      entered.entry_min = std::nextafter(2.0 - radius, 2.0);
      EXPECT_FALSE(closest(discs, through, entered));
      // The limit is closed for positions in the spheres, too.
      std::vector<PointSphere> held;
      find_spheres(discs, {1.0 + radius, 0.5, 0.0}, 0.0, query, held);
      EXPECT_EQ(held.size(), 1u);
      find_spheres(discs, {std::nextafter(1.0 + radius, 2.0), 0.5, 0.0}, 0.0, query, held);
      EXPECT_EQ(held.size(), 1u);
    }
  }
}

/// The box of a flat floor is entered far behind the points whose discs the ray crosses.
TEST(Crossing, a_sheet_that_is_left_is_not_met_far_from_where_its_points_are) {
  std::vector<glm::dvec3> points;
  // Where the floor is sparse, the disc of one point alone holds the crossing.
  for (const double x : {-5.0, -4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.8, 5.8, 6.8})
    for (int y = -8; y <= 8; ++y) points.emplace_back(x, y, 0.0);
  const PointCloud cloud = test::make_cloud(points, {glm::dvec3(1e-3), glm::dvec3(0)});
  const glm::dvec3 start(1.0, 0.0, 2.0);
  const Ray ray = make_ray(start, glm::dvec3(3.7, 0.0, 0.0) - start);
  const SheetOrigin begin{{0.0, 0.0, 1.0}, 0.1f, 2.1f};
  for (const InstructionSet set : available_instruction_sets()) {
    const SurfaceCloud discs = discs_of(cloud, set);
    SurfaceQuery query{.radius = 1.0, .spacing_factor = 0.92, .discs = DiscQuery{}};
    EXPECT_TRUE(closest(discs, ray, query)) << name(set);
    query.discs->begins = {&begin, 1};
    EXPECT_FALSE(closest(discs, ray, query)) << name(set);
    EXPECT_FALSE(occluded(discs, ray, query)) << name(set);
  }
}

TEST(Crossing, sheets_end_where_they_do_however_wide_discs_are_and_farther_on_request) {
  std::vector<glm::dvec3> points;
  for (int x = -20; x <= 20; ++x)
    for (int y = -20; y <= 20; ++y) points.emplace_back(0.1 * x, 0.1 * y, 0.0);
  const PointCloud cloud = test::make_cloud(points, {glm::dvec3(1e-3), glm::dvec3(0)});
  const SurfaceCloud discs = discs_of(cloud);
  // Points at the rim have their 8th neighbours 0.2 m away, and their edges half a step of the grid beside
  // them.
  for (const double factor : {0.92, 1.3}) {
    SurfaceQuery query{.radius = 10.0, .spacing_factor = factor, .discs = DiscQuery{}};
    const auto is_met = [&](double x) {
      return occluded(discs, make_ray({x, 0.03, 1.0}, {0.0, 0.0, -1.0}), query);
    };
    EXPECT_TRUE(is_met(2.02)) << factor;
    EXPECT_FALSE(is_met(2.12)) << factor;
    query.discs->edge_shift = 0.5;
    EXPECT_TRUE(is_met(2.12)) << factor;
  }
}

}  // namespace
}  // namespace alidade
