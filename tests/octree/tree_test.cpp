// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstring>

#include "octree/build.h"
#include "octree/morton.h"
#include "octree/tree_walk.h"
#include "tests/support/point_families.h"

namespace alidade {
namespace {

using test::point_families;
using test::PointFamily;

struct TreeCheck {
  const TreeView& tree;
  const PointCloud& cloud;
  std::vector<int> seen;
  int deepest = 0;

  void visit(const Frame& frame, const Bounds& box, int depth) {
    deepest = std::max(deepest, depth);
    ASSERT_LT(frame.node, tree.node_count);
    ASSERT_GE(frame.level, k_min_frame_level);
    int child_count = 0;
    for (int slot = 0; slot < k_node_width; ++slot) {
      const std::uint8_t kind = tree.nodes[frame.node].kind[slot];
      if (kind == 0) continue;
      ++child_count;
      const Bounds child = child_bounds(tree, frame, slot);
      if (is_inner(kind)) {
        visit(child_frame(tree, frame, slot), child, depth + 1);
      } else {
        check_leaf(child_leaf(tree, frame, slot), child, box);
      }
    }
    ASSERT_GT(child_count, 0);
  }

  void check_leaf(const Leaf& leaf, const Bounds& own, const Bounds& parent) {
    ASSERT_LE(std::uint64_t{leaf.place} + leaf.count, tree.point_count);
    for (std::uint32_t i = 0; i < leaf.count; ++i) {
      const std::uint32_t id = tree.ids[leaf.place + i];
      ASSERT_LT(id, cloud.size());
      ++seen[id];
      ASSERT_EQ(position_of(tree, leaf, i), cloud.positions[id]);
      ASSERT_TRUE(own.contains(cloud.world(id)));
      ASSERT_TRUE(parent.contains(cloud.world(id)));
    }
  }
};

Bounds everything() {
  Bounds bounds;
  bounds.grow(glm::dvec3(-1e300));
  bounds.grow(glm::dvec3(1e300));
  return bounds;
}

TEST(Octree, holds_every_point_once_without_loss_inside_its_boxes) {
  for (const PointFamily& family : point_families()) {
    SCOPED_TRACE(family.name);
    const Octree octree = build(family.cloud);
    ASSERT_EQ(octree.size(), family.cloud.size());
    EXPECT_EQ(octree.bounds().min, family.cloud.bounds().min);
    EXPECT_EQ(octree.bounds().max, family.cloud.bounds().max);
    if (octree.size() == 0) continue;
    TreeCheck check{octree.view(), family.cloud, std::vector<int>(family.cloud.size()), 0};
    check.visit(root_frame(octree.view()), everything(), 1);
    EXPECT_EQ(check.seen, std::vector<int>(family.cloud.size(), 1));
    EXPECT_LE(check.deepest, k_max_tree_depth);
  }
}

TEST(Octree, is_the_same_bytes_on_any_number_of_threads) {
  test::Random random;
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 300000; ++i) positions.push_back(glm::dvec3(50, 50, 5) * random.in_cube());
  const PointCloud cloud = test::make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0)});
  std::optional<Octree> first;
  for (const std::size_t threads : {1, 2, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const Octree octree = build(cloud);
    if (!first) {
      first = octree;
      continue;
    }
    const TreeView &a = first->view(), &b = octree.view();
    ASSERT_EQ(a.node_count, b.node_count);
    EXPECT_EQ(std::memcmp(a.nodes, b.nodes, a.node_count * sizeof(Node)), 0);
    EXPECT_EQ(std::memcmp(a.ids, b.ids, a.point_count * sizeof(std::uint32_t)), 0);
    EXPECT_EQ(std::memcmp(a.coordinates, b.coordinates, 3 * a.point_count * sizeof(std::uint16_t)), 0);
  }
}

TEST(Octree, building_from_a_cloud_that_is_given_away_empties_its_positions_only) {
  for (PointFamily& family : point_families()) {
    const Octree kept = build(family.cloud);
    family.cloud.classifications.resize(family.cloud.size(), 2);
    const Octree taken = build(std::move(family.cloud));
    EXPECT_TRUE(family.cloud.positions.empty()) << family.name;
    EXPECT_EQ(family.cloud.classifications.size(), taken.size()) << family.name;
    ASSERT_EQ(kept.view().node_count, taken.view().node_count) << family.name;
    if (taken.size() == 0) continue;
    EXPECT_EQ(std::memcmp(kept.view().nodes, taken.view().nodes, kept.view().node_count * sizeof(Node)), 0)
        << family.name;
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

}  // namespace
}  // namespace alidade
