// SPDX-License-Identifier: MIT
#include "extensions/placement/placement.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "base/error.h"
#include "extensions/placement/coverage_image.h"
#include "image/font.h"
#include "octree/distance.h"
#include "tests/support/octrees.h"
#include "tests/support/point_families.h"
#include "tests/support/random.h"
#include "tests/visibility/wall_cloud.h"

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

/// A floor with a wall across its middle.
Octree floor_and_wall() {
  return WallCloud()
      .add({-5, -5, 0}, {10, 0, 0}, {0, 10, 0}, 0.1)
      .add({0, -3, 0}, {0, 6, 0}, {0, 0, 2}, 0.1)
      .octree();
}

Observer observer_at(const glm::dvec3& position) {
  Observer observer;
  observer.position = position;
  observer.name = "one";
  return observer;
}

TEST(Coverage, a_wall_hides_what_is_behind_it) {
  const Occluders occluders(floor_and_wall(), {});
  const std::vector<PlacementTarget> targets = thin_points(occluders.octree(), 0.5);
  const std::vector<Observer> candidates = {observer_at({-4, 0, 1}), observer_at({4, 0, 1})};
  const Coverage coverage = see_targets(occluders, candidates, targets, 0.0);
  int checked = 0;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const glm::dvec3 position = targets[i].position;
    if (position.z > 0.05 || std::fabs(position.y) > 2.0 || std::fabs(position.x) < 0.4) continue;
    ++checked;
    EXPECT_EQ(coverage.sees(0, i), position.x < 0.0) << position.x << " " << position.y;
    EXPECT_EQ(coverage.sees(1, i), position.x > 0.0) << position.x << " " << position.y;
  }
  EXPECT_GT(checked, 50);
}

TEST(Coverage, is_that_of_single_sight_lines_within_field_of_view_and_reach) {
  Random random;
  const Occluders occluders(floor_and_wall(), {});
  const std::vector<PlacementTarget> targets = thin_points(occluders.octree(), 0.7);
  std::vector<Observer> candidates;
  for (int i = 0; i < 8; ++i) {
    Observer observer = observer_at({random.between(-4, 4), random.between(-4, 4), random.between(0.5, 2.5)});
    if (i % 2 == 1) observer.azimuth_max = 45.0 * i;
    if (i % 4 >= 2) observer.max_distance = 4.0;
    candidates.push_back(observer);
  }
  for (const double height : {0.0, 0.3}) {
    const Coverage coverage = see_targets(occluders, candidates, targets, height);
    int seen = 0;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      const SightEnd eye = end_near_surface(occluders, candidates[c].position);
      for (std::size_t i = 0; i < targets.size(); ++i) {
        const glm::dvec3 position = targets[i].position + glm::dvec3(0, 0, height);
        const SightEnd end =
            height > 0.0 ? end_near_surface(occluders, position)
                         : end_on_point(occluders, targets[i].point_id, position, candidates[c].position);
        const bool expected = distance(candidates[c].position, position) <= candidates[c].max_distance &&
                              FieldOfView(candidates[c]).contains(position - candidates[c].position) &&
                              !first_blocker(occluders, sight_line(eye, end));
        ASSERT_EQ(coverage.sees(c, i), expected) << c << " " << i;
        seen += expected ? 1 : 0;
      }
    }
    EXPECT_GT(seen, 300);
  }
}

TEST(Coverage, is_the_same_on_one_thread) {
  const Occluders occluders(floor_and_wall(), {});
  const std::vector<PlacementTarget> targets = thin_points(occluders.octree(), 0.3);
  const std::vector<Observer> candidates = {observer_at({-2, 1, 1})};
  const Coverage many = see_targets(occluders, candidates, targets, 0.0);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Coverage single = see_targets(occluders, candidates, targets, 0.0);
  EXPECT_TRUE(std::ranges::equal(many.row(0), single.row(0)));
}

TEST(Coverage, bad_heights_are_errors_and_a_cancelled_run_stops) {
  const Occluders occluders(floor_and_wall(), {});
  const std::vector<PlacementTarget> targets = thin_points(occluders.octree(), 1.0);
  const std::vector<Observer> candidates = {observer_at({-2, 1, 1})};
  EXPECT_THROW(see_targets(occluders, candidates, targets, -1.0), Error);
  EXPECT_THROW(see_targets(occluders, candidates, targets, std::nan("")), Error);
  EXPECT_THROW(
      see_targets(occluders, candidates, targets, 0.0, [](std::uint64_t, std::uint64_t) { return false; }),
      Cancelled);
}

TEST(ThinPoints, vs_brute_force_on_every_family) {
  for (const PointFamily& family : point_families()) {
    const Bounds bounds = family.cloud.bounds();
    const glm::dvec3 size = bounds.size();
    const double spacing = std::max(0.13 * std::max({size.x, size.y, size.z}), 1e-3);
    std::map<std::array<double, 3>, std::pair<double, std::uint64_t>> best;
    for (std::uint64_t id = 0; id < family.cloud.size(); ++id) {
      if (id % 3 == 0) continue;
      const glm::dvec3 position = family.cloud.world(id);
      std::array<double, 3> cell{};
      double sum = 0.0;
      for (int axis = 0; axis < 3; ++axis) {
        cell[axis] = std::floor((position[axis] - bounds.min[axis]) / spacing);
        const double offset = position[axis] - (bounds.min[axis] + (cell[axis] + 0.5) * spacing);
        sum += offset * offset;
      }
      const std::pair<double, std::uint64_t> here{std::sqrt(sum), id};
      const auto [found, is_new] = best.try_emplace(cell, here);
      if (!is_new) found->second = std::min(found->second, here);
    }
    std::vector<std::uint64_t> expected;
    for (const auto& [cell, one] : best) expected.push_back(one.second);
    std::ranges::sort(expected);
    for (const auto& [name, octree] : octrees_of(family.cloud)) {
      std::vector<std::uint64_t> found;
      for (const PlacementTarget& target :
           thin_points(octree, spacing, [](std::uint64_t id) { return id % 3 != 0; })) {
        found.push_back(target.point_id);
        EXPECT_EQ(target.position, family.cloud.world(target.point_id));
      }
      std::ranges::sort(found);
      EXPECT_EQ(found, expected) << family.name << ", " << name;
    }
  }
}

TEST(ThinPoints, impossible_spacings_are_errors) {
  const Octree octree = build(make_cloud({{0, 0, 0}, {100, 0, 0}}, {glm::dvec3(0.001), glm::dvec3(0.0)}));
  EXPECT_THROW(thin_points(octree, 0.0), Error);
  EXPECT_THROW(thin_points(octree, -1.0), Error);
  EXPECT_THROW(thin_points(octree, std::nan("")), Error);
  EXPECT_THROW(thin_points(octree, 1e-5), Error);
  EXPECT_EQ(thin_points(octree, 1e-3).size(), 2u);
  EXPECT_EQ(thin_points(octree, 1e9).size(), 1u);
}

}  // namespace

}  // namespace alidade::test
