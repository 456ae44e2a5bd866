// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <tuple>
#include <vector>

#include "octree/build.h"
#include "octree/spacing.h"
#include "tests/support/spacings.h"
#include "tests/visibility/plain_hits.h"
#include "tests/visibility/point_clusters.h"
#include "visibility/crossing.h"
#include "visibility/sky/sky_of_cloud.h"

namespace alidade {

using namespace visibility;

namespace {

using test::add;
using test::Random;
using test::site_with_clusters;

/// Lines from the scanner, which is in a cluster, from anywhere and between clusters.
std::vector<SightLine> lines_of(const Occluders& occluders, const PointCloud& cloud, std::size_t count) {
  Random random("lines");
  std::vector<SightLine> lines;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t id = random.below(cloud.size());
    const glm::dvec3 anywhere = glm::dvec3(6, 6, 2) * random.in_cube();
    const SightEnd eye{i % 4 == 0   ? glm::dvec3(0)
                       : i % 4 == 1 ? cloud.world(random.below(cloud.size()))
                                    : anywhere};
    lines.push_back(i % 3 == 0 ? sight_ray(eye, random.direction())
                               : sight_line(eye, end_on_point(occluders, id, cloud.world(id), eye.position)));
  }
  return lines;
}

/// The definition: each point that blocks, then those behind the one before.
std::optional<std::uint64_t> blocker_of(const Occluders& occluders, const PointCloud& cloud,
                                        const std::vector<double>& spacings, const SightLine& line) {
  std::vector<std::tuple<double, std::uint64_t, double>> crossings;
  const std::vector<Hit> found =
      test::plain_hits(occluders, cloud, spacings, line, [&](const Candidate& candidate) {
        const std::optional<double> met = crossing(occluders, line, candidate);
        if (met) crossings.emplace_back(*met, candidate.point_id, 2.0 * width_of(occluders, candidate));
        return met.has_value();
      });
  if (occluders.options().transparency == 1)
    return found.empty() ? std::nullopt : std::optional(found.front().point_id);
  std::ranges::sort(crossings);
  int count = 0;
  double end = -std::numeric_limits<double>::infinity();
  for (const auto& [distance, id, diameter] : crossings) {
    if (distance <= end) continue;
    if (++count == occluders.options().transparency) return id;
    end = distance + diameter;
  }
  return std::nullopt;
}

TEST(CoincidentPoints, block_as_a_look_at_every_point_finds) {
  const PointCloud cloud = site_with_clusters(300);
  const Octree octree = with_spacings(build(cloud), k_surface_neighbours);
  const std::vector<double> spacings = test::spacings_by_id(octree);
  const std::vector<OccluderOptions> all = {
      {},
      {.radius = 0.2},
      {.shape = OccluderShape::sphere},
      {.transparency = 2},
      {.counts = [](std::uint64_t id) { return id % 3 == 1; }},
      {.radius = 0.2, .counts = [](std::uint64_t id) { return id % 3 == 1; }},
      {.transparency = 3, .counts = [](std::uint64_t id) { return id % 7 < 5; }}};
  std::size_t blocked_count = 0, line_count = 0;
  for (const OccluderOptions& options : all) {
    const Occluders occluders(octree, options);
    const std::vector<SightLine> lines = lines_of(occluders, cloud, 240);
    std::vector<std::optional<Blocker>> blockers(lines.size());
    std::vector<std::uint8_t> answers(lines.size());
    first_blockers(occluders, lines, blockers);
    blocked(occluders, lines, answers);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      SCOPED_TRACE("options " + std::to_string(&options - all.data()) + ", line " + std::to_string(i));
      const auto expected = blocker_of(occluders, cloud, spacings, lines[i]);
      ASSERT_EQ(blockers[i].has_value(), expected.has_value());
      ASSERT_EQ(answers[i] != 0, expected.has_value());
      if (expected) {
        ASSERT_EQ(blockers[i]->point_id, *expected);
      }
      blocked_count += expected.has_value();
      ++line_count;
    }
  }
  EXPECT_GT(blocked_count, line_count / 8);
  EXPECT_LT(blocked_count, 7 * line_count / 8);
}

/// How often the filter is called per line, by the sky views of all points and by lines from the scanner.
std::uint64_t calls_per_line(const PointCloud& cloud) {
  std::atomic<std::uint64_t> calls = 0;
  const Occluders occluders(build(cloud), {.counts = [&](std::uint64_t) {
                              ++calls;
                              return true;
                            }});
  constexpr int k_directions = 16;
  point_sky_views(occluders, {}, {.directions = k_directions});
  std::vector<SightLine> lines;
  for (std::size_t id = 0; id < cloud.size(); ++id)
    lines.push_back(sight_line({glm::dvec3(0)}, end_on_point(occluders, id, cloud.world(id), glm::dvec3(0))));
  std::vector<std::optional<Blocker>> blockers(lines.size());
  first_blockers(occluders, lines, blockers);
  return calls / (cloud.size() * (k_directions + 1));
}

TEST(CoincidentPoints, are_not_tested_one_by_one) {
  const auto cloud_of = [](std::size_t count, const auto& position) {
    PointCloud cloud;
    cloud.lattice = {.scale = glm::dvec3(1e-3), .offset = glm::dvec3(0)};
    for (std::size_t i = 0; i < count; ++i) add(cloud, position(i));
    return cloud;
  };
  constexpr std::size_t k_count = 4000, k_few = 40;
  EXPECT_LT(calls_per_line(cloud_of(k_count, [](std::size_t) { return glm::dvec3(1, 2, 3); })), k_few);
  EXPECT_LT(calls_per_line(cloud_of(k_count, [](std::size_t i) { return glm::dvec3(1 + i % 2, 2, 3); })),
            k_few);
  EXPECT_LT(calls_per_line(site_with_clusters(1000)), k_few);
}

}  // namespace
}  // namespace alidade
