// SPDX-License-Identifier: MIT
// Meshes that block lines of sight, through every result that has a blocker.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "geo/earth.h"
#include "tests/support/random.h"
#include "tests/support/triangle_oracle.h"
#include "tests/visibility/checked_sight.h"
#include "tests/visibility/viewshed_place.h"
#include "tests/visibility/wall_cloud.h"
#include "visibility/horizon/skyline.h"
#include "visibility/lines/line_report.h"
#include "visibility/points/point_visibility.h"
#include "visibility/sky/sky_view.h"

namespace alidade::test {
namespace {

const glm::dvec3 k_far(690000.0, 5325000.0, 600.0);

void add_rectangle(TriangleMesh& mesh, const glm::dvec3& corner, const glm::dvec3& u, const glm::dvec3& v) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const glm::dvec3& vertex : {corner, corner + u, corner + u + v, corner + v})
    mesh.vertices.push_back(vertex);
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
}

std::shared_ptr<const TriangleTree> tree_of(TriangleMesh mesh) {
  return std::make_shared<const TriangleTree>(std::move(mesh));
}

/// A wall across the x axis, 4 m wide and `height` high.
std::shared_ptr<const TriangleTree> wall_at(double x, double height = 4.0,
                                            const glm::dvec3& offset = glm::dvec3(0.0)) {
  TriangleMesh mesh;
  add_rectangle(mesh, offset + glm::dvec3(x, -2, 0), {0, 4, 0}, {0, 0, height});
  return tree_of(std::move(mesh));
}

/// Points far aside, so that only a mesh can block.
WallCloud elsewhere() {
  return WallCloud().add({0, 50, 0}, {4, 0, 0}, {0, 4, 0}, 0.5);
}

TEST(SightMesh, a_mesh_between_two_positions_blocks_where_the_line_meets_it) {
  for (const glm::dvec3 offset : {glm::dvec3(0.0), k_far}) {
    const Occluders occluders = elsewhere().occluders({.mesh = wall_at(5.0, 4.0, offset)});
    const auto from_to = [&](const glm::dvec3& from, const glm::dvec3& to) {
      return blocker_of(occluders, sight_line({offset + from}, {offset + to}));
    };
    const std::optional<Blocker> blocker = from_to({1, 1, 2}, {9, 1, 2});
    ASSERT_TRUE(blocker);
    EXPECT_TRUE(blocker->is_mesh());
    EXPECT_EQ(blocker->point_id, k_mesh_blocker);
    EXPECT_NEAR(blocker->distance, 4.0, 1e-8);
    EXPECT_NEAR(glm::distance(blocker->position, offset + glm::dvec3(5, 1, 2)), 0.0, 1e-8);
    EXPECT_TRUE(from_to({9, 1, 2}, {1, 1, 2})) << "from the other side";
    EXPECT_FALSE(from_to({1, 1, 2}, {4, 1, 2})) << "the wall is behind the second end";
    EXPECT_FALSE(from_to({6, 1, 2}, {9, 1, 2})) << "the wall is behind the first end";
    EXPECT_FALSE(from_to({1, 1, 5}, {9, 1, 5})) << "over the wall";
  }
}

