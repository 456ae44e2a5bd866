// SPDX-License-Identifier: MIT
// The public benchmark "silent failures" of lines of sight over elevation rasters (github.com/vl4dimr/
// silent-failures-viewshed, 2026): 15 profiles with derived answers and four properties, written from its
// description and its published results.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/random.h"
#include "tests/visibility/exact_terrain.h"
#include "visibility/lines/line_report.h"
#include "visibility/raster/viewshed.h"

namespace alidade::test {

using namespace geo;
using namespace visibility;

namespace {

constexpr double k_cell = 30.0;

/// Level ground from an observer in the first cell to a target in the last one, with one feature.
struct Profile {
  const char* what;
  int steps;  ///< cells from the observer to the target
  double observer_height, target_height;
  bool is_seen;
  double feature_height = 0.0;  ///< of all cells across, metres
  int feature_at = 0, feature_width = 0;
  /// What the answer changes without; a control keeps it without its feature.
  enum class Decides { nothing, feature, target, curvature } decides = Decides::nothing;
};

using enum Profile::Decides;

constexpr std::array<Profile, 15> k_profiles{{
    {"plane, 3 km", 100, 1.7, 3.0, true},
    {"barrier of 50 m, 6 km", 199, 1.7, 3.0, false, 50.0, 100, 1, feature},
    {"barrier of 1 m, 3 km", 99, 1.7, 3.0, true, 1.0, 50, 1},
    {"hollow of 80 m, 3 km", 99, 1.7, 3.0, true, -80.0, 45, 10},
    {"barrier of 2 m, 3 km", 99, 1.7, 3.0, true, 2.0, 50, 1},
    {"barrier of 2 m, 9 km", 299, 1.7, 3.0, false, 2.0, 150, 1, feature},
    {"barrier of one cell, 3 km", 99, 1.7, 3.0, false, 80.0, 50, 1, feature},
    {"target on the ground behind 12 m, 4 km", 133, 1.7, 0.0, false, 12.0, 67, 1, feature},
    {"target of 30 m behind 12 m, 4 km", 133, 1.7, 30.0, true, 12.0, 67, 1, target},
    {"observer on a peak, 6 km", 199, 1.7, 3.0, true, 40.0, 0, 1},
    {"target on a peak, 6 km", 199, 1.7, 3.0, true, 40.0, 199, 1},
    {"plane, below the critical distance, 8.7 km", 290, 1.7, 3.0, true},
    {"plane, above the critical distance, 18.6 km", 619, 1.7, 3.0, false, 0.0, 0, 0, curvature},
    {"plane, 40 km", 1333, 1.7, 3.0, false, 0.0, 0, 0, curvature},
    {"plane, 1 km", 33, 1.7, 3.0, true},
}};

/// Three rows of level ground.
Raster<float> level(int steps) {
  return Raster<float>({{0.0, 3.0 * k_cell}, k_cell, steps + 1, 3}, 0.0f);
}

void set_column(Raster<float>& heights, int column, double height) {
  for (int row = 0; row < heights.grid.rows; ++row) heights.at(column, row) = static_cast<float>(height);
}

Raster<float> heights_of(const Profile& profile) {
  Raster<float> heights = level(profile.steps);
  for (int i = 0; i < profile.feature_width; ++i)
    set_column(heights, profile.feature_at + i, profile.feature_height);
  return heights;
}

/// What an answer depends on beside the heights.
struct Settings {
  double observer_height, target_height, curvature = k_usual_curvature;
};

bool seen_on_map(const Raster<float>& heights, const Settings& settings) {
  Observer observer;
  observer.position = above(heights, {0.0, 1.0}, settings.observer_height);
  const Viewshed seen =
      viewshed(occluders_of(heights), Ground(TerrainSurface(heights)), {&observer, 1}, heights.grid,
               {.target_height = settings.target_height, .curve = SightCurve(settings.curvature, 1.0)});
  return seen.values.at(heights.grid.columns - 1, 1) > 0.0f;
}

bool seen_by_line(const Raster<float>& heights, const Settings& settings) {
  const LinePair pair{.from = {above(heights, {0.0, 1.0}, settings.observer_height)},
                      .to = {above(heights, {heights.grid.columns - 1.0, 1.0}, settings.target_height)}};
  LineReportOptions options;
  options.line.earth_radius = k_earth_radius / settings.curvature;
  return !report_lines(occluders_of(heights), {&pair, 1}, options).front().blocker;
}

/// With its feature, or what decides instead of it, taken away.
bool seen_without_feature(const Profile& profile) {
  Profile without = profile;
  Settings settings{profile.observer_height, profile.target_height};
  if (profile.decides == target)
    settings.target_height = 0.0;
  else
    without.feature_width = 0;
  if (profile.feature_width == 0) settings.curvature = 0.0;
  return seen_on_map(heights_of(without), settings);
}

TEST(ViewshedProfiles, all_fifteen_have_their_derived_answers) {
  int maps = 0, lines = 0;
  for (const Profile& profile : k_profiles) {
    const Settings settings{profile.observer_height, profile.target_height};
    const bool map = seen_on_map(heights_of(profile), settings),
               line = seen_by_line(heights_of(profile), settings);
    maps += map == profile.is_seen;
    lines += line == profile.is_seen;
    EXPECT_EQ(map, profile.is_seen) << profile.what;
    EXPECT_EQ(line, profile.is_seen) << profile.what;
    EXPECT_EQ(seen_without_feature(profile) != profile.is_seen, profile.decides != Profile::Decides::nothing)
        << profile.what;
  }
  std::printf("profiles with the derived answer: maps %d, lines %d of %zu\n", maps, lines, k_profiles.size());
}

TEST(ViewshedProfiles, without_the_heights_asked_for_those_of_other_programs_fail_here_too) {
  // As published for gdal_viewshed and r.viewshed with nothing but their input: this shows that the profiles
  // are the benchmark's. A target on the ground and one of 30 m behind the same hill have opposite answers.
  std::string gdal, grass;
  for (std::size_t i = 0; i < k_profiles.size(); ++i) {
    const Raster<float> heights = heights_of(k_profiles[i]);
    const std::string number = " " + std::to_string(i + 1);
    if (seen_on_map(heights, {2.0, 0.0}) != k_profiles[i].is_seen) gdal += number;
    if (seen_on_map(heights, {1.75, 0.0, 0.0}) != k_profiles[i].is_seen) grass += number;
  }
  EXPECT_EQ(gdal, " 3 5 9 12");
  EXPECT_EQ(grass, " 3 5 9 13 14");
}

/// Hills of some ten metres, 12 x 40 cells.
Raster<float> hills(Random& random) {
  Raster<float> heights({{0.0, 12 * k_cell}, k_cell, 40, 12}, 0.0f);
  const double first = random.between(0.1, 0.6), second = random.between(0.1, 0.6),
               turn = random.between(0.0, 6.0), size = random.between(2.0, 20.0);
  for (int row = 0; row < 12; ++row)
    for (int column = 0; column < 40; ++column)
      heights.at(column, row) = static_cast<float>(
          size * std::sin(first * column + turn) * std::cos(second * row) + random.between(0.0, 3.0));
  return heights;
}

/// Whether one sees from one cell, so high above the ground, to another, over the round Earth.
struct Sight {
  Occluders occluders;
  const Raster<float>& heights;

