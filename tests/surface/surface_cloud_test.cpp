// SPDX-License-Identifier: MIT
#include "surface/surface_cloud.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "octree/build.h"
#include "octree/distance.h"
#include "octree/spacing.h"
#include "octree/tree_walk.h"
#include "surface/decide_point.h"
#include "surface/point_disc.h"
#include "tests/support/octrees.h"
#include "tests/support/point_families.h"
#include "tests/support/random.h"
#include "tests/support/ray_families.h"
#include "tests/support/same_hits.h"
#include "tests/surface/surface_cases.h"

namespace alidade {
namespace {

using test::point_families;
using test::PointFamily;
using test::Random;
using test::same_hits;

class SurfaceCloudOn : public ::testing::TestWithParam<InstructionSet> {};

TEST_P(SurfaceCloudOn, every_instruction_set_finds_all_spheres_near_a_position) {
  std::size_t held = 0;
  for (const test::DiscCase& disc_case : test::disc_cases()) {
    const PointCloud& cloud = disc_case.cloud;
    Random random(disc_case.name + "_near");
    for (const test::NamedOctree& named : test::octrees_of(cloud, GetParam())) {
      const Octree octree = with_spacings(named.octree, k_surface_neighbours);
      const SurfaceCloud spheres = SurfaceCloud::of_spheres(octree);
      for (int i = 0; i < 80 && octree.size() > 0; ++i) {
        SurfaceQuery query = test::disc_query({.radius = std::pow(10.0, random.between(-3.0, 3.0))}, random);
        const double away = std::pow(10.0, random.between(-5.0, i == 0 ? 12.0 : 2.0));
        const glm::dvec3 point = cloud.world(random.below(cloud.size()));
        const glm::dvec3 position = point + away * random.in_cube();
        // On the surface of a sphere.
        if (i % 2 == 1) {
          query.radius = distance(position, i % 4 == 1 ? point : cloud.world(random.below(cloud.size())));
          query.spacing_factor = 1e6;
          if (!(query.radius > 0.0)) continue;
        }
        double reach = 0.0;
        if (i % 3 == 2) {
          reach = std::pow(10.0, random.between(-4.0, 1.0));
          // What just comes within reach.
          if (i % 2 == 0) query.radius = std::max(distance(position, point) - reach, 1e-3);
        }
        // Wider than lanes take.
        if (i == 2) query.radius = 1e20;
        std::vector<PointSphere> expected;
        for_each_leaf(octree.view(), [&](const Leaf& leaf) {
          for (std::uint32_t p = 0; p < leaf.count; ++p) {
            const double radius = own_radius(query, spacing_at(octree.layers(), leaf.first + p));
            const glm::dvec3 center = to_world(octree.lattice(), position_of(octree.view(), leaf, p));
            if (distance(position, center) <= radius + reach)
              expected.push_back({center, radius, leaf.first + p});
          }
        });
        std::ranges::sort(expected, {}, &PointSphere::index);
        std::vector<PointSphere> found{{glm::dvec3(7.0), 7.0, 7}};
        find_spheres(spheres, position, reach, query, found);
        ASSERT_EQ(found.size(), expected.size() + 1) << disc_case.name << " " << named.name << " " << i;
        for (std::size_t s = 0; s < expected.size(); ++s) {
          ASSERT_EQ(found[s + 1].index, expected[s].index);
          ASSERT_EQ(found[s + 1].center, expected[s].center);
          ASSERT_EQ(found[s + 1].radius, expected[s].radius);
        }
        held += expected.size();
      }
    }
  }
  EXPECT_GT(held, 1000u);
}

/// Whether two clouds have the same surfaces and edges.
bool same_surfaces(const SurfaceView& a, const SurfaceView& b) {
  const std::size_t count = a.tree.point_count;
  return a.layers.surface_unit == b.layers.surface_unit &&
         std::equal(a.stored_surfaces, a.stored_surfaces + count, b.stored_surfaces) &&
         std::equal(a.stored_edges, a.stored_edges + count, b.stored_edges);
}

TEST_P(SurfaceCloudOn, every_instruction_set_fits_the_same_surfaces_on_demand) {
  for (const PointFamily& family : point_families()) {
    // Fits take most of the time: one organisation of each, and large clouds with one instruction set.
    constexpr std::size_t k_large = 2500;
    if (family.cloud.size() > k_large && GetParam() != usable(InstructionSet::best)) continue;
    Random random(family.name + "_on_demand");
    const std::vector<test::NamedOctree> octrees = test::octrees_of(family.cloud, GetParam());
    const test::NamedOctree& named = octrees[random.below(octrees.size())];
    SCOPED_TRACE(family.name + " " + named.name);
    const Octree spaced = with_spacings(named.octree, k_surface_neighbours);
    const SurfaceCloud all = SurfaceCloud::of_discs(with_surfaces(spaced));
    if (all.size() == 0) continue;
    EXPECT_EQ(all.view().fitter, nullptr);
    SurfaceCloud discs = SurfaceCloud::of_discs(spaced);
    int number = 0;
    for (const test::RayCase& c : test::ray_cases(family.cloud, 6, random)) {
      // Whatever touches the leaves first; without a cloud of its own, the first query would touch all.
      if (number++ % 3 == 0) discs = SurfaceCloud::of_discs(spaced);
      SurfaceQuery query = test::disc_query(c.query, random);
      if (random.below(3) == 0)
        query.filter.of_position = [&](const Candidate& point) { return point.position.x > c.ray.origin.x; };
      const std::optional<SurfaceHit> expected = closest(all, c.ray, query);
      std::vector<std::optional<SurfaceHit>> hits(40);
      const Ray by_walk = test::beside_lanes(c.ray);
      switch (random.below(4)) {
        case 0:
          closest(discs, std::vector<Ray>(hits.size(), c.ray), query, hits);
          ASSERT_TRUE(same_hits(hits.back(), expected));
          break;
        case 1:
          ASSERT_EQ(occluded(discs, c.ray, query), expected.has_value());
          break;
        case 2:
          ASSERT_TRUE(same_hits(closest(discs, by_walk, query), closest(all, by_walk, query)));
          break;
        default:
          break;
      }
      ASSERT_TRUE(same_hits(closest(discs, c.ray, query), expected));
      if (expected) {
        const std::uint32_t index = expected->index;
        EXPECT_EQ(point_id(spaced.view(), index), expected->point_id);
        EXPECT_EQ(discs.view().stored_surfaces[index], all.view().stored_surfaces[index]);
        EXPECT_EQ(discs.view().stored_edges[index], all.view().stored_edges[index]);
      }
      std::vector<PointSphere> held;
      find_spheres(discs, c.ray.origin, 0.0, query, held);
      for (const PointSphere& sphere : held)
        ASSERT_EQ(discs.view().stored_surfaces[sphere.index], all.view().stored_surfaces[sphere.index]);
    }
    discs.fit_all();
    EXPECT_TRUE(same_surfaces(discs.view(), all.view()));
  }
}

INSTANTIATE_TEST_SUITE_P(, SurfaceCloudOn, ::testing::ValuesIn(available_instruction_sets()),
                         [](const auto& set) { return std::string(name(set.param)); });

TEST(SurfaceCloud, batches_whose_threads_touch_the_same_leaves_are_the_same) {
  const PointFamily family = point_families().back();
  const Octree spaced = with_spacings(build(family.cloud), k_surface_neighbours);
  const SurfaceCloud all = SurfaceCloud::of_discs(with_surfaces(spaced));
  Random random("threads_on_demand");
  std::vector<Ray> rays;
  for (int i = 0; i < 4000; ++i)
    rays.push_back(
        make_ray(family.cloud.world(random.below(family.cloud.size())) + random.in_cube(), random.in_cube()));
  const SurfaceQuery query{.radius = 1e9, .spacing_factor = 0.92, .discs = DiscQuery{}};
  std::vector<std::optional<SurfaceHit>> expected(rays.size()), hits(rays.size());
  closest(all, rays, query, expected);
  EXPECT_GT(std::ranges::count_if(expected, [](const auto& hit) { return hit.has_value(); }), 400);
  for (int round = 0; round < 4; ++round) {
    const SurfaceCloud discs = SurfaceCloud::of_discs(spaced);
    closest(discs, rays, query, hits);
    ASSERT_EQ(hits, expected) << round;
  }
}

/// The street, as discs.
class SurfaceCloudOfStreet : public ::testing::Test {
 protected:
  SurfaceCloudOfStreet()
      : cloud_(point_families().back().cloud),
        octree_(with_surfaces(with_spacings(build(cloud_), k_surface_neighbours))),
        discs_(SurfaceCloud::of_discs(octree_)) {}

