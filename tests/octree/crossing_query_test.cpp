// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <memory>

#include "base/error.h"
#include "octree/brute_force.h"
#include "octree/build.h"
#include "octree/candidate.h"
#include "octree/enclosing_spheres.h"
#include "octree/point_surface.h"
#include "octree/query.h"
#include "octree/spacing.h"
#include "octree/tree_walk.h"
#include "tests/octree/explain.h"
#include "tests/support/octrees.h"
#include "tests/support/point_families.h"
#include "tests/support/random.h"
#include "tests/support/ray_families.h"
#include "tests/support/same_hits.h"

namespace alidade {
namespace {

using test::point_families;
using test::PointFamily;
using test::Random;
using test::ray_cases;
using test::RayCase;
using test::same_hits;

constexpr int k_neighbours = 8;

/// The octree with random surfaces, equal ones at equal positions: three in four points have one, half of
/// them an edge.
Octree with_random_surfaces(const Octree& octree) {
  struct Arrays {
    std::vector<std::uint32_t> surfaces;
    std::vector<std::uint8_t> edges;
  };
  const auto made = std::make_shared<Arrays>();
  for (const LatticePosition& position : positions_in_order(octree.view())) {
    std::uint64_t bits = 0x9e3779b97f4a7c15u;
    for (int axis = 0; axis < 3; ++axis) {
      bits = (bits ^ static_cast<std::uint32_t>(position[axis])) * 0xff51afd7ed558ccdu;
      bits ^= bits >> 32;
    }
    made->surfaces.push_back(static_cast<std::uint32_t>(bits) | static_cast<std::uint32_t>(bits >> 32) << 31);
    made->edges.push_back(static_cast<std::uint8_t>((bits >> 40 & 1) == 0 ? 0 : 32 + (bits >> 41) % 224));
  }
  TreeView view = octree.view();
  view.surfaces = made->surfaces.data();
  view.sheet_edges = made->edges.data();
  view.surface_unit = 0.1 * automatic_radius(octree);
  return octree.with_view(view, made);
}

/// Two walls that meet, a floor that ends, coarse beside fine, and points beside them.
PointCloud sheets(Random& random) {
  const glm::dvec3 site(690000.0, 5325000.0, 300.0);
  std::vector<glm::dvec3> points;
  const auto add = [&](double x, double y, double z) { points.push_back(site + glm::dvec3(x, y, z)); };
  for (int i = 0; i < 400; ++i) {
    add(random.between(0, 4), random.between(0, 4), 0.002 * random.in_cube().z);
    add(random.between(0, 4), 4.0 + 0.002 * random.in_cube().z, random.between(0, 3));
    add(4.0, random.between(0, 4), random.between(0, 0.2));
    if (i % 10 == 0) add(random.between(0, 4), random.between(0, 4), random.between(0.2, 3.0));
  }
  return test::make_cloud(points, {glm::dvec3(1e-4), site});
}

struct CloudCase {
  std::string name;
  PointCloud cloud;
  bool fitted = true;  ///< surfaces are fitted, not random
  std::vector<double> spacings{};
};

std::vector<CloudCase> make_cloud_cases() {
  std::vector<CloudCase> cases;
  Random random("sheets");
  const PointCloud cloud = sheets(random);
  cases.push_back({"fitted sheets", cloud, true});
  cases.push_back({"random sheets", cloud, false});
  // Doubles of its coordinates are as coarse as its lattice.
  const glm::dvec3 site(690000.0, 5325000.0, 300.0);
  std::vector<glm::dvec3> grain;
  for (int i = 0; i < 1000; ++i) grain.push_back(site + 1e-4 * random.in_cube());
  cases.push_back({"grain", test::make_cloud(grain, {glm::dvec3(1e-9), site}), false});
  for (const PointFamily& family : point_families()) cases.push_back({family.name, family.cloud, false});
  for (CloudCase& one : cases) one.spacings = brute_force::spacings(one.cloud, k_neighbours);
  return cases;
}

/// Made once: each spacing looks at every point.
const std::vector<CloudCase>& cloud_cases() {
  static const std::vector<CloudCase> cases = make_cloud_cases();
  return cases;
}

Octree with_discs_of(const Octree& octree, bool fitted) {
  const Octree spaced = with_spacings(octree, k_neighbours);
  return with_discs(fitted ? with_surfaces(spaced) : with_random_surfaces(spaced));
}

RayQuery crossing_query(const RayQuery& from, Random& random) {
  constexpr double k_factors[] = {0.1, 0.92, 3.0, 1e6};
  RayQuery query = from;
  query.measure = Measure::crossing;
  query.spacing_factor = k_factors[random.below(4)];
  if (std::isinf(query.radius)) query.radius = 1e9;
  if (random.below(2) == 0) query.discs.lone_factor = random.between(0.0, 2.0);
  if (random.below(2) == 0) query.discs.edge_shift = random.between(-0.5, 0.5);
  if (random.below(2) == 0) query.discs.lone_radius = query.radius * random.between(0.0, 0.5);
  return query;
}

class CrossingVsBruteForce : public ::testing::TestWithParam<InstructionSet> {};

TEST_P(CrossingVsBruteForce, closest_occluded_find_and_count_are_the_same_bits_on_every_family) {
  std::size_t hit_count = 0, miss_count = 0;
  for (const CloudCase& cloud_case : cloud_cases()) {
    for (const test::NamedOctree& named : test::octrees_of(cloud_case.cloud, GetParam())) {
      const Octree octree = with_discs_of(named.octree, cloud_case.fitted);
      const brute_force::PointProperties properties(cloud_case.spacings, &octree.view());
      Random random(cloud_case.name + "_crossing");
      for (const RayCase& c : ray_cases(cloud_case.cloud, 20, random)) {
        const RayQuery query = crossing_query(c.query, random);
        SCOPED_TRACE(cloud_case.name + " " + named.name + " factor " + std::to_string(query.spacing_factor));
        const std::vector<Hit> expected = brute_force::find(cloud_case.cloud, c.ray, query, properties);
        const std::optional<Hit> first = expected.empty() ? std::nullopt : std::optional(expected.front());
        ASSERT_TRUE(same_hits(closest(octree, c.ray, query), first));
        ASSERT_EQ(occluded(octree, c.ray, query), first.has_value());
        ASSERT_TRUE(same_hits(find(octree, c.ray, query), expected));
        ASSERT_EQ(count(octree, c.ray, query), expected.size());
        ASSERT_TRUE(same_hits(test::explain(octree, c.ray, query).hits, expected));
        ++(first ? hit_count : miss_count);
      }
    }
  }
  EXPECT_GT(hit_count, 300u);
  EXPECT_GT(miss_count, 300u);
}

/// Rays between points, which cross discs at all angles.
TEST_P(CrossingVsBruteForce, batches_are_the_same_bits_whatever_the_filter) {
  BuildOptions options;
  options.instruction_set = GetParam();
  std::size_t hit_count = 0;
  for (const CloudCase& cloud_case : cloud_cases()) {
    if (cloud_case.cloud.size() == 0) continue;
    const Octree octree = with_discs_of(build(cloud_case.cloud, options), cloud_case.fitted);
    const brute_force::PointProperties properties(cloud_case.spacings, &octree.view());
    Random random(cloud_case.name + "_crossing_batches");
    for (int turn = 0; turn < 6; ++turn) {
      const double radius = 2.0 * automatic_radius(octree);
      RayQuery query = crossing_query({.radius = std::max(radius, 1e-3) * std::pow(8.0, turn % 3)}, random);
      if (turn % 2 == 1) {
        const auto leans_aside = [](const Candidate& candidate) {
          return candidate.disc == nullptr || candidate.disc->normal.x < 0.3;
        };
        (turn == 5 ? query.filter : query.position_filter) = leans_aside;
      }
      if (turn == 3) query.filter = [](const Candidate& candidate) { return candidate.point_id % 3 != 0; };
      std::vector<Ray> rays;
      for (int i = 0; i < 60; ++i) {
        const glm::dvec3 from = cloud_case.cloud.world(random.below(cloud_case.cloud.size()));
        const glm::dvec3 to = cloud_case.cloud.world(random.below(cloud_case.cloud.size()));
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
      std::vector<std::optional<Hit>> hits(rays.size());
      std::vector<std::uint8_t> blocked(rays.size());
      closest(octree, rays, query, hits);
      occluded(octree, rays, query, blocked);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        SCOPED_TRACE(cloud_case.name + " turn " + std::to_string(turn) + " ray " + std::to_string(i));
        const std::optional<Hit> expected =
            brute_force::closest(cloud_case.cloud, rays[i], query, properties);
        ASSERT_TRUE(same_hits(hits[i], expected));
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
  BuildOptions options;
  options.instruction_set = GetParam();
  std::size_t hit_count = 0;
  for (const CloudCase& cloud_case : cloud_cases()) {
    if (cloud_case.cloud.size() == 0) continue;
    const Octree octree = with_discs_of(build(cloud_case.cloud, options), cloud_case.fitted);
    const brute_force::PointProperties properties(cloud_case.spacings, &octree.view());
    Random random(cloud_case.name + "_crossing_alone");
    RayQuery query = crossing_query({.radius = std::max(4.0 * automatic_radius(octree), 1e-3)}, random);
    query.spacing_factor = 3.0;
    std::vector<Ray> rays;
    std::vector<std::optional<Hit>> expected;
    for (int i = 0; i < 60; ++i) {
      const glm::dvec3 to = cloud_case.cloud.world(random.below(cloud_case.cloud.size()));
      const double away = std::pow(10.0, random.between(-3.0, 2.0));
      const Ray ray = make_ray(to + away * random.in_cube(), random.direction());
      for (const Hit& hit : brute_force::find(cloud_case.cloud, ray, query, properties)) {
        rays.push_back({ray.origin, ray.direction, hit.t, hit.t});
        expected.push_back(brute_force::closest(cloud_case.cloud, rays.back(), query, properties));
        ASSERT_TRUE(expected.back());
        if (rays.size() % 8 == 0) break;
      }
    }
    std::vector<std::optional<Hit>> hits(rays.size());
    std::vector<std::uint8_t> blocked(rays.size());
    closest(octree, rays, query, hits);
    occluded(octree, rays, query, blocked);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      SCOPED_TRACE(cloud_case.name + " ray " + std::to_string(i));
      ASSERT_TRUE(same_hits(hits[i], expected[i]));
      ASSERT_TRUE(blocked[i] != 0);
      ASSERT_TRUE(same_hits(closest(octree, rays[i], query), expected[i]));
      ++hit_count;
    }
  }
  EXPECT_GT(hit_count, 500u);
}

/// A sheet on which a position lies, by the surfaces of random points or of the one that was met there: its
/// limits are as near to what they decide as floats can say.
SheetOrigin sheet_at(const glm::dvec3& position, const std::optional<Hit>& met, const CloudCase& of,
                     const Octree& octree, const RayQuery& query, Random& random) {
  const auto random_disc = [&] {
    const std::uint64_t id = met && random.below(2) == 0 ? met->point_id : random.below(of.cloud.size());
    PointSurface surface = surface_of(octree.view(), id);
    if (!surface.exists) surface.normal = random.direction();
    return point_disc(of.cloud.world(id), surface, own_radius(query, of.spacings[id]));
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
  BuildOptions options;
  options.instruction_set = GetParam();
  std::size_t hits_of_all = 0, left = 0;
  for (const CloudCase& cloud_case : cloud_cases()) {
    if (cloud_case.cloud.size() == 0) continue;
    const Octree octree = with_discs_of(build(cloud_case.cloud, options), cloud_case.fitted);
    const brute_force::PointProperties properties(cloud_case.spacings, &octree.view());
    Random random(cloud_case.name + "_sheets_left");
    for (int turn = 0; turn < 6; ++turn) {
      const double radius = std::max(2.0 * automatic_radius(octree), 1e-3) * std::pow(8.0, turn % 3);
      RayQuery query = crossing_query({.radius = radius}, random);
      std::vector<Ray> rays;
      std::vector<SheetOrigin> begins;
      // Rays side by side, whose answers lie in lanes, too, and others.
      const glm::dvec3 middle = cloud_case.cloud.world(random.below(cloud_case.cloud.size()));
      const glm::dvec3 there = random.direction(), back = random.direction();
      for (int i = 0; i < 50; ++i) {
        const glm::dvec3 to = cloud_case.cloud.world(random.below(cloud_case.cloud.size()));
        const bool is_beside = turn % 2 == 1;
        const Ray first =
            is_beside ? make_ray(middle + 0.3 * radius * random.in_cube() - 3.0 * radius * there, there)
                      : make_ray(to + radius * random.in_cube(), random.direction());
        const auto met = brute_force::closest(cloud_case.cloud, first, query, properties);
        const glm::dvec3 start = met ? first.position(met->t) : first.origin;
        rays.push_back(make_ray(start, is_beside ? back + 0.005 * random.in_cube() : random.direction(),
                                i % 4 == 0 ? -0.1 * radius : 0.0));
        begins.push_back(i % 5 == 0
                             ? SheetOrigin{.reach = -0.1f * static_cast<float>(i % 2), .thickness = 9.0f}
                             : sheet_at(start, met, cloud_case, octree, query, random));
      }
      std::vector<std::optional<Hit>> hits(rays.size()), of_all(rays.size());
      std::vector<std::uint8_t> blocked(rays.size());
      closest(octree, rays, query, of_all);
      query.discs.begins = begins;
      closest(octree, rays, query, hits);
      occluded(octree, rays, query, blocked);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        SCOPED_TRACE(cloud_case.name + " turn " + std::to_string(turn) + " ray " + std::to_string(i));
        RayQuery alone = query;
        alone.discs.begins = std::span(begins).subspan(i, 1);
        const auto expected = brute_force::closest(cloud_case.cloud, rays[i], alone, properties);
        ASSERT_TRUE(same_hits(hits[i], expected));
        ASSERT_EQ(blocked[i] != 0, expected.has_value());
        ASSERT_TRUE(same_hits(closest(octree, rays[i], alone), expected));
        ASSERT_EQ(occluded(octree, rays[i], alone), expected.has_value());
        ASSERT_TRUE(same_hits(find(octree, rays[i], alone),
                              brute_force::find(cloud_case.cloud, rays[i], alone, properties)));
        hits_of_all += expected.has_value();
        left += of_all[i].has_value() && !same_hits(of_all[i], expected);
      }
    }
  }
  EXPECT_GT(hits_of_all, 1000u);
  EXPECT_GT(left, 300u);
}

TEST_P(CrossingVsBruteForce, spheres_that_hold_a_position_are_all_that_do) {
  std::size_t held = 0;
  for (const CloudCase& cloud_case : cloud_cases()) {
    Random random(cloud_case.name + "_enclosing");
    for (const test::NamedOctree& named : test::octrees_of(cloud_case.cloud, GetParam())) {
      const Octree octree = with_spacings(named.octree, k_neighbours);
      for (int i = 0; i < 80 && octree.size() > 0; ++i) {
        RayQuery query = crossing_query({.radius = std::pow(10.0, random.between(-3.0, 3.0))}, random);
        const double away = std::pow(10.0, random.between(-5.0, i == 0 ? 12.0 : 2.0));
        const glm::dvec3 point = cloud_case.cloud.world(random.below(cloud_case.cloud.size()));
        const glm::dvec3 position = point + away * random.in_cube();
        // On the surface of a sphere.
        if (i % 2 == 1) {
          query.radius = distance(
              position, i % 4 == 1 ? point : cloud_case.cloud.world(random.below(cloud_case.cloud.size())));
          query.spacing_factor = 1e6;
          if (!(query.radius > 0.0)) continue;
        }
        std::vector<PointSphere> expected;
        for_each_leaf(octree.view(), [&](const Leaf& leaf) {
          for (std::uint32_t p = 0; p < leaf.count; ++p) {
            const double radius = own_radius(query, spacing_at(octree.view(), leaf.first + p));
            const glm::dvec3 center = to_world(octree.lattice(), position_of(octree.view(), leaf, p));
            if (distance(position, center) <= radius) expected.push_back({center, radius, leaf.first + p});
          }
        });
        std::ranges::sort(expected, {}, &PointSphere::index);
        std::vector<PointSphere> found{{glm::dvec3(7.0), 7.0, 7}};
        find_enclosing(octree, position, query, found);
        ASSERT_EQ(found.size(), expected.size() + 1) << cloud_case.name << " " << named.name << " " << i;
        for (std::size_t s = 0; s < expected.size(); ++s) {
          ASSERT_EQ(found[s + 1].index, expected[s].index);
          ASSERT_EQ(found[s + 1].center, expected[s].center);
          ASSERT_EQ(found[s + 1].radius, expected[s].radius);
        }
        held += expected.size();
      }
    }
  }
  EXPECT_GT(held, 1000u);
}

/// Whether two octrees have the same surfaces and edges.
bool same_surfaces(const TreeView& a, const TreeView& b) {
  const std::size_t count = a.point_count;
  return a.surface_unit == b.surface_unit && std::equal(a.surfaces, a.surfaces + count, b.surfaces) &&
         std::equal(a.sheet_edges, a.sheet_edges + count, b.sheet_edges) &&
         std::equal(a.stored_surfaces, a.stored_surfaces + count, b.stored_surfaces) &&
         std::equal(a.stored_edges, a.stored_edges + count, b.stored_edges);
}

TEST_P(CrossingVsBruteForce, surfaces_that_are_fitted_on_demand_are_the_same) {
  for (const PointFamily& family : point_families()) {
    // Fits take most of the time: one organisation of each, and large clouds with one instruction set.
    constexpr std::size_t k_large = 2500;
    if (family.cloud.size() > k_large && GetParam() != usable(InstructionSet::best)) continue;
    Random random(family.name + "_on_demand");
    const std::vector<test::NamedOctree> octrees = test::octrees_of(family.cloud, GetParam());
    const test::NamedOctree& named = octrees[random.below(octrees.size())];
    SCOPED_TRACE(family.name + " " + named.name);
    const Octree spaced = with_spacings(named.octree, k_neighbours);
    const Octree all = with_discs(with_surfaces(spaced));
    if (all.size() == 0) continue;
    Octree octree = with_surfaces_on_demand(spaced);
    int number = 0;
    for (const RayCase& c : ray_cases(family.cloud, 6, random)) {
      // Whatever touches the leaves first; without an octree of its own, the first query would touch all.
      if (number++ % 3 == 0) octree = with_surfaces_on_demand(spaced);
      RayQuery query = crossing_query(c.query, random);
      if (random.below(3) == 0)
        query.position_filter = [&](const Candidate& point) { return point.position.x > c.ray.origin.x; };
      const std::optional<Hit> expected = closest(all, c.ray, query);
      std::vector<std::optional<Hit>> hits(40);
      switch (random.below(4)) {
        case 0:
          closest(octree, std::vector<Ray>(hits.size(), c.ray), query, hits);
          ASSERT_TRUE(same_hits(hits.back(), expected));
          break;
        case 1:
          ASSERT_EQ(occluded(octree, c.ray, query), expected.has_value());
          break;
        case 2:
          ASSERT_EQ(find(octree, c.ray, query), find(all, c.ray, query));
          break;
        default:
          break;
      }
      ASSERT_TRUE(same_hits(closest(octree, c.ray, query), expected));
      if (expected) {
        EXPECT_EQ(octree.view().surfaces[expected->point_id], all.view().surfaces[expected->point_id]);
        EXPECT_EQ(octree.view().sheet_edges[expected->point_id], all.view().sheet_edges[expected->point_id]);
      }
      std::vector<PointSphere> held;
      find_enclosing(octree, c.ray.origin, query, held);
      for (const PointSphere& sphere : held)
        ASSERT_EQ(octree.view().stored_surfaces[sphere.index], all.view().stored_surfaces[sphere.index]);
    }
    const Octree completed = with_surfaces(octree);
    EXPECT_EQ(completed.view().fitter, nullptr);
    EXPECT_TRUE(same_surfaces(completed.view(), all.view()));
  }
}

INSTANTIATE_TEST_SUITE_P(, CrossingVsBruteForce, ::testing::ValuesIn(available_instruction_sets()),
                         [](const auto& set) { return std::string(name(set.param)); });

TEST(Crossing, batches_whose_threads_touch_the_same_leaves_are_the_same) {
  const PointFamily family = test::point_families()[1];
  const Octree spaced = with_spacings(build(family.cloud), k_neighbours);
  const Octree all = with_discs(with_surfaces(spaced));
  Random random("threads_on_demand");
  std::vector<Ray> rays;
  for (int i = 0; i < 4000; ++i)
    rays.push_back(
        make_ray(family.cloud.world(random.below(family.cloud.size())) + random.in_cube(), random.in_cube()));
  const RayQuery query{.radius = 1e9, .measure = Measure::crossing, .spacing_factor = 0.92};
  std::vector<std::optional<Hit>> expected(rays.size()), hits(rays.size());
  closest(all, rays, query, expected);
  EXPECT_GT(std::ranges::count_if(expected, [](const auto& hit) { return hit.has_value(); }), 400);
  for (int round = 0; round < 20; ++round) {
    const Octree octree = with_surfaces_on_demand(spaced);
    closest(octree, rays, query, hits);
    ASSERT_EQ(hits, expected) << round;
  }
}

TEST(Crossing, of_a_plane_is_known_on_paper) {
  std::vector<glm::dvec3> points;
  for (int x = -20; x <= 20; ++x)
    for (int y = -20; y <= 20; ++y) points.emplace_back(0.1 * x, 0.1 * y, 0.0);
  points.emplace_back(0.0, 0.0, 40.0);  // a bird
  const PointCloud cloud = test::make_cloud(points, {glm::dvec3(1e-3), glm::dvec3(0)});
  const Octree octree = with_discs(with_surfaces(with_spacings(build(cloud), k_neighbours)));
  const RayQuery query{
      .radius = 1.0, .measure = Measure::crossing, .spacing_factor = 0.92, .discs = {.lone_radius = 0.25}};
  const glm::dvec3 direction = glm::normalize(glm::dvec3(3.0, 0.0, -4.0));
  const auto on_plane = closest(octree, make_ray({-1.2, 0.43, 2.0}, direction), query);
  ASSERT_TRUE(on_plane);
  EXPECT_NEAR(on_plane->t, 2.5, 1e-9);
  EXPECT_NEAR(on_plane->position.x, 0.3, 0.13);
  // Steeply along the sheet, where spheres reach far before and beside it.
  const auto grazing = closest(octree, make_ray({-10.0, 0.43, 0.1}, {100.0, 0.0, -1.0}), query);
  ASSERT_TRUE(grazing);
  EXPECT_NEAR(grazing->t * 0.1 / std::hypot(10.0, 0.1), 0.1, 1e-6);
  EXPECT_FALSE(closest(octree, make_ray({-3.0, 0.0, 0.01}, {1.0, 0.0, 0.0}), query))
      << "passes above the sheet";
  EXPECT_FALSE(occluded(octree, make_ray({2.09, 0.0, 1.0}, {0.0, 0.0, -1.0}), query)) << "beyond the edge";
  const auto bird = closest(octree, make_ray({-3.0, 0.15, 40.0}, {1.0, 0.0, 0.0}), query);
  ASSERT_TRUE(bird);
  EXPECT_NEAR(bird->t, 2.8, 1e-9) << "a sphere of 25 cm, met 20 cm before its middle";
  EXPECT_TRUE(occluded(octree, make_ray({-3.0, 0.25, 40.0}, {1.0, 0.0, 0.0}), query));
  EXPECT_FALSE(occluded(octree, make_ray({-3.0, 0.26, 40.0}, {1.0, 0.0, 0.0}), query));
}

/// The limit is closed: numbers are such that nothing is rounded.
TEST(Crossing, a_ray_at_the_edge_of_a_disc_meets_it_and_one_beside_does_not) {
  std::vector<glm::dvec3> points;
  for (int x = -8; x <= 8; ++x)
    for (int y = -8; y <= 8; ++y) points.emplace_back(0.125 * x, 0.125 * y, 0.0);
  const PointCloud cloud = test::make_cloud(points, {glm::dvec3(0.125), glm::dvec3(0)});
  for (const InstructionSet set : available_instruction_sets()) {
    SCOPED_TRACE(name(set));
    BuildOptions options;
    options.instruction_set = set;
    const Octree octree = with_discs(with_surfaces(with_spacings(build(cloud, options), k_neighbours)));
    // Wider by their spacings, so that all have this radius, and no edge of the sheet cuts them.
    for (const double radius : {0.0625, 0.25}) {
      const RayQuery query{.radius = radius, .measure = Measure::crossing, .spacing_factor = 100.0};
      for (const double t_min : {0.0, 2.0}) {
        const auto down = [&](double beside) {
          return make_ray({1.0 + beside, 0.5, 2.0}, {0.0, 0.0, -1.0}, t_min, 2.0);
        };
        const auto met = closest(octree, down(radius), query);
        ASSERT_TRUE(met) << radius;
        EXPECT_EQ(met->t, 2.0);
        EXPECT_EQ(met->position, glm::dvec3(1.0, 0.5, 0.0));
        EXPECT_TRUE(occluded(octree, down(radius), query));
        const double beyond = std::nextafter(1.0 + radius, 2.0) - 1.0;
        EXPECT_FALSE(closest(octree, down(beyond), query)) << radius;
        EXPECT_FALSE(occluded(octree, down(beyond), query)) << radius;
      }
      // So is the limit on the entry into the sphere around the point.
      RayQuery entered = query;
      entered.filter = [](const Candidate& candidate) {
        return candidate.position == glm::dvec3(1.0, 0.5, 0.0);
      };
      const Ray through = make_ray({1.0, 0.5, 2.0}, {0.0, 0.0, -1.0});
      entered.entry_min = 2.0 - radius;
      EXPECT_TRUE(closest(octree, through, entered));
      entered.entry_min = std::nextafter(2.0 - radius, 2.0);
      EXPECT_FALSE(closest(octree, through, entered));
      // The limit is closed for positions in the spheres, too.
      std::vector<PointSphere> held;
      find_enclosing(octree, {1.0 + radius, 0.5, 0.0}, query, held);
      EXPECT_EQ(held.size(), 1u);
      find_enclosing(octree, {std::nextafter(1.0 + radius, 2.0), 0.5, 0.0}, query, held);
      EXPECT_EQ(held.size(), 1u);
    }
  }
}

TEST(Crossing, sheets_end_where_they_do_however_wide_discs_are_and_farther_on_request) {
  std::vector<glm::dvec3> points;
  for (int x = -20; x <= 20; ++x)
    for (int y = -20; y <= 20; ++y) points.emplace_back(0.1 * x, 0.1 * y, 0.0);
  const PointCloud cloud = test::make_cloud(points, {glm::dvec3(1e-3), glm::dvec3(0)});
  const Octree octree = with_discs(with_surfaces(with_spacings(build(cloud), k_neighbours)));
  // Points at the rim have their 8th neighbours 0.2 m away, and their edges half a step of the grid beside
  // them.
  for (const double factor : {0.92, 1.3}) {
    RayQuery query{.radius = 10.0, .measure = Measure::crossing, .spacing_factor = factor};
    const auto is_met = [&](double x) {
      return occluded(octree, make_ray({x, 0.03, 1.0}, {0.0, 0.0, -1.0}), query);
    };
    EXPECT_TRUE(is_met(2.02)) << factor;
    EXPECT_FALSE(is_met(2.12)) << factor;
    query.discs.edge_shift = 0.5;
    EXPECT_TRUE(is_met(2.12)) << factor;
  }
}

TEST(Crossing, without_what_it_needs_is_an_error) {
  const PointCloud cloud = test::make_cloud({{0, 0, 0}, {1, 0, 0}}, {glm::dvec3(0.5), glm::dvec3(0)});
  const Octree spaced = with_spacings(build(cloud), 1);
  const Octree octree = with_discs(with_surfaces(spaced));
  const Ray ray = make_ray({0.0, -5.0, 0.0}, {0.0, 1.0, 0.0});
  const RayQuery query{.radius = 1.0, .measure = Measure::crossing, .spacing_factor = 1.0};
  EXPECT_NO_THROW(closest(octree, ray, query));
  EXPECT_THROW(closest(spaced, ray, query), Error);
  EXPECT_THROW(brute_force::closest(cloud, ray, query, spacings_in_order(spaced.view())), Error);
  for (const RayQuery& bad : {RayQuery{.radius = 1.0, .measure = Measure::crossing},
                              RayQuery{.measure = Measure::crossing, .spacing_factor = 1.0},
                              RayQuery{.radius = 1.0,
                              .measure = Measure::crossing,
                              .spacing_factor = 1.0,
                              .discs = {.lone_radius = -1.0}}})
    EXPECT_THROW(closest(octree, ray, bad), Error);
  // Sheets that rays begin on: one for each ray, and of crossings only.
  const std::vector<SheetOrigin> begins(2);
  const std::vector<Ray> rays(3, ray);
  std::vector<std::optional<Hit>> hits(3);
  std::vector<std::uint8_t> blocked(3);
  std::vector<std::size_t> counts(3);
  RayQuery wrong = query;
  wrong.discs.begins = begins;
  EXPECT_THROW(closest(octree, ray, wrong), Error);
  EXPECT_THROW(occluded(octree, ray, wrong), Error);
  EXPECT_THROW(find(octree, ray, wrong), Error);
  EXPECT_THROW(count(octree, ray, wrong), Error);
  EXPECT_THROW(closest(octree, rays, wrong, hits), Error);
  EXPECT_THROW(occluded(octree, rays, wrong, blocked), Error);
  EXPECT_THROW(find(octree, rays, wrong), Error);
  EXPECT_THROW(count(octree, rays, wrong, counts), Error);
  wrong.measure = Measure::t;
  wrong.discs.begins = std::span(begins).first(1);
  EXPECT_THROW(closest(octree, ray, wrong), Error);
  EXPECT_THROW(
      closest(octree, make_cone({0, -5, 0}, {0, 1, 0}, 0.1), ConeQuery{.measure = Measure::crossing}), Error);
  EXPECT_THROW(find(octree, make_path({{0, 0, 0}, {1, 0, 0}}), PathQuery{.measure = Measure::crossing}),
               Error);
}

}  // namespace
}  // namespace alidade
