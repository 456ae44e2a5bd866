// SPDX-License-Identifier: MIT
// Sight lines through points against the exact surfaces that the points were sampled from.
#include <gtest/gtest.h>

#include "octree/build.h"
#include "octree/spacing.h"
#include "tests/support/known_visibility.h"
#include "visibility/points/point_visibility.h"

namespace alidade {

using namespace visibility;

namespace {

using test::KnownScene;

std::vector<std::uint8_t> seen_from(const Occluders& occluders, const glm::dvec3& eye) {
  Observer observer;
  observer.position = eye;
  const PointVisibility found = point_visibility(occluders, {&observer, 1}, {});
  return {found.counts.begin(), found.counts.end()};
}

void expect_truth(const KnownScene& scene, double least) {
  const Occluders occluders(build(scene.cloud), {});
  for (const glm::dvec3& eye : scene.observers) {
    const std::vector<std::uint8_t> truth = test::truth(scene, eye);
    const test::Agreement agreement =
        test::agreement(seen_from(occluders, eye), truth,
                        test::near_boundary_or_edge(scene, occluders.octree(), truth, eye, 40));
    EXPECT_GE(agreement.clear, least) << scene.name;
    EXPECT_GT(agreement.precision, 0.7) << scene.name;
    EXPECT_GT(agreement.recall, 0.8) << scene.name;
  }
}

TEST(KnownVisibility, of_a_courtyard_is_found) {
  expect_truth(test::known_courtyard(100000), 0.97);
}

TEST(KnownVisibility, of_a_fence_is_found) {
  expect_truth(test::fence(), 0.99);
}

TEST(KnownVisibility, of_trees_is_found) {
  expect_truth(test::canopy(), 0.985);
}

TEST(KnownVisibility, of_a_wall_of_two_densities_is_found) {
  expect_truth(test::mixed_density(), 0.99);
}

TEST(KnownVisibility, of_ground_at_grazing_angles_is_found) {
  expect_truth(test::grazing_slope(), 0.96);
}

TEST(KnownVisibility, of_a_thin_plate_is_found) {
  // Both sides lie within two radii of each other, so all points are near a boundary.
  const KnownScene scene = test::thin_plate();
  const Occluders occluders(build(scene.cloud), {});
  for (const glm::dvec3& eye : scene.observers) {
    const test::Agreement agreement = test::agreement(seen_from(occluders, eye), test::truth(scene, eye),
                                                      std::vector<std::uint8_t>(scene.cloud.size()));
    EXPECT_GT(agreement.clear, 0.95);
  }
}

}  // namespace
}  // namespace alidade
