// SPDX-License-Identifier: MIT
#include <benchmark/benchmark.h>
#include <pcl/octree/octree_search.h>

#include "tests/bench/point_questions.h"

namespace alidade::bench {
namespace {

/// Cells that hold ten points on average, a good choice by trial.
float resolution_for(std::size_t points) {
  return std::cbrt(10.0f / static_cast<float>(points));
}

class PclPoints {
 public:
  explicit PclPoints(const std::vector<glm::vec3>& positions) : octree_(resolution_for(positions.size())) {
    const auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
    cloud->reserve(positions.size());
    for (const glm::vec3& position : positions) cloud->push_back({position.x, position.y, position.z});
    octree_.setInputCloud(cloud);
    octree_.addPointsFromInputCloud();
  }
  std::size_t nearest(const glm::vec3& point, std::size_t k) {
    octree_.nearestKSearch({point.x, point.y, point.z}, static_cast<unsigned>(k), ids_, distances_sq_);
    return ids_.size();
  }
  std::size_t within(const glm::vec3& point, float radius) {
    octree_.radiusSearch({point.x, point.y, point.z}, radius, ids_, distances_sq_);
    return ids_.size();
  }
  std::size_t box_ids(const glm::vec3& low, const glm::vec3& high) {
    octree_.boxSearch({low.x, low.y, low.z}, {high.x, high.y, high.z}, ids_);
    return ids_.size();
  }

 private:
  pcl::octree::OctreePointCloudSearch<pcl::PointXYZ> octree_;
  pcl::Indices ids_;
  std::vector<float> distances_sq_;
};

}  // namespace

void register_pcl_points() {
  for (const std::int64_t points : k_point_sizes) register_index<PclPoints>("pcl", points);
}

}  // namespace alidade::bench
