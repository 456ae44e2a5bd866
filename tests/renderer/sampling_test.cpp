// SPDX-License-Identifier: MIT
#include "renderer/sampling.h"

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace alidade {

using namespace renderer;

namespace {

TEST(Sampling, basis_is_right_handed_and_orthonormal_for_every_normal) {
  test::Random random;
  for (int i = 0; i < 5000; ++i) {
    glm::dvec3 normal = glm::normalize(random.direction());
    if (i == 0) normal = {0, 0, 1};
    if (i == 1) normal = {0, 0, -1};
    if (i == 2) normal = {1, 0, -0.0};
    const Basis basis = basis_around(normal);
    ASSERT_NEAR(glm::length(glm::cross(basis.tangent, basis.bitangent) - normal), 0.0, 1e-14);
    ASSERT_NEAR(glm::dot(basis.tangent, normal), 0.0, 1e-14);
    ASSERT_NEAR(glm::length(basis.tangent), 1.0, 1e-14);
    ASSERT_NEAR(glm::length(basis.bitangent), 1.0, 1e-14);
    const glm::dvec3 v = random.in_cube();
    ASSERT_NEAR(glm::length(basis.to_world(basis.to_local(v)) - v), 0.0, 1e-14);
  }
}

TEST(Sampling, disc_is_filled_evenly) {
  constexpr int k_side = 400;
  int inner = 0, right = 0;
  for (int i = 0; i < k_side * k_side; ++i) {
    const glm::dvec2 point = sample_disc({(i % k_side + 0.5) / k_side, (i / k_side + 0.5) / k_side});
    ASSERT_LE(glm::length(point), 1.0);
    inner += glm::length(point) < 0.5;
    right += point.x > 0.5;
  }
  EXPECT_NEAR(inner / double{k_side * k_side}, 0.25, 0.003);
  // Segment beyond x = 1/2: (pi / 3 - sqrt(3) / 4) / pi.
  EXPECT_NEAR(right / double{k_side * k_side}, (k_pi / 3.0 - std::sqrt(3.0) / 4.0) / k_pi, 0.003);
}

TEST(Sampling, corners_of_the_square_stay_finite) {
  const double last = 1.0 - 0x1p-32;
  for (const double x : {0.0, 0.5, last}) {
    for (const double y : {0.0, 0.5, last}) {
      EXPECT_NEAR(glm::length(sample_cosine_hemisphere({x, y})), 1.0, 1e-12);
      EXPECT_NEAR(glm::length(sample_cone({x, y}, 2.0)), 1.0, 1e-12);
      EXPECT_NEAR(glm::length(sample_cone({x, y}, 1e-12)), 1.0, 1e-12);
    }
  }
}

TEST(Sampling, cone_of_a_tiny_angle_keeps_its_spread) {
  // Half angle 1e-6: height 5e-13, below what 1 - cosine could hold.
  const double height = 0.5e-12;
  double mean_sq = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const glm::dvec3 direction = sample_cone({(i + 0.5) / 1000.0, 0.3}, height);
    mean_sq += (direction.x * direction.x + direction.y * direction.y) / 1000.0;
  }
  EXPECT_NEAR(mean_sq, 0.5e-12, 1e-15);
}

}  // namespace
}  // namespace alidade
