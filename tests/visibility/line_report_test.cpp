// SPDX-License-Identifier: MIT
#include "visibility/lines/line_report.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "base/error.h"
#include "octree/distance.h"
#include "tests/support/random.h"
#include "tests/visibility/wall_cloud.h"

namespace alidade::test {

using namespace visibility;

namespace {

/// A wall across the x axis at 30 m, 4 m wide, from z = 0 to 2.
WallCloud wall() {
  return WallCloud().add({30, -2, 0}, {0, 4, 0}, {0, 0, 2}, 0.1);
}

LineReport report_one(const Occluders& occluders, const SightEnd& from, const SightEnd& to,
                      const LineReportOptions& options = {}) {
  const LinePair pair{"a", from, "b", to};
  return report_lines(occluders, std::span(&pair, 1), options)[0];
}

TEST(LineReport, a_wall_blocks_and_its_position_is_reported) {
  const Occluders occluders = wall().occluders();
  const LineReport line = report_one(occluders, {{0, 0.03, 1.02}}, {{100, 0.03, 1.02}});
  ASSERT_TRUE(line.blocker);
  EXPECT_NEAR(line.blocker->distance, 30.0, 1e-3);
  EXPECT_NEAR(line.blocker->position.x, 30.0, 1e-3);
  EXPECT_NEAR(line.blocker->position.y, 0.0, 0.15);
  EXPECT_NEAR(line.blocker->position.z, 1.0, 0.15);
  EXPECT_EQ(line.length, 100.0);
}

TEST(LineReport, a_line_over_the_wall_is_free_and_its_clearance_is_reported) {
  const WallCloud cloud = wall();
  const LineReport line = report_one(cloud.occluders(), {{0, 0, 2.5}}, {{100, 0, 2.5}});
  EXPECT_FALSE(line.blocker);
  ASSERT_TRUE(line.nearest);
  EXPECT_NEAR(line.nearest->distance, 0.5, 1e-9);
  EXPECT_NEAR(line.nearest->t, 30.0, 1e-9);
  EXPECT_EQ(line.nearest->position, cloud.positions()[line.nearest->point_id]);
}

TEST(LineReport, points_beyond_the_ends_do_not_reduce_the_clearance) {
  const Occluders occluders = wall().occluders();
  EXPECT_FALSE(report_one(occluders, {{31, 0, 2.2}}, {{100, 0, 2.2}}).nearest);
  EXPECT_FALSE(report_one(occluders, {{0, 0, 2.2}}, {{29, 0, 2.2}}).nearest);
  EXPECT_TRUE(report_one(occluders, {{29, 0, 2.2}}, {{31, 0, 2.2}}).nearest);
  const LineReportOptions bent{.line = {.earth_radius = 1e9}};
  EXPECT_FALSE(report_one(occluders, {{31, 0, 2.2}}, {{100, 0, 2.2}}, bent).nearest);
  EXPECT_FALSE(report_one(occluders, {{0, 0, 2.2}}, {{29, 0, 2.2}}, bent).nearest);
  EXPECT_TRUE(report_one(occluders, {{29, 0, 2.2}}, {{31, 0, 2.2}}, bent).nearest);
}

TEST(LineReport, clearance_vs_brute_force) {
  Random random;
  WallCloud cloud;
  for (int i = 0; i < 2000; ++i) cloud.add(20.0 * random.in_cube());
  const Occluders occluders = cloud.occluders({.radius = 0.01});
  const Octree& octree = occluders.octree();
  int found = 0;
  for (int i = 0; i < 200; ++i) {
    const SightEnd from{25.0 * random.in_cube(), 2.0 * random.unit()}, to{25.0 * random.in_cube()};
    const double margin = i % 2 == 0 ? 0.0 : 3.0 * random.unit();
    const LineReport line = report_one(occluders, from, to, {.line = {.end_margin = margin}});
    const SightLine whole = sight_line(from, to);
    const Ray ray = make_ray(from.position, to.position - from.position);
    std::optional<double> least;
    for (const glm::dvec3& point : cloud.positions()) {
      const auto [t, beside] = project(ray, point);
      if (!(t > margin && t < whole.length - margin)) continue;
      if (margin == 0.0 && distance(from.position, point) <= from.own_reach) continue;
      if (!least || beside < *least) least = beside;
    }
    ASSERT_EQ(line.nearest.has_value(), least.has_value());
    const LineReport bent =
        report_one(occluders, from, to, {.line = {.end_margin = margin, .earth_radius = 1e12}});
    ASSERT_EQ(bent.nearest.has_value(), least.has_value());
    if (!least) continue;
    ++found;
    EXPECT_NEAR(bent.nearest->distance, *least, 2e-4);
    EXPECT_NEAR(bent.nearest->t, project(ray, bent.nearest->position).t, 1e-6);
    // The cloud's positions are rounded to the lattice.
    EXPECT_NEAR(line.nearest->distance, *least, 2e-4);
    EXPECT_NEAR(line.nearest->distance, project(ray, line.nearest->position).distance, 1e-9);
    EXPECT_NEAR(line.nearest->t, project(ray, line.nearest->position).t, 1e-9);
  }
  EXPECT_GT(found, 190);
  EXPECT_EQ(octree.size(), 2000u);
}

TEST(LineReport, blockers_are_those_of_single_sight_lines) {
  Random random;
  WallCloud cloud = wall();
  cloud.add({60, -3, 0}, {0, 3, 1}, {0, 0, 3}, 0.1);
  const Occluders occluders = cloud.occluders();
  std::vector<LinePair> pairs;
  for (int i = 0; i < 500; ++i) {
    pairs.push_back({"",
                     {{random.between(0, 20), random.between(-3, 3), random.between(0, 3)}},
                     "",
                     {{random.between(50, 100), random.between(-3, 3), random.between(0, 3)}}});
  }
  const std::vector<LineReport> lines = report_lines(occluders, pairs, {});
  int hidden = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const std::optional<Blocker> blocker = first_blocker(occluders, sight_line(pairs[i].from, pairs[i].to));
    ASSERT_EQ(lines[i].blocker.has_value(), blocker.has_value());
    if (!blocker) continue;
    ++hidden;
    EXPECT_EQ(lines[i].blocker->point_id, blocker->point_id);
    EXPECT_NEAR(lines[i].blocker->distance, blocker->distance, 1e-9);
  }
  EXPECT_GT(hidden, 100);
  EXPECT_LT(hidden, 450);
}

TEST(LineReport, end_margins_are_not_tested) {
  const Occluders occluders = wall().occluders();
  const SightEnd mast{{29, 0, 1}}, far{{100, 0, 1}};
  EXPECT_TRUE(report_one(occluders, mast, far).blocker);
  const LineReport line = report_one(occluders, mast, far, {.line = {.end_margin = 1.5}});
  EXPECT_FALSE(line.blocker);
  EXPECT_FALSE(line.nearest);
  EXPECT_EQ(line.length, 71.0);
  EXPECT_FALSE(report_one(occluders, far, mast, {.line = {.end_margin = 1.5}}).blocker);
  EXPECT_TRUE(report_one(occluders, far, mast, {.line = {.end_margin = 0.5}}).blocker);
  // The margin alone then decides what belongs to an end.
  const SightEnd on_wall{{29, 0, 1}, 3.0, 2.0};
  EXPECT_FALSE(report_one(occluders, on_wall, far).blocker);
  EXPECT_FALSE(report_one(occluders, on_wall, far).nearest);
  EXPECT_TRUE(report_one(occluders, on_wall, far, {.line = {.end_margin = 0.5}}).blocker);
  EXPECT_TRUE(report_one(occluders, on_wall, far, {.line = {.end_margin = 0.5}}).nearest);
  // Margins that meet leave nothing to look at.
  EXPECT_FALSE(report_one(occluders, mast, {{31, 0, 1}}, {.line = {.end_margin = 1.0}}).blocker);
}

TEST(LineReport, a_bent_line_sinks_as_the_formula_says) {
  // In the middle of 100 m the line sinks by 100^2 / (8 radius).
  const Occluders occluders = WallCloud().add({50, -2, 0}, {0, 4, 0}, {0, 0, 2}, 0.05).occluders();
  const SightEnd from{{0, 0, 2.4}}, to{{100, 0, 2.4}};
  EXPECT_FALSE(report_one(occluders, from, to).blocker);
  const LineReport above = report_one(occluders, from, to, {.line = {.earth_radius = 10000.0 / (8 * 0.25)}});
  EXPECT_FALSE(above.blocker);
  EXPECT_NEAR(above.nearest->distance, 0.15, 1e-3);
  const LineReport below = report_one(occluders, from, to, {.line = {.earth_radius = 10000.0 / (8 * 0.6)}});
  ASSERT_TRUE(below.blocker);
  EXPECT_NEAR(below.blocker->distance, 50.0, 1e-2);
}

TEST(LineReport, spheres_around_the_joints_of_a_bent_line_block) {
  // A row of lone points all along the line: wherever pieces meet, some are near.
  WallCloud cloud;
  for (int i = 1; i < 1000; ++i) cloud.add({0.1 * i, 0.03, 0});
  const Occluders occluders = cloud.occluders({.shape = OccluderShape::sphere, .radius = 0.04});
  for (double start = 0.5; start < 60.0; start += 0.37) {
    const LineReport line =
        report_one(occluders, {{start, 0, 0}}, {{start + 39, 0, 0}}, {.line = {.earth_radius = 1e9}});
    ASSERT_TRUE(line.blocker) << start;
    EXPECT_LT(line.blocker->distance, 0.2);
  }
  // One sphere after another just behind where two of 24 pieces meet.
  for (int joint = 1; joint < 24; ++joint) {
    const double t = 50.0 * (1.0 - std::cos(3.14159265358979 * joint / 24));
    for (const double shift : {-0.03, -0.001, 0.0, 0.001, 0.03}) {
      const Occluders lone =
          WallCloud().add({t + shift, 0.01, 0}).occluders({.shape = OccluderShape::sphere, .radius = 0.04});
      EXPECT_TRUE(report_one(lone, {{0, 0, 0}}, {{100, 0, 0}}, {.line = {.earth_radius = 1e9}}).blocker)
          << joint << " " << shift;
    }
  }
}

TEST(LineReport, is_the_same_on_one_thread) {
  Random random;
  const Occluders occluders = wall().occluders();
  std::vector<LinePair> pairs;
  for (int i = 0; i < 40; ++i)
    pairs.push_back({"", {{0, random.between(-2, 2), random.between(0, 3)}}, "", {{90, 0, 1.5}}});
  const std::vector<LineReport> many = report_lines(occluders, pairs, {});
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const std::vector<LineReport> single = report_lines(occluders, pairs, {});
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    EXPECT_EQ(many[i].blocker, single[i].blocker);
    EXPECT_EQ(many[i].nearest->distance, single[i].nearest->distance);
  }
}

