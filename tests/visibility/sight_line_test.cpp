// SPDX-License-Identifier: MIT
#include "visibility/sight_line.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "octree/build.h"
#include "octree/spacing.h"
#include "tests/support/random.h"
#include "tests/support/spacings.h"
#include "tests/visibility/plain_hits.h"
#include "visibility/crossing.h"

namespace alidade {

using namespace visibility;

namespace {

using test::Random;

const glm::dvec3 k_corner(690000.0, 5325000.0, 600.0);

PointCloud empty_cloud() {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(1e-4), .offset = k_corner};
  return cloud;
}

void add(PointCloud& cloud, const glm::dvec3& position) {
  cloud.positions.emplace_back(glm::round(position / cloud.lattice.scale));
}

/// Points spread over the parallelogram from a corner along two sides.
void add_sheet(PointCloud& cloud, std::size_t count, const glm::dvec3& corner, const glm::dvec3& u,
               const glm::dvec3& v, double noise, Random& random) {
  const glm::dvec3 normal = glm::normalize(glm::cross(u, v));
  for (std::size_t i = 0; i < count; ++i)
    add(cloud, corner + random.unit() * u + random.unit() * v + random.between(-noise, noise) * normal);
}

/// Ground with a wall, a bush and a wire, in the tenth of metres.
PointCloud garden() {
  Random random("garden");
  PointCloud cloud = empty_cloud();
  add_sheet(cloud, 4000, {0, 0, 0}, {20, 0, 0}, {0, 20, 0}, 0.01, random);
  add_sheet(cloud, 1500, {10, 5, 0}, {0, 10, 0}, {0, 0, 3}, 0.01, random);
  for (int i = 0; i < 800; ++i) add(cloud, glm::dvec3(5, 5, 1) + random.in_cube());
  for (int i = 0; i < 200; ++i) add(cloud, {15.0, 0.1 * i, 4.0});
  return cloud;
}

/// The definition: all points that block, in the order in which the line meets them.
std::vector<Hit> all_blockers(const Occluders& occluders, const PointCloud& cloud, const SightLine& line) {
  const std::vector<double> spacings =
      occluders.options().radius ? std::vector<double>() : test::spacings_by_id(occluders.octree());
  return test::plain_hits(occluders, cloud, spacings, line, [&](const Candidate& candidate) {
    return crossing(occluders, line, candidate).has_value();
  });
}

std::vector<SightLine> random_lines(const Occluders& occluders, const PointCloud& cloud, std::size_t count) {
  Random random("random_lines");
  std::vector<SightLine> lines;
  for (std::size_t i = 0; i < count; ++i) {
    const SightEnd eye{k_corner +
                       glm::dvec3(random.between(-2, 22), random.between(-2, 22), random.between(-1, 5))};
    const std::size_t id = random.below(cloud.size());
    if (i % 3 == 0) {
      lines.push_back(sight_ray(eye, random.direction()));
    } else if (i % 3 == 1) {
      lines.push_back(sight_line(eye, end_on_point(occluders, id, cloud.world(id), eye.position)));
    } else {
      lines.push_back(sight_line(eye, end_near_surface(occluders, cloud.world(id))));
    }
  }
  return lines;
}

TEST(SightLine, is_blocked_by_what_a_look_at_every_point_finds) {
  const PointCloud cloud = garden();
  for (const OccluderShape shape : {OccluderShape::automatic, OccluderShape::disc, OccluderShape::sphere}) {
    for (const std::optional<double> radius : {std::optional<double>(), std::optional<double>(0.3)}) {
      std::optional<std::vector<std::uint8_t>> known;
      for (const InstructionSet set : available_instruction_sets()) {
        const Occluders occluders(build(cloud).with_instruction_set(set), {.shape = shape, .radius = radius});
        const std::vector<SightLine> lines = random_lines(occluders, cloud, 300);
        std::vector<std::optional<Blocker>> blockers(lines.size());
        std::vector<std::uint8_t> answers(lines.size());
        first_blockers(occluders, lines, blockers);
        blocked(occluders, lines, answers);
        for (std::size_t i = 0; i < lines.size(); ++i) {
          const std::vector<Hit> expected = all_blockers(occluders, cloud, lines[i]);
          ASSERT_EQ(blockers[i].has_value(), !expected.empty()) << i;
          ASSERT_EQ(answers[i], expected.empty() ? 0 : 1) << i;
          if (!expected.empty()) {
            ASSERT_EQ(blockers[i]->point_id, expected.front().point_id) << i;
          }
          ASSERT_EQ(first_blocker(occluders, lines[i]), blockers[i]);
        }
        if (known) {
          ASSERT_EQ(answers, *known);
        }
        known = answers;
        ASSERT_GT(std::ranges::count(answers, 1), 30);
        ASSERT_GT(std::ranges::count(answers, 0), 30);
      }
    }
  }
}

TEST(SightLine, over_flat_ground_is_free_with_discs_and_blocked_with_spheres) {
  Random random("flat_ground");
  PointCloud cloud = empty_cloud();
  add_sheet(cloud, 40000, {0, 0, 0}, {500, 0, 0}, {0, 20, 0}, 0.02, random);
  const Octree octree = build(cloud);
  const SightEnd eye{k_corner + glm::dvec3(0, 10, 1.7)};
  std::size_t free_discs = 0, free_spheres = 0, count = 0;
  const Occluders discs(octree, {}), spheres(octree, {.shape = OccluderShape::sphere, .radius = 0.7});
  for (std::size_t id = 0; id < cloud.size(); id += 7) {
    const glm::dvec3 target = cloud.world(id);
    if (std::fabs(target.y - eye.position.y) > 8.0 || target.x - eye.position.x < 300.0) continue;
    ++count;
    const auto free = [&](const Occluders& occluders) {
      return first_blocker(occluders, sight_line(eye, end_on_point(occluders, id, target, eye.position))) ? 0
                                                                                                          : 1;
    };
    free_discs += free(discs);
    free_spheres += free(spheres);
  }
  EXPECT_GT(free_discs, 0.99 * static_cast<double>(count));
  EXPECT_EQ(free_spheres, 0u);
}

TEST(SightLine, sees_one_side_of_a_thin_plate) {
  Random random("plate");
  PointCloud cloud = empty_cloud();
  add_sheet(cloud, 6000, {0, 0, 0}, {4, 0, 0}, {0, 0, 4}, 0.0, random);
  const std::size_t front_count = cloud.size();
  add_sheet(cloud, 6000, {0, 0.001, 0}, {4, 0, 0}, {0, 0, 4}, 0.0, random);
  const Occluders occluders(build(cloud), {});
  for (const double side : {-1.0, 1.0}) {
    const SightEnd eye{k_corner + glm::dvec3(1.0, side * 3.0, 1.5)};
    std::size_t right = 0, count = 0;
    for (std::size_t id = 0; id < cloud.size(); ++id) {
      const glm::dvec3 target = cloud.world(id), position = target - k_corner;
      if (std::min(position.x, position.z) < 0.2 || std::max(position.x, position.z) > 3.8) continue;
      const bool seen =
          !first_blocker(occluders, sight_line(eye, end_on_point(occluders, id, target, eye.position)));
      ++count;
      right += seen == ((id < front_count) == (side < 0.0)) ? 1 : 0;
    }
    EXPECT_GT(right, 0.97 * static_cast<double>(count));
  }
}

TEST(SightLine, passes_beside_the_edge_of_a_sheet) {
  Random random("edge_of_a_sheet");
  PointCloud cloud = empty_cloud();
  add_sheet(cloud, 6400, {0, 0, 0}, {4, 0, 0}, {0, 4, 0}, 0.0, random);
  const Occluders occluders(build(cloud), {});
  // Half the distance to the eighth neighbour.
  constexpr double k_beside = 0.04;
  int outside = 0, inside = 0;
  for (int i = 0; i < 400; ++i) {
    const auto is_free = [&](double x) {
      const glm::dvec3 above = k_corner + glm::dvec3(x, 0.5 + 0.0075 * i, 1.0);
      return !first_blocker(occluders, sight_line({above}, {above - glm::dvec3(0.0, 0.0, 2.0)}));
    };
    outside += is_free(-k_beside) ? 1 : 0;
    inside += is_free(k_beside) ? 1 : 0;
  }
  EXPECT_GT(outside, 340);
  EXPECT_LT(inside, 20);
}

TEST(SightLine, passes_as_many_separate_crossings_as_the_transparency_allows) {
  Random random("walls");
  PointCloud cloud = empty_cloud();
  for (int wall = 0; wall < 3; ++wall)
    add_sheet(cloud, 3000, {2.0 + 2.0 * wall, 0, 0}, {0, 4, 0}, {0, 0, 4}, 0.003, random);
  const SightLine line =
      sight_line({k_corner + glm::dvec3(0, 1.9, 1.9)}, {k_corner + glm::dvec3(8, 2.1, 2.1)});
  const Octree octree = build(cloud);
  for (int transparency = 1; transparency <= 4; ++transparency) {
    const Occluders occluders(octree, {.transparency = transparency});
    const std::optional<Blocker> blocker = first_blocker(occluders, line);
    ASSERT_EQ(blocker.has_value(), transparency <= 3) << transparency;
    if (blocker) {
      EXPECT_NEAR(blocker->distance, 2.0 * transparency, 0.02);
    }
  }
}

TEST(SightLine, ends_before_and_begins_behind_what_does_not_block_it) {
  Random random("one_wall");
  PointCloud cloud = empty_cloud();
  add_sheet(cloud, 3000, {2, 0, 0}, {0, 4, 0}, {0, 0, 4}, 0.003, random);
  const Occluders occluders(build(cloud), {});
  const auto seen = [&](double from, double to) {
    return !first_blocker(occluders,
                          sight_line({k_corner + glm::dvec3(from, 2, 2)}, {k_corner + glm::dvec3(to, 2, 2)}));
  };
  EXPECT_TRUE(seen(0.0, 1.97));
  EXPECT_FALSE(seen(0.0, 2.03));
  EXPECT_TRUE(seen(2.03, 4.0));
  EXPECT_FALSE(seen(1.97, 4.0));
  const SightEnd eye{k_corner + glm::dvec3(0, 2, 2)};
  EXPECT_FALSE(first_blocker(occluders, sight_ray(eye, {1, 0, 0}, 1.97)));
  EXPECT_TRUE(first_blocker(occluders, sight_ray(eye, {1, 0, 0})));
  EXPECT_FALSE(first_blocker(occluders, sight_ray(eye, {-1, 0, 0})));
}

TEST(SightLine, to_a_point_without_a_surface_is_not_blocked_by_what_is_beside_it) {
  Random random("beside");
  PointCloud cloud = empty_cloud();
  add_sheet(cloud, 3000, {2, 0, 0}, {0, 4, 0}, {0, 0, 4}, 0.0, random);
  const Occluders occluders(build(cloud), {});
  const SightLine line =
      sight_line({k_corner + glm::dvec3(0, 2, 2)}, {.position = k_corner + glm::dvec3(2.05, 2, 2)});
  const auto blocker = first_blocker(occluders, line);
  ASSERT_TRUE(blocker);
  const double spacing = test::spacings_by_id(occluders.octree())[blocker->point_id];
  const auto blocked_before = [&](double radii) {
    const double behind = radii * candidate_radius(occluders, spacing);
    const SightEnd lone{.position = k_corner + glm::dvec3(2.0 + behind, 2, 2), .is_lone = true};
    const std::vector<Hit> all = all_blockers(occluders, cloud, sight_line(line.from, lone));
    return std::ranges::any_of(all, [&](const Hit& hit) { return hit.point_id == blocker->point_id; });
  };
  EXPECT_FALSE(blocked_before(0.98 * k_lone_radii));
  EXPECT_TRUE(blocked_before(1.02 * k_lone_radii));
  // Where all are spheres, no point has a surface, and none is lone.
  const Occluders spheres(build(cloud), {.shape = OccluderShape::sphere});
  EXPECT_FALSE(end_on_point(spheres, 0, cloud.world(0), line.from.position).is_lone);
}

TEST(SightLine, to_a_surface_is_not_blocked_by_discs_of_a_sheet_that_is_thicker) {
  const SightEnd end{.position = {0, 0, 0}, .own_reach = 1.0, .own_thickness = 0.001};
  const auto own = [&](double above, double thickness) {
    const PointSurface surface{.exists = true, .thickness = thickness};
    return is_own(end, point_disc({0.1, 0, above}, surface, 0.2), surface);
  };
  EXPECT_TRUE(own(0.0009, 0.0));
  EXPECT_FALSE(own(0.0011, 0.0));
  EXPECT_TRUE(own(0.99 * k_sheet_reach * 0.01, 0.01));
  EXPECT_FALSE(own(1.01 * k_sheet_reach * 0.01, 0.01));
}

TEST(SightLine, is_blocked_only_by_points_that_count) {
  const PointCloud cloud = garden();
  const Octree octree = build(cloud);
  const SightLine line =
      sight_line({k_corner + glm::dvec3(8, 10, 1.5)}, {k_corner + glm::dvec3(12, 10, 1.5)});
  const std::optional<Blocker> wall = first_blocker(Occluders(octree, {}), line);
  ASSERT_TRUE(wall);
  OccluderOptions options;
  options.counts = [](std::uint64_t id) { return id < 4000 || id >= 5500; };
  EXPECT_FALSE(first_blocker(Occluders(octree, options), line));
}

TEST(SightLine, spheres_are_smaller_among_discs_which_close_the_surfaces) {
  const Octree octree = build(garden());
  const Occluders mixed(octree, {}), spheres(octree, {.shape = OccluderShape::sphere});
  ASSERT_EQ(mixed.typical_radius(), spheres.typical_radius());
  for (const double share : {0.1, 0.9, 1.2, 1.9, 2.1, 5.0}) {
    const double spacing = share * mixed.typical_radius();
    const double radius = sphere_of(mixed, candidate_radius(mixed, spacing));
    const double own = 0.28 * spacing, widest = 0.35 * mixed.typical_radius();
    EXPECT_NEAR(radius, own < widest ? own : widest * widest / own, 1e-12);
    EXPECT_NEAR(sphere_of(spheres, candidate_radius(spheres, spacing)),
                std::min(0.5 * spacing, spheres.typical_radius()), 1e-12);
  }
}

TEST(SightLine, a_largest_radius_only_makes_smaller) {
  const Octree octree = build(garden());
  const Occluders usual(octree, {});
  const double limit = 0.1 * usual.typical_radius();
  const Occluders limited(octree, {.radius_max = limit});
  for (const double share : {0.05, 0.3, 0.9, 2.0, 50.0}) {
    const double radius = candidate_radius(limited, share * usual.typical_radius());
    ASSERT_EQ(radius, candidate_radius(usual, share * usual.typical_radius()));
    EXPECT_EQ(sphere_of(limited, radius), std::min(limit, sphere_of(usual, radius)));
    EXPECT_EQ(disc_of(limited, radius), std::min(limit, radius));
  }
  EXPECT_THROW(Occluders(octree, {.radius_max = 0.0}), Error);
  EXPECT_THROW(Occluders(octree, {.radius = 1.0, .radius_max = 1.0}), Error);
}

TEST(SightLine, lines_pass_between_discs_that_a_largest_radius_cuts_down) {
  // A wall of points 1 m apart; the line passes 0.5 m from the nearest ones both ways.
  PointCloud cloud = empty_cloud();
  for (int i = 0; i < 20 * 20; ++i)
    cloud.positions.emplace_back(
        *to_lattice(cloud.lattice, cloud.lattice.offset + glm::dvec3(i % 20, 0.0, i / 20)));
  const Octree octree = build(cloud);
  const glm::dvec3 hole = cloud.lattice.offset + glm::dvec3(9.5, 0.0, 9.5);
  const SightLine line = sight_line({hole + glm::dvec3(0, -5, 0)}, {hole + glm::dvec3(0, 5, 0)});
  EXPECT_TRUE(first_blocker(Occluders(octree, {}), line));
  EXPECT_TRUE(first_blocker(Occluders(octree, {.radius_max = 0.72}), line));
  EXPECT_FALSE(first_blocker(Occluders(octree, {.radius_max = 0.70}), line));
}

TEST(SightLine, discs_as_wide_as_any_are_not_cut_off_nearer_than_their_sheet_ends) {
  // Points of a sheet far from each other, in a cloud of points near each other: their discs are narrower
  // than their spacings, the gap behind its edge is a fifth of these.
  Random random("dense and sparse");
  PointCloud cloud;
  cloud.lattice.scale = glm::dvec3(0.0001);
  const auto add = [&](const glm::dvec3& position) {
    cloud.positions.push_back(*to_lattice(cloud.lattice, position));
  };
  for (int i = 0; i < 5000; ++i) add({100.0 + random.unit(), random.unit(), 0.0});
  for (int i = 0; i < 15 * 15; ++i) add({i % 15, i / 15, 0.0});
  const Occluders occluders(build(cloud), {});
  const double widest = occluders.largest_radius();
  ASSERT_LT(widest, 0.92 * 1.4);
  const auto is_seen_beyond_the_edge = [&](double distance) {
    const glm::dvec3 above(14.0 + distance, 7.0, 1.0);
    return !first_blocker(occluders, sight_line({above}, {above - glm::dvec3(0.0, 0.0, 2.0)}));
  };
  EXPECT_FALSE(is_seen_beyond_the_edge(0.2));
  EXPECT_FALSE(is_seen_beyond_the_edge(0.95 * widest));
  EXPECT_TRUE(is_seen_beyond_the_edge(1.05 * widest));
}

TEST(SightLine, rejects_bad_input) {
  const PointCloud cloud = garden();
  const Octree octree = build(cloud);
  EXPECT_THROW(Occluders(octree, {.radius = 0.0}), Error);
  EXPECT_THROW(Occluders(octree, {.radius = std::nan("")}), Error);
  EXPECT_THROW(Occluders(octree, {.transparency = 0}), Error);
  EXPECT_THROW(sight_line({glm::dvec3(std::nan(""))}, {glm::dvec3(0.0)}), Error);
  EXPECT_THROW(sight_ray({glm::dvec3(0.0)}, {0, 0, 0}), Error);
  EXPECT_THROW(sight_ray({glm::dvec3(0.0)}, {0, 0, 1}, -1.0), Error);
  const Occluders occluders(octree, {});
  std::vector<std::uint8_t> room(1);
  const std::vector<SightLine> lines(2, sight_ray({glm::dvec3(0.0)}, {0, 0, 1}));
  EXPECT_THROW(blocked(occluders, lines, room), Error);
  EXPECT_FALSE(first_blocker(Occluders(build(PointCloud()), {}), lines.front()));
}

}  // namespace
}  // namespace alidade
