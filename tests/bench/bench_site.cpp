// SPDX-License-Identifier: MIT
#include "tests/bench/bench_site.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <random>

#include "octree/spacing.h"
#include "simulation/courtyard.h"
#include "simulation/generate.h"

namespace alidade::bench {
namespace {

constexpr int k_width = 600, k_height = 400;

void add_camera(const glm::dvec3& eye, const glm::dvec3& target, std::vector<Ray>& rays) {
  const glm::dvec3 forward = glm::normalize(target - eye);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1)));
  const glm::dvec3 down = glm::cross(forward, right);
  const double pixel = 2.0 * std::tan(0.5 * 60.0 * 3.14159265358979323846 / 180.0) / k_height;
  for (int y = 0; y < k_height; ++y) {
    for (int x = 0; x < k_width; ++x) {
      const double across = (x + 0.5 - 0.5 * k_width) * pixel, along = (y + 0.5 - 0.5 * k_height) * pixel;
      rays.push_back(make_ray(eye, forward + across * right + along * down, 0.0));
    }
  }
}

/// Cosine-distributed around the normal: a point of the unit sphere added to it.
glm::dvec3 scattered(const glm::dvec3& normal, std::mt19937_64& random) {
  std::uniform_real_distribution<double> between(-1.0, 1.0);
  for (;;) {
    const glm::dvec3 v(between(random), between(random), between(random));
    const double square = glm::dot(v, v);
    if (square > 1e-4 && square <= 1.0) return normal + v / std::sqrt(square);
  }
}

BenchSite make_site(std::size_t point_count) {
  BenchSite bench;
  const Site site = courtyard();
  bench.cloud = scan_header(site);
  bench.cloud.positions.reserve(point_count);
  scan(site, courtyard_scan(point_count, 1), [&](const PointCloud& batch) {
    bench.cloud.positions.insert(bench.cloud.positions.end(), batch.positions.begin(), batch.positions.end());
  });
  bench.octree = build(bench.cloud);
  bench.radius = automatic_radius(bench.octree);

  const glm::dvec3 o = site.origin();
  add_camera(o + glm::dvec3(-18, -14, 6), o + glm::dvec3(6, 6, 1), bench.primary);
  add_camera(o + glm::dvec3(12, -10, 1.7), o + glm::dvec3(-10, 8, 3), bench.primary);
  add_camera(o + glm::dvec3(-60, -50, 45), o, bench.primary);

  std::mt19937_64 random(1);
  const glm::dvec3 to_sun = glm::normalize(glm::dvec3(0.5, -0.5, 0.6));
  for (const Ray& ray : bench.primary) {
    const std::optional<Hit> hit = closest(bench.octree, ray, bench.query());
    if (!hit) continue;
    const glm::dvec3 place = ray.position(hit->entry);
    const glm::dvec3 normal = (place - hit->position) / bench.radius;
    bench.secondary.push_back(make_ray(place, scattered(normal, random), 0.0));
    if (glm::dot(normal, to_sun) > 0.0) bench.sun.push_back(make_ray(place, to_sun, 0.0));
  }
  return bench;
}

}  // namespace

const BenchSite& bench_site(std::size_t point_count) {
  static std::map<std::size_t, BenchSite> sites;
  auto found = sites.find(point_count);
  if (found == sites.end()) found = sites.emplace(point_count, make_site(point_count)).first;
  return found->second;
}

}  // namespace alidade::bench
