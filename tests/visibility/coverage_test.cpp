// SPDX-License-Identifier: MIT
#include "visibility/points/placement.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "base/error.h"
#include "octree/distance.h"
#include "tests/support/random.h"
#include "tests/visibility/wall_cloud.h"

namespace alidade::test {

using namespace visibility;

namespace {

/// A floor with a wall across its middle.
Octree floor_and_wall() {
  return WallCloud()
      .add({-5, -5, 0}, {10, 0, 0}, {0, 10, 0}, 0.1)
      .add({0, -3, 0}, {0, 6, 0}, {0, 0, 2}, 0.1)
      .octree();
}

Observer observer_at(const glm::dvec3& position) {
  Observer observer;
  observer.position = position;
  observer.name = "one";
  return observer;
}

TEST(Coverage, a_wall_hides_what_is_behind_it) {
  const Occluders occluders(floor_and_wall(), {});
  const std::vector<PlacementTarget> targets = thin_points(occluders.octree(), 0.5);
  const std::vector<Observer> candidates = {observer_at({-4, 0, 1}), observer_at({4, 0, 1})};
  const Coverage coverage = see_targets(occluders, candidates, targets, 0.0);
  int checked = 0;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const glm::dvec3 position = targets[i].position;
    if (position.z > 0.05 || std::fabs(position.y) > 2.0 || std::fabs(position.x) < 0.4) continue;
    ++checked;
    EXPECT_EQ(coverage.sees(0, i), position.x < 0.0) << position.x << " " << position.y;
    EXPECT_EQ(coverage.sees(1, i), position.x > 0.0) << position.x << " " << position.y;
  }
  EXPECT_GT(checked, 50);
}

TEST(Coverage, is_that_of_single_sight_lines_within_field_of_view_and_reach) {
  Random random;
  const Occluders occluders(floor_and_wall(), {});
  const std::vector<PlacementTarget> targets = thin_points(occluders.octree(), 0.7);
  std::vector<Observer> candidates;
  for (int i = 0; i < 8; ++i) {
    Observer observer = observer_at({random.between(-4, 4), random.between(-4, 4), random.between(0.5, 2.5)});
    if (i % 2 == 1) observer.azimuth_max = 45.0 * i;
    if (i % 4 >= 2) observer.max_distance = 4.0;
    candidates.push_back(observer);
  }
  for (const double height : {0.0, 0.3}) {
    const Coverage coverage = see_targets(occluders, candidates, targets, height);
    int seen = 0;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      const SightEnd eye = end_near_surface(occluders, candidates[c].position);
      for (std::size_t i = 0; i < targets.size(); ++i) {
        const glm::dvec3 position = targets[i].position + glm::dvec3(0, 0, height);
        const SightEnd end =
            height > 0.0 ? end_near_surface(occluders, position)
                         : end_on_point(occluders, targets[i].point_id, position, candidates[c].position);
        const bool expected = distance(candidates[c].position, position) <= candidates[c].max_distance &&
                              FieldOfView(candidates[c]).contains(position - candidates[c].position) &&
                              !first_blocker(occluders, sight_line(eye, end));
        ASSERT_EQ(coverage.sees(c, i), expected) << c << " " << i;
        seen += expected ? 1 : 0;
      }
    }
    EXPECT_GT(seen, 300);
  }
}

TEST(Coverage, is_the_same_on_one_thread) {
  const Occluders occluders(floor_and_wall(), {});
  const std::vector<PlacementTarget> targets = thin_points(occluders.octree(), 0.3);
  const std::vector<Observer> candidates = {observer_at({-2, 1, 1})};
  const Coverage many = see_targets(occluders, candidates, targets, 0.0);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Coverage single = see_targets(occluders, candidates, targets, 0.0);
  EXPECT_TRUE(std::ranges::equal(many.row(0), single.row(0)));
}

TEST(Coverage, bad_heights_are_errors_and_a_cancelled_run_stops) {
  const Occluders occluders(floor_and_wall(), {});
  const std::vector<PlacementTarget> targets = thin_points(occluders.octree(), 1.0);
  const std::vector<Observer> candidates = {observer_at({-2, 1, 1})};
  EXPECT_THROW(see_targets(occluders, candidates, targets, -1.0), Error);
  EXPECT_THROW(see_targets(occluders, candidates, targets, std::nan("")), Error);
  EXPECT_THROW(
      see_targets(occluders, candidates, targets, 0.0, [](std::uint64_t, std::uint64_t) { return false; }),
      Cancelled);
}

}  // namespace
}  // namespace alidade::test
