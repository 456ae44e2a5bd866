// SPDX-License-Identifier: MIT
#include <benchmark/benchmark.h>

#include "octree/build.h"
#include "octree/query.h"
#include "tests/bench/point_questions.h"

namespace alidade::bench {
namespace {

class OctreePoints {
 public:
  explicit OctreePoints(const std::vector<glm::vec3>& positions)
      : octree_(build(cloud_of(positions))), positions_(positions.begin(), positions.end()) {}
  std::size_t nearest(const glm::vec3& point, std::size_t k) {
    return count(find(octree_, glm::dvec3(point), {.k = k}));
  }
  std::size_t nearest_of_all(std::size_t k) {
    ids_.resize(k * positions_.size());
    distances_.resize(ids_.size());
    find(octree_, positions_, {.k = k}, {ids_.data(), distances_.data()});
    benchmark::DoNotOptimize(ids_.data());
    return ids_.size();
  }
  std::size_t within(const glm::vec3& point, float radius) {
    return count(find(octree_, glm::dvec3(point), {.radius = radius}));
  }
  std::size_t box_count(const glm::vec3& low, const glm::vec3& high) {
    return alidade::count(octree_, Bounds{low, high});
  }
  std::size_t box_ids(const glm::vec3& low, const glm::vec3& high) {
    return count(find(octree_, Bounds{low, high}));
  }

 private:
  static PointCloud cloud_of(const std::vector<glm::vec3>& positions) {
    PointCloud cloud;
    cloud.lattice.scale = glm::dvec3(k_uniform_step);
    cloud.positions.reserve(positions.size());
    for (const glm::vec3& position : positions)
      cloud.positions.emplace_back(position / static_cast<float>(k_uniform_step));
    return cloud;
  }
  static std::size_t count(const std::vector<PointHit>& hits) {
    benchmark::DoNotOptimize(hits.data());
    return hits.size();
  }

  Octree octree_;
  std::vector<glm::dvec3> positions_;
  std::vector<std::int64_t> ids_;
  std::vector<double> distances_;
};

void build_from_cloud(benchmark::State& state, std::int64_t points, int threads) {
  const PointCloud cloud = uniform_cloud(static_cast<std::size_t>(points));
  std::size_t memory = 0;
  for (auto _ : state) memory = on_threads(threads, [&] { return build(cloud).memory(); });
  state.counters["bytes_per_point"] = static_cast<double>(memory) / static_cast<double>(points);
}

}  // namespace

void register_octree_points() {
  for (const std::int64_t points : k_point_sizes) {
    register_questions<OctreePoints>("octree", points);
    for (const int threads : {1, 2})
      add_benchmark(threads, {"points", "build", with_threads("octree", threads), std::to_string(points)},
                    build_from_cloud, points, threads);
  }
}

}  // namespace alidade::bench
