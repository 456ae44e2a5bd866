// SPDX-License-Identifier: MIT
#include "renderer/sampler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

#include "tests/support/random.h"

namespace alidade {

using namespace renderer;

namespace {

TEST(Sampler, numbers_are_the_same_in_any_order_of_asking) {
  const auto number = [](std::uint32_t x, std::uint32_t sample, std::uint32_t dimension) {
    Sampler sampler(7, x, 3, sample);
    sampler.start_at(dimension);
    return sampler.next_2d();
  };
  std::vector<glm::dvec2> forward, backward;
  for (std::uint32_t i = 0; i < 1000; ++i) forward.push_back(number(i % 10, i / 10, i % 7));
  for (std::uint32_t i = 1000; i-- > 0;) backward.push_back(number(i % 10, i / 10, i % 7));
  std::reverse(backward.begin(), backward.end());
  EXPECT_EQ(forward, backward);
}

TEST(Sampler, dimensions_follow_each_other) {
  Sampler all(1, 2, 3, 4), part(1, 2, 3, 4);
  all.next_2d();
  all.next_1d();
  part.start_at(2);
  EXPECT_EQ(all.next_1d(), part.next_1d());
}

TEST(Sampler, numbers_lie_in_the_half_open_unit_interval) {
  for (std::uint32_t sample = 0; sample < 100000; ++sample) {
    Sampler sampler(3, 1, 1, sample);
    const glm::dvec2 pair = sampler.next_2d();
    ASSERT_TRUE(pair.x >= 0.0 && pair.x < 1.0 && pair.y >= 0.0 && pair.y < 1.0);
  }
}

/// Number of elementary boxes of area 2^-m, over all shapes, that do not hold exactly one of the points.
int uneven_boxes(const std::vector<glm::dvec2>& points, int m) {
  int uneven = 0;
  for (int a = 0; a <= m; ++a) {
    std::vector<int> counts(points.size());
    for (const glm::dvec2& point : points) {
      const auto column = static_cast<std::size_t>(std::ldexp(point.x, a));
      const auto row = static_cast<std::size_t>(std::ldexp(point.y, m - a));
      ++counts[(row << a) + column];
    }
    uneven +=
        static_cast<int>(std::count_if(counts.begin(), counts.end(), [](int count) { return count != 1; }));
  }
  return uneven;
}

TEST(Sampler, first_power_of_two_samples_have_one_pair_in_every_elementary_box) {
  for (int m = 0; m <= 10; ++m) {
    for (std::uint32_t dimension = 0; dimension < 20; ++dimension) {
      std::vector<glm::dvec2> points;
      for (std::uint32_t sample = 0; sample < (1u << m); ++sample) {
        Sampler sampler(m, 11, 5, sample);
        sampler.start_at(dimension);
        points.push_back(sampler.next_2d());
      }
      ASSERT_EQ(uneven_boxes(points, m), 0) << "m " << m << " dimension " << dimension;
    }
  }
}

TEST(Sampler, first_power_of_two_single_numbers_have_one_in_every_interval) {
  for (std::uint32_t dimension = 0; dimension < 50; ++dimension) {
    std::set<int> intervals;
    for (std::uint32_t sample = 0; sample < 64; ++sample) {
      Sampler sampler(5, 0, 0, sample);
      sampler.start_at(dimension);
      intervals.insert(static_cast<int>(sampler.next_1d() * 64));
    }
    ASSERT_EQ(intervals.size(), 64u);
  }
}

/// Mean of products of two streams around their means, in units of its standard error for independent even
/// numbers.
double correlation_score(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - 0.5) * (b[i] - 0.5);
  return sum / std::sqrt(static_cast<double>(a.size())) * 12.0;
}

TEST(Sampler, pixels_seeds_and_dimensions_are_unrelated) {
  std::vector<double> here, beside, below, other_seed, other_dimension;
  for (std::uint32_t i = 0; i < 40000; ++i) {
    const std::uint32_t x = i % 200, y = i / 200;
    const auto number = [](std::uint64_t seed, std::uint32_t px, std::uint32_t py, std::uint32_t dimension) {
      Sampler sampler(seed, px, py, 0);
      sampler.start_at(dimension);
      return sampler.next_1d();
    };
    here.push_back(number(1, x, y, 0));
    beside.push_back(number(1, x + 1, y, 0));
    below.push_back(number(1, x, y + 1, 0));
    other_seed.push_back(number(2, x, y, 0));
    other_dimension.push_back(number(1, x, y, 1));
  }
  EXPECT_LT(std::abs(correlation_score(here, beside)), 4.0);
  EXPECT_LT(std::abs(correlation_score(here, below)), 4.0);
  EXPECT_LT(std::abs(correlation_score(here, other_seed)), 4.0);
  EXPECT_LT(std::abs(correlation_score(here, other_dimension)), 4.0);
  EXPECT_GT(std::abs(correlation_score(here, here)), 100.0);
}

TEST(Sampler, second_dimension_is_pascals_triangle_modulo_two) {
  test::Random random;
  for (int i = 0; i < 1000; ++i) {
    const auto index = static_cast<std::uint32_t>(random.bits());
    std::uint32_t expected = 0;
    for (unsigned j = 0; j < 32; ++j) {
      for (unsigned k = j; k < 32; ++k) {
        const bool binomial_is_odd = (j & k) == j;
        if (binomial_is_odd && (index >> k & 1u)) expected ^= 1u << j;
      }
    }
    ASSERT_EQ(sobol_second_reversed(index), expected);
  }
}

}  // namespace
}  // namespace alidade
