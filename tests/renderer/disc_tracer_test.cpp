// SPDX-License-Identifier: MIT
#include "renderer/disc_tracer.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "octree/distance.h"
#include "surface/decide_point.h"
#include "tests/renderer/disc_clouds.h"

namespace alidade {

using namespace renderer;

namespace {

using test::corner_points;
using test::disc_cloud;
using test::first_crossing;
using test::PlainPoints;
using test::Random;

/// The blended hit by its definition (renderer/disc_tracer.h): t, and the colour without rounding.
struct Blended {
  double t;
  glm::dvec3 color, nearest_color;
};
std::optional<Blended> blended(const PlainPoints& points, const ColorColumn& colors, const Ray& ray,
                               const Hit& first) {
  const PointSurface own = surface_of(points.layers, first.point_id);
  if (!own.exists) return std::nullopt;
  const glm::dvec3 met = ray.origin + first.t * ray.direction;
  double sum = 0.0, t_sum = 0.0, greatest_weight = 0.0;
  glm::dvec3 color_sum(0.0), nearest_color(0.0);
  for (const std::uint64_t id : points.ids) {
    const PointSurface surface = surface_of(points.layers, id);
    const double radius = own_radius(points.query, points.spacings[id]);
    const glm::dvec3 position = points.cloud.world(id);
    if (!surface.exists || distance(met, position) > radius) continue;
    const glm::dvec3 center = position - surface.height * surface.normal;
    if (std::fabs(glm::dot(surface.normal, own.normal)) < 0.848) continue;
    if (std::fabs(glm::dot(met - center, surface.normal)) > 0.25 * radius + 0.004) continue;
    const double t = glm::dot(center - ray.origin, surface.normal) / glm::dot(ray.direction, surface.normal);
    if (!(std::fabs(t - first.t) <= radius)) continue;
    const glm::dvec3 offset = met - position;
    const double weight = std::exp(-8.0 * glm::dot(offset, offset) / (radius * radius));
    sum += weight;
    t_sum += weight * (t - first.t);
    color_sum += weight * glm::dvec3(colors[id]);
    if (weight > greatest_weight) nearest_color = colors[id];
    greatest_weight = std::max(greatest_weight, weight);
  }
  const double t = first.t + t_sum / sum;
  return Blended{t >= ray.t_min && t <= ray.t_max ? t : first.t, color_sum / sum, nearest_color};
}

/// least_met: so many rays meet something.
void expect_first_crossings(const std::optional<AdaptedRadius>& radius, int least_met, bool blends,
                            bool are_categories = false) {
  Random random;
  LoadedCloud cloud = disc_cloud(corner_points(random, 700), random, radius);
  if (are_categories) cloud.color.swatches.resize(2);
  const DiscCloud discs(cloud, blends);
  const PlainPoints points(cloud);
  std::vector<Ray> rays;
  std::vector<SheetOrigin> origins;
  for (int i = 0; i < 1500; ++i) {
    const bool leaves = i % 3 == 0;
    const std::uint64_t id = random.below(points.cloud.size());
    const glm::dvec3 origin = leaves ? points.cloud.world(id) : glm::dvec3(2, 1, 1) + 4.0 * random.in_cube();
    rays.push_back(make_ray(origin, random.direction(), 0.0, i % 5 == 0 ? random.between(0.0, 6.0) : 1e9));
    origins.push_back(leaves ? SheetOrigin{surface_of(points.layers, id).normal, 0.3f, 0.02f}
                             : SheetOrigin{});
  }
  std::vector<std::optional<DiscHit>> hits(rays.size());
  std::vector<std::uint8_t> blocked(rays.size());
  discs.closest(rays, origins, hits);
  discs.blocked(rays, origins, blocked);
  int met = 0, blends_met = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const std::optional<Hit> expected = first_crossing(points, rays[i], origins[i]);
    ASSERT_EQ(hits[i].has_value(), expected.has_value()) << i;
    ASSERT_EQ(blocked[i] != 0, expected.has_value()) << i;
    if (!expected) continue;
    ++met;
    ASSERT_EQ(hits[i]->point_id, expected->point_id) << i;
    ASSERT_LT(glm::dot(hits[i]->sheet.normal, rays[i].direction), 1e-12);
    const auto mean = blends && origins[i].reach == 0.0f
                          ? blended(points, cloud.point_colors(), rays[i], *expected)
                          : std::nullopt;
    ASSERT_EQ(hits[i]->t, mean ? mean->t : expected->t) << i;
    if (!mean) {
      ASSERT_EQ(hits[i]->color, cloud.point_colors()[expected->point_id]);
      continue;
    }
    ++blends_met;
    ASSERT_EQ(hits[i]->color, Color16(are_categories ? mean->nearest_color : mean->color + 0.5));
  }
  EXPECT_GT(met, least_met);
  EXPECT_GT(blends_met, blends ? least_met / 3 : -1);
}

TEST(DiscCloud, the_first_crossing_is_that_of_its_definition) {
  expect_first_crossings({}, 200, false);
  // Small and large discs, and all as wide as allowed.
  expect_first_crossings(AdaptedRadius{.factor = 0.1}, 3, false);
  expect_first_crossings(AdaptedRadius{.factor = 2.0}, 200, false);
  expect_first_crossings(AdaptedRadius{.factor = 2.0, .max = 0.05}, 30, false);
}

TEST(DiscCloud, a_blended_crossing_is_that_of_its_definition) {
  expect_first_crossings({}, 200, true);
  expect_first_crossings(AdaptedRadius{.factor = 2.0}, 200, true);
}

TEST(DiscCloud, a_blended_crossing_has_the_color_of_one_category) {
  expect_first_crossings({}, 200, true, true);
  expect_first_crossings(AdaptedRadius{.factor = 2.0}, 200, true, true);
}

TEST(DiscCloud, hits_of_many_rays_on_one_disc_are_those_of_each_ray_alone) {
  Random random;
  std::vector<glm::dvec3> points = corner_points(random, 400);
  // A patch so dense that discs beside it are near hundreds of discs that do not hold their hits.
  for (int i = 0; i < 2000; ++i)
    points.emplace_back(2.0 + 0.1 * random.unit(), 2.0 + 0.1 * random.unit(), 0.0005 * random.in_cube().z);
  const LoadedCloud cloud = disc_cloud(points, random, AdaptedRadius{.factor = 1.5, .max = 1.0});
  const DiscCloud discs(cloud, true);
  std::vector<Ray> rays;
  for (int bundle = 0; bundle < 60; ++bundle) {
    const glm::dvec3 eye = glm::dvec3(2, 1, 3) + random.in_cube();
    const glm::dvec3 target =
        bundle % 2 == 0 ? glm::dvec3(2.05, 2.05, 0.0) + 0.3 * random.in_cube() : points[random.below(800)];
    for (int i = 0; i < 30; ++i) rays.push_back(make_ray(eye, target + 0.1 * random.in_cube() - eye, 0.0));
  }
  const std::vector<SheetOrigin> origins(rays.size());
  std::vector<std::optional<DiscHit>> hits(rays.size());
  discs.closest(rays, origins, hits);
  std::size_t shared = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    std::optional<DiscHit> alone;
    discs.closest({&rays[i], 1}, {&origins[i], 1}, {&alone, 1});
    ASSERT_EQ(hits[i].has_value(), alone.has_value());
    if (!alone) continue;
    ASSERT_EQ(hits[i]->point_id, alone->point_id);
    ASSERT_EQ(hits[i]->t, alone->t);
    ASSERT_EQ(hits[i]->color, alone->color);
    ASSERT_EQ(hits[i]->sheet.normal, alone->sheet.normal);
    ASSERT_EQ(hits[i]->sheet.thickness, alone->sheet.thickness);
    if (i > 0 && hits[i - 1] && hits[i - 1]->point_id == alone->point_id) ++shared;
  }
  EXPECT_GT(shared, 200u);
}

