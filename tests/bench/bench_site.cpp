// SPDX-License-Identifier: MIT
#include "tests/bench/bench_site.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <random>

#include "octree/spacing.h"
#include "tests/bench/camera_rays.h"
#include "tests/bench/campus.h"

namespace alidade::bench {
namespace {

glm::dvec3 above_ground(double x, double y, double height) {
  return {x, y, terrain_height(x, y) + height};
}

std::vector<Ray> primary_rays(const CampusLayout& layout) {
  const glm::dvec3 west = layout.buildings[10].low, south = layout.buildings[20].low;
  const Building& tower = layout.buildings[12];
  const glm::dvec3 roof = {tower.low.x + 1.0, tower.low.y + 1.0, tower.high.z + 1.7};
  const std::pair<glm::dvec3, glm::dvec3> views[] = {
      {above_ground(west.x - 9.0, west.y - 4.0, 1.7), above_ground(west.x + 1.0, west.y + 9.0, 1.5)},
      {above_ground(south.x - 3.0, south.y - 11.0, 1.7), above_ground(south.x + 12.0, south.y, 1.5)},
      {roof, above_ground(roof.x - 60.0, roof.y - 30.0, 4.0)}};
  std::vector<Ray> rays;
  for (const auto& [eye, target] : views) {
    const std::vector<Ray> of_view = camera_rays(k_campus_origin + eye, k_campus_origin + target);
    rays.insert(rays.end(), of_view.begin(), of_view.end());
  }
  return rays;
}

std::vector<Ray> segments(const CampusLayout& layout, const PointCloud& cloud, double radius) {
  constexpr int k_observers = 50, k_targets = 10000;
  constexpr double k_reach = 30.0;
  std::mt19937_64 random(3);
  std::vector<Ray> rays;
  for (int observer = 0; observer < k_observers; ++observer) {
    const glm::dvec3 eye = k_campus_origin + open_position(layout, random);
    for (int i = 0; i < k_targets;) {
      const glm::dvec3 apart = cloud.world(random() % cloud.size()) - eye;
      if (glm::length(apart) > k_reach) continue;
      ++i;
      // The target's own sphere and its neighbours' do not hide it.
      const double end = glm::length(apart) - 3.0 * radius;
      rays.push_back(make_ray(eye, apart, 0.0, end));
    }
  }
  return rays;
}

BenchSite make_site(std::size_t point_count) {
  const CampusLayout layout = campus_layout();
  BenchSite site;
  site.cloud = campus_cloud(layout, point_count);
  site.octree = build(site.cloud);
  site.radius = 2.5 * measure_spacing(site.octree).mean;

  std::vector<Ray> primary = primary_rays(layout);
  std::vector<std::optional<Hit>> hits(primary.size());
  closest(site.octree, primary, site.query(), hits);
  const std::vector<BounceOrigin> origins = bounce_origins(primary, hits);
  std::vector<Ray> bounces = bounce_rays(origins, 1);
  std::vector<Ray> mixed = shuffled(bounces, 2);
  const glm::dvec3 to_sun = glm::normalize(glm::dvec3(0.5, -0.5, 0.3));
  site.ray_sets = {{{"P", std::move(primary)},
                    {"S", std::move(bounces)},
                    {"S_shuffled", std::move(mixed)},
                    {"A_sun", parallel_rays(origins, to_sun)},
                    {"A_vis", segments(layout, site.cloud, site.radius)}}};
  return site;
}

}  // namespace

const std::vector<Ray>& BenchSite::rays(std::string_view set) const {
  return std::ranges::find(ray_sets, set, &RaySet::name)->rays;
}

const BenchSite& bench_site(std::size_t point_count) {
  static std::map<std::size_t, BenchSite> sites;
  auto found = sites.find(point_count);
  if (found == sites.end()) found = sites.emplace(point_count, make_site(point_count)).first;
  return found->second;
}

}  // namespace alidade::bench
