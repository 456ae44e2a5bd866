// SPDX-License-Identifier: MIT
#include "base/exact_math.h"

#include <gtest/gtest.h>

#include "base/color.h"
#include "tests/support/random.h"

namespace alidade {
namespace {

TEST(DeterministicMath, sine_and_cosine_agree_with_the_c_library) {
  test::Random random;
  for (int i = 0; i < 100000; ++i) {
    const double turns = random.between(-3.0, 3.0);
    const long double angle = 2.0L * std::numbers::pi_v<long double> * turns;
    const SineCosine found = sine_cosine_of_turns(turns);
    ASSERT_NEAR(found.sine, static_cast<double>(std::sin(angle)), 4e-16) << turns;
    ASSERT_NEAR(found.cosine, static_cast<double>(std::cos(angle)), 4e-16) << turns;
  }
}

TEST(DeterministicMath, sine_and_cosine_are_exact_at_quarter_turns) {
  const double sines[] = {0.0, 1.0, 0.0, -1.0};
  for (int quarter = -8; quarter <= 8; ++quarter) {
    EXPECT_EQ(sine_cosine_of_turns(0.25 * quarter).sine, sines[(quarter + 8) % 4]);
    EXPECT_EQ(sine_cosine_of_turns(0.25 * quarter).cosine, sines[(quarter + 9) % 4]);
  }
}

TEST(DeterministicMath, small_angles_keep_their_digits) {
  for (double turns = 1e-3; turns > 1e-300; turns *= 1e-7) {
    const double sine = std::sin(2.0 * std::numbers::pi * turns);
    EXPECT_NEAR(sine_cosine_of_turns(turns).sine / sine, 1.0, 1e-15);
  }
}

TEST(DeterministicMath, angles_agree_with_the_c_library) {
  test::Random random;
  for (int i = 0; i < 100000; ++i) {
    const double x = random.between(-1.0, 1.0), y = random.between(-1.0, 1.0);
    const long double expected = std::atan2(static_cast<long double>(y), static_cast<long double>(x));
    ASSERT_NEAR(angle_of(y, x), static_cast<double>(expected), 5e-16) << y << " " << x;
  }
  for (double y = 1.0; y > 1e-300; y *= 1e-3) {
    EXPECT_NEAR(angle_of(y, 1.0) / std::atan(y), 1.0, 4e-16) << y;
    EXPECT_EQ(angle_of(-y, 3.0), -angle_of(y, 3.0));
  }
}

TEST(DeterministicMath, angles_along_the_axes_are_exact) {
  EXPECT_EQ(angle_of(0.0, 0.0), 0.0);
  EXPECT_EQ(angle_of(0.0, 2.0), 0.0);
  EXPECT_EQ(angle_of(2.0, 0.0), 0.5 * std::numbers::pi);
  EXPECT_EQ(angle_of(-2.0, 0.0), -0.5 * std::numbers::pi);
  EXPECT_EQ(angle_of(0.0, -2.0), std::numbers::pi);
}

TEST(DeterministicMath, roots_agree_with_the_c_library) {
  test::Random random;
  for (int i = 0; i < 20000; ++i) {
    const double value = random.unit() * random.unit();
    const int degree = 2 + static_cast<int>(random.below(11));
    ASSERT_NEAR(root(value, degree) / std::pow(value, 1.0 / degree), 1.0, 4e-15) << value << " " << degree;
  }
  EXPECT_EQ(root(0.0, 5), 0.0);
  EXPECT_EQ(root(1.0, 5), 1.0);
}

TEST(DeterministicMath, srgb_curve_agrees_with_its_definition_both_ways) {
  for (int value = 0; value < 65536; ++value) {
    const double display = value / 65535.0;
    const double linear = display <= 0.04045 ? display / 12.92 : std::pow((display + 0.055) / 1.055, 2.4);
    ASSERT_NEAR(linear_from_srgb(display), linear, 1e-14 * linear);
    // The standard's two pieces meet at slightly different positions in the two directions.
    ASSERT_NEAR(srgb_from_linear(linear), display, 3e-8);
  }
  EXPECT_DOUBLE_EQ(linear_from_srgb(1.0), 1.0);
  EXPECT_DOUBLE_EQ(srgb_from_linear(1.0), 1.0);
}

}  // namespace
}  // namespace alidade