TEST(LineReport, bad_options_are_errors) {
  const Occluders occluders = wall().occluders(), through = wall().occluders({.transparency = 2});
  const SightEnd from{{0, 0, 1}}, to{{9, 0, 1}};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(report_one(occluders, from, to, {.line = {.end_margin = -1.0}}), Error);
  EXPECT_THROW(report_one(occluders, from, to, {.line = {.end_margin = nan}}), Error);
  EXPECT_THROW(report_one(occluders, from, to, {.line = {.earth_radius = 0.0}}), Error);
  EXPECT_THROW(report_one(occluders, {{nan, 0, 0}}, to), Error);
  EXPECT_THROW(report_one(through, from, to, {.line = {.earth_radius = 1e7}}), Error);
}

TEST(LineReport, stops_when_requested) {
  const Occluders occluders = wall().occluders();
  const std::vector<LinePair> pairs(3, {"", {{0, 0, 1}}, "", {{9, 0, 1}}});
  EXPECT_THROW(report_lines(occluders, pairs, {}, [](std::uint64_t, std::uint64_t) { return false; }),
               Cancelled);
}

/// The length of a line, from one end to the other.
class LengthMeasure : public LineMeasure {
 public:
  Measure begin(const Occluders&, const LineOptions&, std::size_t lines) override {
    lengths.resize(lines);
    return [](const SightEnd& from, const SightEnd& to, PartWriter& writer) {
      writer.put(distance(from.position, to.position));
    };
  }
  void take(std::size_t line, PartReader& reader) override { lengths[line] = reader.take<double>(); }
  void add_columns(std::size_t, std::span<const std::uint8_t>, Row&) const override {}

