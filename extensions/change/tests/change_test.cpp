// SPDX-License-Identifier: MIT
#include "extensions/change/change.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <set>

#include "base/error.h"
#include "tests/support/random.h"
#include "tests/visibility/sampled_shapes.h"

namespace alidade::test {
namespace {

using namespace visibility;

constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();

/// Ground from -5 to 5 with a wall along y = 5, 3 m high.
Points yard(double spacing = 0.1) {
  Points points;
  add_rectangle(points, {-5, -5, 0}, {10, 0, 0}, {0, 10, 0}, spacing);
  add_rectangle(points, {-5, 5, 0}, {10, 0, 0}, {0, 0, 3}, spacing);
  return points;
}

/// The five visible faces of a box on the ground; returns the number of its first point.
std::size_t add_box(Points& points, const glm::dvec3& low, const glm::dvec3& size, double spacing = 0.1) {
  const std::size_t first = points.size();
  const glm::dvec3 x(size.x, 0, 0), y(0, size.y, 0), z(0, 0, size.z);
  add_rectangle(points, low, x, z, spacing);
  add_rectangle(points, low + y, x, z, spacing);
  add_rectangle(points, low, y, z, spacing);
  add_rectangle(points, low + x, y, z, spacing);
  add_rectangle(points, low + z, x, y, spacing);
  return first;
}

Points moved_by(Points points, const glm::dvec3& shift) {
  for (glm::dvec3& point : points) point += shift;
  return points;
}

/// One scan in memory.
struct Scan {
  explicit Scan(const Points& points, std::vector<glm::dvec3> origins_ = {},
                const OccluderOptions& options = {})
      : occluders(octree_of(points), options), origins(std::move(origins_)) {}
  Epoch epoch() const { return {occluders, origins}; }

