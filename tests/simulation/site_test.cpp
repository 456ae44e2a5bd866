// SPDX-License-Identifier: MIT
#include "simulation/site.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "simulation/courtyard.h"
#include "tests/support/random.h"

namespace alidade {

using namespace simulation;

namespace {

using glm::dvec3;

const dvec3 k_origin(690000.0, 5325000.0, 600.0);

/// Some hundred shapes of every kind in a cube of 20 m, some of them twice at the same position.
Site crowd(test::Random& random) {
  std::vector<SiteObject> objects;
  const auto add = [&](shapes::Shape shape) {
    const auto seed = static_cast<std::uint32_t>(objects.size());
    objects.push_back(
        {std::move(shape), {.material = SiteMaterial::metal, .tint = dvec3(0.5), .seed = seed}});
  };
  for (int i = 0; i < 40; ++i) {
    const dvec3 position = 10.0 * random.in_cube(), axis = glm::normalize(random.direction());
    const dvec3 across = glm::normalize(glm::cross(axis, dvec3(0.3, 0.5, 0.8)));
    const shapes::Box box{position, glm::dmat3(across, glm::cross(axis, across), axis), {0.4, 0.7, 0.2}};
    add(shapes::Sphere{10.0 * random.in_cube(), random.between(0.1, 1.0)});
    add(shapes::Ellipsoid{10.0 * random.in_cube(), {0.5, 1.0, 0.3}});
    add(shapes::Frustum{10.0 * random.in_cube(), axis, 2.0, 0.5, 0.1, dvec3(0.0)});
    add(shapes::Disc{10.0 * random.in_cube(), axis, 0.8, 0.2});
    add(box);
    if (i % 4 == 0) add(box);
    add(shapes::Niche{box});
    add(shapes::Panel{10.0 * random.in_cube(), across, axis, {2, 1}, {{{0.5, 0.2}, {1.5, 0.8}, i % 2 == 0}}});
    add(shapes::Polygon{{position, position + 2.0 * across, position + axis}});
  }
  // Upright boxes on whole numbers: rays along the axes run within their faces.
  for (int i = 0; i < 10; ++i) {
    const double x = static_cast<double>(random.below(8)), y = static_cast<double>(random.below(8));
    add(shapes::Box{{x, y, 0}, glm::dmat3(1.0), dvec3(1.0)});
  }
  add(shapes::Ground{{15, 15}, {3, 3}, 8.0, {{0.5, {0.4, 0.3}, 0.2}}, {}});
  return Site(std::move(objects), k_origin);
}

Ray some_ray(test::Random& random, const dvec3& half, int kind) {
  dvec3 origin = random.in_cube() * half, direction = glm::normalize(random.direction());
  if (kind % 5 == 1)
    direction = dvec3(0.0), direction[static_cast<int>(random.below(3))] = random.below(2) == 0 ? 1.0 : -1.0;
  if (kind % 5 == 2) origin = glm::round(origin);
  if (kind % 5 == 3) direction.z = 0.0;
  if (kind % 5 == 4) origin *= 1000.0, direction = random.in_cube() * half - origin;
  return make_ray(k_origin + origin, direction, random.between(-5.0, 1.0),
                  kind % 7 == 0 ? random.between(0.0, 20.0) : 1e9);
}

TEST(Site, ClosestEqualsBruteForceOnACrowdOfAllShapes) {
  test::Random random;
  const Site site = crowd(random);
  int hits = 0;
  for (int i = 0; i < 20000; ++i) {
    const Ray ray = some_ray(random, dvec3(12.0), i);
    const std::optional<SiteHit> expected = brute_force::closest(site, ray);
    ASSERT_EQ(site.closest(ray), expected) << "ray " << i;
    ASSERT_EQ(site.occluded(ray), expected.has_value()) << "ray " << i;
    hits += expected ? 1 : 0;
  }
  EXPECT_GT(hits, 5000);
  EXPECT_LT(hits, 19000);
}

TEST(Site, ClosestEqualsBruteForceInTheCourtyard) {
  test::Random random;
  const Site site = courtyard();
  for (int i = 0; i < 500; ++i) {
    const Ray ray = some_ray(random, dvec3(40, 35, 12), i);
    const std::optional<SiteHit> expected = brute_force::closest(site, ray);
    ASSERT_EQ(site.closest(ray), expected) << "ray " << i;
    ASSERT_EQ(site.occluded(ray), brute_force::occluded(site, ray)) << "ray " << i;
  }
}

TEST(Site, EqualPositionsBelongToTheLowestObject) {
  std::vector<SiteObject> objects;
  for (int i = 0; i < 20; ++i) objects.push_back({shapes::Sphere{dvec3(0.0), 1.0}, {}});
  const Site site(std::move(objects), k_origin);
  EXPECT_EQ(site.closest(make_ray(k_origin + dvec3(0, 0, 5), {0, 0, -1}))->object, 0u);
}

TEST(Site, NothingLiesBehindTheOriginOfARay) {
  const Site site({{shapes::Sphere{dvec3(0.0), 1.0}, {}}}, k_origin);
  EXPECT_FALSE(site.closest(make_ray(k_origin + dvec3(0, 0, 5), {0, 0, 1})));
  EXPECT_FALSE(site.occluded(make_ray(k_origin + dvec3(0, 0, 5), {0, 0, 1})));
}

TEST(Site, HitsAreInWorldCoordinatesWithTheNormalTowardsTheRay) {
  const Site site({{shapes::Sphere{dvec3(1, 2, 3), 1.0}, {}}}, k_origin);
  const auto outside = site.closest(make_ray(k_origin + dvec3(1, 2, 8), {0, 0, -1}));
  ASSERT_TRUE(outside);
  EXPECT_DOUBLE_EQ(outside->t, 4.0);
  EXPECT_EQ(outside->position, k_origin + dvec3(1, 2, 4));
  EXPECT_EQ(outside->normal, dvec3(0, 0, 1));
  const auto inside = site.closest(make_ray(k_origin + dvec3(1, 2, 3), {0, 0, 1}));
  ASSERT_TRUE(inside);
  EXPECT_EQ(inside->normal, dvec3(0, 0, -1));
}

TEST(Site, WithoutObjectsAnswersNothing) {
  const Site site({}, k_origin);
  EXPECT_FALSE(site.closest(make_ray(k_origin, {0, 0, 1})));
  EXPECT_TRUE(site.bounds().empty());
}

TEST(Courtyard, GivesKnownAnswers) {
  const Site site = courtyard();
  const auto from = [&](const dvec3& position, const dvec3& direction) {
    return site.closest(make_ray(site.origin() + position, direction, 0.0));
  };
  const auto paving = from({3.0, -12.0, 1.7}, {0, 0, -1});
  ASSERT_TRUE(paving);
  EXPECT_NEAR(paving->t, 1.7, 1e-9);
  EXPECT_EQ(paving->classification, 2);
  const auto facade =
      from({10.0, 0.0, 3.6}, {0, 1, 0});  // between two storeys of the north wing, whose wall is at y = 16.5
  ASSERT_TRUE(facade);
  EXPECT_NEAR(facade->t, 16.5, 0.5);
  EXPECT_EQ(facade->classification, 6);
  const auto roof = from({0.0, 21.25, 30.0}, {0, 0, -1});  // on the ridge tiles
  ASSERT_TRUE(roof);
  EXPECT_NEAR(30.0 - roof->t, 12.4 + 0.26, 0.05);
  EXPECT_TRUE(from({-5.0, -12.0, 1.5}, {0, -1, 0})->t > 20.0);  // out of the gate, across the street
  EXPECT_FALSE(site.occluded(make_ray(site.origin() + dvec3(6, -12, 2), {0, 0, 1}, 0.0)));
}

TEST(Courtyard, ColorsAreWithinZeroAndOneAndNormalsFaceTheRay) {
  test::Random random;
  const Site site = courtyard();
  std::array<int, 256> classes{};
  for (int i = 0; i < 40000; ++i) {
    const Ray ray = make_ray(site.origin() + random.in_cube() * dvec3(24, 17, 4) + dvec3(0, 0, 4.1),
                             glm::normalize(random.direction()), 0.0);
    const auto hit = site.closest(ray);
    if (!hit) continue;
    ++classes[hit->classification];
    for (int channel = 0; channel < 3; ++channel)
      ASSERT_TRUE(hit->color[channel] >= 0.0 && hit->color[channel] <= 1.0);
    ASSERT_LE(glm::dot(hit->normal, ray.direction), 0.0);
    ASSERT_NEAR(glm::length(hit->normal), 1.0, 1e-9);
    ASSERT_LT(glm::length(hit->position - ray.position(hit->t)), 1e-6);
  }
  for (const int expected : {2, 5, 6, 9, 64, 65})
    EXPECT_GT(classes[static_cast<std::size_t>(expected)], 0) << expected;
}

}  // namespace
}  // namespace alidade