TEST(SightMesh, an_end_is_not_blocked_by_what_it_lies_on_within_a_millimetre) {
  const Occluders occluders = elsewhere().occluders({.mesh = wall_at(5.0, 4.0, k_far)});
  const auto is_free = [&](const glm::dvec3& from, const glm::dvec3& to) {
    const SightLine line = sight_line({k_far + from}, {k_far + to}),
                    back = sight_line({k_far + to}, {k_far + from});
    const bool free = !blocker_of(occluders, line);
    EXPECT_EQ(!blocker_of(occluders, back), free);
    return free;
  };
  for (const double depth : {0.0, 0.0009, -0.0009}) {
    // Straight to it, and at 6 degrees, where the line meets the wall 9 mm before its end.
    EXPECT_TRUE(is_free({1, 0, 2}, {5 + depth, 0, 2})) << depth;
    EXPECT_TRUE(is_free({4.9, 1, 2}, {5 + depth, 0, 2})) << depth;
  }
  EXPECT_FALSE(is_free({1, 0, 2}, {5.0011, 0, 2}));
  EXPECT_FALSE(is_free({4.9, 1, 2}, {5.0011, 0, 2}));
  EXPECT_TRUE(is_free({5, -1, 2}, {5, 1, 2})) << "along the wall";
  // What a ray ends on blocks it: its interval is closed, and its end is no one's.
  const SightEnd eye{{1, 0, 2}};
  const Occluders near = elsewhere().occluders({.mesh = wall_at(5.0)});
  EXPECT_TRUE(blocker_of(near, sight_ray(eye, {1, 0, 0}, 4.0)));
  EXPECT_FALSE(blocker_of(near, sight_ray(eye, {1, 0, 0}, 3.999)));
  EXPECT_TRUE(blocker_of(near, sight_ray(eye, {1, 0, 0})));
  EXPECT_FALSE(blocker_of(near, sight_ray({{5, 0, 2}}, {1, 0, 0})));
  EXPECT_FALSE(blocker_of(near, sight_line({{5, 0, 2}}, {{5, 0, 2}}))) << "no length";
}

TEST(SightMesh, of_points_and_mesh_the_first_blocks_and_a_mesh_is_never_transparent) {
  WallCloud cloud;
  for (const double x : {2.0, 4.0, 6.0}) cloud.add({x, -2, 0}, {0, 4, 0}, {0, 0, 4}, 0.1);
  const SightLine line = sight_line({{0, 0.03, 2.02}}, {{9, 0.03, 2.02}});
  const auto at = [&](std::shared_ptr<const TriangleTree> mesh, int transparency) {
    const std::optional<Blocker> blocker =
        blocker_of(cloud.occluders({.transparency = transparency, .mesh = std::move(mesh)}), line);
    return blocker ? std::pair(blocker->is_mesh(), std::round(100.0 * blocker->distance) / 100.0)
                   : std::pair(false, -1.0);
  };
  EXPECT_EQ(at(wall_at(3.0), 1), std::pair(false, 2.0));
  EXPECT_EQ(at(wall_at(1.0), 1), std::pair(true, 1.0));
  EXPECT_EQ(at(wall_at(3.0), 2), std::pair(true, 3.0)) << "after one crossing of two";
  EXPECT_EQ(at(wall_at(5.0), 2), std::pair(false, 4.0));
  EXPECT_EQ(at(wall_at(8.0), 9), std::pair(true, 8.0));
  EXPECT_EQ(at(nullptr, 9), std::pair(false, -1.0));
}

TEST(SightMesh, nothing_slips_through_where_chords_meet) {
  const glm::dvec3 joint(5.0, 0, 2);
  const SightLine chords[] = {sight_line({{1, 0, 2}}, chord_end(joint)),
                              sight_line(chord_end(joint), {{9, 0, 2.5}})};
  const double starts[] = {0.0, 4.0};
  const std::size_t begin[] = {0, 2};
  for (const int transparency : {1, 2}) {
    const Occluders some = elsewhere().occluders({.transparency = transparency, .mesh = wall_at(5.0)});
    std::optional<Blocker> blocker;
    first_blockers(some, ChordLines{chords, starts, begin}, {&blocker, 1});
    ASSERT_TRUE(blocker) << transparency;
    EXPECT_NEAR(blocker->distance, 4.0, 1e-8);
  }
}

TEST(SightMesh, bent_lines_meet_meshes_outside_of_the_cloud) {
  // On a round Earth the middle of a line of 20 km hangs 7 m below its chord.
  const SightCurve curve(1.0, 1.0);
  const glm::dvec3 from(-10000, 0, 100), to(10000, 0, 100);
  for (const auto& [height, hidden] : {std::pair(92.0, false), std::pair(93.0, true)}) {
    for (const int transparency : {1, 2}) {
      SightBatch batch(elsewhere().occluders({.transparency = transparency, .mesh = wall_at(3000.0, height)}),
                       curve);
      batch.add({from}, {to});
      const double low = curve.position(from, to, 0.65).z;
      ASSERT_EQ(low < height, hidden);
      EXPECT_EQ(batch.blocked()[0], hidden ? 1 : 0);
      const std::optional<Blocker> blocker = batch.first_blockers()[0];
      ASSERT_EQ(blocker.has_value(), hidden);
      if (blocker) {
        EXPECT_NEAR(blocker->distance, 13000.0, 0.1);
      }
    }
  }
}