  Occluders occluders;
  std::vector<glm::dvec3> origins;
};

Changes changes_of(const Scan& before, const Scan& after, const ChangeOptions& options = {}) {
  return find_changes(before.epoch(), after.epoch(), options);
}

/// Share of the points from `first` on that have a class.
double share(const PointChanges& changes, ChangeClass kind, std::size_t first = 0,
             std::size_t end = std::numeric_limits<std::size_t>::max()) {
  end = std::min(end, changes.classes.size());
  const auto begin = changes.classes.begin();
  return static_cast<double>(std::count(begin + static_cast<std::ptrdiff_t>(first),
                                        begin + static_cast<std::ptrdiff_t>(end), kind)) /
         static_cast<double>(end - first);
}

TEST(Change, names_are_those_of_the_manual) {
  EXPECT_STREQ(name_of(ChangeClass::appeared), "new");
  EXPECT_STREQ(name_of(ChangeClass::never_seen), "never seen");
  EXPECT_STREQ(name_of(ChangeClass::ignored), "ignored");
  EXPECT_STREQ(name_of(ChangeClass::not_measured), "not measured");
}

TEST(Change, planes_have_their_distance_and_level_of_detection) {
  Points ground;
  add_rectangle(ground, {0, 0, 0}, {4, 0, 0}, {0, 4, 0}, 0.1);
  const Scan before(ground, {{2, 2, 2}}), after(moved_by(ground, {0, 0, 0.03}), {{2, 2, 2}});
  for (const auto& [error, kind] :
       {std::pair(0.005, ChangeClass::moved), std::pair(0.02, ChangeClass::same)}) {
    const Changes changes = changes_of(before, after, {.registration_error = error});
    for (const PointChanges* epoch : {&changes.before, &changes.after}) {
      EXPECT_EQ(share(*epoch, kind), 1.0);
      for (std::size_t id = 0; id < ground.size(); ++id) {
        ASSERT_NEAR(epoch->distances[id], 0.03, 1e-4) << "up is positive in both epochs";
        ASSERT_NEAR(epoch->detection_levels[id], 1.96 * error, 1e-4);
      }
    }
  }
}

TEST(Change, one_point_in_twenty_exceeds_the_level_of_detection_of_noise) {
  const auto noisy = [](const char* seed) {
    Random random(seed);
    Points ground;
    add_rectangle(ground, {0, 0, 0}, {6, 0, 0}, {0, 6, 0}, 0.05);
    for (glm::dvec3& point : ground)
      for (int i = 0; i < 12; ++i) point.z += 0.005 * (random.unit() - 0.5);
    return ground;
  };
  const Changes changes = changes_of(Scan(noisy("one"), {{3, 3, 2}}), Scan(noisy("two"), {{3, 3, 2}}));
  EXPECT_NEAR(share(changes.before, ChangeClass::moved), 0.05, 0.03);
  EXPECT_NEAR(share(changes.after, ChangeClass::moved), 0.05, 0.03);
}

TEST(Change, distances_are_positive_towards_the_scanner) {
  Points ceiling;
  add_rectangle(ceiling, {0, 0, 3}, {4, 0, 0}, {0, 4, 0}, 0.1);
  const Points lower = moved_by(ceiling, {0, 0, -0.05});
  const Changes below = changes_of(Scan(ceiling, {{2, 2, 1}}), Scan(lower, {{2, 2, 1}}));
  EXPECT_NEAR(below.before.distances[500], 0.05, 1e-3);
  EXPECT_NEAR(below.after.distances[500], 0.05, 1e-3);
  const Changes unknown = changes_of(Scan(ceiling), Scan(lower));
  EXPECT_NEAR(unknown.before.distances[500], -0.05, 1e-3) << "upwards without scanners";
}

TEST(Change, of_several_scanners_the_nearest_that_sees_the_point_is_on_its_side) {
  Points wall;
  add_rectangle(wall, {0, 0, 0}, {4, 0, 0}, {0, 0, 3}, 0.05);
  const std::size_t count = wall.size();
  add_rectangle(wall, {0, 0.5, 0}, {4, 0, 0}, {0, 0, 3}, 0.05);  // hides it from behind
  Points moved = wall;
  for (std::size_t i = 0; i < count; ++i) moved[i].y -= 0.02;
  const std::vector<glm::dvec3> scanners{{2, 2, 1.5}, {2, -6, 1.5}};
  const Changes changes = changes_of(Scan(wall, scanners), Scan(moved, scanners));
  EXPECT_NEAR(changes.before.distances[count / 2], 0.02, 1e-3);
}

TEST(Change, what_lines_of_sight_pass_through_is_gone_or_new) {
  Points with_box = yard();
  const std::size_t first = add_box(with_box, {-0.5, 0, 0}, {1, 1, 1});
  const std::vector<glm::dvec3> scanner{{0, -3, 1.7}};
  const Changes removed = changes_of(Scan(with_box, scanner), Scan(yard(), scanner));
  // Its lowest points lie on the ground.
  EXPECT_GT(share(removed.before, ChangeClass::gone, first), 0.8);
  EXPECT_EQ(share(removed.before, ChangeClass::never_seen, first), 0.0);
  EXPECT_GT(share(removed.before, ChangeClass::same, 0, first), 0.99);
  EXPECT_EQ(share(removed.after, ChangeClass::appeared), 0.0) << "ground that it hid is not new";
  const Changes placed = changes_of(Scan(yard(), scanner), Scan(with_box, scanner));
  EXPECT_GT(share(placed.after, ChangeClass::appeared, first), 0.8);
  EXPECT_EQ(share(placed.before, ChangeClass::gone), 0.0);
}

TEST(Change, what_is_hidden_was_never_seen) {
  Points open = yard();
  const std::size_t first = add_box(open, {-0.5, 2, 0}, {1, 1, 1});
  Points screened;
  for (const glm::dvec3& point : yard())
    if (point.y < 1.0) screened.push_back(point);
  add_rectangle(screened, {-5, 1, 0}, {10, 0, 0}, {0, 0, 3}, 0.05);
  const std::vector<glm::dvec3> scanner{{0, -3, 1.7}};
  const Changes changes = changes_of(Scan(open, scanner), Scan(screened, scanner));
  EXPECT_EQ(share(changes.before, ChangeClass::never_seen, first), 1.0);
  // A second scanner sees the position of the box from above the screen, empty.
  for (const glm::dvec3& point : yard())
    if (point.y > 1.5) screened.push_back(point);
  const Changes seen = changes_of(Scan(open, scanner), Scan(screened, {{0, -3, 1.7}, {0, 1.3, 4.5}}));
  EXPECT_GT(share(seen.before, ChangeClass::gone, first), 0.7);
}

TEST(Change, what_has_nothing_behind_it_or_is_out_of_range_was_never_seen) {
  Points with_ball = yard();
  const std::size_t first = with_ball.size();
  add_sphere(with_ball, {0, 0, 4}, 0.5, 2000);
  const std::vector<glm::dvec3> scanner{{0, -3, 1.7}};
  const Changes sky = changes_of(Scan(with_ball, scanner), Scan(yard(), scanner));
  EXPECT_EQ(share(sky.before, ChangeClass::never_seen, first), 1.0) << "no echo is no proof";
  Points with_box = yard();
  const std::size_t box = add_box(with_box, {-0.5, 3.5, 0.5}, {1, 1, 1});
  const Changes far =
      changes_of(Scan(with_box, scanner), Scan(yard(), scanner), {.max_distance = 0.2, .max_range = 6.0});
  EXPECT_EQ(share(far.before, ChangeClass::never_seen, box), 1.0);
  const Changes near =
      changes_of(Scan(with_box, scanner), Scan(yard(), scanner), {.max_distance = 0.2, .max_range = 20.0});
  EXPECT_GT(share(near.before, ChangeClass::gone, box), 0.95);
}

TEST(Change, ground_below_a_scanner_is_never_seen_and_not_gone) {
  Points all;
  add_rectangle(all, {-5, -5, 0}, {10, 0, 0}, {0, 7, 0}, 0.1);
  add_rectangle(all, {-5, 2, 0}, {10, 0, 0}, {0, 6, -6}, 0.1);
  Points with_hole;
  for (const glm::dvec3& point : all)
    if (glm::length(point) > 1.2) with_hole.push_back(point);
  // The second scanner looks across the hole: its lines continue below the ground and leave it again on the
  // slope, which the third scanner sees.
  const std::vector<glm::dvec3> scanners{{0, 0, 1.7}, {0, -4.5, 1.7}, {0, 8, 3}};
  const Changes changes = changes_of(Scan(all, scanners), Scan(with_hole, scanners));
  EXPECT_EQ(share(changes.before, ChangeClass::gone), 0.0);
  EXPECT_EQ(share(changes.before, ChangeClass::moved), 0.0);
  for (std::size_t id = 0; id < all.size(); ++id) {
    // Points beyond are within a spacing of the edge.
    if (glm::length(all[id]) < 0.9)
      ASSERT_EQ(changes.before.classes[id], ChangeClass::never_seen) << all[id].x << " " << all[id].y;
  }
}

TEST(Change, a_surface_on_one_side_only_is_no_counterpart) {
  // A valley whose one slope AFTER has not scanned: the mean of the points beside is higher.
  Points valley, half;
  for (int x = -40; x <= 40; ++x)
    for (int y = -40; y <= 40; ++y) {
      const glm::dvec3 point(0.05 * x, 0.05 * y, 0.6 * 0.05 * x * 0.05 * x);
      valley.push_back(point);
      if (x >= 0) half.push_back(point);
    }
  const std::vector<glm::dvec3> scanner{{0, 0, 5}};
  const Changes changes = changes_of(Scan(valley, scanner), Scan(half, scanner));
  for (std::size_t id = 0; id < valley.size(); ++id)
    if (valley[id].x < -0.03 && valley[id].x > -0.3 && std::fabs(valley[id].y) < 1.5)
      ASSERT_NE(changes.before.classes[id], ChangeClass::moved) << valley[id].x;
}

TEST(Change, a_line_that_grazes_the_ground_does_not_pass) {
  // Ground that AFTER lacks a strip of, 2 cm lower where lines over the strip meet it again.
  Points all;
  add_rectangle(all, {-2, -2, 0}, {4, 0, 0}, {0, 6, 0}, 0.1);
  Points after;
  for (const glm::dvec3& point : all)
    if (point.y < 0.95 || point.y > 1.65)
      after.push_back(point - glm::dvec3(0, 0, point.y > 1.65 ? 0.02 : 0.0));
  const std::vector<glm::dvec3> scanner{{0, -3, 0.4}};
  EXPECT_EQ(share(changes_of(Scan(all, scanner), Scan(after, scanner)).before, ChangeClass::gone), 0.0);
}

TEST(Change, thin_things_are_gone_only_where_beams_would_have_met_them) {
  Points with_wire = yard();
  const std::size_t first = with_wire.size();
  for (int i = 0; i <= 100; ++i) with_wire.emplace_back(0.01 * i - 0.5, 0.0, 1.0);
  const std::vector<glm::dvec3> scanner{{0, -3, 1.7}};
  const Scan before(with_wire, scanner);
  EXPECT_GT(share(changes_of(before, Scan(yard(0.05), scanner)).before, ChangeClass::gone, first), 0.95);
  EXPECT_GT(share(changes_of(before, Scan(yard(0.4), scanner)).before, ChangeClass::never_seen, first), 0.95);
}

TEST(Change, foliage_is_compared_without_normals) {
  const auto crown = [](const char* seed) {
    Random random(seed);
    Points points;
    for (int i = 0; i < 3000; ++i)
      points.emplace_back(random.between(-1, 1), random.between(-1, 1), random.between(2, 4));
    return points;
  };
  const Changes changes = changes_of(Scan(crown("a"), {{0, -5, 2}}), Scan(crown("b"), {{0, -5, 2}}));
  EXPECT_GT(share(changes.before, ChangeClass::same), 0.97);
  EXPECT_GT(share(changes.after, ChangeClass::same), 0.97);
}

TEST(Change, without_scanners_points_are_unmatched) {
  Points with_box = yard();
  const std::size_t first = add_box(with_box, {-0.5, 0, 0}, {1, 1, 1});
  const Changes changes = changes_of(Scan(with_box), Scan(yard()));
  EXPECT_GT(share(changes.before, ChangeClass::unmatched, first), 0.9);
  EXPECT_EQ(share(changes.before, ChangeClass::gone), 0.0);
}

TEST(Change, a_surface_beyond_the_maximum_distance_is_another_one) {
  Points ground;
  add_rectangle(ground, {0, 0, 0}, {4, 0, 0}, {0, 4, 0}, 0.1);
  const Scan before(moved_by(ground, {0, 0, 0.3}), {{2, 2, 20}}), after(ground, {{2, 2, 20}});
  EXPECT_EQ(share(changes_of(before, after, {.max_distance = 0.31}).before, ChangeClass::moved), 1.0);
  EXPECT_GT(share(changes_of(before, after, {.max_distance = 0.29}).before, ChangeClass::gone), 0.95);
}

TEST(Change, points_that_do_not_count_are_ignored_and_match_nothing) {
  Points with_noise = yard();
  const std::size_t first = with_noise.size();
  for (int i = 0; i < 50; ++i) with_noise.emplace_back(-1 + 0.04 * i, 0.0, 1.0);
  OccluderOptions options;
  options.counts = [first](std::uint64_t id) { return id < first; };
  const std::vector<glm::dvec3> scanner{{0, -3, 1.7}};
  const Changes changes = changes_of(Scan(with_noise, scanner, options), Scan(with_noise, scanner));
  EXPECT_EQ(share(changes.before, ChangeClass::ignored, first), 1.0);
  EXPECT_TRUE(std::isnan(changes.before.distances[first]));
  EXPECT_GT(share(changes.after, ChangeClass::appeared, first), 0.9);
}

TEST(Change, radii_that_are_given_hold) {
  Points ground;
  add_rectangle(ground, {0, 0, 0}, {4, 0, 0}, {0, 4, 0}, 0.1);
  Points dense;
  add_rectangle(dense, {0, 0, 0.01}, {4, 0, 0}, {0, 4, 0}, 0.02);
  const ChangeOptions options{.normal_radius = 0.5, .cylinder_radius = 0.4};
  const Changes changes = changes_of(Scan(ground), Scan(dense), options);
  EXPECT_EQ(share(changes.before, ChangeClass::moved), 1.0);
  EXPECT_NEAR(changes.after.distances[1000], 0.01, 1e-4);
  // Too few points of the other epoch in a small cylinder.
  const Changes thin = changes_of(Scan(ground), Scan(dense), {.cylinder_radius = 0.03});
  EXPECT_TRUE(std::isnan(thin.after.distances[1000]));
  EXPECT_EQ(thin.after.classes[1000], ChangeClass::not_measured);
}

TEST(Change, dense_points_are_measured_by_the_spacing_of_the_other_epoch) {
  // Cylinders of twice their own spacing, 0.02 sqrt(2) m, would hold too few points of the thin epoch.
  Points thin, dense;
  add_rectangle(thin, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0.1);
  add_rectangle(dense, {0, 0, 0.01}, {1, 0, 0}, {0, 1, 0}, 0.02);
  const Changes changes = changes_of(Scan(thin), Scan(dense));
  EXPECT_EQ(share(changes.after, ChangeClass::moved), 1.0);
  for (const float distance : changes.after.distances) ASSERT_NEAR(distance, 0.01, 1e-4);
}

/// A grid of 30 by 30 m with a point about every metre, and noise of a centimetre.
Points thin_ground(const char* seed, double height) {
  Random random(seed);
  Points points;
  for (int x = 0; x < 30; ++x)
    for (int y = 0; y < 30; ++y)
      points.emplace_back(x + random.between(-0.2, 0.2), y + random.between(-0.2, 0.2),
                          height + random.between(-0.02, 0.02));
  return points;
}

Points crown(const char* seed) {
  Random random(seed);
  Points points;
  for (int i = 0; i < 2000; ++i)
    points.emplace_back(random.between(-1, 1), random.between(-1, 1), random.between(2, 4));
  return points;
}

/// With given radii, that is what `same` means.
void expect_measured_or_not(const PointChanges& changes) {
  std::uint64_t unmeasured = 0;
  for (std::size_t id = 0; id < changes.classes.size(); ++id) {
    const ChangeClass kind = changes.classes[id];
    const bool is_found = kind == ChangeClass::same || kind == ChangeClass::moved;
    ASSERT_EQ(is_found, !std::isnan(changes.distances[id])) << id << " is " << name_of(kind);
    unmeasured += kind == ChangeClass::not_measured ? 1 : 0;
  }
  EXPECT_EQ(changes.without_normal + changes.too_few_points, unmeasured);
}

TEST(Change, what_was_not_measured_is_never_the_same) {
  const ChangeOptions options{.normal_radius = 1.1, .cylinder_radius = 2.0, .max_distance = 2.0};
  const Changes changes =
      changes_of(Scan(thin_ground("before", 0.0)), Scan(thin_ground("after", 0.5)), options);
  for (const PointChanges* epoch : {&changes.before, &changes.after}) {
    expect_measured_or_not(*epoch);
    EXPECT_EQ(share(*epoch, ChangeClass::same), 0.0);
    EXPECT_GT(share(*epoch, ChangeClass::moved), 0.98);
    EXPECT_EQ(epoch->wider_normals, 900u) << "spheres hold 1 to 6 points";
    for (std::size_t id = 0; id < epoch->distances.size(); ++id)
      ASSERT_TRUE(std::isnan(epoch->distances[id]) || std::fabs(epoch->distances[id] - 0.5f) < 0.03f) << id;
  }
}

TEST(Change, a_point_without_a_normal_is_not_measured_with_given_radii) {
  Points moved = crown("before");
  for (glm::dvec3& point : moved) point.x += 0.03;
  const Scan before(crown("before"), {{0, -5, 3}}), after(moved, {{0, -5, 3}});
  for (const ChangeOptions& options :
       {ChangeOptions{.normal_radius = 0.4}, ChangeOptions{.cylinder_radius = 0.2}}) {
    const Changes changes = changes_of(before, after, options);
    expect_measured_or_not(changes.before);
    expect_measured_or_not(changes.after);
    EXPECT_LT(share(changes.before, ChangeClass::same), 0.1);
    EXPECT_GT(changes.before.without_normal, 1600u);
    EXPECT_LT(changes.before.wider_normals, 100u) << "only corners have few points";
  }
  EXPECT_EQ(changes_of(before, after).before.without_normal, 0u) << "presence decides without radii";
}

TEST(Change, a_cylinder_with_too_few_points_measures_nothing) {
  Points ground;
  add_rectangle(ground, {0, 0, 0}, {4, 0, 0}, {0, 4, 0}, 0.1);
  const Changes changes =
      changes_of(Scan(ground), Scan(moved_by(ground, {0, 0, 0.02})), {.cylinder_radius = 0.05});
  EXPECT_EQ(share(changes.before, ChangeClass::not_measured), 1.0);
  EXPECT_EQ(changes.before.too_few_points, ground.size());
  EXPECT_EQ(changes.before.without_normal, 0u);
  // 4 are enough, as at the border of the grid; its corners have 3.
  const Changes enough =
      changes_of(Scan(ground), Scan(moved_by(ground, {0, 0, 0.02})), {.cylinder_radius = 0.105});
  EXPECT_EQ(enough.before.too_few_points, 4u);
  EXPECT_EQ(share(enough.before, ChangeClass::moved), 1.0 - 4.0 / static_cast<double>(ground.size()));
}

TEST(Change, identical_epochs_are_the_same_at_distance_0) {
  Points points = yard(0.2);
  for (const glm::dvec3& leaf : crown("leaves")) points.push_back(leaf);
  points.emplace_back(30.0, 30.0, 30.0);
  for (const ChangeOptions& options :
       {ChangeOptions{}, ChangeOptions{.normal_radius = 0.01, .cylinder_radius = 0.01},
        ChangeOptions{.registration_error = 0.01, .normal_radius = 0.5, .cylinder_radius = 0.5}}) {
    const Changes changes = changes_of(Scan(points), Scan(points), options);
    for (std::size_t id = 0; id < points.size(); ++id) {
      ASSERT_EQ(changes.before.classes[id], ChangeClass::same) << id;
      ASSERT_EQ(changes.before.distances[id], 0.0f) << id;
      ASSERT_GE(changes.before.detection_levels[id], 1.959f * static_cast<float>(options.registration_error));
    }
  }
}

TEST(Change, degenerate_epochs_are_not_measured_rather_than_the_same) {
  Points few{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, one{{0, 0, 0}}, twins(20, {0, 0, 0}), line;
  for (int i = 0; i < 100; ++i) line.emplace_back(0.1 * i, 0, 0);
  const ChangeOptions given{.normal_radius = 1.0, .cylinder_radius = 1.0, .max_distance = 2.0};
  for (const Points& points : {few, one, twins, line}) {
    // A cloud of no extent overlaps only itself.
    Points there = points, here = points;
    there.emplace_back(0, 0, 20);
    here.emplace_back(0, 0, 20);
    for (std::size_t i = 0; i < points.size(); ++i) there[i].z += 0.5;
    const std::size_t count = points.size();
    const Changes strict = changes_of(Scan(here), Scan(there), given);
    EXPECT_EQ(share(strict.before, ChangeClass::not_measured, 0, count), 1.0) << count;
    expect_measured_or_not(strict.before);
    if (count < 9 || points == twins) {
      const Changes usual = changes_of(Scan(here), Scan(there));
      EXPECT_EQ(share(usual.before, ChangeClass::same, 0, count), 0.0) << count << " without spacing";
    }
    EXPECT_EQ(share(changes_of(Scan(here), Scan(here), given).before, ChangeClass::same), 1.0) << count;
  }
}

TEST(Change, lines_of_sight_decide_before_what_is_not_measured) {
  Points with_box = yard();
  const std::size_t first = add_box(with_box, {-0.5, 0, 0}, {1, 1, 1});
  const std::vector<glm::dvec3> scanner{{0, -3, 1.7}};
  const ChangeOptions options{.normal_radius = 0.3, .cylinder_radius = 0.3, .max_distance = 0.2};
  const Changes removed = changes_of(Scan(with_box, scanner), Scan(yard(), scanner), options);
  EXPECT_GT(share(removed.before, ChangeClass::gone, first), 0.6);
  expect_measured_or_not(removed.before);
  const Changes unknown = changes_of(Scan(with_box), Scan(yard()), options);
  EXPECT_GT(share(unknown.before, ChangeClass::unmatched, first), 0.6);
  EXPECT_EQ(share(unknown.before, ChangeClass::gone), 0.0);
}

TEST(Change, summaries_have_counts_areas_and_medians) {
  Points ground;
  add_rectangle(ground, {0, 0, 0}, {10, 0, 0}, {0, 10, 0}, 0.1);
  const Scan before(ground, {{5, 5, 2}}), after(moved_by(ground, {0, 0, -0.05}), {{5, 5, 2}});
  const Changes changes = changes_of(before, after, {.registration_error = 0.01});
  const std::vector<ChangeSummary> all = summaries_of(changes.before, before.occluders);
  ASSERT_EQ(all.size(), std::size_t{k_change_classes});
  const ChangeSummary& moved = all[static_cast<std::size_t>(ChangeClass::moved)];
  EXPECT_EQ(moved.count, ground.size());
  EXPECT_EQ(moved.measured, ground.size());
  EXPECT_NEAR(*moved.median_distance, -0.05, 1e-4);
  EXPECT_NEAR(*moved.median_absolute_distance, 0.05, 1e-4);
  EXPECT_NEAR(*moved.median_detection_level, 0.0196, 1e-4);
  EXPECT_NEAR(moved.area, 100.0, 25.0);
  EXPECT_EQ(all[0].count, 0u);
  EXPECT_FALSE(all[0].median_distance);
}

TEST(Change, answers_are_the_same_bits_on_any_threads_and_instruction_set) {
  Points with_box = yard();
  add_box(with_box, {-0.5, 0, 0}, {1, 1, 1});
  const std::vector<glm::dvec3> scanners{{0, -3, 1.7}, {3, 3, 1.7}};
  const auto text = [](const Changes& changes) {
    std::string bytes;
    for (const PointChanges* epoch : {&changes.before, &changes.after}) {
      bytes.append(reinterpret_cast<const char*>(epoch->classes.data()), epoch->classes.size());
      bytes.append(reinterpret_cast<const char*>(epoch->distances.data()), 4 * epoch->distances.size());
      bytes.append(reinterpret_cast<const char*>(epoch->detection_levels.data()),
                   4 * epoch->distances.size());
    }
    return bytes;
  };
  std::set<std::string> answers;
  for (const InstructionSet set : {InstructionSet::scalar, InstructionSet::best}) {
    const auto occluders = [&](const Points& points) {
      return Occluders(octree_of(points).with_instruction_set(set), {});
    };
    const Occluders before = occluders(with_box), after = occluders(yard());
    for (const std::size_t threads : {1, 3}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      answers.insert(text(find_changes({before, scanners}, {after, scanners})));
    }
  }
  EXPECT_EQ(answers.size(), 1u);
}

TEST(Change, progress_is_in_points_of_both_clouds) {
  const Scan scan(yard());
  const std::uint64_t points = 2 * scan.occluders.octree().size();
  std::uint64_t last = 0;
  changes_of(scan, scan, {.progress = [&](std::uint64_t done, std::uint64_t total) {
               EXPECT_EQ(total, points);
               EXPECT_GE(done, last);
               last = done;
               return true;
             }});
  EXPECT_EQ(last, points);
  EXPECT_THROW(changes_of(scan, scan, {.progress = [](std::uint64_t, std::uint64_t) { return false; }}),
               Cancelled);
}

/// What an error says.
std::string error_of(const Scan& before, const Scan& after, const ChangeOptions& options = {}) {
  try {
    changes_of(before, after, options);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Change, errors_name_what_is_wrong) {
  const Scan good(yard());
  EXPECT_NE(error_of(Scan({}), good).find("the epoch BEFORE has no points"), std::string::npos);
  EXPECT_NE(error_of(good, Scan({})).find("the epoch AFTER has no points"), std::string::npos);
  const Scan elsewhere(moved_by(yard(), {12, 0, 0}));
  EXPECT_NE(error_of(good, elsewhere).find("the epochs do not overlap"), std::string::npos);
  EXPECT_NE(error_of(good, Scan(yard(), {{k_nan, 0, 0}})).find("scanner position of AFTER"),
            std::string::npos);
  EXPECT_NE(error_of(good, Scan(yard(), {}, {.radius = 0.1})).find("unsupported occluders"),
            std::string::npos);
  const std::pair<ChangeOptions, const char*> wrong[] = {
      {{.registration_error = -1.0}, "registration error"},
      {{.registration_error = k_nan}, "registration error"},
      {{.normal_radius = 0.0}, "radius of normals"},
      {{.cylinder_radius = -0.1}, "radius of cylinders"},
      {{.max_distance = k_nan}, "maximum distance"},
      {{.max_range = 0.0}, "range of the scanners"}};
  for (const auto& [options, words] : wrong)
    EXPECT_NE(error_of(good, good, options).find(words), std::string::npos) << words;
}

TEST(Change, a_few_points_are_no_surface_and_no_trouble) {
  for (const std::size_t count : {1, 2, 5, 9}) {
    Points points;
    for (std::size_t i = 0; i < count; ++i) points.emplace_back(0.1 * static_cast<double>(i), 0, 0);
    const Changes changes = changes_of(Scan(points, {{0, 0, 1}}), Scan(points, {{0, 0, 1}}));
    EXPECT_EQ(share(changes.before, ChangeClass::same), 1.0) << count;
    // All at one position, that of the scanner.
    const Points equal(count, glm::dvec3(1.0));
    EXPECT_EQ(share(changes_of(Scan(equal, {{1, 1, 1}}), Scan(equal, {{1, 1, 1}})).after, ChangeClass::same),
              1.0);
  }
}

}  // namespace
}  // namespace alidade::test
