// SPDX-License-Identifier: MIT
#include "visibility/crossing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <vector>

#include "octree/build.h"
#include "octree/spacing.h"
#include "tests/support/random.h"
#include "tests/support/spacings.h"
#include "tests/visibility/plain_hits.h"
#include "tests/visibility/sampled_shapes.h"

namespace alidade {

using namespace visibility;

namespace {

using test::Random;

constexpr double k_side = 20.0;

/// A thicket of points without surfaces between walls, and a few strays far from all.
PointCloud thicket() {
  Random random("thicket");
  test::Points points;
  for (int i = 0; i < 2000; ++i) points.push_back(k_side * (0.5 + 0.5 * random.in_cube()));
  for (const double x : {2.0, 4.0, 4.5, 7.0, 9.0, 9.5, 13.0, 16.0})
    test::add_rectangle(points, {x, 0, 0}, {0, k_side, 0}, {0, 0, k_side}, 0.8);
  for (int i = 0; i < 5; ++i) points.push_back(glm::dvec3(0.0, 0.0, 60.0) + 20.0 * random.in_cube());
  Lattice lattice;
  lattice.scale = glm::dvec3(0.0001);
  return test::make_cloud(points, lattice);
}

struct Lines {
  std::vector<SightLine> chords;
  std::vector<double> starts;
  std::vector<std::size_t> begin{0};

  operator ChordLines() const { return {chords, starts, begin}; }
};

/// Straight lines as one chord, lines as chords that overlap, lines to points and lines without an end.
Lines lines_through(const Occluders& occluders, const PointCloud& cloud, int count) {
  Random random("lines_through");
  Lines lines;
  for (int i = 0; i < count; ++i) {
    const SightEnd eye{k_side * (0.5 + 0.7 * random.in_cube())};
    const std::size_t id = random.below(cloud.size());
    const SightEnd target = end_on_point(occluders, id, cloud.world(id), eye.position);
    if (i % 3 == 0) {
      lines.chords.push_back(sight_ray(eye, random.direction()));
      lines.starts.push_back(0.0);
    } else {
      const int chords = i % 3 == 1 ? 1 : 7;
      const glm::dvec3 way = target.position - eye.position;
      for (int chord = 0; chord < chords; ++chord) {
        const double begin = std::max(0.0, (chord - 0.2) / chords),
                     end = std::min(1.0, (chord + 1.2) / chords);
        lines.chords.push_back(
            sight_line(chord == 0 ? eye : chord_end(eye.position + begin * way),
                       chord + 1 == chords ? target : chord_end(eye.position + end * way)));
        lines.starts.push_back(begin * glm::length(way));
      }
    }
    lines.begin.push_back(lines.chords.size());
  }
  return lines;
}

/// The definition: all that blocks the chords, the first crossing of each point, then those behind the one
/// before.
std::optional<Blocker> separate_blocker(const Occluders& occluders, const PointCloud& cloud,
                                        const std::vector<double>& spacings, const Lines& lines,
                                        std::size_t line) {
  std::map<std::uint64_t, std::pair<double, double>> of_points;  // distance and diameter
  for (std::size_t chord = lines.begin[line]; chord < lines.begin[line + 1]; ++chord) {
    const auto collect = [&](const Candidate& candidate) {
      const std::optional<double> met = crossing(occluders, lines.chords[chord], candidate);
      if (!met) return false;
      const std::pair crossed(lines.starts[chord] + *met, 2.0 * width_of(occluders, candidate));
      const auto [known, is_new] = of_points.try_emplace(candidate.point_id, crossed);
      if (!is_new && crossed.first < known->second.first) known->second = crossed;
      return true;
    };
    (void)test::plain_hits(occluders, cloud, spacings, lines.chords[chord], collect);
  }
  std::vector<std::tuple<double, std::uint64_t, double>> crossings;
  for (const auto& [id, crossed] : of_points) crossings.emplace_back(crossed.first, id, crossed.second);
  std::ranges::sort(crossings);
  int count = 0;
  double end = -std::numeric_limits<double>::infinity();
  for (const auto& [distance, id, diameter] : crossings) {
    if (distance <= end) continue;
    if (++count == occluders.options().transparency) return Blocker{id, cloud.world(id), distance};
    end = distance + diameter;
  }
  return std::nullopt;
}

TEST(SeparateCrossings, are_those_that_a_look_at_every_point_finds) {
  const PointCloud cloud = thicket();
  const Octree octree = with_spacings(build(cloud), k_surface_neighbours);
  const std::vector<double> spacings = test::spacings_by_id(octree);
  std::ptrdiff_t blocked = 0, lines_in_all = 0;
  for (const auto& [shape, radius] : {std::pair<OccluderShape, std::optional<double>>{},
                                      {OccluderShape::disc, {}},
                                      {OccluderShape::sphere, {}},
                                      {OccluderShape::sphere, 0.4}}) {
    for (const int transparency : {2, 3, 5}) {
      const OccluderOptions options{.shape = shape, .radius = radius, .transparency = transparency};
      std::vector<std::optional<Blocker>> known;
      for (const InstructionSet set : available_instruction_sets()) {
        const Occluders occluders(octree.with_instruction_set(set), options);
        const Lines lines = lines_through(occluders, cloud, 90);
        std::vector<std::optional<Blocker>> blockers(lines.begin.size() - 1);
        find_separate_blockers(occluders, lines, blockers);
        if (known.empty()) {
          for (std::size_t line = 0; line < blockers.size(); ++line)
            known.push_back(separate_blocker(occluders, cloud, spacings, lines, line));
          blocked += std::ranges::count_if(known, [](const auto& one) { return one.has_value(); });
          lines_in_all += std::ssize(known);
        }
        for (std::size_t line = 0; line < blockers.size(); ++line)
          ASSERT_EQ(blockers[line], known[line]) << line << ' ' << transparency;
      }
    }
  }
  EXPECT_GT(blocked, lines_in_all / 5);
  EXPECT_LT(blocked, 4 * lines_in_all / 5);
}

}  // namespace
}  // namespace alidade