/// Ground with a wall, and triangles of all sizes over it.
struct Jumble {
  WallCloud cloud;
  TriangleMesh mesh;

  explicit Jumble(Random& random) {
    cloud.add({0, 0, 0}, {10, 0, 0}, {0, 10, 0}, 0.25).add({5, 2, 0}, {0, 6, 0}, {0, 0, 3}, 0.2);
    for (std::uint32_t i = 0; i < 60; ++i) {
      const glm::dvec3 middle(random.between(0, 10), random.between(0, 10), random.between(0, 4));
      const double size = i % 10 == 0 ? 3.0 : 0.6;
      for (int corner = 0; corner < 3; ++corner) mesh.vertices.push_back(middle + size * random.in_cube());
      mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
  }
};

/// Where a line meets the first triangle on whose plane none of its ends lies: a loop over all triangles,
/// repeated behind each of those.
std::optional<double> first_triangle(const TriangleMesh& mesh, const SightLine& line) {
  constexpr double k_infinity = std::numeric_limits<double>::infinity();
  Ray ray{line.from.position, line.direction, 0.0, line.length};
  while (const auto hit = closest_by_brute_force(mesh, ray)) {
    const glm::dvec3 met = ray.position(hit->t);
    const auto plane_distance = [&](const SightEnd& end) {
      return std::fabs(glm::dot(end.position - met, hit->normal));
    };
    const double to = line.length == k_infinity ? 1.0 : plane_distance(line.to);
    if (plane_distance(line.from) >= line.from.mesh_contact && to >= line.to.mesh_contact) return hit->t;
    ray.t_min = std::nextafter(hit->t, k_infinity);
  }
  return std::nullopt;
}

std::vector<SightLine> random_lines(const Jumble& jumble, Random& random, std::size_t count) {
  std::vector<SightLine> lines;
  const auto position = [&] {
    return glm::dvec3(random.between(-1, 11), random.between(-1, 11), random.between(-0.5, 5));
  };
  // On a triangle, as well as doubles allow.
  const auto on_mesh = [&] {
    const TriangleMesh::Triangle& triangle =
        jumble.mesh.triangles[random.below(jumble.mesh.triangles.size())];
    const double a = random.unit(), b = random.unit() * (1.0 - a);
    return a * jumble.mesh.vertices[triangle[0]] + b * jumble.mesh.vertices[triangle[1]] +
           (1.0 - a - b) * jumble.mesh.vertices[triangle[2]];
  };
  for (std::size_t i = 0; i < count; ++i) {
    const SightEnd from{i % 4 == 1 ? on_mesh() : position()};
    if (i % 4 == 2)
      lines.push_back(sight_ray(from, random.direction(), random.between(0, 12)));
    else if (i % 4 == 3)
      lines.push_back(sight_ray(from, random.direction()));
    else
      lines.push_back(sight_line(from, {i % 3 == 0 ? on_mesh() : position()}));
  }
  return lines;
}

TEST(SightMesh, answers_are_those_of_a_loop_over_all_triangles_beside_those_of_the_points) {
  Random random;
  const Jumble jumble(random);
  const std::shared_ptr<const TriangleTree> tree = tree_of(jumble.mesh);
  const std::vector<SightLine> lines = random_lines(jumble, random, 3000);
  for (const int transparency : {1, 2}) {
    const Occluders both = jumble.cloud.occluders({.transparency = transparency, .mesh = tree}),
                    points = jumble.cloud.occluders({.transparency = transparency});
    std::vector<std::optional<Blocker>> blockers(lines.size()), by_points(lines.size());
    std::vector<std::uint8_t> answers(lines.size());
    first_blockers(both, lines, blockers);
    first_blockers(points, lines, by_points);
    blocked(both, lines, answers);
    int meshes = 0, clouds = 0, free = 0, both_block = 0;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      std::optional<Blocker> expected = by_points[i];
      const std::optional<double> t = first_triangle(jumble.mesh, lines[i]);
      both_block += t && expected ? 1 : 0;
      if (t && (!expected || *t < expected->distance))
        expected = Blocker{k_mesh_blocker, lines[i].from.position + *t * lines[i].direction, *t};
      ASSERT_EQ(blockers[i], expected) << i;
      ASSERT_EQ(answers[i], expected ? 1 : 0) << i;
      ASSERT_EQ(first_blocker(both, lines[i]), expected) << i;
      ++(!expected ? free : expected->is_mesh() ? meshes : clouds);
    }
    EXPECT_GT(std::min({meshes, clouds, free, both_block}), transparency == 1 ? 100 : 5);
    // As lines of three chords each, one behind the other.
    std::vector<double> starts(lines.size());
    std::vector<std::size_t> begin;
    for (std::size_t chord = 0; chord <= lines.size(); chord += 3) begin.push_back(chord);
    for (std::size_t chord = 0; chord < lines.size(); ++chord)
      starts[chord] = 100.0 * static_cast<double>(chord % 3);
    const ChordLines chords{lines, starts, begin};
    std::vector<std::optional<Blocker>> of_lines(lines.size() / 3), of_points(lines.size() / 3);
    first_blockers(both, chords, of_lines);
    first_blockers(points, chords, of_points);
    for (std::size_t line = 0; line < of_lines.size(); ++line) {
      std::optional<Blocker> expected = of_points[line];
      for (std::size_t chord = 3 * line; chord < 3 * line + 3; ++chord) {
        const SightLine& one = lines[chord];
        const std::optional<double> t = first_triangle(jumble.mesh, one);
        if (!t) continue;
        const Blocker met{k_mesh_blocker, one.from.position + *t * one.direction, starts[chord] + *t};
        if (!expected || met.distance < expected->distance) expected = met;
        break;
      }
      ASSERT_EQ(of_lines[line], expected) << line;
    }
  }
}