  explicit Sight(const Raster<float>& raster) : occluders(occluders_of(raster)), heights(raster) {}

  bool operator()(const glm::dvec2& from, double from_height, const glm::dvec2& to, double to_height) const {
    SightBatch batch(occluders, SightCurve(k_usual_curvature, 1.0));
    batch.add({above(heights, from, from_height)}, {above(heights, to, to_height)});
    return batch.blocked()[0] == 0;
  }
};

glm::dvec2 any_cell(Random& random, int first_column, int columns) {
  return {first_column + static_cast<double>(random.below(columns)), static_cast<double>(random.below(12))};
}

TEST(ViewshedProfiles, sight_is_the_same_from_the_other_end_with_heights_exchanged) {
  Random random;
  int seen = 0;
  for (int terrain = 0; terrain < 40; ++terrain) {
    const Raster<float> heights = hills(random);
    const Sight sees(heights);
    for (int i = 0; i < 12; ++i) {
      const glm::dvec2 from = any_cell(random, 0, 15), to = any_cell(random, 25, 15);
      const double low = random.between(0.0, 5.0), high = random.between(0.0, 30.0);
      const bool there = sees(from, low, to, high);
      EXPECT_EQ(there, sees(to, high, from, low)) << terrain << " " << i;
      seen += there;
    }
  }
  EXPECT_GT(seen, 60);
  EXPECT_LT(seen, 420);
}

TEST(ViewshedProfiles, a_dominant_obstacle_blocks_wherever_it_stands) {
  Random random;
  for (int i = 0; i < 120; ++i) {
    const int steps = 20 + static_cast<int>(random.below(80)),
              at = 1 + static_cast<int>(random.below(steps - 1));
    Raster<float> heights = level(steps);
    for (float& height : heights.values) height = static_cast<float>(random.between(0.0, 2.0));
    set_column(heights, at, 200.0);
    EXPECT_FALSE(seen_on_map(heights, {random.between(0.0, 40.0), random.between(0.0, 40.0)}))
        << at << " of " << steps;
  }
}

TEST(ViewshedProfiles, sight_over_a_plane_ends_at_the_sum_of_both_horizons) {
  Random random;
  const Raster<float> plane = level(2000);
  const Sight sees(plane);
  const double radius = k_earth_radius / k_usual_curvature;
  double farthest_off = 0.0;
  for (int i = 0; i < 60; ++i) {
    const double observer = random.between(1.0, 20.0), target = random.between(1.0, 20.0);
    const double critical = std::sqrt(2.0 * radius * observer) + std::sqrt(2.0 * radius * target);
    double near = 0.0, far = 2000.0 * k_cell;
    while (far - near > 0.01) {
      const double middle = 0.5 * (near + far);
      (sees({0.0, 1.0}, observer, {middle / k_cell, 1.0}, target) ? near : far) = middle;
    }
    farthest_off = std::max(farthest_off, std::fabs(near / critical - 1.0));
    EXPECT_NEAR(near / critical, 1.0, 0.002) << observer << " " << target;
  }
  std::printf("sight over a plane ends within %.3f %% of the critical distance\n", 100.0 * farthest_off);
}

TEST(ViewshedProfiles, higher_ends_never_lose_sight_and_high_ones_have_it) {
  Random random;
  int gained = 0;
  for (int terrain = 0; terrain < 16; ++terrain) {
    const Raster<float> heights = hills(random);
    const Sight sees(heights);
    for (int i = 0; i < 10; ++i) {
      const glm::dvec2 from = any_cell(random, 0, 15), to = any_cell(random, 25, 15);
      const double fixed = random.between(0.5, 3.0);
      for (const bool is_target : {false, true}) {
        bool was_seen = false;
        for (double height = 0.0; height < 2000.0; height = 1.5 * height + 0.3) {
          const bool seen = is_target ? sees(from, fixed, to, height) : sees(from, height, to, fixed);
          EXPECT_TRUE(seen || !was_seen) << terrain << " " << i << " " << height;
          gained += seen && !was_seen && height > 0.0;
          was_seen = seen;
        }
        EXPECT_TRUE(was_seen) << terrain << " " << i;
      }
    }
  }
  EXPECT_GT(gained, 60);
}

}  // namespace
}  // namespace alidade::test
