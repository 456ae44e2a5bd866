// SPDX-License-Identifier: MIT
// Index files with right checksums and sound links whose contents contradict each other: only verify() finds
// that.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "octree/index_file/check_tree.h"
#include "octree/index_file/index_file.h"
#include "octree/index_file/index_header.h"
#include "octree/index_file/save_index.h"
#include "octree/octree.h"
#include "tests/octree/index_file/damaged_index.h"

namespace alidade {
namespace {

using test::Bytes;
using test::error_of;
using test::get;
using test::in_node;
using test::is_rejected;
using test::k_kind;
using test::put;
using test::seal;
using test::section;
using test::sound_file;

TEST(IndexVerify, points_that_are_in_no_leaf) {
  const PointCloud cloud =
      test::make_cloud(std::vector<glm::dvec3>(300, glm::dvec3(1, 2, 3)), {glm::dvec3(0.001), glm::dvec3(0)});
  const auto path = test::test_folder() / "one_position.alidade";
  save_index(path, build(cloud), cloud);
  Bytes file = test::read_bytes(path);
  std::size_t slot = k_node_width - 1;
  while (get<std::uint8_t>(file, in_node(file, 0, k_kind + slot)) == 0) --slot;
  const std::size_t last = in_node(file, 0, k_kind + slot);
  put<std::uint8_t>(file, last, static_cast<std::uint8_t>(get<std::uint8_t>(file, last) - 1));
  seal(file);
  const std::string message = error_of([&] { test::index_in_memory(file).verify(); });
  EXPECT_NE(message.find("wrong number of points in the leaves; expected 300, found 299"), std::string::npos)
      << message;
}

TEST(IndexVerify, contents_that_contradict_each_other) {
  const auto expect = [](const std::string& part, const auto& change) {
    Bytes file = sound_file();
    change(file);
    seal(file);
    EXPECT_FALSE(is_rejected(file)) << part;
    const std::string message = error_of([&] { test::index_in_memory(file).verify(); });
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  expect("duplicate id", [](Bytes& file) {
    const std::uint64_t offset = section(file, IndexSection::ids).offset;
    put(file, offset, get<std::uint32_t>(file, offset + 4));
  });
  expect("the point is outside the box of its leaf", [](Bytes& file) {
    const std::uint64_t offset = section(file, IndexSection::coordinates).offset;
    put<std::uint16_t>(file, offset, static_cast<std::uint16_t>(get<std::uint16_t>(file, offset) + 30000));
  });
  expect("corrupt section positions", [](Bytes& file) {
    const std::uint64_t offset = section(file, IndexSection::positions).offset;
    put<std::int32_t>(file, offset, get<std::int32_t>(file, offset) ^ 0x40000000);
  });
  expect("wrong largest spacing of slot", [](Bytes& file) {
    const std::uint64_t offset = section(file, IndexSection::slot_spacings).offset;
    put<std::uint16_t>(file, offset, static_cast<std::uint16_t>(get<std::uint16_t>(file, offset) + 1));
  });
  expect("wrong largest spacing of slot", [](Bytes& file) {
    const std::uint64_t offset = section(file, IndexSection::spacings).offset;
    put<std::uint16_t>(file, offset + 100, 0x7f80);
  });
  for (const std::uint16_t spacing : {0x0000, 0x7f81, 0xbf80}) {
    expect("the spacing is not positive",
           [&](Bytes& file) { put(file, section(file, IndexSection::spacings).offset + 100, spacing); });
  }
  expect("wrong bounds of the points", [](Bytes& file) { put(file, 136, get<double>(file, 136) - 1.0); });
  expect("wrong bounds of the points", [](Bytes& file) { put(file, 160, get<double>(file, 160) + 1.0); });
  expect("levels", [](Bytes& file) { put<std::uint32_t>(file, 60, get<std::uint32_t>(file, 60) + 1); });
}

TEST(IndexVerify, different_spacings_at_one_position) {
  const PointCloud cloud =
      test::make_cloud(std::vector<glm::dvec3>(300, glm::dvec3(1, 2, 3)), {glm::dvec3(0.001), glm::dvec3(0)});
  const auto path = test::test_folder() / "one_position.alidade";
  save_index(path, with_spacings(build(cloud), 2), cloud);
  Bytes file = test::read_bytes(path);
  const std::uint64_t offset = section(file, IndexSection::spacings).offset;
  put<std::uint16_t>(file, offset + 10, 0x3f80);
  seal(file);
  const std::string message = error_of([&] { test::index_in_memory(file).verify(); });
  EXPECT_NE(message.find("points with equal positions have different spacings"), std::string::npos)
      << message;
}

TEST(IndexVerify, lower_ids_behind_higher_ones_at_one_position) {
  const PointCloud cloud =
      test::make_cloud(std::vector<glm::dvec3>(300, glm::dvec3(1, 2, 3)), {glm::dvec3(0.001), glm::dvec3(0)});
  const auto path = test::test_folder() / "one_position.alidade";
  save_index(path, build(cloud), cloud);
  Bytes file = test::read_bytes(path);
  EXPECT_NO_THROW(test::index_in_memory(file).verify());
  const std::size_t ids = section(file, IndexSection::ids).offset;
  // Within a leaf any order will do.
  put<std::uint32_t>(file, ids, 1);
  put<std::uint32_t>(file, ids + 4, 0);
  seal(file);
  EXPECT_NO_THROW(test::index_in_memory(file).verify());
  put<std::uint32_t>(file, ids, 299);
  put<std::uint32_t>(file, ids + 4 * 299, 1);
  seal(file);
  const std::string message = error_of([&] { test::index_in_memory(file).verify(); });
  EXPECT_NE(message.find("slots with equal positions are not sorted by id: slot"), std::string::npos)
      << message;
}

TEST(IndexVerify, coordinates_beside_exact_positions) {
  Bytes file = sound_file();
  const std::uint64_t first_exact = get<std::uint32_t>(file, 132);
  const std::uint64_t offset =
      section(file, IndexSection::coordinates).offset + 3 * sizeof(std::uint16_t) * first_exact;
  put<std::uint16_t>(file, offset, static_cast<std::uint16_t>(get<std::uint16_t>(file, offset) ^ 1));
  seal(file);
  const std::string message = error_of([&] { test::index_in_memory(file).verify(); });
  EXPECT_NE(message.find("the coordinates do not match the exact position"), std::string::npos) << message;
  EXPECT_NE(message.find(fmt::format("byte {}:", offset)), std::string::npos) << message;
}

// With ids, two equal ones would be found first.
TEST(IndexVerify, a_point_in_two_leaves_of_a_tree_without_ids) {
  Node nodes[2] = {};
  for (Node& node : nodes)
    for (auto& row : node.high) std::ranges::fill(row, std::uint8_t{255});
  nodes[0].kind[0] = 1;
  nodes[0].kind[1] = k_inner_kind;
  nodes[0].first_child = 1;
  nodes[1].kind[0] = 1;
  const std::vector<std::uint16_t> coordinates(6 + k_coordinate_padding);
  TreeView tree;
  tree.lattice = {glm::dvec3(1.0), glm::dvec3(0.0)};
  tree.point_count = tree.node_count = 2;
  tree.level_count = 2;
  tree.bounds.grow(glm::dvec3(0.0));
  tree.nodes = nodes;
  tree.coordinates = coordinates.data();
  const auto fault = find_misplaced_point(tree, {});
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->problem, "storage index 0 is in two leaves");
  nodes[1].first_point = 1;
  EXPECT_FALSE(find_misplaced_point(tree, {}));
}

TEST(IndexVerify, a_box_of_any_child_beyond_the_box_of_its_parent) {
  Node nodes[2] = {};
  for (Node& node : nodes) {
    for (auto& row : node.low) std::ranges::fill(row, std::uint8_t{1});
    for (auto& row : node.high) std::ranges::fill(row, std::uint8_t{9});
  }
  nodes[0].kind[0] = k_inner_kind;
  nodes[0].first_child = 1;
  std::ranges::fill(nodes[1].kind, std::uint8_t{1});
  const std::vector<std::uint16_t> coordinates(3 * k_node_width + k_coordinate_padding, 5);
  TreeView tree;
  tree.lattice = {glm::dvec3(1.0), glm::dvec3(0.0)};
  tree.point_count = k_node_width;
  tree.node_count = tree.level_count = 2;
  tree.bounds.grow(glm::dvec3(5.0));
  tree.nodes = nodes;
  tree.coordinates = coordinates.data();
  EXPECT_FALSE(find_misplaced_point(tree, {}));
  for (int slot = 0; slot < k_node_width; ++slot) {
    for (int axis = 0; axis < 3; ++axis) {
      for (std::uint8_t* const side : {&nodes[1].low[axis][slot], &nodes[1].high[axis][slot]}) {
        const std::uint8_t sound = *side;
        *side = sound == 1 ? 0 : 10;
        const auto fault = find_misplaced_point(tree, {});
        ASSERT_TRUE(fault) << slot << " " << axis;
        EXPECT_EQ(fault->problem, "its box in slot 0 does not contain the boxes of its child");
        *side = sound;
      }
    }
  }
}

}  // namespace
}  // namespace alidade