TEST(SightMesh, the_horizon_is_the_highest_blocked_of_all_lines) {
  Random random;
  const Jumble jumble(random);
  TriangleMesh mesh = jumble.mesh;
  add_rectangle(mesh, {1, 1, 1.5}, {3, 0, 0}, {0, 3, 0});
  const Occluders occluders = jumble.cloud.occluders({.mesh = tree_of(std::move(mesh))});
  // In the air, and on the level rectangle.
  for (const SightEnd& eye : {SightEnd{{5.3, 5.2, 1.7}}, SightEnd{{2, 2.5, 1.5}}}) {
    int meshes = 0;
    for (const HorizonDirection& direction :
         horizon(occluders, eye, {.step = 2.0, .resolution = 0.25, .max_distance = 7.0})) {
      expect_highest_blocked(direction, occluders, eye, 7.0);
      if (!direction.elevation) continue;
      meshes += direction.blocker->is_mesh() ? 1 : 0;
    }
    EXPECT_GT(meshes, 60);
  }
}

TEST(SightMesh, horizon_files_have_no_point_of_a_mesh) {
  const Occluders occluders = elsewhere().occluders({.mesh = wall_at(5.0)});
  const std::vector<HorizonDirection> line =
      horizon(occluders, {{0, 0, 0}}, {.step = 30.0, .azimuth_min = 90.0, .azimuth_max = 90.5});
  ASSERT_EQ(line.size(), 1u);
  ASSERT_TRUE(line[0].elevation);
  EXPECT_NEAR(*line[0].elevation, 38.66, 0.01) << "4 m high and 5 m away";
  EXPECT_NE(horizon_csv(line).find("\n90,38.65,6.4022,,5,0,"), std::string::npos) << horizon_csv(line);
  const std::string text = horizon_geojson(line, {}, {});
  EXPECT_NE(text.find("\"point_id\":null"), std::string::npos) << text;
  EXPECT_EQ(text.find("1844674407"), std::string::npos) << text;
}

TEST(SightMesh, panoramas_show_its_distance_and_no_point) {
  const Occluders occluders = elsewhere().occluders({.mesh = wall_at(5.0)});
  const image::Film film = depth_panorama(occluders, {{0, 0, 2}}, 64, 32);
  const std::size_t east = film.index(48, 15);
  EXPECT_NEAR(film.distance[east], 5.0, 0.1);
  EXPECT_EQ(film.id[east], 0u);
}

