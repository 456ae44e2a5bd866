// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include "octree/brute_force.h"
#include "octree/query.h"
#include "tests/support/octrees.h"
#include "tests/support/point_families.h"
#include "tests/support/query_families.h"
#include "tests/support/same_hits.h"

namespace alidade::test {

/// How many cases were answered, to check that a test queried something.
struct Tally {
  std::size_t answers = 0;  ///< points
  std::size_t empty = 0;    ///< cases without any
  std::size_t cases = 0;
};

/// Queries one case in every way.
template <class Target, class Query>
void expect_as_brute_force(const PointCloud& cloud, const Octree& octree, const QueryCase<Target, Query>& c,
                           Tally& tally) {
  const auto expected = brute_force::find(cloud, c.target, c.query);
  ASSERT_TRUE(same_hits(find(octree, c.target, c.query), expected));
  ASSERT_EQ(count(octree, c.target, c.query), expected.size());
  if constexpr (requires { closest(octree, c.target, c.query); }) {
    std::optional<typename decltype(expected)::value_type> first;
    if (!expected.empty()) first = expected.front();
    ASSERT_TRUE(same_hits(closest(octree, c.target, c.query), first));
    ASSERT_EQ(occluded(octree, c.target, c.query), first.has_value());
  }
  tally.answers += expected.size();
  tally.empty += expected.empty();
  ++tally.cases;
}

/// Queries cases around every point family in octrees of every organisation with every instruction set, in
/// turn. make_cases(cloud, count, random) as in query_families.h.
template <class MakeCases>
Tally expect_as_brute_force_on_every_family(std::size_t cases_per_family, const MakeCases& make_cases) {
  Tally tally;
  const std::vector<InstructionSet> sets = available_instruction_sets();
  const std::string test = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  for (const PointFamily& family : point_families()) {
    const std::vector<NamedOctree> octrees = octrees_of(family.cloud);
    const std::string seed = test + " " + family.name;
    Random random(seed);
    std::size_t i = 0;
    for (const auto& c : make_cases(family.cloud, cases_per_family, random)) {
      const NamedOctree& named = octrees[i % octrees.size()];
      const InstructionSet set = sets[i / octrees.size() % sets.size()];
      SCOPED_TRACE("seed \"" + seed + "\", case " + std::to_string(i) + ", " + named.name + ", " +
                   std::string(name(set)) + ": " + describe(c));
      expect_as_brute_force(family.cloud, named.octree.with_instruction_set(set), c, tally);
      if (::testing::Test::HasFailure()) return tally;
      ++i;
    }
  }
  return tally;
}

/// Three points along the x axis: 0 at (10, 0, 0), 1 at (5, 0.5, 0), 2 at (20, 0, 0).
inline PointCloud three_points() {
  return make_cloud({{10, 0, 0}, {5, 0.5, 0}, {20, 0, 0}}, {glm::dvec3(0.001), glm::dvec3(0)});
}

/// Ids in the order of the answers.
template <class Answers>
std::vector<std::uint64_t> ids_of(const Answers& answers) {
  std::vector<std::uint64_t> ids;
  for (const auto& answer : answers) ids.push_back(answer.point_id);
  return ids;
}

using Ids = std::vector<std::uint64_t>;

}  // namespace alidade::test
