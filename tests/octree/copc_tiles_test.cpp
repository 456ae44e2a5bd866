// SPDX-License-Identifier: MIT
#include "octree/copc_tiles.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <cstring>
#include <random>

#include "cloud/catalog.h"
#include "octree/brute_force.h"
#include "octree/build.h"
#include "octree/explained_query.h"
#include "octree/query_targets.h"
#include "octree/tree_query.h"
#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/copc/copc_builder.h"
#include "tests/support/same_hits.h"

// Answers from many COPC files, each opened when a query enters it, against brute force over the cloud of all
// of them.

namespace alidade {
namespace {

using test::build_copc;
using test::CopcSample;
using test::error_of;

/// Files in a row, whose offsets are not sums of powers of two, so that other roundings would be found out.
class CopcTilesTest : public ::testing::Test {
 protected:
  static constexpr double k_step = 127.007;

  void add(std::size_t points, std::uint64_t seed) {
    CopcSample sample = build_copc(points, 40, seed);
    for (const std::size_t byte : {std::size_t{155}, sample.info_offset}) {
      double x = 0.0;
      std::memcpy(&x, sample.bytes.data() + byte, sizeof x);
      x += k_step * static_cast<double>(samples_.size());
      std::memcpy(sample.bytes.data() + byte, &x, sizeof x);
    }
    samples_.push_back(std::move(sample));
  }

  void add_some() {
    const std::size_t counts[] = {300, 1, 900, 400, 50, 700, 2, 300, 500, 600, 1, 800};
    for (std::size_t i = 0; i < std::size(counts); ++i) add(counts[i], i + 1);
  }

  /// With what a catalog would state, or not.
  CloudInputs inputs(bool is_stated = true) const {
    CloudInputs clouds;
    for (const CopcSample& sample : samples_) {
      CloudInput input =
          cloud_in_memory(sample.bytes, "tile_" + std::to_string(clouds.inputs.size()) + ".copc.laz");
      if (is_stated) {
        const PointCloud points = test::read_memory(sample.bytes);
        input.stated =
            std::make_shared<const StatedFile>(StatedFile{"a catalog", points.bounds(), points.size()});
      }
      clouds.inputs.push_back(std::move(input));
    }
    return clouds;
  }

  template <class Target, class Query>
  static ::testing::AssertionResult as_brute_force(const CopcTiles& tiles, const PointCloud& cloud,
                                                   const Target& target, const Query& query) {
    const auto tree_target = make_target(target, query, 0);
    Nearest neighbors(tree_target, query.k);
    tree_query(CopcTilesTree(tiles), tree_target, neighbors);
    const auto found = neighbors.in_order();
    const auto expected = brute_force::find(cloud, target, query);
    return test::same_hits(std::span(found), std::span(expected));
  }

  /// A vertical ray in the middle of a file.
  static Ray down(int tile) { return make_ray({690000 + k_step * tile, 5325000, 600}, {0, 0, -1}, 0.0); }

