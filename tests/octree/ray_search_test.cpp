// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "octree/brute_force.h"
#include "octree/query.h"
#include "tests/support/octrees.h"
#include "tests/support/point_families.h"
#include "tests/support/query_families.h"
#include "tests/support/same_hits.h"

namespace alidade {
namespace {

using test::describe;
using test::find_ray_cases;
using test::FindRayCase;
using test::NamedOctree;
using test::octrees_of;
using test::point_families;
using test::PointFamily;
using test::Random;
using test::same_hits;

class RaySearchVsBruteForce : public ::testing::TestWithParam<InstructionSet> {};

TEST(RaySearch, points_along_a_ray_are_those_of_brute_force_in_every_organisation) {
  std::size_t hit_count = 0, miss_count = 0;
  for (const PointFamily& family : point_families()) {
    Random random(family.name + "_ray_search");
    const std::vector<NamedOctree> octrees = octrees_of(family.cloud);
    for (const FindRayCase& c : find_ray_cases(family.cloud, 300, random)) {
      const std::vector<Hit> expected = brute_force::find(family.cloud, c.target, c.query);
      ++(expected.empty() ? miss_count : hit_count);
      for (const NamedOctree& named : octrees) {
        ASSERT_TRUE(same_hits(find(named.octree, c.target, c.query), expected))
            << family.name << ", " << named.name << ", " << describe(c);
        ASSERT_EQ(count(named.octree, c.target, c.query), expected.size())
            << family.name << ", " << named.name << ", " << describe(c);
      }
    }
  }
  EXPECT_GT(hit_count, 1000u);
  EXPECT_GT(miss_count, 1000u);
}

TEST_P(RaySearchVsBruteForce, gives_the_bits_of_brute_force) {
  for (const PointFamily& family : point_families()) {
    Random random(family.name + "_instruction_sets");
    const std::vector<FindRayCase> cases = find_ray_cases(family.cloud, 200, random);
    for (const Organisation organisation : {Organisation::adaptive, Organisation::layered}) {
      BuildOptions options;
      options.organisation = organisation;
      options.instruction_set = GetParam();
      const Octree octree = build(family.cloud, options);
      for (const FindRayCase& c : cases) {
        const std::vector<Hit> expected = brute_force::find(family.cloud, c.target, c.query);
        ASSERT_TRUE(same_hits(find(octree, c.target, c.query), expected))
            << family.name << ", " << describe(c);
        ASSERT_EQ(count(octree, c.target, c.query), expected.size()) << family.name << ", " << describe(c);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(RaySearch, RaySearchVsBruteForce, ::testing::ValuesIn(available_instruction_sets()),
                         [](const auto& set) { return std::string(name(set.param)); });

TEST(RaySearch, many_points_are_those_of_brute_force_by_every_measure) {
  for (const PointFamily& family : point_families()) {
    Random random(family.name + "_many_points");
    const Octree octree = build(family.cloud);
    for (FindRayCase& c : find_ray_cases(family.cloud, 20, random)) {
      for (const std::size_t k : {16, 17, 64, 65, 300, 1499}) {
        c.query.k = k;
        ASSERT_TRUE(
            same_hits(find(octree, c.target, c.query), brute_force::find(family.cloud, c.target, c.query)))
            << family.name << ", " << describe(c);
      }
    }
  }
}

TEST(RaySearch, of_points_at_one_position_those_with_the_lowest_ids_come_first) {
  PointCloud cloud;
  cloud.lattice.scale = glm::dvec3(0.001);
  cloud.positions.assign(40000, LatticePosition(5000));
  const Ray through = make_ray({0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}),
            beside = make_ray({0.0, 0.0, 0.1}, {1.0, 0.9, 1.0});
  for (const NamedOctree& named : octrees_of(cloud)) {
    for (const Measure measure : {Measure::distance, Measure::t, Measure::entry}) {
      for (const std::size_t k : {1, 8, 33, 1000}) {
        const RayQuery query{.radius = 3.0, .measure = measure, .k = k};
        for (const Ray& ray : {through, beside}) {
          ASSERT_TRUE(same_hits(find(named.octree, ray, query), brute_force::find(cloud, ray, query)))
              << named.name << " k " << k;
        }
      }
    }
  }
}

TEST(RaySearch, offsets_far_from_the_points_cost_no_answer) {
  // Steps and offset nearly cancel, so world coordinates are rounded much more coarsely than their size
  // suggests.
  PointCloud cloud;
  cloud.lattice = {glm::dvec3(0.001), glm::dvec3(-2e6, 1.5e6, 1e6)};
  Random random;
  for (int i = 0; i < 3000; ++i) {
    LatticePosition position;
    for (int axis = 0; axis < 3; ++axis)
      position[axis] = static_cast<std::int32_t>(-cloud.lattice.offset[axis] * 1000.0) +
                       static_cast<std::int32_t>(random.below(2000));
    cloud.positions.push_back(position);
  }
  const Octree octree = build(cloud);
  for (const FindRayCase& c : find_ray_cases(cloud, 500, random)) {
    ASSERT_TRUE(same_hits(find(octree, c.target, c.query), brute_force::find(cloud, c.target, c.query)))
        << describe(c);
  }
}

}  // namespace
}  // namespace alidade
