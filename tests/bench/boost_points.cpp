// SPDX-License-Identifier: MIT
#include <benchmark/benchmark.h>

#include <algorithm>
#include <boost/geometry.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <boost/iterator/function_output_iterator.hpp>

#include "tests/bench/point_questions.h"

namespace alidade::bench {
namespace {

namespace geometry = boost::geometry;

using BoostPoint = geometry::model::point<float, 3, geometry::cs::cartesian>;
using BoostEntry = std::pair<BoostPoint, std::uint32_t>;
using Tree = geometry::index::rtree<BoostEntry, geometry::index::rstar<16>>;

BoostPoint boost_point(const glm::vec3& point) {
  return {point.x, point.y, point.z};
}

auto inside(const glm::vec3& low, const glm::vec3& high) {
  return geometry::index::covered_by(geometry::model::box<BoostPoint>(boost_point(low), boost_point(high)));
}

class BoostPoints {
 public:
  std::size_t nearest(const glm::vec3& point, std::size_t k) {
    found_.clear();
    tree_.query(geometry::index::nearest(boost_point(point), static_cast<unsigned>(k)),
                std::back_inserter(found_));
    std::ranges::sort(found_, {}, [&](const BoostEntry& entry) {
      return geometry::comparable_distance(entry.first, boost_point(point));
    });
    return found_.size();
  }
  std::size_t box_count(const glm::vec3& low, const glm::vec3& high) {
    std::size_t count = 0;
    tree_.query(inside(low, high), boost::make_function_output_iterator([&](const BoostEntry&) { ++count; }));
    return count;
  }
  std::size_t box_ids(const glm::vec3& low, const glm::vec3& high) {
    ids_.clear();
    tree_.query(inside(low, high), boost::make_function_output_iterator(
                                       [&](const BoostEntry& entry) { ids_.push_back(entry.second); }));
    return ids_.size();
  }

 protected:
  static std::vector<BoostEntry> entries(const std::vector<glm::vec3>& positions) {
    std::vector<BoostEntry> entries;
    entries.reserve(positions.size());
    for (const glm::vec3& position : positions)
      entries.emplace_back(boost_point(position), static_cast<std::uint32_t>(entries.size()));
    return entries;
  }

  Tree tree_;

 private:
  std::vector<BoostEntry> found_;
  std::vector<std::uint32_t> ids_;
};

class BoostPacked : public BoostPoints {
 public:
  explicit BoostPacked(const std::vector<glm::vec3>& positions) { tree_ = Tree(entries(positions)); }
};

class BoostInserted : public BoostPoints {
 public:
  explicit BoostInserted(const std::vector<glm::vec3>& positions) {
    for (const BoostEntry& entry : entries(positions)) tree_.insert(entry);
  }
};

}  // namespace

void register_boost_points() {
  for (const std::int64_t points : k_point_sizes) register_index<BoostPacked>("boost_packed", points);
  // One million points take longer than all else together.
  register_index<BoostInserted>("boost_inserted", k_point_sizes[0]);
}

}  // namespace alidade::bench