  std::vector<CopcSample> samples_;
};

TEST_F(CopcTilesTest, answers_equal_brute_force_over_all_files) {
  add_some();
  const PointCloud cloud = read_cloud(inputs());
  std::mt19937_64 engine(5);
  const auto number = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(engine);
  };
  const auto position = [&] {
    return glm::dvec3(690000 + number(-100, 12 * k_step), 5325000 + number(-70, 70), 500 + number(-50, 50));
  };
  const auto direction = [&] { return glm::dvec3(number(-1, 1), number(-0.2, 0.2), number(-0.1, 0.1)); };
  for (const std::size_t room : {std::size_t{1} << 30, std::size_t{60'000}}) {
    for (const bool is_stated : {true, false}) {
      const CopcTiles tiles(inputs(is_stated), {.byte_count = room});
      EXPECT_EQ(tiles.point_count(), cloud.size());
      EXPECT_EQ(tiles.lattice(), cloud.lattice);
      for (int i = 0; i < 10; ++i) {
        const Ray ray = make_ray(position(), direction());
        EXPECT_TRUE(as_brute_force(tiles, cloud, ray, RayQuery{.radius = 5.0}));
        EXPECT_TRUE(
            as_brute_force(tiles, cloud, ray, RayQuery{.radius = 9.0, .measure = Measure::t, .k = 3}));
        EXPECT_TRUE(as_brute_force(tiles, cloud, ray, RayQuery{.measure = Measure::distance, .k = 5}));
        EXPECT_TRUE(as_brute_force(tiles, cloud, position(), PointQuery{.k = 9}));
        const glm::dvec3 corner = position();
        EXPECT_TRUE(as_brute_force(tiles, cloud, Bounds{corner, corner + 90.0}, PointQuery{}));
      }
    }
  }
}

/// Batches whose work is counted, over an octree or tiles, beside those of the octree.
template <class Target, class Index, class Query>
void expect_explained(const Octree& octree, const Index& index, const std::vector<Target>& targets,
                      const Query& query) {
  using Explained = ExplainedQuery<Target, Index>;
  const auto expected = find(octree, targets, query);
  QueryStatistics work;
  const auto found = Explained::find(index, targets, query, k_all, work);
  EXPECT_EQ(found.begin, expected.begin);
  EXPECT_TRUE(found.all == expected.all);
  EXPECT_GE(work.nodes_visited, targets.size());
  const auto first = Explained::find(index, targets, query, 1, work);
  for (std::size_t i = 0; i < targets.size(); ++i)
    EXPECT_EQ(first[i].size(), std::min<std::size_t>(expected[i].size(), 1));
  std::vector<std::size_t> counts(targets.size()), expected_counts(targets.size());
  const std::uint64_t before = work.points_tested;
  Explained::count(index, targets, query, counts, work);
  EXPECT_GT(work.points_tested, before);
  count(octree, targets, query, expected_counts);
  EXPECT_EQ(counts, expected_counts);
}

TEST_F(CopcTilesTest, explained_batches_have_the_answers_of_the_octree_of_all_files) {
  add_some();
  const Octree octree = build(read_cloud(inputs()));
  const CopcTiles tiles(inputs(), {.byte_count = 60'000});
  std::vector<Ray> rays;
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 40; ++i) {
    positions.emplace_back(690000 + 37 * i, 5325000 - i, 480);
    rays.push_back(make_ray(positions.back() + glm::dvec3(0, 0, 100), {0.1, 0.02 * i, -1}));
  }
  for (const RayQuery& query : {RayQuery{.radius = 5.0}, RayQuery{.radius = 5.0, .k = 1}}) {
    expect_explained(octree, tiles, rays, query);
    expect_explained(octree, octree, rays, query);
  }
  expect_explained(octree, tiles, positions, PointQuery{.k = 9});
  expect_explained(octree, octree, positions, PointQuery{.radius = 20.0});
}

TEST_F(CopcTilesTest, only_files_that_are_entered_are_opened) {
  add_some();
  CloudInputs clouds = inputs();
  for (std::size_t i = 0; i < clouds.size(); ++i)
    if (i != 0 && i != 5)
      clouds.inputs[i] = {.name = "/nowhere/tile.copc.laz", .stated = clouds.inputs[i].stated};
  const PointCloud cloud = read_cloud(inputs());
  const CopcTiles tiles(clouds, {});
  EXPECT_TRUE(as_brute_force(tiles, cloud, down(5), RayQuery{.radius = 20.0}));
  const CopcTiles::Work work = tiles.work();
  EXPECT_EQ(work.files_opened, 2u);
  EXPECT_GT(work.reads.points_decoded, 0u);
  EXPECT_LE(work.reads.points_decoded, 700u);
  EXPECT_NE(
      error_of([&] { as_brute_force(tiles, cloud, down(6), RayQuery{.radius = 200.0}); }).find("/nowhere"),
      std::string::npos);
}

TEST_F(CopcTilesTest, many_threads_with_little_room_answer_the_same) {
  add_some();
  const PointCloud cloud = read_cloud(inputs());
  const CopcTiles tiles(inputs(), {.byte_count = 40'000});
  std::atomic<int> wrong = 0;
  tbb::parallel_for(0, 200, [&](int i) {
    if (!as_brute_force(tiles, cloud, down(i * 5 % 12), RayQuery{.radius = 12.0})) ++wrong;
  });
  EXPECT_EQ(wrong, 0);
}

TEST_F(CopcTilesTest, files_that_do_not_belong_together_are_errors_when_they_are_opened) {
  add(300, 1);
  add(300, 2);
  const PointCloud cloud = read_cloud(inputs());
  const auto error = [&](const CloudInputs& clouds) {
    return error_of([&] {
      const CopcTiles tiles(clouds, {});
      as_brute_force(tiles, cloud, down(1), RayQuery{.radius = 20.0});
    });
  };
  CloudInputs clouds = inputs();
  StatedFile stated = *clouds.inputs[1].stated;
  stated.point_count = 299;
  clouds.inputs[1].stated = std::make_shared<const StatedFile>(stated);
  EXPECT_NE(error(clouds).find("tile_1.copc.laz: a catalog states another number of points"),
            std::string::npos);
  stated.point_count = 300;
  stated.box.max.x -= 60;
  clouds.inputs[1].stated = std::make_shared<const StatedFile>(stated);
  EXPECT_NE(error(clouds).find("the point is outside the box that a catalog states"), std::string::npos);
  const double scale = 0.0013;
  std::memcpy(samples_[1].bytes.data() + 131, &scale, sizeof scale);
  EXPECT_NE(error(inputs()).find("the lattice differs"), std::string::npos);
}

TEST_F(CopcTilesTest, files_without_points_are_never_opened) {
  add(200, 1);
  const PointCloud cloud = read_cloud(inputs());
  CloudInputs clouds = inputs();
  const StatedFile none{"a catalog", Bounds{glm::dvec3(-1e9), glm::dvec3(1e9)}, 0};
  const CloudInput empty{.name = "/nowhere/tile.copc.laz",
                         .stated = std::make_shared<const StatedFile>(none)};
  clouds.inputs.insert(clouds.inputs.begin(), empty);
  clouds.inputs.push_back(empty);
  const CopcTiles tiles(clouds, {});
  EXPECT_EQ(tiles.lattice(), cloud.lattice);
  EXPECT_TRUE(as_brute_force(tiles, cloud, down(0), RayQuery{.radius = 20.0}));
}

}  // namespace
}  // namespace alidade
