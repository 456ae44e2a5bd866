// SPDX-License-Identifier: MIT
#include "visibility/points/coverage_image.h"

#include <gtest/gtest.h>
#include <filesystem>

#include <cmath>
#include <set>

#include "base/error.h"
#include "image/font.h"
#include "tests/support/random.h"

namespace alidade::test {

using namespace image;
using namespace visibility;

namespace {

Coverage coverage_of(const std::vector<std::set<std::size_t>>& seen, std::size_t targets) {
  Coverage coverage(seen.size(), targets);
  for (std::size_t candidate = 0; candidate < seen.size(); ++candidate) {
    for (const std::size_t target : seen[candidate]) coverage.set(candidate, target);
  }
  return coverage;
}

Coverage random_coverage(Random& random, std::size_t candidates, std::size_t targets) {
  Coverage coverage(candidates, targets);
  for (std::size_t candidate = 0; candidate < candidates; ++candidate) {
    const double density = random.unit();
    for (std::size_t target = 0; target < targets; ++target) {
      if (random.unit() < 0.5 * density * density) coverage.set(candidate, target);
    }
  }
  return coverage;
}

double weight_seen(const Coverage& coverage, const std::vector<std::size_t>& candidates,
                   const std::vector<double>& weights) {
  double sum = 0.0;
  for (std::size_t target = 0; target < coverage.targets(); ++target) {
    bool is_seen = false;
    for (const std::size_t candidate : candidates) is_seen = is_seen || coverage.sees(candidate, target);
    if (is_seen) sum += weights.empty() ? 1.0 : weights[target];
  }
  return sum;
}

/// The best of all choices of `count` candidates from `first` on, added to `chosen`.
double best_of_all(const Coverage& coverage, std::size_t count, std::size_t first,
                   std::vector<std::size_t> chosen, const std::vector<double>& weights) {
  if (count == 0) return weight_seen(coverage, chosen, weights);
  double best = 0.0;
  for (std::size_t i = first; i + count <= coverage.candidates(); ++i) {
    chosen.push_back(i);
    best = std::max(best, best_of_all(coverage, count - 1, i + 1, chosen, weights));
    chosen.pop_back();
  }
  return best;
}

std::vector<std::size_t> candidates_of(const Placement& placement) {
  std::vector<std::size_t> candidates;
  for (const ChosenPosition& position : placement.positions) candidates.push_back(position.candidate);
  return candidates;
}

TEST(Placement, each_choice_is_the_largest_gain_with_the_lowest_number) {
  Random random;
  for (int repeat = 0; repeat < 100; ++repeat) {
    const Coverage coverage = random_coverage(random, 1 + random.below(30), 1 + random.below(150));
    std::vector<double> weights;
    // Whole weights, so that sums are equal where they should be.
    if (repeat % 2 == 1) {
      for (std::size_t i = 0; i < coverage.targets(); ++i)
        weights.push_back(static_cast<double>(random.below(4)));
    }
    const Placement placement = choose_places(coverage, 8, weights);
    std::vector<std::size_t> chosen;
    double covered = 0.0;
    for (const ChosenPosition& position : placement.positions) {
      double best_gain = 0.0;
      std::size_t best = coverage.candidates();
      for (std::size_t i = 0; i < coverage.candidates(); ++i) {
        std::vector<std::size_t> with = chosen;
        with.push_back(i);
        const double gain = weight_seen(coverage, with, weights) - covered;
        if (gain > best_gain) {
          best_gain = gain;
          best = i;
        }
      }
      ASSERT_EQ(position.candidate, best);
      ASSERT_EQ(position.gain, best_gain);
      covered += best_gain;
      ASSERT_EQ(position.covered, covered);
      chosen.push_back(best);
    }
    if (placement.positions.size() < 8) {
      std::vector<std::size_t> all(coverage.candidates());
      for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
      EXPECT_EQ(weight_seen(coverage, all, weights), covered) << "there was more to gain";
    }
  }
}

TEST(Placement, keeps_the_guarantee_against_all_choices_and_tells_a_bound) {
  Random random;
  double worst = 1.0;
  for (int repeat = 0; repeat < 300; ++repeat) {
    const Coverage coverage = random_coverage(random, 3 + random.below(9), 1 + random.below(60));
    std::vector<double> weights;
    if (repeat % 2 == 1) {
      for (std::size_t i = 0; i < coverage.targets(); ++i) weights.push_back(random.unit());
    }
    const std::size_t count = 1 + random.below(3);
    const Placement placement = choose_places(coverage, count, weights);
    const double best = best_of_all(coverage, count, 0, {}, weights);
    const double covered = placement.positions.empty() ? 0.0 : placement.positions.back().covered;
    const double guarantee = 1.0 - std::pow(1.0 - 1.0 / static_cast<double>(count), count);
    EXPECT_GE(covered, guarantee * best - 1e-9);
    EXPECT_LE(covered, best + 1e-9);
    EXPECT_GE(placement.best_possible, best - 1e-9);
    EXPECT_LE(placement.best_possible, placement.total + 1e-9);
    if (best > 0.0) worst = std::min(worst, covered / best);
  }
  EXPECT_LT(worst, 1.0) << "greedy is not always the best";
}

TEST(Placement, greedy_meets_the_known_trap) {
  // The first sees most, but the other two see everything.
  const Coverage coverage = coverage_of({{0, 1, 2, 3}, {0, 1, 4}, {2, 3, 5}}, 6);
  const Placement placement = choose_places(coverage, 2);
  EXPECT_EQ(candidates_of(placement), (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(placement.positions.back().covered, 5.0);
  EXPECT_EQ(placement.best_possible, 6.0);
}

TEST(Placement, bound_is_the_best_of_those_along_the_way) {
  // At the start the first two add up to 19, in the end two of the pairs could come to 12; after the first,
  // which sees all that the second sees, two pairs at most come to 10.
  const Coverage coverage = coverage_of(
      {{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}, {0, 1, 2, 3, 4, 5, 6, 7, 8}, {10, 11}, {12, 13}, {14, 15}}, 30);
  EXPECT_EQ(choose_places(coverage, 2).best_possible, 14.0);
}

TEST(Placement, of_equal_gains_the_lowest_number_wins) {
  const Coverage coverage = coverage_of({{0}, {1, 2}, {3, 4}, {1, 2}, {5, 6}}, 7);
  EXPECT_EQ(candidates_of(choose_places(coverage, 9)), (std::vector<std::size_t>{1, 2, 4, 0}));
}

TEST(Placement, weights_count) {
  const Coverage coverage = coverage_of({{0, 1, 2}, {3}}, 4);
  const std::vector<double> weights = {1, 1, 1, 10};
  const Placement placement = choose_places(coverage, 1, weights);
  EXPECT_EQ(candidates_of(placement), (std::vector<std::size_t>{1}));
  EXPECT_EQ(placement.total, 13.0);
  EXPECT_EQ(placement.positions[0].gain, 10.0);
  EXPECT_EQ(placement.best_possible, 10.0);
}

TEST(Placement, stops_where_nothing_is_gained) {
  EXPECT_EQ(choose_places(coverage_of({{0}, {0}, {}}, 2), 3).positions.size(), 1u);
  EXPECT_TRUE(choose_places(coverage_of({{}, {}}, 2), 3).positions.empty());
  EXPECT_TRUE(choose_places(coverage_of({}, 2), 3).positions.empty());
  EXPECT_TRUE(choose_places(coverage_of({{}}, 0), 3).positions.empty());
}

TEST(Placement, bad_input_is_an_error) {
  const Coverage coverage = coverage_of({{0}}, 2);
  EXPECT_THROW(choose_places(coverage, 0), Error);
  for (const std::vector<double>& weights :
       {std::vector<double>{1}, {1, -1}, {1, std::nan("")}, {1, std::numeric_limits<double>::infinity()}})
    EXPECT_THROW(choose_places(coverage, 1, weights), Error);
}

TEST(Placement, coverage_beyond_memory_is_an_error) {
  EXPECT_NO_THROW(check_coverage(1000, 1000));
  EXPECT_THROW(check_coverage(std::size_t{1} << 25, std::size_t{1} << 25), Error);
  EXPECT_THROW(Coverage(std::size_t{1} << 40, std::size_t{1} << 40), Error);
  EXPECT_THROW(Coverage(std::size_t{1} << 25, std::size_t{1} << 25), Error);
}

TEST(CoverageImage, bars_rise_as_the_curve_does) {
  const Placement placement{{{4, 50.0, 50.0}, {2, 25.0, 75.0}, {7, 5.0, 80.0}}, 100.0, 90.0};
  const Canvas canvas = draw_coverage(placement, Font(find_font()));
  // Rows of the bars' tops, in the middles of the three bars.
  std::vector<int> tops;
  for (const int x : {220, 480, 740}) {
    int y = 0;
    while (y < canvas.height() && canvas.at(x, y) != Rgb8{31, 98, 152}) ++y;
    tops.push_back(y);
  }
  EXPECT_GT(tops[0], tops[1]);
  EXPECT_GT(tops[1], tops[2]);
  // 25 % are five times as high as 5 %.
  EXPECT_NEAR(tops[0] - tops[1], 5.0 * (tops[1] - tops[2]), 4.0);
}

TEST(CoverageImage, is_written_as_png_and_nothing_else) {
  const Placement placement{{{0, 1.0, 1.0}}, 1.0, 1.0};
  const std::filesystem::path folder = std::filesystem::temp_directory_path();
  write_coverage_image(placement, folder / "coverage.png", true);
  EXPECT_GT(std::filesystem::file_size(folder / "coverage.png"), 1000u);
  EXPECT_THROW(write_coverage_image(placement, folder / "coverage.png", false), Error);
  EXPECT_THROW(write_coverage_image(placement, folder / "coverage.svg", true), Error);
  std::filesystem::remove(folder / "coverage.png");
}

}  // namespace
}  // namespace alidade::test
