// SPDX-License-Identifier: MIT
#include "octree/copc_tree.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <numeric>
#include <random>

#include "octree/brute_force.h"
#include "octree/query_targets.h"
#include "octree/tree_query.h"
#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/copc/copc_builder.h"
#include "tests/support/same_hits.h"

// Answers from a COPC file in place against brute force over the cloud that is read from it.

namespace alidade {
namespace {

using test::build_copc;
using test::CopcSample;

struct Opened {
  explicit Opened(const std::vector<std::byte>& bytes, const CopcCache::Options& options = {})
      : file(InputFile(bytes, "memory")), cache(file, options) {}
  CopcFile file;
  CopcCache cache;
};

template <class Target, class Query>
auto find_in(const CopcCache& cache, const Target& target, const Query& query,
             QueryStatistics* statistics = nullptr) {
  const auto tree_target = make_target(target, query, 0);
  Nearest neighbors(tree_target, query.k);
  const QueryStatistics work = tree_query(CopcTree(cache), tree_target, neighbors);
  if (statistics != nullptr) *statistics = work;
  return neighbors.in_order();
}

template <class Target, class Query>
::testing::AssertionResult as_brute_force(const CopcCache& cache, const PointCloud& cloud,
                                          const Target& target, const Query& query) {
  const auto found = find_in(cache, target, query);
  const auto expected = brute_force::find(cloud, target, query);
  return test::same_hits(std::span(found), std::span(expected));
}

class RandomTargets {
 public:
  explicit RandomTargets(std::uint64_t seed) : engine_(seed) {}
  double number(double low, double high) { return std::uniform_real_distribution(low, high)(engine_); }
  /// In the cube or beside it.
  glm::dvec3 position() {
    const auto offset = [&] { return number(-80, 80); };
    return glm::dvec3(690000, 5325000, 500) + glm::dvec3(offset(), offset(), offset());
  }
  glm::dvec3 direction() { return {number(-1, 1), number(-1, 1), number(-1, 1)}; }