TEST(SightMesh, points_behind_it_are_not_seen_and_name_it) {
  WallCloud cloud;
  cloud.add({9, -1, 1}, {0, 2, 0}, {0, 0, 2}, 0.2).add({9, -1, 6}, {0, 2, 0}, {0, 0, 2}, 0.2);
  const Occluders occluders = cloud.occluders({.mesh = wall_at(5.0)});
  Observer observer;
  observer.position = {1, 0, 2};
  const PointVisibility seen =
      point_visibility(occluders, {&observer, 1}, {.sub_rays = 4, .with_blockers = true});
  for (std::size_t id = 0; id < cloud.positions().size(); ++id) {
    const double height = cloud.positions()[id].z;
    // The line to 6 m passes the edge of the wall.
    if (height > 6.1) {
      ASSERT_EQ(seen.counts[id], 1u) << id;
      ASSERT_EQ(seen.blockers[0][id], k_no_blocker);
    }
    if (height > 5.9) continue;
    ASSERT_EQ(seen.counts[id], 0u) << id;
    ASSERT_EQ(seen.blockers[0][id], k_blocked_by_mesh);
    ASSERT_EQ(seen.fractions[id], 0.0f);
  }
}

TEST(SightMesh, line_reports_name_it_and_come_back_from_their_bytes) {
  const Occluders occluders = elsewhere().occluders({.mesh = wall_at(5.0, 2.0)});
  const LinePair pairs[] = {{"a", {{0, 0, 2}}, "b", {{10, 0, 2}}}, {"a", {{0, 0, 1}}, "b", {{10, 0, 1}}}};
  const std::vector<LineReport> reports = report_lines(occluders, pairs, {});
  ASSERT_TRUE(reports[1].blocker);
  EXPECT_TRUE(reports[1].blocker->is_mesh());
  EXPECT_NEAR(reports[1].blocker->distance, 5.0, 1e-8);
  PartWriter writer;
  for (const LineReport& report : reports) put_report(report, writer);
  PartReader reader(writer.bytes(), "file", 0);
  for (const LineReport& report : reports)
    EXPECT_EQ(take_report(reader, occluders.octree().size()).blocker, report.blocker);
  reader.finish();
}

TEST(SightMesh, the_lowest_seen_height_behind_it_is_on_the_line_over_its_edge) {
  Field field;
  TriangleMesh mesh;
  add_rectangle(mesh, {0, -30, 0}, {0, 60, 0}, {0, 0, 3});
  OccluderOptions options;
  options.mesh = tree_of(std::move(mesh));
  const Occluders occluders(field.occluders().octree(), options);
  const Observer eye = at(-10, 0, 1.5);
  const Viewshed seen = viewshed(occluders, field.ground(), {&eye, 1}, Field::grid(),
                                 {.mode = ViewshedMode::height, .highest = 50.0});
  int hidden = 0;
  for_cells(seen, [&](float value, const glm::dvec2& cell) {
    if (cell.x < 1) return;
    ++hidden;
    EXPECT_NEAR(value, 1.5 + 1.5 * (cell.x + 10.0) / 10.0, 0.03) << cell.x << " " << cell.y;
  });
  EXPECT_GT(hidden, 100);
  // Without it all of the ground is seen.
  const Viewshed open = field.seen({&eye, 1});
  EXPECT_GT(std::ranges::count(open.values.values, 1.0f), 600);
}

TEST(SightMesh, a_roof_takes_the_sky) {
  TriangleMesh mesh;
  add_rectangle(mesh, {-1000, -1000, 3}, {2000, 0, 0}, {0, 2000, 0});
  const Occluders occluders = elsewhere().occluders({.mesh = tree_of(std::move(mesh))});
  EXPECT_LT(sky_shares(occluders, {{0, 0, 1}}, 256).cosine_weighted, 0.01);
  EXPECT_GT(sky_shares(occluders, {{0, 0, 4}}, 256).cosine_weighted, 0.95);
  EXPECT_GT(sky_shares(occluders, {{0, 0, 3}}, 256).cosine_weighted, 0.95) << "on the roof";
}

}  // namespace
}  // namespace alidade::test
