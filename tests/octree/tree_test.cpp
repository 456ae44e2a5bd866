// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstring>
#include <limits>
#include <optional>

#include "base/morton.h"
#include "octree/build.h"
#include "tests/octree/tree_check.h"
#include "tests/support/point_families.h"

namespace alidade {
namespace {

using test::point_families;
using test::PointFamily;

constexpr Organisation k_organisations[] = {Organisation::adaptive, Organisation::fixed,
                                            Organisation::layered};

PointCloud cloud_on(const Lattice& lattice, std::vector<LatticePosition> positions) {
  PointCloud cloud;
  cloud.lattice = lattice;
  cloud.positions = std::move(positions);
  return cloud;
}

TEST(Octree, holds_every_point_once_without_loss_in_boxes_that_fit) {
  for (const PointFamily& family : point_families()) {
    for (const Organisation organisation : k_organisations) {
      for (const int leaf_size : {1, 5, k_max_leaf_size}) {
        SCOPED_TRACE(family.name + " organisation " + std::to_string(static_cast<int>(organisation)) +
                     " leaf size " + std::to_string(leaf_size));
        BuildOptions options;
        options.organisation = organisation;
        options.leaf_size = leaf_size;
        const Octree octree = build(family.cloud, options);
        EXPECT_EQ(octree.view().organisation, organisation);
        EXPECT_EQ(octree.bounds().min, family.cloud.bounds().min);
        EXPECT_EQ(octree.bounds().max, family.cloud.bounds().max);
        test::TreeCheck(octree.view(), family.cloud, leaf_size).run();
        if (HasFatalFailure() || HasNonfatalFailure()) return;
      }
    }
  }
}

TEST(Octree, holds_points_at_all_ends_of_the_lattice) {
  constexpr std::int32_t k_low = std::numeric_limits<std::int32_t>::min(),
                         k_high = std::numeric_limits<std::int32_t>::max();
  test::Random random;
  std::vector<LatticePosition> positions;
  for (int i = 0; i < 8000; ++i) {
    const auto near = [&](bool at_high) {
      const auto step = static_cast<std::int32_t>(random.below(3000));
      return at_high ? k_high - step : k_low + step;
    };
    positions.emplace_back(near(i & 1), near(i & 2), near(i & 4));
  }
  for (int i = 0; i < 8; ++i)
    positions.emplace_back(i & 1 ? k_high : k_low, i & 2 ? k_high : k_low, i & 4 ? k_high : k_low);
  const PointCloud cloud = cloud_on({glm::dvec3(0.001), glm::dvec3(0)}, positions);
  for (const Organisation organisation : k_organisations) {
    SCOPED_TRACE(static_cast<int>(organisation));
    BuildOptions options;
    options.organisation = organisation;
    const Octree octree = build(cloud, options);
    EXPECT_EQ(octree.view().root_level, 32);
    test::TreeCheck(octree.view(), cloud, options.leaf_size).run();
  }
}

TEST(Octree, exact_positions_stand_beside_sparse_leaves_only) {
  test::Random random;
  // A dense patch, far outliers: without outliers it would take 17 bits per axis, with them 32.
  std::vector<LatticePosition> positions;
  for (int i = 0; i < 100000; ++i) {
    positions.emplace_back(random.below(100000), random.below(100000), random.below(100));
  }
  for (int i = 0; i < 10; ++i) positions.emplace_back(random.bits(), random.bits(), random.bits());
  const PointCloud cloud = cloud_on({glm::dvec3(0.001), glm::dvec3(0)}, positions);
  const Octree octree = build(cloud);
  EXPECT_EQ(octree.view().root_level, 32);
  EXPECT_GE(octree.view().exact_count(), 10u);
  EXPECT_LT(octree.view().exact_count(), 40u);
  EXPECT_LT(static_cast<double>(octree.memory()) / static_cast<double>(octree.size()), 11.8);
}

void expect_same_bytes(const TreeView& a, const TreeView& b) {
  ASSERT_EQ(a.node_count, b.node_count);
  ASSERT_EQ(a.point_count, b.point_count);
  EXPECT_EQ(a.root_level, b.root_level);
  EXPECT_EQ(a.level_count, b.level_count);
  ASSERT_EQ(a.exact_count(), b.exact_count());
  if (a.point_count == 0) return;
  EXPECT_EQ(std::memcmp(a.nodes, b.nodes, a.node_count * sizeof(Node)), 0);
  EXPECT_EQ(std::memcmp(a.ids, b.ids, a.point_count * sizeof(std::uint32_t)), 0);
  EXPECT_EQ(std::memcmp(a.coordinates, b.coordinates,
                        (3 * a.point_count + k_coordinate_padding) * sizeof(std::uint16_t)),
            0);
  if (a.exact_count() > 0) {
    EXPECT_EQ(std::memcmp(a.positions, b.positions, a.exact_count() * sizeof(LatticePosition)), 0);
  }
}

TEST(Octree, is_the_same_bytes_on_any_number_of_threads) {
  for (const std::int32_t width : {50000, 4000000, 2000000000}) {
    test::Random random("threads" + std::to_string(width));
    std::vector<LatticePosition> positions;
    for (int i = 0; i < 150000; ++i) {
      // Half of them in a corner, many at equal positions.
      const std::uint64_t extent = i % 2 == 0 ? width : 40 + width / 1000;
      positions.emplace_back(random.below(extent), random.below(extent), random.below(40));
    }
    const PointCloud cloud = cloud_on({glm::dvec3(0.001), glm::dvec3(0)}, positions);
    for (const Organisation organisation : k_organisations) {
      SCOPED_TRACE(std::to_string(width) + " organisation " + std::to_string(static_cast<int>(organisation)));
      BuildOptions options;
      options.organisation = organisation;
      std::optional<Octree> first;
      for (const std::size_t threads : {1, 2, 4}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        const Octree octree = build(cloud, options);
        if (!first) first = octree;
        expect_same_bytes(first->view(), octree.view());
      }
    }
  }
}

TEST(Octree, building_from_a_cloud_that_is_given_away_empties_its_positions_only) {
  for (PointFamily& family : point_families()) {
    SCOPED_TRACE(family.name);
    const Octree kept = build(family.cloud);
    family.cloud.classifications.resize(family.cloud.size(), 2);
    const Octree taken = build(std::move(family.cloud));
    EXPECT_TRUE(family.cloud.positions.empty());
    EXPECT_EQ(family.cloud.classifications.size(), taken.size());
    expect_same_bytes(kept.view(), taken.view());
  }
}

TEST(Octree, takes_about_eleven_bytes_per_point_on_a_scanned_surface) {
  test::Random random;
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 200000; ++i) {
    positions.push_back({random.between(0, 100), random.between(0, 100), random.between(0, 0.02)});
  }
  const Octree octree = build(test::make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0)}));
  EXPECT_LT(static_cast<double>(octree.memory()) / static_cast<double>(octree.size()), 11.6);
}

