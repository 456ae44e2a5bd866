// SPDX-License-Identifier: MIT
#include "cloud/copc/copc_file.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/copc/copc_builder.h"

namespace alidade {
namespace {

using test::build_copc;
using test::CopcSample;
using test::error_of;

CopcFile open(const std::vector<std::byte>& bytes) {
  return CopcFile(InputFile(bytes, "memory"));
}

template <class T>
std::string error_with(std::size_t offset, T value) {
  CopcSample sample = build_copc(500);
  std::memcpy(sample.bytes.data() + offset, &value, sizeof value);
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

TEST(CopcHierarchyTest, nodes_are_ordered_by_level_and_each_is_child_of_its_parent) {
  const CopcSample sample = build_copc(3000);
  const CopcFile file = open(sample.bytes);
  const std::vector<CopcNode>& nodes = file.hierarchy().nodes;
  EXPECT_EQ(nodes[0].key, CopcKey{});
  std::set<std::uint32_t> met = {0};
  for (const CopcNode& node : nodes) {
    for (const std::uint32_t child : file.hierarchy().children_of(node)) {
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
    for (const std::uint32_t child : file.hierarchy().children_of(node)) {
      const Bounds inner = file.bounds(file.hierarchy().nodes[child]), outer = file.bounds(node);
      EXPECT_TRUE(outer.contains(inner.min) && outer.contains(inner.max));
    }
  }
}

TEST(CopcHierarchyTest,
     a_node_without_parent_hangs_below_the_smallest_cube_around_it_and_no_others_are_made) {
  CopcSample sample = build_copc(500);
  // The root's entry is somewhere in the page; its chunk becomes that of a deep node without relatives.
  for (std::size_t offset = sample.pages_offset; offset < sample.bytes.size(); offset += 32) {
    std::int32_t level = 0;
    std::memcpy(&level, sample.bytes.data() + offset, 4);
    if (level != 0) continue;
    const std::int32_t key[4] = {20, 1000, 2000, 3000};
    std::memcpy(sample.bytes.data() + offset, key, sizeof key);
  }
  const CopcFile file = open(sample.bytes);
  const CopcHierarchy& hierarchy = file.hierarchy();
  EXPECT_EQ(hierarchy.nodes[0].key, CopcKey{});
  EXPECT_EQ(hierarchy.nodes[0].chunk.point_count, 0u);
  EXPECT_EQ(hierarchy.levels(), 21);
  EXPECT_EQ(hierarchy.nodes.size(), sample.keys.size() + 1);
  // The deep one is the last.
  CopcKey above = hierarchy.nodes.back().key;
  while (std::ranges::find(hierarchy.nodes, above.parent(), &CopcNode::key) == hierarchy.nodes.end())
    above = above.parent();
  const auto parent = std::ranges::find(hierarchy.nodes, above.parent(), &CopcNode::key);
  EXPECT_EQ(hierarchy.children_of(*parent).back(), hierarchy.nodes.size() - 1);
}

TEST(CopcHierarchyTest, pages_may_be_anywhere) {
  // A second page takes over all entries; the first keeps one that points to it.
  CopcSample sample = build_copc(500);
  const std::vector<std::byte> page(sample.bytes.begin() + static_cast<std::ptrdiff_t>(sample.pages_offset),
                                    sample.bytes.end());
  const std::uint64_t second = sample.bytes.size();
  sample.bytes.insert(sample.bytes.end(), page.begin(), page.end());
  const auto put = [&](std::size_t offset, auto value) {
    std::memcpy(sample.bytes.data() + offset, &value, sizeof value);
  };
  for (std::size_t i = 0; i < 4; ++i) put(sample.pages_offset + 4 * i, std::int32_t{0});
  put(sample.pages_offset + 16, second);
  put(sample.pages_offset + 24, static_cast<std::int32_t>(page.size()));
  put(sample.pages_offset + 28, std::int32_t{-1});
  put(sample.info_offset + 48, std::uint64_t{32});
  EXPECT_EQ(open(sample.bytes).hierarchy().nodes.size(), sample.keys.size());

  // Now it points to itself.
  put(sample.pages_offset + 16, std::uint64_t{sample.pages_offset});
  put(sample.pages_offset + 24, std::int32_t{32});
  EXPECT_TRUE(contains(error_of([&] { open(sample.bytes); }),
                       "page of the COPC hierarchy referenced more than once; expected one reference, found "
                       "a second one from byte " +
                           std::to_string(sample.pages_offset)));
}

TEST(CopcHierarchyTest, pages_may_be_long_and_have_nodes_without_points) {
  CopcSample sample = build_copc(500);
  const std::int32_t deepest = open(sample.bytes).hierarchy().levels();
  constexpr std::int32_t k_empty = 5000;
  for (std::int32_t i = 0; i < k_empty; ++i) {
    const std::int32_t entry[8] = {deepest + 12, i, 0, 0, 0, 0, 0, 0};
    const auto bytes = std::as_bytes(std::span(entry));
    sample.bytes.insert(sample.bytes.end(), bytes.begin(), bytes.end());
  }
  const std::uint64_t size = sample.bytes.size() - sample.pages_offset;
  std::memcpy(sample.bytes.data() + sample.info_offset + 48, &size, sizeof size);
  const CopcFile file = open(sample.bytes);
  EXPECT_EQ(file.hierarchy().nodes.size(), sample.keys.size() + k_empty);
  EXPECT_EQ(file.hierarchy().children.size(), sample.keys.size() + k_empty - 1);
}

TEST(CopcHierarchyTest, pages_that_overlap_are_not_read_for_ever) {
  // Every entry points to a page that begins a byte behind the one before.
  CopcSample sample = build_copc(500);
  const std::size_t page_size = sample.bytes.size() - sample.pages_offset;
  const auto put = [&](std::size_t offset, auto value) {
    std::memcpy(sample.bytes.data() + offset, &value, sizeof value);
  };
  const std::size_t entries = page_size / 32, most = sample.bytes.size() / 32 * 32 - 64 * entries;
  for (std::size_t i = 0; i < entries; ++i) {
    put(sample.pages_offset + 32 * i + 16, std::uint64_t{i + 1});
    put(sample.pages_offset + 32 * i + 24, static_cast<std::int32_t>(most));
    put(sample.pages_offset + 32 * i + 28, std::int32_t{-1});
  }
  EXPECT_TRUE(
      contains(error_of([&] { open(sample.bytes); }), "the pages of the COPC hierarchy exceed the file"));
}

TEST(CopcHierarchyTest, records_that_cannot_be_true_are_errors) {
  const std::size_t info = 429;
  EXPECT_TRUE(contains(error_with(info, std::nan("")), "byte 429: invalid centre"));
  EXPECT_TRUE(contains(error_with(info + 24, 0.0), "byte 453: invalid size of the COPC octree"));
  EXPECT_TRUE(
      contains(error_with(info + 24, static_cast<double>(INFINITY)), "invalid size of the COPC octree"));
  EXPECT_TRUE(contains(error_with(info + 24, 1e308), "invalid size of the COPC octree"));
  EXPECT_TRUE(contains(error_with(info + 32, -1.0), "invalid spacing"));
  EXPECT_TRUE(contains(error_with(info + 48, std::uint64_t{0}), "invalid page"));
  EXPECT_TRUE(contains(error_with(info + 48, std::uint64_t{33}), "invalid page"));
  EXPECT_TRUE(contains(error_with(info + 40, std::uint64_t{1} << 60), "invalid page"));
  CopcSample wide = build_copc(100);
  const double far[4] = {0.0, -1.7e308, 0.0, 5e307};  // centre and half of the side
  std::memcpy(wide.bytes.data() + info, far, sizeof far);
  EXPECT_TRUE(contains(error_of([&] { open(wide.bytes); }), "byte 437: invalid centre"));
}

TEST(CopcHierarchyTest, entries_that_cannot_be_true_are_errors) {
  const std::size_t entry = build_copc(500).pages_offset;
  EXPECT_TRUE(contains(error_with(entry, std::int32_t{-1}), "invalid key"));
  EXPECT_TRUE(contains(error_with(entry, std::int32_t{31}), "invalid key"));
  EXPECT_TRUE(contains(error_with(entry + 4, std::int32_t{-1}), "invalid key"));
  EXPECT_TRUE(contains(error_with(entry + 12, std::int32_t{1 << 30}), "invalid key"));
  EXPECT_TRUE(contains(error_with(entry + 28, std::int32_t{-2}), "invalid number of points"));
  EXPECT_TRUE(contains(error_with(entry + 28, std::int32_t{9999}), "does not match a chunk of the file"));
  EXPECT_TRUE(contains(error_with(entry + 28, std::int32_t{0}),
                       "the COPC hierarchy does not reference a chunk of the file"));
  EXPECT_TRUE(contains(error_with(entry + 16, std::uint64_t{1000}), "does not match a chunk of the file"));
  EXPECT_TRUE(contains(error_with(entry + 24, std::int32_t{-5}), "does not match a chunk of the file"));
  CopcSample twice = build_copc(500);
  std::memcpy(twice.bytes.data() + twice.pages_offset, twice.bytes.data() + twice.pages_offset + 32, 16);
  EXPECT_TRUE(contains(error_of([&] { open(twice.bytes); }), "expected one with points, found "));
}

/// What holds for every hierarchy that is not an error: it is a tree with all points of the file once, in
/// chunks inside the file.
void expect_sound(const CopcFile& file, std::size_t bytes) {
  const CopcHierarchy& hierarchy = file.hierarchy();
  std::uint64_t points = 0;
  std::set<std::uint64_t> rows;
  std::set<std::uint32_t> met = {0};
  for (const CopcNode& node : hierarchy.nodes) {
    points += node.chunk.point_count;
    if (node.chunk.point_count > 0) EXPECT_TRUE(rows.insert(node.first_row).second);
    EXPECT_LE(node.chunk.offset + node.chunk.byte_count, bytes);
    EXPECT_LE(node.first_row + node.chunk.point_count, file.header().point_count);
    for (const std::uint32_t child : hierarchy.children_of(node)) {
      ASSERT_LT(child, hierarchy.nodes.size());
      EXPECT_GT(hierarchy.nodes[child].key.level, node.key.level);
      EXPECT_TRUE(met.insert(child).second);
    }
  }
  EXPECT_EQ(points, file.header().point_count);
  EXPECT_EQ(met.size(), hierarchy.nodes.size());
}

TEST(CopcHierarchyTest, every_flipped_bit_of_pages_and_record_is_an_error_or_harmless) {
  CopcSample sample = build_copc(300);
  int rejected = 0, read = 0;
  const auto flip = [&](std::size_t offset) {
    SCOPED_TRACE(offset);
    const std::byte bit = static_cast<std::byte>(1u << (offset * 5 % 8));
    sample.bytes[offset] ^= bit;
    try {
      expect_sound(open(sample.bytes), sample.bytes.size());
      ++read;
    } catch (const Error& error) {
      EXPECT_EQ(error.parts().file, "memory") << error.what();
      ++rejected;
    }
    sample.bytes[offset] ^= bit;
  };
  for (std::size_t offset = sample.info_offset; offset < sample.info_offset + 160; ++offset) flip(offset);
  // The bytes after the record's numbers are unused, and some flipped bits of a centre or a spacing give
  // another valid one.
  EXPECT_GT(read, 100);
  EXPECT_GT(rejected, 10);
  rejected = read = 0;
  for (std::size_t offset = sample.pages_offset; offset < sample.bytes.size(); ++offset) flip(offset);
  // A node's key may become that of another cube; no number of points, offset or size of a chunk may change.
  EXPECT_GE(rejected, 16 * static_cast<int>(sample.keys.size()));
}

TEST(CopcFileTest, chunks_are_found_without_a_table_and_a_warning_says_so) {
  CopcSample sample = build_copc(500);
  EXPECT_TRUE(open(sample.bytes).warnings().empty());
  std::uint32_t points_offset = 0;
  std::memcpy(&points_offset, sample.bytes.data() + 96, 4);
  std::memset(sample.bytes.data() + points_offset, 0, 8);
  const CopcFile file = open(sample.bytes);
  EXPECT_EQ(file.hierarchy().nodes.size(), sample.keys.size());
  ASSERT_EQ(file.warnings().size(), 1u);
  EXPECT_TRUE(contains(file.warnings()[0], "memory: missing offset of the chunk table"));
}

TEST(CopcFileTest, other_files_are_no_copc) {
  const std::vector<std::byte> laz = test::build_laz(test::sample_las(4, 7));
  EXPECT_FALSE(is_copc(laz));
  EXPECT_TRUE(contains(error_of([&] { open(laz); }), "not a COPC 1.0 file"));
  const CopcSample sample = build_copc(100);
  EXPECT_TRUE(is_copc(sample.bytes));
}

}  // namespace
}  // namespace alidade
