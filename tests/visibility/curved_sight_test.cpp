// SPDX-License-Identifier: MIT
#include "visibility/raster/curved_sight.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <limits>

#include "base/error.h"
#include "octree/build.h"
#include "tests/support/random.h"

namespace alidade::test {

using namespace geo;
using namespace visibility;

namespace {

/// Walls of 2 x 2 across the x axis, each between two heights.
struct Wall {
  double x, bottom, top;
};

Octree walls(const std::vector<Wall>& all) {
  Random random("walls");
  PointCloud cloud;
  cloud.lattice.scale = glm::dvec3(0.0001);
  for (const Wall& wall : all) {
    for (int i = 0; i < 1500; ++i) {
      cloud.positions.push_back(
          *to_lattice(cloud.lattice, {wall.x, random.between(-1, 1), random.between(wall.bottom, wall.top)}));
    }
  }
  return build(cloud);
}

bool is_blocked(const Occluders& occluders, const SightCurve& curve, const glm::dvec3& from,
                const glm::dvec3& to) {
  SightBatch batch(occluders, curve);
  batch.add({from}, {to});
  const bool blocked = batch.blocked()[0] != 0;
  EXPECT_EQ(batch.first_blockers()[0].has_value(), blocked);
  return blocked;
}

TEST(SightCurveTest, things_drop_by_the_square_of_their_distance) {
  // A kilometre away the Earth has fallen by 7.85 cm.
  EXPECT_NEAR(SightCurve(1.0, 1.0).drop(1000.0), 0.0785, 0.0001);
  EXPECT_NEAR(SightCurve(k_usual_curvature, 1.0).drop(1000.0), 0.0673, 0.0001);
  EXPECT_EQ(SightCurve().drop(1000.0), 0.0);
  const double foot = 0.3048;
  EXPECT_NEAR(SightCurve(1.0, foot).drop(1000.0 / foot) * foot, 0.0785, 0.0001);
}

TEST(SightCurveTest, the_bent_line_is_straight_where_everything_has_dropped) {
  const SightCurve curve(k_usual_curvature, 1.0);
  const glm::dvec3 from(100, 200, 50), to(4100, 3200, 90);
  const double distance = 5000.0, slope = (to.z - curve.drop(distance) - from.z) / distance;
  for (double share = 0.0; share <= 1.0; share += 0.125) {
    const glm::dvec3 position = curve.position(from, to, share);
    const double along = share * distance;
    EXPECT_NEAR(position.z - curve.drop(along), from.z + slope * along, 1e-9);
  }
}

TEST(SightCurveTest, chords_stay_within_five_millimetres_of_the_line) {
  const SightCurve curve(1.0, 1.0);
  const glm::dvec3 from(0, 0, 0), to(20000, 0, 300);
  const std::int64_t count = curve.chord_count(20000.0);
  EXPECT_GT(count, 10);
  for (std::int64_t i = 0; i < count; ++i) {
    const double chords = static_cast<double>(count), begin = static_cast<double>(i) / chords,
                 end = static_cast<double>(i + 1) / chords;
    const glm::dvec3 middle = 0.5 * (curve.position(from, to, begin) + curve.position(from, to, end));
    const double sag = middle.z - curve.position(from, to, 0.5 * (begin + end)).z;
    EXPECT_GT(sag, 0.0);
    EXPECT_LE(sag, k_most_sag * 1.000001);
  }
  EXPECT_EQ(curve.chord_count(100.0), 1);
  EXPECT_EQ(SightCurve().chord_count(1e9), 1);
}

TEST(SightBatchTest, a_bent_line_hangs_below_the_straight_one) {
  // Over 8 km the bent line hangs 1.08 m below the chord at its middle.
  const SightCurve curve(k_usual_curvature, 1.0);
  const glm::dvec3 from(0, 0, 10), to(8000, 0, 10);
  const Octree below = walls({{4000, 8.0, 9.5}}), above = walls({{4000, 9.5, 11.0}});
  const Occluders low(below, {}), high(above, {});
  EXPECT_FALSE(is_blocked(low, {}, from, to));
  EXPECT_TRUE(is_blocked(low, curve, from, to));
  EXPECT_TRUE(is_blocked(high, {}, from, to));
  EXPECT_FALSE(is_blocked(high, curve, from, to));
}

TEST(SightBatchTest, the_first_blocker_is_as_far_as_it_is_along_all_chords) {
  const Octree octree = walls({{3000, -5, 5}, {6000, -5, 5}});
  const Occluders occluders(octree, {});
  SightBatch batch(occluders, SightCurve(1.0, 1.0));
  batch.add({glm::dvec3(0, 0, 1)}, {glm::dvec3(8000, 0, 1)});
  EXPECT_GT(batch.chord_count(), 5u);
  const std::optional<Blocker> blocker = batch.first_blockers()[0];
  ASSERT_TRUE(blocker);
  EXPECT_NEAR(blocker->distance, 3000.0, 0.01);
}

TEST(SightBatchTest, crossings_are_counted_over_all_chords) {
  const Octree octree = walls({{1100, -5, 5}, {3100, -5, 5}, {5900, -5, 5}});
  const SightCurve curve(1.0, 1.0);
  for (const auto& [transparency, blocked] : {std::pair(1, true), {2, true}, {3, true}, {4, false}}) {
    const Occluders occluders(octree, {.transparency = transparency});
    EXPECT_EQ(is_blocked(occluders, curve, {0, 0, 1}, {8000, 0, 1}), blocked) << transparency;
    EXPECT_EQ(is_blocked(occluders, {}, {0, 0, 1}, {8000, 0, 1}), blocked) << transparency;
  }
}

TEST(SightBatchTest, a_sphere_where_two_chords_meet_is_crossed_once) {
  const SightCurve curve(1.0, 1.0);
  const glm::dvec3 from(0, 0, 1), to(8000, 0, 1);
  const auto chords = static_cast<double>(curve.chord_count(8000.0));
  PointCloud cloud;
  cloud.lattice.scale = glm::dvec3(0.0001);
  const auto blocked_from = [&](int transparency) {
    const Occluders occluders(build(cloud),
                              {.shape = OccluderShape::sphere, .radius = 0.3, .transparency = transparency});
    return is_blocked(occluders, curve, from, to);
  };
  const auto add_at = [&](double chord) {
    cloud.positions.push_back(*to_lattice(cloud.lattice, curve.position(from, to, chord / chords)));
  };
  add_at(3.0);
  EXPECT_TRUE(blocked_from(1));
  EXPECT_FALSE(blocked_from(2));
  add_at(6.5);
  EXPECT_TRUE(blocked_from(2));
  EXPECT_FALSE(blocked_from(3));
  add_at(8.0);
  EXPECT_TRUE(blocked_from(3));
  EXPECT_FALSE(blocked_from(4));
}

/// The chords of a bent line, all of them, and what blocks any.
std::optional<Blocker> unclipped_blocker(const Occluders& occluders, const SightCurve& curve,
                                         const glm::dvec3& from, const glm::dvec3& to) {
  const std::int64_t count = curve.chord_count(glm::length(glm::dvec2(to) - glm::dvec2(from)));
  const double length = glm::length(to - from), overlap = 2.0 * occluders.typical_radius() / length;
  for (std::int64_t i = 0; i < count; ++i) {
    const double begin = std::max(0.0, static_cast<double>(i) / static_cast<double>(count) - overlap),
                 end = std::min(1.0, static_cast<double>(i + 1) / static_cast<double>(count) + overlap);
    const SightEnd chord_from{i == 0 ? from : curve.position(from, to, begin)},
        chord_to{i + 1 == count ? to : curve.position(from, to, end)};
    std::optional<Blocker> blocker = first_blocker(occluders, sight_line(chord_from, chord_to));
    if (!blocker) continue;
    blocker->distance += i == 0 ? 0.0 : begin * length;
    return blocker;
  }
  return std::nullopt;
}

TEST(SightBatchTest, chords_without_points_below_are_left_out_and_nothing_else_changes) {
  const Octree octree = walls({{0, -5, 5}, {700, -5, 5}, {2500, -5, 5}});
  const Occluders occluders(octree, {});
  const SightCurve curve(1.0, 1.0);
  Random random("far places");
  SightBatch batch(occluders, curve);
  std::vector<std::optional<Blocker>> expected;
  std::int64_t chords = 0;
  for (int i = 0; i < 300; ++i) {
    // Two positions on either side, nearly in line with the walls; some lines end between these.
    const auto far = [&](double least) { return least + std::pow(10.0, random.between(0.0, 4.7)); };
    const glm::dvec3 from(-far(0.0), random.between(-1.5, 1.5), random.between(-8, 8));
    const glm::dvec3 to(i % 3 == 0 ? random.between(0, 2500) : far(2500.0), random.between(-1.5, 1.5),
                        random.between(-8, 8));
    batch.add({from}, {to});
    expected.push_back(unclipped_blocker(occluders, curve, from, to));
    chords += curve.chord_count(glm::length(glm::dvec2(to) - glm::dvec2(from)));
  }
  const auto blocked = std::ranges::count_if(expected, [](const auto& one) { return one.has_value(); });
  EXPECT_GT(blocked, 40);
  EXPECT_LT(blocked, 260);
  EXPECT_LT(2 * batch.chord_count(), static_cast<std::size_t>(chords));
  const std::span<const std::optional<Blocker>> blockers = batch.first_blockers();
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(blockers[i], expected[i]) << i;
  const std::span<const std::uint8_t> answers = batch.blocked();
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(answers[i] != 0, expected[i].has_value()) << i;
}

TEST(SightBatchTest, an_observer_at_any_distance_takes_few_chords) {
  const Octree octree = walls({{0, -5, 5}, {700, -5, 5}});
  const Occluders occluders(octree, {});
  for (const double distance : {1e6, 1e9, 1e12}) {
    SightBatch batch(occluders, SightCurve(10.0, 1.0));
    batch.add({glm::dvec3(distance, 0, 0)}, {glm::dvec3(300, 0, 0)});
    batch.add({glm::dvec3(distance, 0, 0)}, {glm::dvec3(300, distance, 0)});
    EXPECT_LT(batch.chord_count(), 12u) << distance;
    EXPECT_EQ(batch.blocked().size(), 2u);
    EXPECT_EQ(batch.blocked()[1], 0) << "it passes far from all points";
  }
  SightBatch batch(occluders, SightCurve(1.0, 1.0));
  EXPECT_THROW(batch.add({glm::dvec3(1e200, 0, 0)}, {glm::dvec3(0, 0, 0)}), Error);
  EXPECT_THROW(batch.add({glm::dvec3(std::nan(""), 0, 0)}, {glm::dvec3(0, 0, 0)}), Error);
}

TEST(SightBatchTest, a_batch_can_be_used_again) {
  const Octree octree = walls({{10, -5, 5}});
  const Occluders occluders(octree, {});
  SightBatch batch(occluders, {});
  batch.add({glm::dvec3(0, 0, 0)}, {glm::dvec3(20, 0, 0)});
  EXPECT_EQ(batch.blocked()[0], 1);
  batch.clear();
  batch.add({glm::dvec3(0, 0, 0)}, {glm::dvec3(5, 0, 0)});
  batch.add({glm::dvec3(0, 0, 0)}, {glm::dvec3(20, 0, 0)});
  ASSERT_EQ(batch.blocked().size(), 2u);
  EXPECT_EQ(batch.blocked()[0], 0);
  EXPECT_EQ(batch.blocked()[1], 1);
}

TEST(SightCurveTest, bad_coefficients_are_errors) {
  EXPECT_THROW(SightCurve(-0.1, 1.0), Error);
  EXPECT_THROW(SightCurve(11.0, 1.0), Error);
  EXPECT_THROW(SightCurve(std::numeric_limits<double>::quiet_NaN(), 1.0), Error);
}

}  // namespace
}  // namespace alidade::test
