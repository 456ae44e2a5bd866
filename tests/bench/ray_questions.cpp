// SPDX-License-Identifier: MIT
// Questions to rays that Embree has no answer for.
#include <benchmark/benchmark.h>

#include <map>
#include <string>
#include <vector>

#include "octree/build.h"
#include "octree/query.h"
#include "tests/bench/bench_site.h"
#include "tests/bench/ray_bench.h"
#include "tests/bench/timing.h"
#include "tests/bench/uniform_points.h"

namespace alidade::bench {
namespace {

const Octree& uniform_octree(std::int64_t points) {
  static std::map<std::int64_t, Octree> octrees;
  auto found = octrees.find(points);
  if (found == octrees.end())
    found = octrees.emplace(points, build(uniform_cloud(static_cast<std::size_t>(points)))).first;
  return found->second;
}

/// From random positions in the cube into random directions.
std::vector<Ray> uniform_rays(int count) {
  std::mt19937_64 random(6);
  std::vector<Ray> rays;
  while (rays.size() < static_cast<std::size_t>(count)) {
    const glm::dvec3 origin = uniform_position(random), direction = 2.0 * uniform_position(random) - 1.0;
    const double square = direction.x * direction.x + direction.y * direction.y + direction.z * direction.z;
    if (square > 0.01 && square < 1.0) rays.push_back(make_ray(origin, direction, 0.0));
  }
  return rays;
}

/// Every tenth or so of the primary rays, so that neighbours are not alike.
std::vector<Ray> site_rays(const BenchSite& site) {
  constexpr std::size_t k_count = 3000;
  const std::vector<Ray>& primary = site.rays("P");
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < k_count; ++i) rays.push_back(primary[i * primary.size() / k_count]);
  return rays;
}

/// Queries the lists of the rays one after the other.
void find_each(benchmark::State& state, const Octree& octree, const std::vector<Ray>& rays,
               const RayQuery& query) {
  std::size_t found = 0;
  for (auto _ : state) {
    for (const Ray& ray : rays) found += find(octree, ray, query).size();
  }
  report_queries(state, rays.size(), found);
}

void closest_each(benchmark::State& state, const Octree& octree, const std::vector<Ray>& rays,
                  const RayQuery& query) {
  std::size_t found = 0;
  for (auto _ : state) {
    for (const Ray& ray : rays) {
      const std::optional<Hit> hit = closest(octree, ray, query);
      if (hit) benchmark::DoNotOptimize(hit->point_id), ++found;
    }
  }
  report_queries(state, rays.size(), found);
}

// Lists of a wide radius in a large cloud hold tens of thousands of points.
constexpr int k_uniform_rays = 200;

void time_uniform(benchmark::State& state, std::int64_t points, const RayQuery& query) {
  find_each(state, uniform_octree(points), uniform_rays(k_uniform_rays), query);
}

/// All points between two planes across the ray.
void time_interval(benchmark::State& state, std::int64_t points, double width) {
  constexpr double k_begin = 0.3;
  std::vector<Ray> rays = uniform_rays(k_uniform_rays);
  for (Ray& ray : rays) ray = make_ray(ray.origin, ray.direction, k_begin, k_begin + width);
  find_each(state, uniform_octree(points), rays, {.measure = Measure::t});
}

void time_site(benchmark::State& state, std::int64_t points, std::size_t k) {
  const BenchSite& site = bench_site(static_cast<std::size_t>(points));
  find_each(state, site.octree, site_rays(site), {.measure = Measure::distance, .k = k});
}

void time_site_by_t(benchmark::State& state, std::int64_t points) {
  const BenchSite& site = bench_site(static_cast<std::size_t>(points));
  closest_each(state, site.octree, site_rays(site), {.radius = site.radius, .measure = Measure::t});
}

/// All points at one position, and rays that pass it within the radius.
void time_identical(benchmark::State& state, std::int64_t points, bool any) {
  PointCloud cloud;
  cloud.positions.assign(static_cast<std::size_t>(points), LatticePosition(5000, 5000, 5000));
  const Octree octree = build(cloud);
  std::vector<Ray> rays = uniform_rays(1000);
  for (Ray& ray : rays) {
    const glm::dvec3 origin = 10.0 * ray.origin;
    ray = make_ray(origin, glm::dvec3(5.0) + 0.001 * ray.direction - origin, 0.0);
  }
  const RayQuery query{.radius = 0.01};
  if (!any) return closest_each(state, octree, rays, query);
  std::size_t found = 0;
  for (auto _ : state) {
    for (const Ray& ray : rays) found += occluded(octree, ray, query);
  }
  report_queries(state, rays.size(), found);
}

}  // namespace

void register_ray_questions() {
  for (const std::int64_t points : {1'000'000, 10'000'000, 100'000'000}) {
    const std::string count = std::to_string(points);
    for (const std::size_t k : {1, 2, 4, 8, 16, 32, 64, 128, 256}) {
      const RayQuery query{.measure = Measure::distance, .k = k};
      add_benchmark(1, {"uniform", "nearest", std::to_string(k), count}, time_uniform, points, query);
    }
    for (const char* width : {"0.000001", "0.00001", "0.0001", "0.001"})
      add_benchmark(1, {"uniform", "interval", width, count}, time_interval, points, std::stod(width));
    for (const char* radius : {"0.0003", "0.001", "0.003", "0.01", "0.03"}) {
      RayQuery query{.radius = std::stod(radius), .measure = Measure::t};
      add_benchmark(1, {"uniform", "radius", radius, count}, time_uniform, points, query);
      for (const std::size_t k : {1, 8, 64}) {
        query.k = k;
        const std::string question = "closest_" + std::to_string(k);
        add_benchmark(1, {"uniform", question, radius, count}, time_uniform, points, query);
      }
    }
  }
  for (const std::int64_t points : k_site_sizes) {
    const std::string count = std::to_string(points);
    for (const std::size_t k : {1, 8, 64})
      add_benchmark(1, {"site", "nearest", std::to_string(k), count}, time_site, points, k);
    add_benchmark(1, {"site", "closest_by_t", count}, time_site_by_t, points);
  }
  for (const std::int64_t points : {1'000'000}) {
    add_benchmark(1, {"identical", "closest", std::to_string(points)}, time_identical, points, false);
    add_benchmark(1, {"identical", "occluded", std::to_string(points)}, time_identical, points, true);
  }
}

}  // namespace alidade::bench
