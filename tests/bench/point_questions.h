// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/morton.h"
#include "tests/bench/process_memory.h"
#include "tests/bench/timing.h"
#include "tests/bench/uniform_points.h"

// The same questions to every index of points, after the paper's Table 1: random points of the unit cube in
// random order. An index is a class with a name, made from positions, that has these functions or some of
// them; all answer how many points they found:
//   std::size_t nearest(const glm::vec3& point, std::size_t k)           k nearest points, nearest first
//   std::size_t within(const glm::vec3& point, float radius)             all within, nearest first
//   std::size_t box_count(const glm::vec3& low, const glm::vec3& high)   how many
//   std::size_t box_ids(const glm::vec3& low, const glm::vec3& high)     their ids
//   std::size_t nearest_of_all(std::size_t k)      of each of its own points, in their order

namespace alidade::bench {

/// Each registers the benchmarks of one library:
/// - points/build/INDEX/POINTS: on one thread; of the octree also octree_2_threads
/// - points/nearest_8/INDEX/POINTS, points/within_20/INDEX/POINTS (a radius that holds 20 points on average)
/// - points/box_count_large/INDEX/POINTS, points/box_ids_large/...: two random corners, as in the paper
/// - points/all_nearest_10_ORDER/INDEX/POINTS: of all points; ORDER raw (random), morton (the points given to
///   the index and asked for along a Morton curve)
/// - points/box_count_small/INDEX/POINTS, points/box_ids_small/...: boxes that hold 20 points on average
void register_octree_points();
void register_nanoflann_points();
void register_boost_points();
void register_pcl_points();

constexpr std::size_t k_point_queries = 1000;

inline std::vector<glm::vec3> uniform_positions(std::int64_t points) {
  const PointCloud cloud = uniform_cloud(static_cast<std::size_t>(points));
  std::vector<glm::vec3> positions(cloud.size());
  for (std::size_t i = 0; i < positions.size(); ++i) positions[i] = glm::vec3(cloud.world(i));
  return positions;
}

inline std::vector<glm::vec3> along_morton_curve(std::vector<glm::vec3> positions) {
  const auto key = [](const glm::vec3& position) {
    const glm::vec3 cell = position * 1024.0f;
    return morton_key(static_cast<std::uint32_t>(cell.x), static_cast<std::uint32_t>(cell.y),
                      static_cast<std::uint32_t>(cell.z));
  };
  std::ranges::sort(positions, {}, key);
  return positions;
}

/// Made at the first call for a size and an order, then kept.
template <class Index>
Index& kept_index(std::int64_t points, bool along_curve = false) {
  static std::map<std::pair<std::int64_t, bool>, std::unique_ptr<Index>> indexes;
  std::unique_ptr<Index>& index = indexes[{points, along_curve}];
  if (!index) {
    const std::vector<glm::vec3> positions = uniform_positions(points);
    index = std::make_unique<Index>(along_curve ? along_morton_curve(positions) : positions);
  }
  return *index;
}

struct QueryBox {
  glm::vec3 low, high;
};

inline std::vector<QueryBox> large_boxes() {
  std::mt19937_64 random(7);
  std::vector<QueryBox> boxes(k_point_queries);
  for (QueryBox& box : boxes) {
    const glm::vec3 a(uniform_position(random)), b(uniform_position(random));
    for (int axis = 0; axis < 3; ++axis) {
      box.low[axis] = std::fmin(a[axis], b[axis]);
      box.high[axis] = std::fmax(a[axis], b[axis]);
    }
  }
  return boxes;
}

inline std::vector<QueryBox> small_boxes(std::int64_t points) {
  std::mt19937_64 random(8);
  const auto side = static_cast<float>(std::cbrt(20.0 / static_cast<double>(points)));
  std::vector<QueryBox> boxes(k_point_queries);
  for (QueryBox& box : boxes) {
    box.low = glm::vec3(uniform_position(random)) * (1.0f - side);
    box.high = box.low + side;
  }
  return boxes;
}

template <class Index>
void build_index(benchmark::State& state, std::int64_t points) {
  const std::vector<glm::vec3> positions = uniform_positions(points);
  const std::size_t before = process_memory().resident;
  std::unique_ptr<Index> index;
  for (auto _ : state) on_threads(1, [&] { index = std::make_unique<Index>(positions); });
  state.counters["bytes_per_point"] =
      static_cast<double>(process_memory().resident - before) / static_cast<double>(points);
}

inline std::vector<glm::vec3> query_positions() {
  std::mt19937_64 random(9);
  std::vector<glm::vec3> positions(k_point_queries);
  for (glm::vec3& position : positions) position = glm::vec3(uniform_position(random));
  return positions;
}

template <class Index>
void time_nearest(benchmark::State& state, std::int64_t points, std::size_t k) {
  Index& index = kept_index<Index>(points);
  const std::vector<glm::vec3> positions = query_positions();
  std::size_t found = 0;
  for (auto _ : state) {
    for (const glm::vec3& position : positions) found += index.nearest(position, k);
  }
  report_queries(state, positions.size(), found);
}

template <class Index>
void time_nearest_of_all(benchmark::State& state, std::int64_t points, std::size_t k, bool along_curve) {
  Index& index = kept_index<Index>(points, along_curve);
  std::size_t found = 0;
  for (auto _ : state) found += on_threads(1, [&] { return index.nearest_of_all(k); });
  report_queries(state, static_cast<std::size_t>(points), found);
}

template <class Index>
void time_within(benchmark::State& state, std::int64_t points, float radius) {
  Index& index = kept_index<Index>(points);
  const std::vector<glm::vec3> positions = query_positions();
  std::size_t found = 0;
  for (auto _ : state) {
    for (const glm::vec3& position : positions) found += index.within(position, radius);
  }
  report_queries(state, positions.size(), found);
}

template <class Index>
void time_boxes(benchmark::State& state, std::int64_t points, const std::vector<QueryBox>& boxes,
                std::size_t (Index::*question)(const glm::vec3&, const glm::vec3&)) {
  Index& index = kept_index<Index>(points);
  std::size_t found = 0;
  for (auto _ : state) {
    for (const QueryBox& box : boxes) found += (index.*question)(box.low, box.high);
  }
  report_queries(state, boxes.size(), found);
}

template <class Index>
void register_build(std::string_view name, std::int64_t points) {
  add_benchmark(1, {"points", "build", name, std::to_string(points)}, build_index<Index>, points);
}

template <class Index>
void register_questions(std::string_view name, std::int64_t points) {
  const std::string count = std::to_string(points);
  add_benchmark(1, {"points", "nearest_8", name, count}, time_nearest<Index>, points, 8);
  if constexpr (requires { &Index::within; }) {
    const auto radius = static_cast<float>(std::cbrt(20.0 / (4.18879 * static_cast<double>(points))));
    add_benchmark(1, {"points", "within_20", name, count}, time_within<Index>, points, radius);
  }
  if constexpr (requires { &Index::nearest_of_all; }) {
    constexpr std::int64_t k_fewest = 1'000'000;
    for (const bool along_curve : {false, true}) {
      if (points < k_fewest) continue;
      add_benchmark(1, {"points", along_curve ? "all_nearest_10_morton" : "all_nearest_10_raw", name, count},
                    time_nearest_of_all<Index>, points, 10, along_curve);
    }
  }
  const auto add_boxes = [&](const std::string& question, auto function) {
    add_benchmark(1, {"points", question + "_small", name, count}, time_boxes<Index>, points,
                  small_boxes(points), function);
    constexpr std::int64_t k_size_of_table_1 = 100'000;
    if (points == k_size_of_table_1)
      add_benchmark(1, {"points", question + "_large", name, count}, time_boxes<Index>, points, large_boxes(),
                    function);
  };
  if constexpr (requires { &Index::box_count; }) add_boxes("box_count", &Index::box_count);
  if constexpr (requires { &Index::box_ids; }) add_boxes("box_ids", &Index::box_ids);
}

template <class Index>
void register_index(std::string_view name, std::int64_t points) {
  register_build<Index>(name, points);
  register_questions<Index>(name, points);
}

inline constexpr std::int64_t k_point_sizes[] = {100'000, 1'000'000, 10'000'000};

}  // namespace alidade::bench
