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

using test::box_cases;
using test::BoxCase;
using test::describe;
using test::NamedOctree;
using test::octrees_of;
using test::point_cases;
using test::point_families;
using test::PointCase;
using test::PointFamily;
using test::Random;
using test::same_hits;

class PointSearchVsBruteForce : public ::testing::TestWithParam<InstructionSet> {};

/// find and count of all cases, in all organisations.
template <class Case, class MakeCases>
void expect_brute_force(const MakeCases& make_cases) {
  std::size_t hit_count = 0, miss_count = 0;
  for (const PointFamily& family : point_families()) {
    Random random(family.name + ::testing::UnitTest::GetInstance()->current_test_info()->name());
    const std::vector<Case> cases = make_cases(family.cloud, random);
    const std::vector<NamedOctree> octrees = octrees_of(family.cloud);
    for (const Case& c : cases) {
      const std::vector<PointHit> expected = brute_force::find(family.cloud, c.target, c.query);
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
  EXPECT_GT(miss_count, 100u);
}

TEST(PointSearch, points_near_a_point_are_those_of_brute_force_in_every_organisation) {
  expect_brute_force<PointCase>(
      [](const PointCloud& cloud, Random& random) { return point_cases(cloud, 200, random); });
}

TEST(PointSearch, points_in_a_box_are_those_of_brute_force_in_every_organisation) {
  expect_brute_force<BoxCase>(
      [](const PointCloud& cloud, Random& random) { return box_cases(cloud, 200, random); });
}

TEST_P(PointSearchVsBruteForce, gives_the_bits_of_brute_force) {
  for (const PointFamily& family : point_families()) {
    Random random(family.name + "_instruction_sets");
    const std::vector<PointCase> near_points = point_cases(family.cloud, 100, random);
    const std::vector<BoxCase> boxes = box_cases(family.cloud, 100, random);
    for (const Organisation organisation : {Organisation::adaptive, Organisation::layered}) {
      BuildOptions options;
      options.organisation = organisation;
      options.instruction_set = GetParam();
      const Octree octree = build(family.cloud, options);
      for (const PointCase& c : near_points) {
        const std::vector<PointHit> expected = brute_force::find(family.cloud, c.target, c.query);
        ASSERT_TRUE(same_hits(find(octree, c.target, c.query), expected))
            << family.name << ", " << describe(c);
        ASSERT_EQ(count(octree, c.target, c.query), expected.size()) << family.name << ", " << describe(c);
      }
      for (const BoxCase& c : boxes) {
        const std::vector<PointHit> expected = brute_force::find(family.cloud, c.target, c.query);
        ASSERT_TRUE(same_hits(find(octree, c.target, c.query), expected))
            << family.name << ", " << describe(c);
        ASSERT_EQ(count(octree, c.target, c.query), expected.size()) << family.name << ", " << describe(c);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(PointSearch, PointSearchVsBruteForce,
                         ::testing::ValuesIn(available_instruction_sets()),
                         [](const auto& set) { return std::string(name(set.param)); });

TEST(PointSearch, many_neighbours_are_those_of_brute_force) {
  for (const PointFamily& family : point_families()) {
    Random random(family.name + "_many_neighbours");
    const Octree octree = build(family.cloud);
    for (PointCase& c : point_cases(family.cloud, 20, random)) {
      for (const std::size_t k : {16, 17, 63, 64, 65, 300, 1499}) {
        c.query.k = k;
        ASSERT_TRUE(
            same_hits(find(octree, c.target, c.query), brute_force::find(family.cloud, c.target, c.query)))
            << family.name << ", " << describe(c);
      }
    }
  }
}

TEST(PointSearch, of_points_at_one_position_those_with_the_lowest_ids_are_nearest) {
  PointCloud cloud;
  cloud.lattice.scale = glm::dvec3(0.001);
  cloud.positions.assign(40000, LatticePosition(5000));
  for (std::size_t id = 1; id < cloud.positions.size(); id += 20000)
    cloud.positions[id] = LatticePosition(5001);
  for (const NamedOctree& named : octrees_of(cloud)) {
    for (const std::size_t k : {1, 8, 33, 100, 1000}) {
      const PointQuery query{.k = k};
      for (const glm::dvec3& point : {glm::dvec3(5.0), glm::dvec3(5.001), glm::dvec3(9.0)}) {
        ASSERT_TRUE(same_hits(find(named.octree, point, query), brute_force::find(cloud, point, query)))
            << named.name << " k " << k;
      }
    }
  }
}

TEST(PointSearch, ids_follow_the_level_when_only_coarse_levels_are_asked_for) {
  for (const PointFamily& family : point_families()) {
    for (const NamedOctree& named : octrees_of(family.cloud)) {
      if (named.octree.view().organisation != Organisation::layered) continue;
      Random random(family.name + named.name);
      const std::vector<int> levels = test::levels_by_id(named.octree);
      for (int level = 0; level < 4; ++level) {
        const auto is_coarse = [&](const Candidate& point) { return levels[point.point_id] <= level; };
        for (PointCase& c : point_cases(family.cloud, 20, random)) {
          c.query.filter = is_coarse;
          const std::vector<PointHit> expected = brute_force::find(family.cloud, c.target, c.query);
          c.query.filter = {};
          c.query.max_level = level;
          ASSERT_TRUE(same_hits(find(named.octree, c.target, c.query), expected))
              << family.name << describe(c);
          ASSERT_EQ(count(named.octree, c.target, c.query), expected.size()) << family.name << describe(c);
        }
        for (BoxCase& c : box_cases(family.cloud, 20, random)) {
          c.query.filter = is_coarse;
          const std::vector<PointHit> expected = brute_force::find(family.cloud, c.target, c.query);
          c.query.filter = {};
          c.query.max_level = level;
          ASSERT_TRUE(same_hits(find(named.octree, c.target, c.query), expected))
              << family.name << describe(c);
          ASSERT_EQ(count(named.octree, c.target, c.query), expected.size()) << family.name << describe(c);
        }
      }
    }
  }
}

}  // namespace
}  // namespace alidade