TEST(Octree, a_leaf_size_out_of_range_is_an_error) {
  const PointCloud cloud = test::make_cloud({{0, 0, 0}}, {glm::dvec3(0.001), glm::dvec3(0)});
  BuildOptions options;
  for (const int leaf_size : {-1, 0, 33}) {
    options.leaf_size = leaf_size;
    EXPECT_THROW(build(cloud, options), Error);
  }
}

TEST(Octree, a_cell_size_out_of_range_is_an_error) {
  const PointCloud cloud = test::make_cloud({{0, 0, 0}}, {glm::dvec3(0.001), glm::dvec3(0)});
  BuildOptions options;
  options.organisation = Organisation::fixed;
  for (const double cell_size :
       {-1.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    options.cell_size = cell_size;
    EXPECT_THROW(build(cloud, options), Error);
  }
}

TEST(Octree, a_progress_callback_that_says_stop_cancels_the_build) {
  const PointCloud cloud = test::make_cloud({{0, 0, 0}}, {glm::dvec3(0.001), glm::dvec3(0)});
  BuildOptions options;
  options.progress = [](std::uint64_t, std::uint64_t) { return false; };
  EXPECT_THROW(build(cloud, options), Cancelled);
}

TEST(Morton, interleaving_is_undone_exactly) {
  test::Random random;
  for (int i = 0; i < 10000; ++i) {
    const auto x = static_cast<std::uint32_t>(random.below(1u << 21)),
               y = static_cast<std::uint32_t>(random.below(1u << 21)),
               z = static_cast<std::uint32_t>(random.below(1u << 21));
    const std::uint64_t key = morton_key(x, y, z);
    ASSERT_EQ(morton_coordinate(key, 0), x);
    ASSERT_EQ(morton_coordinate(key, 1), y);
    ASSERT_EQ(morton_coordinate(key, 2), z);
  }
  EXPECT_EQ(morton_key(1, 0, 0), 1u);
  EXPECT_EQ(morton_key(0, 1, 0), 2u);
  EXPECT_EQ(morton_key(0, 0, 1), 4u);
  EXPECT_EQ(morton_key(0x1fffff, 0x1fffff, 0x1fffff), 0x7fffffffffffffffu);
}

TEST(Morton, wide_keys_hold_all_bits_in_the_same_order) {
  test::Random random;
  for (int i = 0; i < 10000; ++i) {
    const auto x = static_cast<std::uint32_t>(random.bits()), y = static_cast<std::uint32_t>(random.bits()),
               z = static_cast<std::uint32_t>(random.bits());
    const WideMortonKey key = wide_morton_key(x, y, z);
    ASSERT_EQ(morton_coordinate(key, 0), x);
    ASSERT_EQ(morton_coordinate(key, 1), y);
    ASSERT_EQ(morton_coordinate(key, 2), z);
    ASSERT_EQ(wide_morton_key(x & 0x1fffff, y & 0x1fffff, z & 0x1fffff), morton_key(x, y, z));
    const int bit = static_cast<int>(random.below(96));
    ASSERT_EQ(highest_bit(WideMortonKey{1} << bit | (key & ((WideMortonKey{1} << bit) - 1))), bit);
  }
  EXPECT_EQ(highest_bit(WideMortonKey{0}), -1);
  EXPECT_EQ(highest_bit(std::uint64_t{0}), -1);
}

}  // namespace
}  // namespace alidade