 private:
  std::mt19937_64 engine_;
};

TEST(CopcTreeTest, answers_equal_brute_force_over_the_loaded_cloud) {
  const CopcSample sample = build_copc(4000);
  const PointCloud cloud = test::read_memory(sample.bytes);
  const Opened opened(sample.bytes);
  RandomTargets random(7);
  for (int i = 0; i < 60; ++i) {
    const Ray ray =
        make_ray(random.position(), random.direction(), random.number(-50, 0), random.number(0, 200));
    for (const Measure measure : {Measure::distance, Measure::t, Measure::entry}) {
      EXPECT_TRUE(as_brute_force(opened.cache, cloud, ray, RayQuery{.radius = 2.0, .measure = measure}));
      EXPECT_TRUE(
          as_brute_force(opened.cache, cloud, ray, RayQuery{.radius = 5.0, .measure = measure, .k = 3}));
    }
    EXPECT_TRUE(as_brute_force(opened.cache, cloud, ray, RayQuery{.measure = Measure::distance, .k = 5}));
    const Cone cone = make_cone(random.position(), random.direction(), 0.1, 0.5, 0.0, 150.0);
    EXPECT_TRUE(as_brute_force(opened.cache, cloud, cone, ConeQuery{}));
    const Path path = make_path(std::vector{random.position(), random.position(), random.position()});
    EXPECT_TRUE(as_brute_force(opened.cache, cloud, path, PathQuery{.radius = 3.0}));
    const glm::dvec3 corner = random.position();
    EXPECT_TRUE(as_brute_force(opened.cache, cloud, Bounds{corner, corner + 20.0}, PointQuery{}));
    EXPECT_TRUE(as_brute_force(opened.cache, cloud, random.position(), PointQuery{.k = 9}));
    EXPECT_TRUE(as_brute_force(opened.cache, cloud, random.position(), PointQuery{.radius = 12.0}));
    const HalfSpaces region{{make_plane(random.position(), random.direction()),
                             make_plane(random.position(), random.direction())}};
    EXPECT_TRUE(as_brute_force(opened.cache, cloud, region, PointQuery{}));
  }
}

TEST(CopcTreeTest, chunks_that_cannot_matter_are_not_decoded) {
  const CopcSample sample = build_copc(4000);
  const Opened opened(sample.bytes);
  QueryStatistics work;
  const glm::dvec3 origin(690000, 5325000, 500);
  find_in(opened.cache, make_ray(origin + glm::dvec3(30, 30, 60), {0, 0, -1}, 0.0),
          RayQuery{.radius = 0.5, .measure = Measure::entry}, &work);
  const CopcReads reads = opened.cache.reads();
  EXPECT_GT(reads.chunks_decoded, 0u);
  EXPECT_LT(reads.chunks_decoded, sample.keys.size() / 3);
  EXPECT_EQ(reads.chunks_met, reads.chunks_decoded);
  EXPECT_LT(work.points_tested, 4000u / 4);
}

TEST(CopcTreeTest, points_asked_for_again_are_not_decoded_again_while_there_is_room) {
  const CopcSample sample = build_copc(2000);
  const Bounds everything{glm::dvec3(0), glm::dvec3(1e7)};
  {
    const Opened opened(sample.bytes);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(find_in(opened.cache, everything, PointQuery{}).size(), 2000u);
    EXPECT_EQ(opened.cache.reads().chunks_decoded, sample.keys.size());
    EXPECT_EQ(opened.cache.reads().points_decoded, 2000u);
  }
  const Opened narrow(sample.bytes, {.byte_count = 1});
  for (int i = 0; i < 3; ++i) EXPECT_EQ(find_in(narrow.cache, everything, PointQuery{}).size(), 2000u);
  EXPECT_EQ(narrow.cache.reads().chunks_decoded, 3 * sample.keys.size());
  EXPECT_EQ(narrow.cache.reads().chunks_met, sample.keys.size());
}

TEST(CopcTreeTest, what_is_kept_has_no_more_bytes_than_there_is_room_for) {
  const CopcSample sample = build_copc(4000);
  const Opened all(sample.bytes);
  std::vector<std::size_t> sizes;
  for (std::uint32_t node = 0; node < sample.keys.size(); ++node)
    sizes.push_back(all.cache.points(node)->byte_count());
  const std::size_t room = std::accumulate(sizes.begin(), sizes.end(), std::size_t{0}) / 3;
  const Opened opened(sample.bytes, {.byte_count = room});
  for (std::uint32_t node = 0; node < sizes.size(); ++node) opened.cache.points(node);
  // The last are kept, one more than fit is not.
  std::size_t kept = 0;
  auto node = static_cast<std::uint32_t>(sizes.size());
  do {
    opened.cache.points(--node);
    kept += sizes[node];
  } while (opened.cache.reads().chunks_decoded == sizes.size());
  EXPECT_GT(kept, room);
  EXPECT_LE(kept - sizes[node], room);
}

TEST(CopcTreeTest, asking_ends_when_the_progress_function_says_so) {
  const CopcSample sample = build_copc(2000);
  std::vector<std::uint64_t> done;
  CopcCache::Options options;
  options.progress = [&](std::uint64_t points, std::uint64_t of) {
    EXPECT_EQ(of, 2000u);
    done.push_back(points);
    return done.size() < 3;
  };
  const Opened opened(sample.bytes, options);
  EXPECT_THROW(find_in(opened.cache, Bounds{glm::dvec3(0), glm::dvec3(1e7)}, PointQuery{}), Cancelled);
  ASSERT_EQ(done.size(), 3u);
  EXPECT_EQ(done.back(), opened.cache.reads().points_decoded);
}

TEST(CopcTreeTest, many_threads_with_little_room_answer_the_same) {
  const CopcSample sample = build_copc(3000);
  const PointCloud cloud = test::read_memory(sample.bytes);
  const Opened opened(sample.bytes, {.byte_count = 4000});
  tbb::parallel_for(0, 100, [&](int i) {
    RandomTargets random(static_cast<std::uint64_t>(i));
    const glm::dvec3 position = random.position();
    EXPECT_TRUE(as_brute_force(opened.cache, cloud, position, PointQuery{.radius = 20.0}));
  });
}

TEST(CopcTreeTest, only_points_of_the_classes_are_there) {
  const CopcSample sample = build_copc(1000);
  const PointCloud cloud = test::read_memory(sample.bytes);
  std::bitset<256> classes;
  for (std::size_t i = 0; i < 60; ++i) classes.set(i);
  const Opened opened(sample.bytes, {.classes = classes});
  const auto wanted = [&](const Candidate& point) { return cloud.classifications[point.point_id] < 60; };
  RandomTargets random(3);
  for (int i = 0; i < 50; ++i) {
    const glm::dvec3 position = random.position();
    const auto found = find_in(opened.cache, position, PointQuery{.k = 7});
    const auto expected = brute_force::find(cloud, position, PointQuery{.k = 7, .filter = wanted});
    EXPECT_TRUE(test::same_hits(std::span(found), std::span(expected)));
  }
}

TEST(CopcTreeTest, points_outside_the_cube_of_their_node_are_an_error_when_they_are_read) {
  CopcSample sample = build_copc(1000);
  // The octree moves by half a metre: most nodes then have points outside.
  double centre = 0;
  std::memcpy(&centre, sample.bytes.data() + sample.info_offset, 8);
  centre += 0.5;
  std::memcpy(sample.bytes.data() + sample.info_offset, &centre, 8);
  const Opened opened(sample.bytes);
  const std::string error = test::error_of([&] {
    find_in(opened.cache, Bounds{glm::dvec3(0), glm::dvec3(1e7)}, PointQuery{});
  });
  EXPECT_NE(error.find("the point is outside the cube of its node; expected a position from (6"),
            std::string::npos)
      << error;
  EXPECT_NE(error.find(", found (6"), std::string::npos) << error;
  EXPECT_NE(error.find("memory:COPC node "), std::string::npos);
}

TEST(CopcTreeTest, damaged_chunks_are_an_error_that_names_the_node) {
  CopcSample sample = build_copc(1000);
  const CopcFile sound(InputFile(sample.bytes, "memory"));
  const CopcNode& root = sound.hierarchy().nodes[0];
  std::memset(sample.bytes.data() + root.chunk.offset + 36, 0xff, 4);  // the count in the chunk
  const Opened opened(sample.bytes);
  const std::string error = test::error_of([&] {
    find_in(opened.cache, Bounds{glm::dvec3(0), glm::dvec3(1e7)}, PointQuery{});
  });
  EXPECT_NE(error.find("memory:COPC node 0-0-0-0"), std::string::npos) << error;
}

TEST(BoxedPointsTest, boxes_hold_their_points_and_rows_stay_with_them) {
  std::mt19937_64 engine(5);
  for (const std::size_t count : {0u, 1u, 16u, 17u, 129u, 5000u}) {
    std::vector<LatticePosition> positions;
    std::vector<std::uint32_t> rows;
    for (std::size_t i = 0; i < count; ++i) {
      positions.emplace_back(static_cast<std::int32_t>(engine()), static_cast<std::int32_t>(engine()),
                             static_cast<std::int32_t>(engine()));
      rows.push_back(static_cast<std::uint32_t>(i));
    }
    const BoxedPoints points(positions, rows);
    ASSERT_EQ(points.size(), count);
    std::size_t group = BoxedPoints::k_block_points;
    for (int level = 0; level < points.levels(); ++level, group *= BoxedPoints::k_fan_out) {
      EXPECT_EQ(points.boxes(level).capacity(), points.boxes(level).size());
      for (std::size_t i = 0; i < count; ++i) {
        const BoxedPoints::Box& box = points.boxes(level)[i / group];
        EXPECT_TRUE(glm::all(glm::lessThanEqual(box.low, points.positions()[i])) &&
                    glm::all(glm::lessThanEqual(points.positions()[i], box.high)));
      }
    }
    std::vector<bool> met(count);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(points.positions()[i], positions[points.rows()[i]]);
      met[points.rows()[i]] = true;
    }
    EXPECT_EQ(std::count(met.begin(), met.end(), true), static_cast<std::ptrdiff_t>(count));
    if (count == 0) continue;
    EXPECT_LE(points.boxes(points.levels() - 1).size(), BoxedPoints::k_fan_out);
  }
}

TEST(CopcSharedDataTest, a_file_from_elsewhere_answers_as_when_it_is_loaded) {
  const std::filesystem::path path = test::shared_data("lidar_rgb/lion_takanawa.copc.laz");
  if (path.empty()) GTEST_SKIP() << test::k_no_shared_data;
  const PointCloud cloud = read_cloud(path);
  const CopcFile file{InputFile(path)};
  const CopcCache cache(file, {});
  const Bounds box = cloud.bounds();
  RandomTargets random(11);
  const auto inside = [&] {
    return box.min +
           (box.max - box.min) * glm::dvec3(random.number(0, 1), random.number(0, 1), random.number(0, 1));
  };
  for (int i = 0; i < 20; ++i) {
    const Ray ray = make_ray(inside(), random.direction(), -10.0, 10.0);
    EXPECT_TRUE(as_brute_force(cache, cloud, ray, RayQuery{.radius = 0.02}));
    EXPECT_TRUE(as_brute_force(cache, cloud, inside(), PointQuery{.k = 20}));
  }
}

}  // namespace
}  // namespace alidade