  /// From points and beside them, so scattered that large batches are sorted.
  std::vector<Ray> scattered_rays(std::size_t count) {
    std::vector<Ray> rays;
    while (rays.size() < count)
      rays.push_back(
          make_ray(cloud_.world(random_.below(cloud_.size())) + random_.in_cube(), random_.direction(), 0.0));
    return rays;
  }

  const PointCloud cloud_;
  const Octree octree_;
  const SurfaceCloud discs_;
  const SurfaceQuery spheres_query_{.radius = 0.5, .spacing_factor = 0.5},
      disc_query_{.radius = 0.5, .spacing_factor = k_disc_spacings, .discs = DiscQuery{}};
  Random random_;
};

TEST_F(SurfaceCloudOfStreet, returns_the_surfaces_of_its_octree_by_storage_index) {
  EXPECT_EQ(discs_.size(), octree_.size());
  EXPECT_EQ(discs_.octree().layers().surfaces, octree_.layers().surfaces);
  EXPECT_TRUE(discs_.has_discs());
  EXPECT_FALSE(SurfaceCloud::of_spheres(octree_).has_discs());
  const auto expect_same = [](const PointSurface& found, const PointSurface& expected) {
    EXPECT_EQ(found.exists, expected.exists);
    EXPECT_EQ(found.normal, expected.normal);
    EXPECT_EQ(found.height, expected.height);
    EXPECT_EQ(found.thickness, expected.thickness);
  };
  for (std::uint32_t index = 0; index < octree_.size(); ++index) {
    const std::uint64_t id = point_id(octree_.view(), index);
    const PointSurface expected = surface_of(octree_.layers(), id);
    expect_same(discs_.surface_at(index), expected);
  }
}

TEST_F(SurfaceCloudOfStreet, batches_answer_in_the_order_of_the_rays_on_any_number_of_threads) {
  // Small ones go through the tree as they are, large ones sorted.
  for (const std::size_t count : {std::size_t{700}, std::size_t{50000}}) {
    std::vector<Ray> rays = scattered_rays(count);
    // Some that lanes do not answer, at seams between tasks, too.
    for (std::size_t i = 255; i < count; i += 256) rays[i] = test::beside_lanes(rays[i]);
    for (const SurfaceQuery& query : {spheres_query_, disc_query_}) {
      std::vector<std::optional<SurfaceHit>> expected;
      for (const Ray& ray : rays) expected.push_back(closest(discs_, ray, query));
      EXPECT_GT(std::ranges::count_if(expected, [](const auto& hit) { return hit.has_value(); }),
                static_cast<std::ptrdiff_t>(count / 20));
      for (const std::size_t threads : {1, 2, 5}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        std::vector<std::optional<SurfaceHit>> hits(count);
        std::vector<std::uint8_t> blocked(count);
        closest(discs_, rays, query, hits);
        occluded(discs_, rays, query, blocked);
        for (std::size_t i = 0; i < count; ++i) {
          ASSERT_TRUE(same_hits(hits[i], expected[i])) << "ray " << i;
          ASSERT_EQ(blocked[i] != 0, expected[i].has_value()) << "ray " << i;
        }
      }
    }
  }
}

/// The filter and the sheets that rays begin on go by the number of a ray in its batch, however large.
TEST_F(SurfaceCloudOfStreet, filters_and_sheets_know_the_number_of_the_ray) {
  const std::vector<Ray> rays = scattered_rays(50000);
  std::vector<std::optional<SurfaceHit>> all(rays.size()), odd(rays.size()), free(rays.size());
  std::vector<std::uint8_t> blocked(rays.size());
  SurfaceQuery query = disc_query_;
  query.discs->lone_factor = 0.0;
  closest(discs_, rays, query, all);
  SurfaceQuery filtered = query;
  filtered.filter = [](const Candidate& point) { return point.query_index % 2 == 1; };
  closest(discs_, rays, filtered, odd);
  occluded(discs_, rays, filtered, blocked);
  // Every third begins on the sheet that it would meet first.
  std::vector<SheetOrigin> begins(rays.size());
  for (std::size_t i = 0; i < rays.size(); i += 3) {
    if (!all[i] || !discs_.surface_at(all[i]->index).exists) continue;
    begins[i] = {discs_.surface_at(all[i]->index).normal, 1e6f, 1e6f};
  }
  query.discs->begins = begins;
  closest(discs_, rays, query, free);
  std::size_t hit_count = 0, left = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_TRUE(same_hits(odd[i], i % 2 == 1 ? all[i] : std::nullopt)) << i;
    ASSERT_EQ(blocked[i] != 0, odd[i].has_value()) << i;
    hit_count += odd[i].has_value();
    if (begins[i].reach == 0.0f) {
      ASSERT_TRUE(same_hits(free[i], all[i])) << i;
    } else {
      ASSERT_FALSE(same_hits(free[i], all[i])) << i;
      ++left;
    }
  }
  EXPECT_GT(hit_count, 1000u);
  EXPECT_GT(left, 500u);
}

TEST_F(SurfaceCloudOfStreet, answers_the_same_with_every_instruction_set_and_from_a_map) {
  const std::vector<Ray> rays = scattered_rays(2000);
  std::vector<SurfaceCloud> clouds{SurfaceCloud::of_discs(octree_.with_mapped(true))};
  EXPECT_NE(clouds[0].view().tree.coordinates, octree_.view().coordinates) << "out of the map";
  EXPECT_EQ(clouds[0].octree().view().coordinates, clouds[0].view().tree.coordinates);
  EXPECT_EQ(clouds[0].octree().layers().spacings, clouds[0].view().layers.spacings);
  EXPECT_FALSE(clouds[0].octree().is_mapped());
  EXPECT_EQ(discs_.view().tree.coordinates, octree_.view().coordinates) << "not mapped";
  for (const InstructionSet set : available_instruction_sets()) {
    clouds.push_back(SurfaceCloud::of_discs(octree_.with_instruction_set(set)));
    EXPECT_EQ(clouds.back().octree().instruction_set(), set);
  }
  for (const SurfaceQuery& query : {spheres_query_, disc_query_}) {
    std::vector<std::optional<SurfaceHit>> expected(rays.size()), hits(rays.size());
    closest(discs_, rays, query, expected);
    for (const SurfaceCloud& cloud : clouds) {
      closest(cloud, rays, query, hits);
      ASSERT_EQ(hits, expected);
    }
  }
}

TEST_F(SurfaceCloudOfStreet, filters_of_positions_are_called_for_a_few_of_many_equal_points) {
  constexpr std::size_t k_equal = 100'000, k_rays = 3000, k_few = 300;
  std::vector<glm::dvec3> positions(k_equal, glm::dvec3(1, 0, 0));
  for (int i = 0; i < 1000; ++i) positions.push_back(glm::dvec3(3, 0, 0) + random_.in_cube());
  const PointCloud cloud = test::make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0)});
  const SurfaceCloud discs =
      SurfaceCloud::of_discs(with_surfaces(with_spacings(build(cloud), k_surface_neighbours)));
  const std::vector<Ray> rays(k_rays, make_ray({0, 0, 0}, {1, 0, 0}, 0.0));
  const SurfaceQuery by_t{.radius = 0.5, .spacing_factor = 1.0, .measure = Measure::t},
      by_entry{.radius = 0.5, .spacing_factor = 1.0},
      crossing{.radius = 0.5, .spacing_factor = 1.0, .discs = DiscQuery{}};
  for (SurfaceQuery query : {by_t, by_entry, crossing}) {
    for (const bool has_ids : {false, true}) {
      std::atomic<std::size_t> called = 0;
      query.filter.of_position = [&](const Candidate& point) {
        ++called;
        return point.position.x > 1.5;
      };
      if (has_ids) query.filter.of_point = [](const Candidate& point) { return point.point_id >= k_equal; };
      std::vector<std::optional<SurfaceHit>> hits(rays.size());
      std::vector<std::uint8_t> blocked(rays.size());
      closest(discs, rays, query, hits);
      occluded(discs, rays, query, blocked);
      EXPECT_LT(called, 2 * k_rays * k_few);
      for (std::size_t i = 0; i < k_rays; ++i) ASSERT_EQ(blocked[i] != 0, hits[i].has_value());
      called = 0;
      EXPECT_TRUE(same_hits(closest(discs, rays[0], query), hits[0]));
      EXPECT_LT(called, k_few);
    }
  }
}

