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

TEST(FitLatticeTest, an_axis_along_which_nothing_lies_asks_for_no_resolution) {
  // Half an ulp of a float of 0 is the least number that a float holds.
  constexpr double k_least = 0.5 * std::numeric_limits<float>::denorm_min();
  EXPECT_EQ(fit(survey({-12, 0, 0}, {9, 3, 0}, {5e-7, 5e-7, k_least})).scale, glm::dvec3(1e-6));
  EXPECT_EQ(fit(survey({-12, 0, -1e-30}, {9, 3, 1e-30}, {5e-7, 5e-7, k_least})).scale, glm::dvec3(1e-6));
  EXPECT_EQ(fit(survey({0, 0, 0}, {0, 0, 0}, glm::dvec3(k_least))).scale, glm::dvec3(0.001));
  const CoordinateSurvey heights[] = {survey({-3, -3, 0}, {3, 3, 0}, {1.2e-7, 1.2e-7, k_least}),
                                      survey({-3, -3, 0.4}, {3, 3, 0.4}, {1.2e-7, 1.2e-7, 1.5e-8})};
  EXPECT_EQ(fit_lattice(heights).scale, glm::dvec3(1e-8)) << "two scans, one of them at height 0";
  // What is small beside others but there keeps its digits.
  EXPECT_EQ(fit(survey({-12, 0, 0}, {9, 3, 1e-6}, {5e-7, 5e-7, 5e-14})).scale.z, 1e-13);
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
  EXPECT_EQ(*steps_between(from, to), (LatticeSteps{glm::i64vec3(1), {-63701224, -84802831, 1}}));
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
  EXPECT_EQ(*steps_between(from, to), (LatticeSteps{glm::i64vec3(1), glm::i64vec3(123456)}));
  EXPECT_FALSE(steps_between({.scale = to.scale, .offset = to.offset + 0.5e-6}, to));
}

TEST(StepsBetweenTest, a_step_may_be_a_whole_number_of_the_others) {
  const Lattice fine{.scale = {0.001, 0.0005, 1e-7}, .offset = {0.5, 0, 0}};
  const Lattice coarse{.scale = {0.01, 0.01, 0.001}, .offset = {0.523, 100, -7}};
  ASSERT_TRUE(steps_between(coarse, fine));
  EXPECT_EQ(*steps_between(coarse, fine), (LatticeSteps{{10, 20, 10'000}, {23, 200'000, -70'000'000}}));
  EXPECT_FALSE(steps_between(fine, coarse));
  // Off by a hundred-thousandth of a step after 32 bits of steps.
  EXPECT_FALSE(steps_between({.scale = glm::dvec3(0.01 * (1 + 1e-12))}, {.scale = glm::dvec3(0.01)}));
  EXPECT_TRUE(steps_between({.scale = glm::dvec3(0.01 * (1 + 1e-15))}, {.scale = glm::dvec3(0.01)}));
}

const Bounds k_site{glm::dvec3(0.0), glm::dvec3(1000.0)};

glm::dvec3 joined_scale(std::initializer_list<Lattice> lattices, const Bounds& bounds = k_site) {
  return joined_lattice(std::span(lattices.begin(), lattices.size()), bounds).scale;
}

Lattice of_scale(double scale, double offset = 0.0) {
  return {.scale = glm::dvec3(scale), .offset = glm::dvec3(offset)};
}

TEST(JoinedLatticeTest, the_first_is_kept_if_it_holds_all) {
  const Lattice first = of_scale(0.001, 5.0);
  const Lattice lattices[] = {first, of_scale(0.01, 7.0), of_scale(0.001, 9.123), of_scale(0.25, 0.0)};
  EXPECT_EQ(joined_lattice(lattices, k_site), first);
  EXPECT_EQ(joined_lattice({&first, 1}, {}), first);
}

TEST(JoinedLatticeTest, the_finest_scale_or_a_part_of_it_holds_all_exactly) {
  EXPECT_EQ(joined_scale({of_scale(0.01), of_scale(0.001)}), glm::dvec3(0.001));
  EXPECT_EQ(joined_scale({of_scale(0.01), of_scale(0.01, 0.005)}), glm::dvec3(0.005));
  EXPECT_EQ(joined_scale({of_scale(0.025), of_scale(0.01)}), glm::dvec3(0.005));
  EXPECT_EQ(joined_scale({of_scale(0.01, 0.0001), of_scale(0.001)}), glm::dvec3(0.0001));
  EXPECT_EQ(joined_scale({of_scale(0.01), {.scale = {0.01, 0.01, 0.001}}}), glm::dvec3(0.01, 0.01, 0.001));
}

TEST(JoinedLatticeTest, where_no_lattice_holds_all_it_is_the_finest_that_32_bits_reach_with) {
  EXPECT_EQ(joined_scale({of_scale(0.01), of_scale(0.0013)}), glm::dvec3(0.0013));
  EXPECT_EQ(joined_scale({of_scale(1.7e-6), of_scale(1.1e-6)}), glm::dvec3(1.1e-6));
  EXPECT_EQ(joined_scale({of_scale(1.7e-6), of_scale(1.1e-6)}, {glm::dvec3(0), glm::dvec3(5000)}),
            glm::dvec3(1.1e-5));
  EXPECT_EQ(joined_scale({of_scale(1.7e-6), of_scale(1.1e-6)}, {glm::dvec3(-5000), glm::dvec3(0)}),
            glm::dvec3(1.1e-5));
  EXPECT_EQ(joined_scale({of_scale(0.01), of_scale(1e-7)}), glm::dvec3(1e-6)) << "exact, but out of reach";
}

TEST(LatticeShiftTest, positions_stay_where_they_are) {
  test::Random random;
  const Lattice coarse = of_scale(0.01, 690000.0), fine = of_scale(0.001, 689000.5), odd = of_scale(0.0013);
  const LatticeShift exact(coarse, fine, "a"), rounded(coarse, odd, "a");
  EXPECT_FALSE(exact.is_none());
  EXPECT_FALSE(rounded.is_none());
  EXPECT_TRUE(LatticeShift(odd, odd, "a").is_none());
  for (int i = 0; i < 1000; ++i) {
    const LatticePosition position(static_cast<int>(random.between(-1e5, 1e5)));
    EXPECT_EQ(exact(position), position * 10 + 999'500);
    EXPECT_NEAR(to_world(odd, rounded(position)).x, to_world(coarse, position).x, 0.00065 + 1e-9);
  }
  EXPECT_THROW(exact(LatticePosition(300'000'000)), Error);
  EXPECT_THROW(rounded(LatticePosition(2'000'000'000)), Error);
}

}  // namespace
}  // namespace alidade