  std::vector<double> lengths;
};

TEST(LineReport, measures_have_a_result_for_every_line_in_order) {
  const Occluders occluders = wall().occluders();
  std::vector<LinePair> pairs;
  for (int i = 0; i < 20; ++i) pairs.push_back({"", {{0, 0.1 * i, 1}}, "", {{90, 0, 1.5}}});
  const auto one = std::make_shared<LengthMeasure>(), two = std::make_shared<LengthMeasure>();
  const std::vector<LineReport> reports = report_lines(occluders, pairs, {.measures = {one, two}});
  ASSERT_EQ(one->lengths.size(), pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) EXPECT_NEAR(one->lengths[i], reports[i].length, 1e-12);
  EXPECT_EQ(two->lengths, one->lengths);
}

TEST(LineReport, comes_back_from_its_bytes) {
  LineReport report;
  report.length = 12.5;
  report.blocker = Blocker{3, {1, 2, 3}, 4.5};
  report.nearest = LinePoint{4, {5, 6, 7}, 8.5, 9.5};
  PartWriter writer;
  put_report(report, writer);
  PartReader reader(writer.bytes(), "file", 0);
  const LineReport back = take_report(reader, 5);
  reader.finish();
  PartWriter again;
  put_report(back, again);
  EXPECT_EQ(again.bytes(), writer.bytes());
  EXPECT_EQ(back.blocker, report.blocker);
  // A cloud of four points has no point 4.
  PartReader small(writer.bytes(), "file", 0);
  EXPECT_THROW(take_report(small, 4), Error);
}

}  // namespace
}  // namespace alidade::test
