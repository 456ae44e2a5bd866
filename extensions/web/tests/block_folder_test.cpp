// SPDX-License-Identifier: MIT
#include "extensions/web/block_folder.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

namespace alidade::test {

using namespace geo;
namespace fs = std::filesystem;

namespace {

constexpr std::size_t k_block = 256, k_head = 24;

class BlockFolderTest : public ::testing::Test {
 protected:
  BlockFolderTest() { fs::remove_all(folder_); }
  ~BlockFolderTest() override { fs::remove_all(folder_); }

  /// So many, each used a second after the one before, all of them long ago.
  void keep_old(BlockFolder& blocks, int count) const {
    const auto long_ago = fs::file_time_type::clock::now() - std::chrono::hours(24);
    std::vector<fs::path> known;
    for (int i = 0; i < count; ++i) {
      blocks.keep(fmt::format("old {}", i), std::vector<std::byte>(k_block));
      for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
        if (entry.path().extension() != ".block" || std::ranges::find(known, entry.path()) != known.end())
          continue;
        fs::last_write_time(entry.path(), long_ago + std::chrono::seconds(i));
        known.push_back(entry.path());
      }
    }
  }

  const fs::path folder_ = fs::temp_directory_path() / "alidade_block_folder";
};

TEST_F(BlockFolderTest, removes_what_was_not_used_for_longest) {
  BlockFolder blocks(folder_, 10 * (k_block + k_head));
  keep_old(blocks, 10);
  // Both are used again, one of them by a reader that finds it damaged, which does not count as a use.
  EXPECT_TRUE(blocks.find("old 0", k_block));
  EXPECT_TRUE(blocks.find("old 2", k_block));
  EXPECT_FALSE(blocks.find("old 3", k_block + 1));
  blocks.keep("new", std::vector<std::byte>(k_block));
  for (int i = 0; i < 10; ++i) {
    const bool is_left = i != 1 && i != 3 && i != 4;
    EXPECT_EQ(blocks.contains(fmt::format("old {}", i)), is_left) << i;
  }
  EXPECT_TRUE(blocks.contains("new"));
}

TEST_F(BlockFolderTest, what_has_room_stays_whatever_else_is_there) {
  constexpr std::uint64_t k_most = 100 * (k_block + k_head);
  std::uint64_t fitting = 0;
  {
    const BlockFolder blocks(folder_, k_most);
    while (blocks.has_room((fitting + 1) * k_block, k_block)) ++fitting;
    // Four fifths of all, with the heads.
    EXPECT_GT(fitting, 70u);
    EXPECT_LE(fitting, 80u);
    EXPECT_TRUE(blocks.has_room(0, k_block));
    EXPECT_FALSE(blocks.has_room(k_most, k_block));
  }
  for (int others = 0; others < 100; others += 7) {
    fs::remove_all(folder_);
    BlockFolder blocks(folder_, k_most);
    keep_old(blocks, others);
    for (std::uint64_t i = 0; i < fitting; ++i)
      blocks.keep(fmt::format("new {}", i), std::vector<std::byte>(k_block));
    blocks.keep("mark", std::vector<std::byte>(8));
    for (std::uint64_t i = 0; i < fitting; ++i)
      ASSERT_TRUE(blocks.find(fmt::format("new {}", i), k_block)) << i << " of " << others;
    ASSERT_TRUE(blocks.find("mark", 8));
  }
}

class WholeCopies : public BlockFolderTest {
 protected:
  static constexpr std::uint64_t k_size = 1000;

  static std::vector<std::byte> bytes_of(const KeptCopy& copy, std::size_t count) {
    std::vector<std::byte> bytes(count);
    bytes.resize(copy.file.read_at(0, bytes));
    return bytes;
  }
  static std::vector<std::byte> part(int value, std::size_t count) {
    return std::vector<std::byte>(count, std::byte(value));
  }
};

TEST_F(WholeCopies, of_an_interrupted_fetch_are_continued) {
  BlockFolder blocks(folder_, 1 << 20);
  EXPECT_EQ(blocks.fetched_of("a", k_size), 0u);
  {
    auto copy = blocks.copy_of("a", k_size);
    ASSERT_TRUE(copy);
    EXPECT_EQ(copy->fetched, 0u);
    blocks.extend(*copy, "a", k_size, part(1, 400));
    // Another process leaves it alone meanwhile.
    EXPECT_FALSE(blocks.copy_of("a", k_size));
  }
  BlockFolder later(folder_, 1 << 20);
  EXPECT_EQ(later.fetched_of("a", k_size), 400u);
  EXPECT_EQ(later.fetched_of("b", k_size), 0u);
  auto copy = later.copy_of("a", k_size);
  ASSERT_TRUE(copy);
  ASSERT_EQ(copy->fetched, 400u);
  later.extend(*copy, "a", k_size, part(2, 600));
  // Complete ones are for everybody.
  const auto again = later.copy_of("a", k_size);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->fetched, k_size);
  std::vector<std::byte> expected = part(1, 400);
  expected.resize(k_size, std::byte{2});
  EXPECT_EQ(bytes_of(*again, k_size), expected);
}

TEST_F(WholeCopies, that_are_damaged_begin_anew) {
  BlockFolder blocks(folder_, 1 << 20);
  {
    auto copy = blocks.copy_of("a", k_size);
    blocks.extend(*copy, "a", k_size, part(1, k_size));
  }
  for (const auto& entry : fs::recursive_directory_iterator(folder_))
    if (entry.path().extension() == ".whole") fs::resize_file(entry.path(), k_size + 3);
  EXPECT_EQ(blocks.fetched_of("a", k_size), 0u);
  const auto copy = blocks.copy_of("a", k_size);
  ASSERT_TRUE(copy);
  EXPECT_EQ(copy->fetched, 0u);
}

TEST_F(WholeCopies, count_for_the_size_of_the_folder) {
  BlockFolder blocks(folder_, 10 * (k_block + k_head));
  EXPECT_FALSE(blocks.copy_of("larger", 10 * (k_block + k_head)));
  keep_old(blocks, 5);
  ASSERT_TRUE(blocks.copy_of("a", 6 * k_block));
  EXPECT_FALSE(blocks.contains("old 0"));
  EXPECT_TRUE(blocks.contains("old 4"));
  for (const auto& entry : fs::recursive_directory_iterator(folder_))
    if (entry.path().extension() == ".whole")
      fs::last_write_time(entry.path(), fs::file_time_type::clock::now() - std::chrono::hours(48));
  keep_old(blocks, 9);
  for (const auto& entry : fs::recursive_directory_iterator(folder_))
    EXPECT_NE(entry.path().extension(), ".whole");
}

}  // namespace
}  // namespace alidade::test
