// SPDX-License-Identifier: MIT
// What renderer/disc_tracer.h states about sheets and trust, computed by plain loops over all points.
// disc_tracer_test.cpp has the first crossing, and t and colour of blended ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "octree/distance.h"
#include "tests/renderer/disc_clouds.h"

namespace alidade {

using namespace renderer;

namespace {

using test::corner_points;
using test::disc_cloud;
using test::first_crossing;
using test::k_sheet_cosine;
using test::PlainPoints;
using test::Random;

constexpr double k_infinity = std::numeric_limits<double>::infinity();

// Sums are added in the order of storage indices, as the renderer does. This is the relative difference that
// another order may make.
constexpr double k_tolerance = 1e-12;

// The sheet of a crossing, and how its discs weigh.
constexpr double k_falloff = 8.0;                  // exp(-falloff d^2 / r^2)
constexpr double k_share = 0.25, k_slack = 0.004;  // from the crossing to planes: of the radius, and metres
constexpr double k_reach = 3.0;                    // radii that a sheet reaches around a crossing
constexpr double k_own_thickness = 3.0,
                 k_own_rise = 0.1;  // of what rays leave behind: of its thickness, and of the radius

// What depths are trusted to.
constexpr double k_shift = 1.0;      // spacings by which sheets may end later
constexpr double k_wider = 2.5;      // times the radius of discs
constexpr double k_larger = 4.0;     // times that of spheres
constexpr double k_around = 1.1;     // spacings within which points surround a crossing
constexpr double k_apart = 1.2;      // standard deviations between two depths that may be one
constexpr double k_thinnest = 0.01;  // thickness of a sheet, of its radius
constexpr int k_rims = 32;           // one behind another

struct Disc {
  glm::dvec3 point, normal;
  double height, radius, thickness;
};

std::optional<Disc> disc_of(const PlainPoints& points, std::uint64_t id, double factor) {
  const PointSurface surface = surface_of(points.layers, id);
  if (!surface.exists) return std::nullopt;
  return Disc{points.cloud.world(id), surface.normal, surface.height,
              std::min(points.query.radius, factor * points.spacings[id]), surface.thickness};
}

double above(const Disc& disc, const glm::dvec3& position) {
  return glm::dot(position - (disc.point - disc.height * disc.normal), disc.normal);
}

/// The discs of the sheet that has this normal where a ray meets it, by points within `factor` of their
/// spacings.
std::vector<Disc> sheet_at(const PlainPoints& points, const glm::dvec3& met, const glm::dvec3& normal,
                           double factor) {
  std::vector<Disc> sheet;
  for (const std::uint64_t id : points.ids) {
    const std::optional<Disc> disc = disc_of(points, id, factor);
    if (!disc || distance(met, disc->point) > disc->radius) continue;
    if (std::fabs(glm::dot(disc->normal, normal)) < k_sheet_cosine) continue;
    if (std::fabs(above(*disc, met)) > k_share * disc->radius + k_slack) continue;
    sheet.push_back(*disc);
  }
  return sheet;
}

/// What a ray meets whose first crossing is known, without blending.
SheetOrigin own_sheet(const Disc& own, const Ray& ray) {
  return {.normal = glm::dot(own.normal, ray.direction) > 0.0 ? -own.normal : own.normal,
          .reach = static_cast<float>(k_reach * own.radius),
          .thickness = static_cast<float>(k_own_thickness * own.thickness + k_own_rise * own.radius)};
}

/// Over the discs of the sheet.
struct Sums {
  std::uint32_t count = 0;
  double weight = 0.0, mean = 0.0, variance = 0.0;  ///< of t from the first crossing
  glm::dvec3 normal{0.0};
  double farthest = 0.0;
};

Sums sums_of(const PlainPoints& points, const Ray& ray, double t, const glm::dvec3& normal) {
  const glm::dvec3 met = ray.origin + t * ray.direction;
  Sums sums;
  double square = 0.0;
  for (const Disc& disc : sheet_at(points, met, normal, points.query.spacing_factor)) {
    const double later = -above(disc, ray.origin) / glm::dot(ray.direction, disc.normal) - t;
    if (!(std::fabs(later) <= disc.radius)) continue;
    const glm::dvec3 offset = met - disc.point;
    const double weight = std::exp(-k_falloff * glm::dot(offset, offset) / (disc.radius * disc.radius));
    ++sums.count;
    sums.weight += weight;
    sums.mean += weight * later;
    square += weight * later * later;
    sums.normal += (glm::dot(disc.normal, normal) < 0.0 ? -weight : weight) * disc.normal;
    sums.farthest = std::max(sums.farthest, std::fabs(above(disc, met)));
  }
  if (sums.weight == 0.0) return sums;
  sums.mean /= sums.weight;
  sums.variance = std::max(0.0, square / sums.weight - sums.mean * sums.mean);
  return sums;
}

/// Whether no half of the plane around a position is free of points.
bool is_surrounded(const std::vector<Disc>& sheet, const glm::dvec3& met, const glm::dvec3& normal) {
  const auto is_free = [&](const glm::dvec3& side) {
    return std::ranges::all_of(sheet,
                               [&](const Disc& disc) { return glm::dot(disc.point - met, side) <= 1e-12; });
  };
  return !sheet.empty() && std::ranges::none_of(sheet, [&](const Disc& disc) {
    const glm::dvec3 side = glm::cross(disc.point - met, normal);
    return is_free(side) || is_free(-side);
  });
}

HitTrust trust_of(const PlainPoints& points, const Ray& ray, const Hit& first) {
  HitTrust trust{.support = 1};
  const auto own = disc_of(points, first.point_id, points.query.spacing_factor);
  if (!own) {
    trust.sigma = project(ray, first.position).t - first.t;
  } else {
    const Sums sums = sums_of(points, ray, first.t, own->normal);
    trust.support = std::max(sums.count, 1u);
    const double along =
        (own->thickness + k_thinnest * own->radius) / std::fabs(glm::dot(own->normal, ray.direction));
    trust.sigma = std::sqrt(sums.variance + along * along / trust.support);
  }
  SurfaceQuery wide = points.query;
  wide.discs->edge_shift = k_shift;
  wide.spacing_factor *= k_wider;
  wide.discs->lone_factor *= k_larger;
  const auto earlier = brute_force::closest(points.cloud, ray, wide, points.spacings, points.layers);
  if (earlier) trust.sigma = std::max(trust.sigma, (first.t - earlier->t) / k_apart);
  // From rim to rim.
  Ray on = ray;
  Hit at = first;
  double before = 0.0;
  for (int rim = 0; rim < k_rims; ++rim) {
    const auto disc = disc_of(points, at.point_id, points.query.spacing_factor);
    const glm::dvec3 met = on.origin + at.t * on.direction;
    if (disc && is_surrounded(sheet_at(points, met, disc->normal, k_around), met, disc->normal)) break;
    const double passed = disc ? 0.0 : 2.0 * (project(on, at.position).t - at.t);
    const SheetOrigin origin = disc ? own_sheet(*disc, on) : SheetOrigin{};
    before += at.t;
    on = {ray.origin + before * ray.direction, ray.direction, passed, ray.t_max - before};
    const std::optional<Hit> behind = first_crossing(points, on, origin);
    if (!behind) return {k_infinity, trust.support};
    trust.sigma = std::max(trust.sigma, (before + behind->t - first.t) / k_apart);
    at = *behind;
  }
  return trust;
}

/// The corner, and foliage in which spheres overlap.
std::vector<glm::dvec3> corner_with_foliage(Random& random, int count) {
  std::vector<glm::dvec3> points = corner_points(random, count);
  for (int i = 0; i < count; ++i) points.push_back(glm::dvec3(1, 1, 1.5) + 0.5 * random.in_cube());
  return points;
}

/// A third of them goes along the floor, where blended normals may face away.
std::vector<Ray> rays_through(Random& random, int count) {
  std::vector<Ray> rays;
  for (int i = 0; i < count; ++i) {
    glm::dvec3 origin = glm::dvec3(2, 1, 1) + 4.0 * random.in_cube(), direction = random.direction();
    if (i % 3 == 0) {
      origin = {random.between(0, 4), random.between(0, 4), 0.02 * random.unit()};
      direction.z *= 0.01;
    }
    rays.push_back(make_ray(origin, direction, 0.0, i % 5 == 0 ? random.between(0.0, 6.0) : k_infinity));
  }
  return rays;
}

class DiscDefinition : public ::testing::Test {
 protected:
  static std::vector<std::optional<DiscHit>> hits_of(const DiscCloud& discs, const std::vector<Ray>& rays) {
    const std::vector<SheetOrigin> origins(rays.size());
    std::vector<std::optional<DiscHit>> hits(rays.size(), DiscHit{});  // which must not stay
    discs.closest(rays, origins, hits);
    return hits;
  }
};

TEST_F(DiscDefinition, the_sheet_that_rays_leave_is_that_of_the_points) {
  Random random;
  const LoadedCloud cloud = disc_cloud(corner_with_foliage(random, 1000), random);
  const PlainPoints points(cloud);
  const std::vector<Ray> rays = rays_through(random, 1200);
  int discs_met = 0, lone_met = 0, facing_away = 0;
  for (const bool blends : {false, true}) {
    const DiscCloud discs(cloud, blends);
    const auto hits = hits_of(discs, rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const std::optional<Hit> first = first_crossing(points, rays[i], {});
      ASSERT_EQ(hits[i].has_value(), first.has_value()) << i;
      if (!first) continue;
      const SheetOrigin& found = hits[i]->sheet;
      const auto own = disc_of(points, first->point_id, points.query.spacing_factor);
      if (!own) {
        const glm::dvec3 out = rays[i].origin + first->t * rays[i].direction - first->position;
        ASSERT_NEAR(glm::distance(found.normal, glm::normalize(out)), 0.0, k_tolerance) << i;
        ASSERT_EQ(found.reach, 0.0f);
        ++lone_met;
        continue;
      }
      SheetOrigin expected = own_sheet(*own, rays[i]);
      if (blends) {
        const Sums sums = sums_of(points, rays[i], first->t, expected.normal);
        if (glm::dot(sums.normal, rays[i].direction) < 0.0)
          expected.normal = glm::normalize(sums.normal);
        else
          ++facing_away;
        expected.thickness += static_cast<float>(2.0 * sums.farthest);
      }
      ASSERT_NEAR(glm::distance(found.normal, expected.normal), 0.0, k_tolerance) << i;
      ASSERT_EQ(found.reach, expected.reach) << i;
      ASSERT_FLOAT_EQ(found.thickness, expected.thickness) << i;
      ++discs_met;
    }
  }
  EXPECT_GT(discs_met, 200);
  EXPECT_GT(lone_met, 20);
  EXPECT_GT(facing_away, 0);
}

TEST_F(DiscDefinition, a_mean_outside_of_the_interval_does_not_count) {
  Random random;
  const LoadedCloud cloud = disc_cloud(corner_points(random, 1000), random);
  const PlainPoints points(cloud);
  const DiscCloud discs(cloud, true);
  std::vector<Ray> rays, to_first, from_first;
  std::vector<double> first_t;
  for (const Ray& ray : rays_through(random, 1000)) {
    const std::optional<Hit> first = first_crossing(points, ray, {});
    if (!first) continue;
    rays.push_back(ray);
    first_t.push_back(first->t);
    to_first.push_back({ray.origin, ray.direction, 0.0, first->t});
    from_first.push_back({ray.origin, ray.direction, first->t, ray.t_max});
  }
  const auto hits = hits_of(discs, rays), ended = hits_of(discs, to_first),
             begun = hits_of(discs, from_first);
  int before = 0, behind = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_TRUE(hits[i] && ended[i] && begun[i]) << i;
    ASSERT_EQ(ended[i]->t, std::min(hits[i]->t, first_t[i])) << i;
    ASSERT_EQ(begun[i]->t, std::max(hits[i]->t, first_t[i])) << i;
    before += hits[i]->t < first_t[i] ? 1 : 0;
    behind += hits[i]->t > first_t[i] ? 1 : 0;
  }
  EXPECT_GT(before, 5);
  EXPECT_GT(behind, 50);
}

TEST_F(DiscDefinition, trust_follows_from_the_points_around_before_and_behind) {
  Random random;
  const LoadedCloud cloud = disc_cloud(corner_with_foliage(random, 500), random);
  const PlainPoints points(cloud);
  const DiscCloud discs(cloud, true);
  const std::vector<Ray> rays = rays_through(random, 3000);
  std::vector<HitTrust> answers(rays.size(), {7.0, 7});  // which must not stay
  discs.trust(rays, answers);
  int amid = 0, before_nothing = 0, lone = 0, uncertain = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const std::optional<Hit> first = first_crossing(points, rays[i], {});
    if (!first) {
      ASSERT_EQ(answers[i].support, 0u) << i;
      continue;
    }
    const HitTrust expected = trust_of(points, rays[i], *first);
    ASSERT_EQ(answers[i].support, expected.support) << i;
    if (std::isinf(expected.sigma)) {
      ASSERT_EQ(answers[i].sigma, k_infinity) << i;
      ++before_nothing;
      continue;
    }
    // Variances lose half of the digits of their sums.
    ASSERT_NEAR(answers[i].sigma, expected.sigma, 1e-7 * expected.sigma) << i;
    amid += expected.sigma < 0.05 ? 1 : 0;
    uncertain += expected.sigma >= 0.05 ? 1 : 0;
    lone += expected.support == 1 ? 1 : 0;
  }
  EXPECT_GT(amid, 100);
  EXPECT_GT(before_nothing, 50);
  EXPECT_GT(uncertain, 50);
  EXPECT_GT(lone, 5);
}

}  // namespace
}  // namespace alidade
