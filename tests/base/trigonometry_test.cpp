// SPDX-License-Identifier: MIT
#include "base/exact_math.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/random.h"

namespace alidade {
namespace {

TEST(SineCosine, DiffersFromTheStandardLibraryByLessThan1e15) {
  test::Random random;
  for (int i = 0; i < 200000; ++i) {
    const double angle = random.between(-100.0, 100.0);
    const SineCosine own = sine_cosine_by_quarters(angle);
    ASSERT_LT(std::fabs(own.sine - std::sin(angle)), 1e-15) << angle;
    ASSERT_LT(std::fabs(own.cosine - std::cos(angle)), 1e-15) << angle;
  }
}

TEST(SineCosine, IsExactAtZeroAndRightAroundQuarterTurns) {
  EXPECT_EQ(sine_cosine_by_quarters(0.0).sine, 0.0);
  EXPECT_EQ(sine_cosine_by_quarters(0.0).cosine, 1.0);
  for (int quarter = -8; quarter <= 8; ++quarter) {
    for (const double offset : {-1e-3, -1e-9, 0.0, 1e-9, 1e-3, std::numbers::pi / 4}) {
      const double angle = quarter * (std::numbers::pi / 2) + offset;
      EXPECT_NEAR(sine_cosine_by_quarters(angle).sine, std::sin(angle), 1e-15);
      EXPECT_NEAR(sine_cosine_by_quarters(angle).cosine, std::cos(angle), 1e-15);
    }
  }
}

}  // namespace
}  // namespace alidade
