// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "octree/query_targets.h"
#include "octree/simd/sort_keys.h"
#include "tests/support/random.h"
#include "tests/support/same_hits.h"

namespace alidade {
namespace {

using test::Random;

/// Answers with these distances, and their order by comparing.
void expect_sorted(const std::function<double(std::size_t)>& distance, std::size_t count) {
  const glm::dvec3 point(0.0);
  const PointQuery query;
  const PointTarget target(point, query);
  for (const std::size_t first : {std::size_t{0}, std::size_t{3}}) {
    std::vector<PointHit> answers;
    for (std::size_t i = 0; i < first + count; ++i)
      answers.push_back({(i * 7919) % 100003, glm::dvec3(static_cast<double>(i)), distance(i)});
    std::vector<PointHit> expected = answers;
    std::sort(expected.begin() + static_cast<std::ptrdiff_t>(first), expected.end(),
              simd::Precedes<PointTarget>{target});
    simd::sort_answers(target, first, answers);
    ASSERT_EQ(answers, expected) << count << " answers behind " << first;
  }
}

TEST(SortAnswers, equals_sorting_by_comparing) {
  Random random("sort_answers");
  for (const std::size_t count : {0, 1, 2, 64, 65, 300, 5000}) {
    expect_sorted([&](std::size_t) { return random.unit(); }, count);
    expect_sorted([](std::size_t) { return 0.25; }, count);
    expect_sorted([](std::size_t i) { return static_cast<double>(i % 3); }, count);
    expect_sorted([](std::size_t i) { return i == 0 ? 1e300 : 1.0 + 1e-15 * static_cast<double>(i % 50); },
                  count);
    expect_sorted([](std::size_t i) { return 5e-324 * static_cast<double>(i % 2); }, count);
    expect_sorted([](std::size_t i) { return i % 2 ? 1e308 : -1e308; }, count);
    expect_sorted([](std::size_t i) { return i % 2 ? 1.0 : -std::numeric_limits<double>::infinity(); },
                  count);
    expect_sorted(
        [](std::size_t i) { return std::numeric_limits<double>::infinity() * (i % 2 ? 1.0 : -1.0); }, count);
  }
}

TEST(SortKeys, equal_upper_halves_keep_their_order) {
  Random random("sort_keys");
  for (const std::uint64_t greatest : {1u, 10u, 2047u, 2048u, 70000u, 0xffffffffu}) {
    std::vector<simd::SortKey> keys;
    for (std::uint64_t i = 0; i < 3000; ++i) keys.push_back(random.below(greatest) << 32 | i);
    keys.push_back(greatest << 32 | 3000);
    std::vector<simd::SortKey> expected = keys;
    std::ranges::sort(expected);
    simd::sort_keys(keys);
    ASSERT_EQ(keys, expected) << greatest;
  }
}

}  // namespace
}  // namespace alidade
