// SPDX-License-Identifier: MIT
// Batches of rays that start side by side: they meet the points of a leaf together, and what hides one of
// them is tried for the next.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <limits>
#include <string>

#include "octree/brute_force.h"
#include "octree/build.h"
#include "octree/query.h"
#include "octree/spacing.h"
#include "surface/brute_force_surface.h"
#include "surface/surface_cloud.h"
#include "tests/support/point_families.h"
#include "tests/support/random.h"
#include "tests/surface/surface_cases.h"

namespace alidade {
namespace {

using test::Random;

/// A floor, a wall on it that has a gap, and a few points in the air.
PointCloud yard() {
  const glm::dvec3 site(690000.0, 5325000.0, 300.0);
  Random random("yard");
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 900; ++i) {
    points.push_back(site +
                     glm::dvec3(random.between(0, 4), random.between(0, 4), 0.002 * random.in_cube().z));
    const double x = random.between(0, 4);
    if (x < 1.5 || x > 2.0)
      points.push_back(site + glm::dvec3(x, 3.0 + 0.002 * random.in_cube().y, random.between(0, 2)));
    if (i % 20 == 0) points.push_back(site + 4.0 * glm::abs(random.in_cube()));
  }
  return test::make_cloud(points, {glm::dvec3(1e-4), site});
}

/// Rays, and the sheets that they begin on.
struct Rays {
  std::vector<Ray> rays;
  std::vector<SheetOrigin> begins;
};

/// From the floor towards a sun behind the wall, or from an eye in front of it; some with limits, far away,
/// or in other directions.
Rays neighbours(const PointCloud& cloud, bool from_floor, Random& random) {
  Rays made;
  const glm::dvec3 low = cloud.bounds().min;
  const glm::dvec3 eye = low + glm::dvec3(2.0, -3.0, 1.0), sun = unit_direction({0.1, 1.0, 0.4});
  for (int i = 0; i < 700; ++i) {
    // Along rows, as pixels are.
    const double x = 4.0 * (i % 50) / 50.0 + 0.01 * random.in_cube().x, y = 2.8 * (i / 50) / 14.0;
    glm::dvec3 origin = from_floor ? low + glm::dvec3(x, y, 0.002) : eye;
    glm::dvec3 direction = from_floor ? sun : low + glm::dvec3(x, 3.0, y) - eye;
    if (random.below(40) == 0) direction = random.in_cube();
    double t_max = std::numeric_limits<double>::infinity();
    if (random.below(4) == 0) t_max = random.between(0.0, 7.0);
    const double t_min = random.below(8) == 0 ? random.between(0.0, 6.0) : 0.0;
    if (random.below(60) == 0) origin -= 1e5 * unit_direction(direction);
    made.rays.push_back(make_ray(origin, direction, t_min, t_max));
    made.begins.push_back({});
    if (from_floor && random.below(5) != 0) made.begins.back() = {{0.0, 0.0, 1.0}, 0.3f, 0.02f};
  }
  return made;
}

/// points: an octree or a SurfaceCloud. by_brute_force(i): the answer to ray i. Some rays must have one, and
/// some none.
template <class Points, class Query, class ByBruteForce>
void expect_answers(const Points& points, const std::vector<Ray>& rays, const Query& query,
                    const ByBruteForce& by_brute_force) {
  std::vector<decltype(closest(points, rays.front(), query))> hits(rays.size());
  std::vector<std::uint8_t> blocked(rays.size());
  closest(points, rays, query, hits);
  occluded(points, rays, query, blocked);
  std::size_t blocked_count = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    SCOPED_TRACE(i);
    const std::optional<Hit> expected = by_brute_force(i);
    ASSERT_TRUE(test::same_hits(hits[i], expected));
    ASSERT_EQ(blocked[i] != 0, expected.has_value());
    blocked_count += blocked[i];
  }
  EXPECT_GT(blocked_count, rays.size() / 4);
  EXPECT_LT(blocked_count, rays.size() * 19 / 20);
}

class NeighbourRays : public ::testing::TestWithParam<InstructionSet> {
 protected:
  NeighbourRays()
      : cloud_(yard()),
        octree_(with_surfaces(
            with_spacings(build(cloud_, {.instruction_set = GetParam()}), k_surface_neighbours))),
        spacings_(brute_force::spacings(cloud_, k_surface_neighbours)) {}

  /// Calls check(rays, from_floor) with rays of both kinds.
  template <class Check>
  void for_rays(const Check& check) const {
    Random random("neighbours");
    for (const bool from_floor : {false, true}) {
      SCOPED_TRACE(from_floor ? "from the floor" : "from an eye");
      check(neighbours(cloud_, from_floor, random), from_floor);
    }
  }

  const PointCloud cloud_;
  const Octree octree_;
  const std::vector<double> spacings_;
  const double radius_ = automatic_radius(octree_);
};

TEST_P(NeighbourRays, have_the_answers_of_each_alone_at_spheres_of_one_radius) {
  const RayQuery query{.radius = 2.0 * radius_, .entry_min = 1e-9};
  for_rays([&](const Rays& made, bool) {
    expect_answers(octree_, made.rays, query,
                   [&](std::size_t i) { return brute_force::closest(cloud_, made.rays[i], query); });
  });
}

TEST_P(NeighbourRays, have_the_answers_of_each_alone_at_spheres_with_radii_of_their_own) {
  const SurfaceQuery query{.radius = 2.0 * radius_, .spacing_factor = 0.5, .measure = Measure::t};
  for_rays([&](const Rays& made, bool) {
    expect_answers(SurfaceCloud::of_spheres(octree_), made.rays, query, [&](std::size_t i) {
      return brute_force::closest(cloud_, made.rays[i], query, spacings_);
    });
  });
}

TEST_P(NeighbourRays, have_the_answers_of_each_alone_at_discs) {
  for_rays([&](const Rays& made, bool from_floor) {
    SurfaceQuery query{.radius = 16.0 * radius_, .spacing_factor = 0.92, .discs = DiscQuery{}};
    if (from_floor) query.discs->begins = made.begins;
    expect_answers(SurfaceCloud::of_discs(octree_), made.rays, query, [&](std::size_t i) {
      SurfaceQuery alone = query;
      if (from_floor) alone.discs->begins = query.discs->begins.subspan(i, 1);
      return brute_force::closest(cloud_, made.rays[i], alone, spacings_, octree_.layers());
    });
  });
}

INSTANTIATE_TEST_SUITE_P(, NeighbourRays, ::testing::ValuesIn(available_instruction_sets()),
                         [](const auto& set) { return std::string(name(set.param)); });

}  // namespace
}  // namespace alidade
