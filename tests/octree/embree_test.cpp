// SPDX-License-Identifier: MIT
// Our `entry` hits against Embree's sphere geometry, hit for hit. Built only where Embree 3 is installed.
#include <gtest/gtest.h>

#include <cmath>

#include "octree/build.h"
#include "octree/candidate.h"
#include "tests/support/embree_spheres.h"
#include "tests/support/point_families.h"

namespace alidade {
namespace {

constexpr double k_radius = 0.1;

TEST(Embree, sphere_hits_agree_with_entry_hits_within_float_error) {
  test::Random random;
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 60000; ++i) {
    positions.push_back(
        {random.between(-10, 10), random.between(-10, 10), 0.3 * std::floor(random.between(0, 10))});
  }
  const PointCloud cloud = test::make_cloud(positions, {glm::dvec3(0.0009765625), glm::dvec3(0)});
  const test::EmbreeSpheres spheres(cloud, k_radius);
  const Octree octree = build(cloud);
  // A float at 20 m is good for 2e-6 m; t near a rim moves with the square root of that.
  constexpr double k_position_tolerance = 2e-5, k_rim_tolerance = 1e-5;
  int hits = 0, misses = 0, other_point = 0;
  for (int i = 0; i < 40000; ++i) {
    const glm::dvec3 origin(random.between(-15, 15), random.between(-15, 15), 20.0);
    const glm::dvec3 target(random.between(-10, 10), random.between(-10, 10), 0.0);
    Ray ray = make_ray(glm::vec3(origin), target - origin, 0.0);
    const std::optional<Hit> ours = closest(octree, ray, {.radius = k_radius});
    const RTCRayHit theirs = spheres.closest(ray);
    const bool embree_hit = theirs.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    if (ours && embree_hit && ours->point_id == theirs.hit.primID) {
      const double rim = std::sqrt(std::max(0.0, k_radius * k_radius - ours->distance * ours->distance));
      EXPECT_NEAR(ours->entry, theirs.ray.tfar, k_position_tolerance + 4e-7 / std::max(rim, 1e-4))
          << "ray " << i;
      ++hits;
    } else if (ours.has_value() == embree_hit) {
      misses += !ours;
      other_point += ours.has_value();
      // Two spheres entered at the same position within float error may change order.
      if (ours) {
        EXPECT_NEAR(ours->entry, theirs.ray.tfar, 1e-3) << "ray " << i;
      }
    } else {
      // One of the two just misses a rim: the sphere that only one sees must be grazed.
      const auto seen = ours ? *ours
                             : Hit{theirs.hit.primID, cloud.world(theirs.hit.primID), 0,
                                   project(ray, cloud.world(theirs.hit.primID)).distance, 0};
      EXPECT_NEAR(seen.distance, k_radius, k_rim_tolerance) << "ray " << i;
    }
  }
  EXPECT_GT(hits, 25000);
  EXPECT_GT(misses, 100);
  EXPECT_LT(other_point, 40);
}

}  // namespace
}  // namespace alidade
