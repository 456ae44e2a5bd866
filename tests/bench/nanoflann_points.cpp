// SPDX-License-Identifier: MIT
#include <benchmark/benchmark.h>

#include <nanoflann.hpp>

#include "tests/bench/point_questions.h"

namespace alidade::bench {
namespace {

/// How nanoflann reads points.
struct Positions {
  std::vector<glm::vec3> all;
  std::size_t kdtree_get_point_count() const { return all.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const { return all[i][static_cast<int>(axis)]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

class NanoflannPoints {
 public:
  explicit NanoflannPoints(const std::vector<glm::vec3>& positions)
      : positions_{positions}, tree_(3, positions_, nanoflann::KDTreeSingleIndexAdaptorParams(10)) {
    tree_.buildIndex();
  }
  std::size_t nearest(const glm::vec3& point, std::size_t k) {
    ids_.resize(k);
    distances_sq_.resize(k);
    return tree_.knnSearch(&point.x, k, ids_.data(), distances_sq_.data());
  }
  std::size_t nearest_of_all(std::size_t k) {
    std::size_t found = 0;
    for (const glm::vec3& position : positions_.all) {
      found += nearest(position, k);
      benchmark::DoNotOptimize(ids_.data());
    }
    return found;
  }
  std::size_t within(const glm::vec3& point, float radius) {
    return tree_.radiusSearch(&point.x, radius * radius, found_, nanoflann::SearchParams());
  }

 private:
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Positions>, Positions,
                                                   3, std::uint32_t>;
  Positions positions_;
  Tree tree_;
  std::vector<std::uint32_t> ids_;
  std::vector<float> distances_sq_;
  std::vector<std::pair<std::uint32_t, float>> found_;
};

}  // namespace

void register_nanoflann_points() {
  for (const std::int64_t points : k_point_sizes) register_index<NanoflannPoints>("nanoflann", points);
}

}  // namespace alidade::bench
