// SPDX-License-Identifier: MIT
// What the extension for PostgreSQL decides, without a server.
#include "extensions/postgres/alidade_pg/cloud_limit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "base/morton.h"
#include "tests/support/random.h"

namespace alidade {

using namespace database;

namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();
constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();
constexpr double k_tiny = std::numeric_limits<double>::denorm_min();
constexpr double k_huge = std::numeric_limits<double>::max();
constexpr Comparison k_comparisons[] = {Comparison::less, Comparison::less_equal, Comparison::equal,
                                        Comparison::greater_equal, Comparison::greater};

/// What PostgreSQL answers.
bool is_true(double value, Comparison comparison, double bound) {
  const int order = compare_numbers(value, bound);
  switch (comparison) {
    case Comparison::less:
      return order < 0;
    case Comparison::less_equal:
      return order <= 0;
    case Comparison::equal:
      return order == 0;
    case Comparison::greater_equal:
      return order >= 0;
    case Comparison::greater:
      return order > 0;
  }
  return false;
}

TEST(CloudLimit, limits_are_the_comparisons_they_stand_for) {
  // The distance of a point to the plane z = 0 is its z.
  const CloudLine plane = make_line(DistanceKind::plane, {0, 0, 0}, {0, 0, 1});
  const double values[] = {0.0,
                           -0.0,
                           1.0,
                           -1.0,
                           std::nextafter(1.0, 2.0),
                           std::nextafter(1.0, 0.0),
                           k_tiny,
                           -k_tiny,
                           k_huge,
                           -k_huge,
                           k_infinity,
                           -k_infinity,
                           k_nan,
                           1e-308,
                           5325000.5,
                           -5325000.5};
  for (const Comparison comparison : k_comparisons)
    for (const double bound : values) {
      const CloudLimit limit = make_limit(DistanceKind::plane, plane, comparison, bound);
      for (const double value : values) {
        const glm::dvec3 point(0, 0, value);
        // An infinite coordinate times zero is NaN.
        const double distance_of_point = distance(DistanceKind::plane, plane, point);
        EXPECT_EQ(holds(limit, point), is_true(distance_of_point, comparison, bound))
            << value << ' ' << static_cast<int>(comparison) << ' ' << bound;
      }
    }
}

glm::dvec3 position(test::Random& random) {
  const double reach = random.below(2) ? 200.0 : 1e6;
  return glm::dvec3(690000, 5325000, 400) * static_cast<double>(random.below(2)) + reach * random.in_cube();
}

glm::dvec3 direction(test::Random& random) {
  if (random.below(3) == 0) {
    glm::dvec3 axis(0.0, -0.0, 0.0);
    axis[static_cast<int>(random.below(3))] = random.below(2) ? 1.0 : -1.0;
    return axis;
  }
  return random.direction() * (random.below(2) ? 1.0 : 1e-200);
}

TEST(CloudLimit, no_box_is_pruned_that_has_a_match) {
  test::Random random;
  int kept = 0, pruned = 0, wholly = 0;
  for (int i = 0; i < 100000; ++i) {
    const DistanceKind kind = random.below(2) ? DistanceKind::ray : DistanceKind::plane;
    const CloudLine line = make_line(kind, position(random), direction(random));
    const glm::dvec3 corner = position(random);
    Bounds box = box_of(corner);
    box.grow(corner + random.unit() * 50.0 * glm::dvec3(random.unit(), random.unit(), random.unit()));
    glm::dvec3 inside;
    for (int axis = 0; axis < 3; ++axis) {
      const double share = random.below(3) == 0 ? static_cast<double>(random.below(2)) : random.unit();
      inside[axis] =
          std::clamp(box.min[axis] + share * (box.max[axis] - box.min[axis]), box.min[axis], box.max[axis]);
    }
    // Half of the limits are decided by the last bit.
    const double own = distance(kind, line, inside);
    const double bound = random.below(2) ? own : own * random.between(0, 2);
    const CloudLimit limit = make_limit(kind, line, k_comparisons[random.below(5)], bound);
    ASSERT_TRUE(!holds(limit, inside) || may_hold(limit, box)) << i;
    ASSERT_TRUE(holds(limit, inside) || may_break(limit, box)) << i;
    // For a single point nothing is left open.
    ASSERT_EQ(may_hold(limit, box_of(inside)), holds(limit, inside)) << i;
    ASSERT_EQ(may_break(limit, box_of(inside)), !holds(limit, inside)) << i;
    kept += holds(limit, inside);
    pruned += !may_hold(limit, box);
    wholly += !may_break(limit, box);
  }
  EXPECT_GT(kept, 10000);
  EXPECT_GT(pruned, 10000);
  EXPECT_GT(wholly, 10000);
}

TEST(CloudLimit, boxes_with_points_without_a_position_are_not_pruned_if_these_match) {
  test::Random random;
  const double odd[] = {k_nan, k_infinity, -k_infinity, k_huge, 1e154, 0.0};
  const double bounds[] = {k_nan, k_infinity, -k_infinity, 0.0, 1.0, -1.0, k_huge};
  int kept = 0;
  for (int i = 0; i < 100000; ++i) {
    const DistanceKind kind = random.below(2) ? DistanceKind::ray : DistanceKind::plane;
    const CloudLine line = make_line(kind, position(random), direction(random));
    const glm::dvec3 point(odd[random.below(6)], odd[random.below(6)], odd[random.below(6)]);
    Bounds box = box_of(point);
    if (random.below(2)) box.grow(box_of(position(random)));
    const CloudLimit limit = make_limit(kind, line, k_comparisons[random.below(5)], bounds[random.below(7)]);
    ASSERT_TRUE(!holds(limit, point) || may_hold(limit, box)) << i;
    ASSERT_TRUE(holds(limit, point) || may_break(limit, box)) << i;
    kept += holds(limit, point);
  }
  EXPECT_GT(kept, 10000);
}

TEST(CloudLimit, boxes_are_not_pruned_where_a_distance_overflows_to_none) {
  test::Random random;
  const double ends[] = {1e308, -1e308, k_huge, 0.0, 1.0};
  const double bounds[] = {k_nan, k_infinity, -k_infinity, 0.0, 1000.0, -1000.0, k_huge};
  const auto corner = [&] {
    return glm::dvec3(ends[random.below(5)], ends[random.below(5)], ends[random.below(5)]);
  };
  int without_number = 0;
  for (int i = 0; i < 100000; ++i) {
    const DistanceKind kind = random.below(2) ? DistanceKind::ray : DistanceKind::plane;
    const CloudLine line = make_line(kind, corner(), direction(random));
    const glm::dvec3 point = corner();
    Bounds box = box_of(point);
    box.grow(corner());
    const CloudLimit limit = make_limit(kind, line, k_comparisons[random.below(5)], bounds[random.below(7)]);
    ASSERT_TRUE(!holds(limit, point) || may_hold(limit, box)) << i;
    ASSERT_TRUE(holds(limit, point) || may_break(limit, box)) << i;
    without_number += std::isnan(distance(kind, line, point));
  }
  EXPECT_GT(without_number, 10000);
}

TEST(CloudLimit, invalid_lines_are_rejected) {
  for (const DistanceKind kind : {DistanceKind::ray, DistanceKind::plane}) {
    EXPECT_THROW(make_line(kind, {0, 0, 0}, {0, -0.0, 0}), Error);
    EXPECT_THROW(make_line(kind, {0, 0, 0}, {0, k_nan, 0}), Error);
    EXPECT_THROW(make_line(kind, {k_infinity, 0, 0}, {0, 1, 0}), Error);
  }
}

TEST(MortonOrder, is_that_of_the_keys) {
  test::Random random;
  for (int i = 0; i < 20000; ++i) {
    const auto cell = [&] {
      const auto coordinate = [&] {
        return static_cast<std::uint32_t>(random.below(random.below(2) ? 8 : 1 << 21));
      };
      return glm::uvec3(coordinate(), coordinate(), coordinate());
    };
    const glm::uvec3 a = cell(), b = cell();
    const std::uint64_t key_a = morton_key(a.x, a.y, a.z), key_b = morton_key(b.x, b.y, b.z);
    const int order = key_a < key_b ? -1 : key_a > key_b ? 1 : 0;
    ASSERT_EQ(compare_morton(glm::dvec3(a) * 0x1p-20, glm::dvec3(b) * 0x1p-20), order) << i;
    // Below zero as above it.
    const glm::dvec3 shift(-2.0);
    ASSERT_EQ(compare_morton(glm::dvec3(a) * 0x1p-20 + shift, glm::dvec3(b) * 0x1p-20 + shift), order) << i;
  }
}

TEST(MortonOrder, is_one_also_for_odd_positions) {
  const double values[] = {0.0,    -0.0, 1e-9,  -1e-9,      0.5,         -k_huge,
                           k_huge, 1e13, -1e13, k_infinity, -k_infinity, k_nan};
  std::vector<glm::dvec3> points;
  for (const double x : values)
    for (const double y : values) points.emplace_back(x, y, 0.5);
  for (const glm::dvec3& a : points)
    for (const glm::dvec3& b : points) {
      ASSERT_EQ(compare_morton(a, b), -compare_morton(b, a));
      ASSERT_EQ(compare_morton(a, b) == 0, compare_numbers(a.x, b.x) == 0 && compare_numbers(a.y, b.y) == 0);
      for (const glm::dvec3& c : points)
        ASSERT_FALSE(compare_morton(a, b) < 0 && compare_morton(b, c) < 0 && compare_morton(a, c) >= 0);
    }
}

TEST(EstimatedShare, is_near_the_share_of_all_points) {
  test::Random random;
  std::vector<glm::dvec3> points;
  points.reserve(100000);
  for (int i = 0; i < 100000; ++i) points.push_back(100.0 * random.in_cube());
  for (const DistanceKind kind : {DistanceKind::ray, DistanceKind::plane}) {
    const CloudLine line = make_line(kind, {0, 0, 0}, {1, 0.5, 0.25});
    std::vector<double> sample;
    for (std::size_t i = 0; i < points.size(); i += 1000) sample.push_back(distance(kind, line, points[i]));
    std::ranges::sort(sample);
    for (const double bound : {1.0, 5.0, 20.0, 60.0}) {
      const CloudLimit within{
          .line = line, .least = kind == DistanceKind::ray ? 0.0 : -bound, .largest = bound, .kind = kind};
      const auto count = std::ranges::count_if(points, [&](const glm::dvec3& p) { return holds(within, p); });
      const double share = static_cast<double>(count) / static_cast<double>(points.size());
      EXPECT_GT(estimated_share(within, sample), 0.3 * share) << bound;
      EXPECT_LT(estimated_share(within, sample), 3.0 * share) << bound;
    }
  }
}

TEST(EstimatedShare, is_exact_where_nothing_or_everything_keeps_the_limit) {
  const CloudLine line = make_line(DistanceKind::ray, {0, 0, 0}, {1, 0, 0});
  const std::vector<double> sample = {0, 0, 1, 2, 3, 4, 5, 6, 7, k_infinity, k_nan};
  const auto share = [&](Comparison comparison, double bound) {
    return estimated_share(make_limit(DistanceKind::ray, line, comparison, bound), sample);
  };
  EXPECT_EQ(share(Comparison::less, 0), 0.0);
  EXPECT_EQ(share(Comparison::less_equal, -1), 0.0);
  EXPECT_EQ(share(Comparison::less_equal, k_nan), 1.0);
  EXPECT_EQ(share(Comparison::greater_equal, -1), 1.0);
  EXPECT_EQ(share(Comparison::greater, k_nan), 0.0);
  EXPECT_EQ(share(Comparison::less, -k_infinity), 0.0);
}

}  // namespace
}  // namespace alidade
