// SPDX-License-Identifier: MIT
#include "cloud/lattice.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "base/error.h"
#include "tests/support/random.h"

namespace alidade {
namespace {

CoordinateSurvey survey(glm::dvec3 min, glm::dvec3 max, glm::dvec3 resolution) {
  CoordinateSurvey result;
  result.bounds.grow(min);
  result.bounds.grow(max);
  result.finite_count = 2;
  result.resolution = resolution;
  return result;
}

Lattice fit(const CoordinateSurvey& one) {
  return fit_lattice(std::span(&one, 1));
}

TEST(FitLatticeTest, millimetres_in_text_give_a_scale_of_a_millimetre) {
  const Lattice lattice = fit(survey({690000, 5325000, 480}, {690100, 5325100, 530}, glm::dvec3(0.0005)));
  EXPECT_EQ(lattice.scale, glm::dvec3(0.001));
  EXPECT_EQ(lattice.offset, glm::dvec3(690050, 5325050, 505));
}

TEST(FitLatticeTest, rounding_stays_within_the_resolution_where_32_bits_reach) {
  test::Random random;
  for (int i = 0; i < 1000; ++i) {
    const double resolution = std::pow(10.0, random.between(-6, 0));
    const glm::dvec3 corner(random.between(-1e6, 1e6));
    const Lattice lattice = fit(survey(corner, corner + random.between(0, 1000), glm::dvec3(resolution)));
    EXPECT_LE(0.5 * lattice.scale.x, resolution);
    EXPECT_GT(5.0 * lattice.scale.x, resolution) << "finer than needed";
  }
}

TEST(FitLatticeTest, doubles_get_the_finest_power_of_ten_that_32_bits_hold) {
  const CoordinateSurvey one = survey({690000, 5325000, 480}, {690100, 5325100, 530}, glm::dvec3(0));
  const Lattice lattice = fit(one);
  EXPECT_EQ(lattice.scale, glm::dvec3(1e-7));
  EXPECT_TRUE(to_lattice(lattice, one.bounds.min) && to_lattice(lattice, one.bounds.max));
}

TEST(FitLatticeTest, every_extent_fits_into_32_bits) {
  test::Random random;
  for (int i = 0; i < 1000; ++i) {
    const double size = std::pow(10.0, random.between(-30, 30)),
                 centre = std::pow(10.0, random.between(-30, 30));
    const CoordinateSurvey one = survey(glm::dvec3(centre - size), glm::dvec3(centre + size), glm::dvec3(0));
    const Lattice lattice = fit(one);
    EXPECT_TRUE(to_lattice(lattice, one.bounds.min) && to_lattice(lattice, one.bounds.max))
        << centre << " " << size;
  }
}

TEST(FitLatticeTest, an_axis_that_cannot_have_the_common_scale_gets_the_nearest) {
  // Degrees beside metres.
  EXPECT_EQ(fit(survey({8, 47, 0}, {9, 48, 4000}, {5e-10, 5e-10, 5e-3})).scale, glm::dvec3(1e-9, 1e-9, 1e-6));
  // Whole metres beside a z of many digits.
  EXPECT_EQ(fit(survey({0, 0, 0}, {400, 400, 10}, {0.5, 0.5, 5e-9})).scale, glm::dvec3(1e-7, 1e-7, 1e-8));
}

TEST(FitLatticeTest, the_finest_file_decides_and_files_without_points_do_not) {
  const std::vector<CoordinateSurvey> surveys = {survey({0, 0, 0}, {10, 10, 10}, glm::dvec3(0.05)),
                                                 survey({5, 5, 5}, {20, 20, 20}, glm::dvec3(0.005)),
                                                 CoordinateSurvey{}};
  EXPECT_EQ(fit_lattice(surveys).scale, glm::dvec3(0.01));
  EXPECT_EQ(fit_lattice(surveys).offset, glm::dvec3(10));
}

TEST(FitLatticeTest, no_points_one_point_and_a_flat_cloud_have_a_lattice) {
  EXPECT_EQ(fit_lattice({}), Lattice{});
  EXPECT_EQ(fit(survey({3, 4, 5}, {3, 4, 5}, glm::dvec3(0))).scale, glm::dvec3(0.001));
  const Lattice flat = fit(survey({0, 0, 7}, {100, 100, 7}, glm::dvec3(0)));
  EXPECT_GT(flat.scale.z, 0.0);
  EXPECT_EQ(to_world(flat, *to_lattice(flat, {1, 1, 7})).z, 7.0);
}

TEST(FitLatticeTest, coordinates_beyond_all_reason_are_an_error) {
  const double huge = std::numeric_limits<double>::max();
  EXPECT_THROW(fit(survey(glm::dvec3(-huge), glm::dvec3(huge), glm::dvec3(0))), Error);
  EXPECT_THROW(fit(survey(glm::dvec3(huge), glm::dvec3(huge), glm::dvec3(0))), Error);
}

TEST(StepsBetweenTest, offsets_may_differ_by_whole_steps_only) {
  const Lattice to{.scale = glm::dvec3(0.01), .offset = {637012.24, 849028.31, 431.66}};
  const Lattice from{.scale = glm::dvec3(0.01), .offset = {0, 1000, 431.67}};
  ASSERT_TRUE(steps_between(from, to));
  EXPECT_EQ(*steps_between(from, to), glm::i64vec3(-63701224, -84802831, 1));
  EXPECT_FALSE(steps_between({.scale = glm::dvec3(0.01), .offset = {0.005, 0, 0}}, to));
  EXPECT_FALSE(steps_between({.scale = glm::dvec3(0.001), .offset = to.offset}, to));
  EXPECT_FALSE(steps_between({.scale = glm::dvec3(0.01), .offset = glm::dvec3(1e300)}, to));
}

TEST(StepsBetweenTest, fine_scales_at_far_offsets_agree_within_the_rounding_of_the_offsets) {
  const Lattice to{.scale = glm::dvec3(1e-6), .offset = glm::dvec3(5325000.1)};
  const Lattice from{.scale = glm::dvec3(1e-6), .offset = glm::dvec3(5325000.1 + 123456e-6)};
  const double exact = (from.offset.x - to.offset.x) / 1e-6;
  ASSERT_GT(std::abs(exact - std::nearbyint(exact)), 1e-5) << "the offsets are too good for this test";
  ASSERT_TRUE(steps_between(from, to));
  EXPECT_EQ(*steps_between(from, to), glm::i64vec3(123456));
  EXPECT_FALSE(steps_between({.scale = to.scale, .offset = to.offset + 0.5e-6}, to));
}

}  // namespace
}  // namespace alidade