TEST(SurfaceCloud, of_no_points_answers_nothing) {
  const Ray ray = make_ray({0, 0, 0}, {1, 0, 0});
  const std::vector<Ray> rays(2, ray);
  const Octree octree = with_spacings(build(PointCloud{}), k_surface_neighbours);
  for (const SurfaceCloud& cloud :
       {SurfaceCloud(), SurfaceCloud::of_spheres(octree), SurfaceCloud::of_discs(octree)}) {
    EXPECT_EQ(cloud.size(), 0u);
    cloud.fit_all();
    for (const SurfaceQuery& query :
         {SurfaceQuery{.radius = 1.0}, SurfaceQuery{.radius = 1.0, .discs = DiscQuery{}}}) {
      EXPECT_FALSE(closest(cloud, ray, query));
      EXPECT_FALSE(occluded(cloud, ray, query));
      std::vector<std::optional<SurfaceHit>> hits(2, SurfaceHit{});
      std::vector<std::uint8_t> blocked(2, 1);
      closest(cloud, rays, query, hits);
      occluded(cloud, rays, query, blocked);
      EXPECT_EQ(hits, std::vector<std::optional<SurfaceHit>>(2));
      EXPECT_EQ(blocked, std::vector<std::uint8_t>(2, 0));
      std::vector<PointSphere> held;
      find_spheres(cloud, {0, 0, 0}, 0.0, query, held);
      EXPECT_TRUE(held.empty());
    }
  }
}

}  // namespace
}  // namespace alidade
