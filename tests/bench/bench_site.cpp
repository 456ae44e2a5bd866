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

std::vector<Ray> primary_rays(const CampusLayout& layout) {
  const auto view = [&](const Building& house, const glm::dvec3& eye_from_low,
                        const glm::dvec3& target_from_low) {
    return camera_rays(k_campus_origin + house.low + eye_from_low,
                       k_campus_origin + house.low + target_from_low);
  };
  const Building &west = layout.buildings[10], &south = layout.buildings[20], &tower = layout.buildings[12];
  const double roof = tower.high.z - tower.low.z;
  // Buildings begin 2 m below ground.
  const std::vector<Ray> views[] = {view(west, {-9.0, -4.0, 3.7}, {1.0, 9.0, 3.2}),
                                    view(south, {-3.0, -11.0, 3.7}, {12.0, 0.0, 3.2}),
                                    view(tower, {-1.0, -1.0, roof + 1.0}, {-25.0, -20.0, 2.0})};
  std::vector<Ray> rays;
  for (const std::vector<Ray>& of_view : views) rays.insert(rays.end(), of_view.begin(), of_view.end());
  return rays;
}

std::vector<Ray> segments(const CampusLayout& layout, const PointCloud& cloud, double radius) {
  constexpr int k_observers = 50, k_targets = 10000;
  constexpr double k_reach = 60.0;
  std::mt19937_64 random(3);
  std::vector<Ray> rays;
  for (int observer = 0; observer < k_observers; ++observer) {
    const glm::dvec3 eye = k_campus_origin + open_place(layout, random);
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
  const std::vector<SpherePlace> places = hit_places(primary, hits);
  std::vector<Ray> bounces = bounce_rays(places, 1);
  std::vector<Ray> mixed = shuffled(bounces, 2);
  const glm::dvec3 to_sun = glm::normalize(glm::dvec3(0.5, -0.5, 0.6));
  site.ray_sets = {{{"P", std::move(primary)},
                    {"S", std::move(bounces)},
                    {"S_shuffled", std::move(mixed)},
                    {"A_sun", parallel_rays(places, to_sun)},
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