TEST(DiscCloud, a_blended_plane_is_flat_and_a_rim_stays_sharp) {
  Random random;
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 20000; ++i)
    points.emplace_back(random.between(-2, 2), random.between(-2, 2), 0.003 * random.in_cube().z);
  const LoadedCloud cloud = disc_cloud(points, random);
  const DiscCloud discs(cloud, true);
  std::vector<Ray> rays;
  for (int i = 0; i < 2000; ++i)
    rays.push_back(make_ray({random.between(-1.9, 1.9), random.between(-1.9, 1.9), 3.0}, {0.3, 0.2, -1}));
  const std::vector<SheetOrigin> origins(rays.size());
  std::vector<std::optional<DiscHit>> hits(rays.size());
  discs.closest(rays, origins, hits);
  int met = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const glm::dvec3 ground = rays[i].origin + 3.0 / -rays[i].direction.z * rays[i].direction;
    const double from_middle = std::max(std::fabs(ground.x), std::fabs(ground.y));
    const bool inside = from_middle < 1.9;
    const bool outside = from_middle > 2.05;
    if (outside) {
      ASSERT_FALSE(hits[i]) << ground.x << " " << ground.y;
    }
    if (!inside) continue;
    ++met;
    ASSERT_TRUE(hits[i]) << ground.x << " " << ground.y;
    ASSERT_NEAR(hits[i]->t * -rays[i].direction.z, 3.0, 0.003);
    ASSERT_GT(hits[i]->sheet.normal.z, 0.995);
  }
  EXPECT_GT(met, 1000);
}

TEST(DiscCloud, settings_that_discs_do_not_have_are_errors) {
  Random random;
  const std::vector<glm::dvec3> points = corner_points(random, 50);
  const auto expect_error = [&](const CloudSettings& settings) {
    LoadedCloud cloud = test::loaded(points, 0.1);
    EXPECT_THROW(choose_radius(settings, cloud), Error);
  };
  CloudSettings discs;
  discs.shape = PointShape::disc;
  CloudSettings settings = discs;
  settings.radius = 0.1;
  expect_error(settings);
  settings = discs;
  settings.material = Dielectric{};
  expect_error(settings);
  settings = discs;
  settings.adapted_radius = AdaptedRadius{.neighbours = 5};
  expect_error(settings);
  settings = discs;
  settings.max_level = 3;
  expect_error(settings);
  LoadedCloud cloud = test::loaded(points, 0.1);
  EXPECT_NO_THROW(choose_radius(discs, cloud));
}

}  // namespace
}  // namespace alidade
