// SPDX-License-Identifier: MIT
#include "octree/cloud/copc/copc_hierarchy.h"

#include <gtest/gtest.h>

#include <set>

#include "octree/cloud/copc/copc_file.h"
#include "tests/cloud/cloud_test_support.h"
#include "tests/octree/copc_builder.h"

namespace alidade {
namespace {

using test::build_copc;
using test::CopcSample;
using test::error_of;

CopcFile open(const std::vector<std::byte>& bytes) {
  return CopcFile(InputFile(bytes, "memory"));
}

template <class T>
std::string error_with(std::size_t place, T value) {
  CopcSample sample = build_copc(500);
  std::memcpy(sample.bytes.data() + place, &value, sizeof value);
  return error_of([&] { open(sample.bytes); });
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(CopcHierarchyTest, every_node_of_the_file_is_found_with_the_rows_of_its_points) {
  const CopcSample sample = build_copc(3000);
  const CopcFile file = open(sample.bytes);
  const CopcHierarchy& hierarchy = file.hierarchy();
  ASSERT_EQ(hierarchy.nodes.size(), sample.keys.size());
  EXPECT_GE(hierarchy.levels(), 3);
  std::uint64_t row = 0;
  for (std::size_t i = 0; i < sample.keys.size(); ++i) {
    const auto node = std::ranges::find(hierarchy.nodes, sample.keys[i], &CopcNode::key);
    ASSERT_NE(node, hierarchy.nodes.end());
    EXPECT_EQ(node->first_row, row);
    EXPECT_EQ(node->chunk.point_count, sample.counts[i]);
    row += sample.counts[i];
  }
}

TEST(CopcHierarchyTest, nodes_stand_level_by_level_and_each_is_child_of_its_parent) {
  const CopcSample sample = build_copc(3000);
  const CopcFile file = open(sample.bytes);
  const std::vector<CopcNode>& nodes = file.hierarchy().nodes;
  EXPECT_EQ(nodes[0].key, CopcKey{});
  std::set<std::uint32_t> met = {0};
  for (const CopcNode& node : nodes) {
    for (const std::uint32_t child : node.children) {
      if (child == k_no_copc_node) continue;
      EXPECT_EQ(nodes[child].key.parent(), node.key);
      EXPECT_TRUE(met.insert(child).second);
    }
  }
  EXPECT_EQ(met.size(), nodes.size());
}

TEST(CopcHierarchyTest, boxes_hold_those_of_their_children) {
  const CopcSample sample = build_copc(3000);
  const CopcFile file = open(sample.bytes);
  for (const CopcNode& node : file.hierarchy().nodes) {
    for (const std::uint32_t child : node.children) {
      if (child == k_no_copc_node) continue;
      const Bounds inner = file.bounds(file.hierarchy().nodes[child]), outer = file.bounds(node);
      EXPECT_TRUE(outer.contains(inner.min) && outer.contains(inner.max));
    }
  }
}

TEST(CopcHierarchyTest, ancestors_that_are_left_out_are_added) {
  CopcSample sample = build_copc(500);
  // The root's entry stands somewhere in the page; its chunk becomes that of a deep node without relatives.
  for (std::size_t place = sample.pages_place; place < sample.bytes.size(); place += 32) {
    std::int32_t level = 0;
    std::memcpy(&level, sample.bytes.data() + place, 4);
    if (level != 0) continue;
    const std::int32_t key[4] = {20, 1000, 2000, 3000};
    std::memcpy(sample.bytes.data() + place, key, sizeof key);
  }
  const CopcFile file = open(sample.bytes);
  EXPECT_EQ(file.hierarchy().nodes[0].key, CopcKey{});
  EXPECT_EQ(file.hierarchy().nodes[0].chunk.point_count, 0u);
  EXPECT_EQ(file.hierarchy().levels(), 21);
}

TEST(CopcHierarchyTest, pages_may_stand_elsewhere) {
  // A second page takes over all entries; the first keeps one that points to it.
  CopcSample sample = build_copc(500);
  const std::vector<std::byte> page(sample.bytes.begin() + static_cast<std::ptrdiff_t>(sample.pages_place),
                                    sample.bytes.end());
  const std::uint64_t second = sample.bytes.size();
  sample.bytes.insert(sample.bytes.end(), page.begin(), page.end());
  const auto put = [&](std::size_t place, auto value) {
    std::memcpy(sample.bytes.data() + place, &value, sizeof value);
  };
  for (std::size_t i = 0; i < 4; ++i) put(sample.pages_place + 4 * i, std::int32_t{0});
  put(sample.pages_place + 16, second);
  put(sample.pages_place + 24, static_cast<std::int32_t>(page.size()));
  put(sample.pages_place + 28, std::int32_t{-1});
  put(sample.info_place + 48, std::uint64_t{32});
  EXPECT_EQ(open(sample.bytes).hierarchy().nodes.size(), sample.keys.size());

  // Now it points to itself.
  put(sample.pages_place + 16, std::uint64_t{sample.pages_place});
  put(sample.pages_place + 24, std::int32_t{32});
  EXPECT_TRUE(contains(error_of([&] { open(sample.bytes); }), "is met twice"));
}

TEST(CopcHierarchyTest, records_that_cannot_be_true_are_errors) {
  const std::size_t info = 429;
  EXPECT_TRUE(contains(error_with(info, std::nan("")), "byte 429: bad centre"));
  EXPECT_TRUE(contains(error_with(info + 24, 0.0), "byte 453: bad size of the COPC octree"));
  EXPECT_TRUE(contains(error_with(info + 24, static_cast<double>(INFINITY)), "bad size of the COPC octree"));
  EXPECT_TRUE(contains(error_with(info + 32, -1.0), "bad spacing"));
  EXPECT_TRUE(contains(error_with(info + 48, std::uint64_t{0}), "bad page"));
  EXPECT_TRUE(contains(error_with(info + 48, std::uint64_t{33}), "bad page"));
  EXPECT_TRUE(contains(error_with(info + 40, std::uint64_t{1} << 60), "bad page"));
}

TEST(CopcHierarchyTest, entries_that_cannot_be_true_are_errors) {
  const std::size_t entry = build_copc(500).pages_place;
  EXPECT_TRUE(contains(error_with(entry, std::int32_t{-1}), "bad key"));
  EXPECT_TRUE(contains(error_with(entry, std::int32_t{31}), "bad key"));
  EXPECT_TRUE(contains(error_with(entry + 4, std::int32_t{-1}), "bad key"));
  EXPECT_TRUE(contains(error_with(entry + 12, std::int32_t{1 << 30}), "bad key"));
  EXPECT_TRUE(contains(error_with(entry + 28, std::int32_t{-2}), "bad number of points"));
  EXPECT_TRUE(contains(error_with(entry + 28, std::int32_t{9999}), "is no chunk of the file"));
  EXPECT_TRUE(contains(error_with(entry + 28, std::int32_t{0}), "chunk of the file"));
  EXPECT_TRUE(contains(error_with(entry + 16, std::uint64_t{1000}), "is no chunk of the file"));
  EXPECT_TRUE(contains(error_with(entry + 24, std::int32_t{-5}), "is no chunk of the file"));
  CopcSample twice = build_copc(500);
  std::memcpy(twice.bytes.data() + twice.pages_place, twice.bytes.data() + twice.pages_place + 32, 16);
  EXPECT_TRUE(contains(error_of([&] { open(twice.bytes); }), "has two nodes"));
}

TEST(CopcHierarchyTest, every_flipped_bit_of_pages_and_record_is_an_error_or_harmless) {
  CopcSample sample = build_copc(300);
  const auto flip = [&](std::size_t place) {
    const std::byte bit = static_cast<std::byte>(1u << (place * 5 % 8));
    sample.bytes[place] ^= bit;
    try {
      open(sample.bytes);
    } catch (const Error&) {
    }
    sample.bytes[place] ^= bit;
  };
  for (std::size_t place = sample.info_place; place < sample.info_place + 160; ++place) flip(place);
  for (std::size_t place = sample.pages_place; place < sample.bytes.size(); ++place) flip(place);
}

TEST(CopcFileTest, other_files_are_no_copc) {
  const std::vector<std::byte> laz = test::build_laz(test::sample_las(4, 7));
  InputFile file(laz, "memory");
  EXPECT_FALSE(is_copc(file));
  EXPECT_TRUE(contains(error_of([&] { open(laz); }), "is no COPC 1.0"));
  const CopcSample sample = build_copc(100);
  InputFile copc(sample.bytes, "memory");
  EXPECT_TRUE(is_copc(copc));
}

}  // namespace
}  // namespace alidade
