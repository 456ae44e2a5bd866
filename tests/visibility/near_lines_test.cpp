// SPDX-License-Identifier: MIT
#include "visibility/horizon/near_lines.h"

#include <gtest/gtest.h>

#include "geo/earth.h"
#include "tests/support/random.h"
#include "tests/visibility/sampled_shapes.h"

namespace alidade::test {
namespace {

using namespace visibility;

/// Crowns around an eye, some of them straight above and below it and one that holds it.
Points crowns() {
  Random random("crowns");
  Points points;
  for (const glm::dvec3& middle : {glm::dvec3(8, 3, 2), {-5, -20, 9}, {0, 0, 6}, {0.5, 0, -4}, {0, 0.3, 0}})
    for (int i = 0; i < 300; ++i) points.push_back(middle + 1.5 * random.in_cube());
  return points;
}

TEST(NearLines, no_line_that_is_called_free_is_blocked) {
  const Octree octree = octree_of(crowns());
  const ElevationSteps elevations{.per_quarter = 45, .low = -45, .high = 40};
  for (const AzimuthSteps& azimuths :
       {AzimuthSteps{90, 0, 90}, AzimuthSteps{90, -7, 20}, AzimuthSteps{90, 85, 90}}) {
    for (const int steps_together : {1, 4, 16}) {
      const SightEnd eye{{0.1, 0.2, 1.9}};
      const Occluders occluders(octree, {});
      const NearLines near(occluders, eye, azimuths, elevations, steps_together);
      int blocked_lines = 0, free_lines = 0, called_free = 0;
      for (int azimuth = 0; azimuth < azimuths.count; ++azimuth) {
        for (int step = elevations.low; step <= elevations.high; ++step) {
          const SightLine line =
              sight_ray(eye, geo::compass_direction(azimuths.azimuth(azimuth), elevations.elevation(step)));
          const bool is_blocked = first_blocker(occluders, line).has_value();
          const bool is_free = near.are_free(azimuth, step, step);
          ASSERT_FALSE(is_blocked && is_free) << azimuth << ' ' << step;
          ASSERT_LE(near.are_free(azimuth, std::max(step - 5, elevations.low), step), is_free);
          (is_blocked ? blocked_lines : free_lines) += 1;
          called_free += is_free;
        }
      }
      EXPECT_GT(blocked_lines, 50);
      if (steps_together == 1) {
        EXPECT_GT(called_free, free_lines / 3);
      }
    }
  }
}

TEST(NearLines, nothing_is_free_around_an_eye_within_reach_of_a_point) {
  const Octree octree = octree_of({{0, 0, 0}, {50, 0, 0}, {0, 50, 0}});
  const Occluders occluders(octree, {.shape = OccluderShape::sphere, .radius = 2.0});
  const AzimuthSteps azimuths{8, 0, 8};
  const ElevationSteps elevations{.per_quarter = 2, .low = -2, .high = 2};
  // Beside the sphere, whose near side fills almost half of what is seen.
  const NearLines beside(occluders, {{0, -2.001, 0}}, azimuths, elevations, 1);
  EXPECT_FALSE(beside.are_free(0, -2, 2));
  EXPECT_TRUE(beside.are_free(4, 0, 0)) << "south";
  // Within it the point does not block.
  const NearLines within(occluders, {{0, -1.9, 0}}, azimuths, elevations, 1);
  EXPECT_TRUE(within.are_free(0, 1, 2));
}

}  // namespace
}  // namespace alidade::test
