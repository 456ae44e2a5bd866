// SPDX-License-Identifier: MIT
#include "base/scratch_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <vector>

#include "base/error.h"
#include "base/huge_memory.h"

namespace alidade {
namespace {

class ScratchFileTest : public ::testing::Test {
 protected:
  ScratchFileTest() : folder_(std::filesystem::path(testing::TempDir()) / "scratch_file_test") {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directory(folder_);
  }
  ~ScratchFileTest() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
};

TEST_F(ScratchFileTest, keeps_what_was_appended) {
  ScratchFile file(folder_);
  EXPECT_EQ(file.size(), 0u);
  EXPECT_TRUE(file.map().empty());
  const std::array<std::byte, 3> bytes{std::byte{1}, std::byte{2}, std::byte{3}};
  file.append(bytes);
  file.append_zeros(5000);
  file.append(bytes);
  ASSERT_EQ(file.size(), 5006u);
  std::array<std::byte, 4> found{};
  file.read(5002, found);
  EXPECT_EQ(found, (std::array<std::byte, 4>{std::byte{0}, std::byte{1}, std::byte{2}, std::byte{3}}));
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

TEST_F(ScratchFileTest, changes_where_its_map_changes) {
  ScratchFile first(folder_);
  first.append_zeros(10'000);
  ScratchFile file = std::move(first);
  const std::span<std::byte> map = file.map();
  ASSERT_EQ(map.size(), 10'000u);
  map[9'999] = std::byte{7};
  std::array<std::byte, 1> found{};
  file.read(9'999, found);
  EXPECT_EQ(found[0], std::byte{7});
  // Whole pages go; what shares a page with others stays.
  map[0] = map[5000] = std::byte{8};
  discard_scratch_pages(map.subspan(1, 9'000));
  EXPECT_EQ(map[0], std::byte{8});
  EXPECT_EQ(map[5000], std::byte{0});
  EXPECT_EQ(map[9'999], std::byte{7});
  discard_scratch_pages(map);
  EXPECT_EQ(map[5000], std::byte{0});
}

TEST_F(ScratchFileTest, names_the_folder_that_it_cannot_write_to) {
  ScratchFile file(folder_ / "missing");
  try {
    file.append_zeros(1);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("missing"), std::string::npos) << error.what();
  }
  EXPECT_THROW(map_scratch_pages(1 << 22, folder_ / "missing"), Error);
}

TEST_F(ScratchFileTest, holds_large_arrays) {
  constexpr std::size_t k_size = std::size_t{1} << 20;
  HugeArray<std::uint64_t> array(k_size, folder_);
  for (std::size_t i = 0; i < k_size; ++i) array[i] = i;
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
  PageRelease release(array.data(), k_size * sizeof(std::uint64_t), 1 << 16, true);
  release.use_up(0, 4 << 20);
  EXPECT_EQ(array[0], 0u);
  EXPECT_EQ(array[1000], 0u);
  EXPECT_EQ(array[k_size - 1], k_size - 1);
  HugeArray<std::uint8_t> small(100, folder_ / "missing");
  small[99] = 1;
}

TEST_F(ScratchFileTest, holds_large_vectors_and_what_they_are_moved_and_copied_to) {
  constexpr std::size_t k_size = std::size_t{1} << 20;
  const auto lies_in_file = [](const HugeVector<float>& values) {
    std::ifstream maps("/proc/self/maps");
    for (std::string line; std::getline(maps, line);) {
      std::uint64_t begin = 0, end = 0;
      if (std::sscanf(line.c_str(), "%lx-%lx", &begin, &end) != 2) continue;
      const auto address = reinterpret_cast<std::uint64_t>(values.data());
      if (begin <= address && address < end) return line.find("(deleted)") != std::string::npos;
    }
    return false;
  };
  HugeVector<float> values(k_size, 7.0f, ScratchFolder(folder_));
  EXPECT_TRUE(lies_in_file(values));
  EXPECT_EQ(values.back(), 7.0f);
  HugeVector<float> moved;
  moved = std::move(values);
  moved.push_back(8.0f);
  EXPECT_TRUE(lies_in_file(moved));
  EXPECT_TRUE(lies_in_file(HugeVector<float>(moved)));
  EXPECT_EQ(moved[0], 7.0f);
  EXPECT_FALSE(lies_in_file(HugeVector<float>(k_size, 7.0f)));
  EXPECT_THROW(HugeVector<float>(k_size, 7.0f, ScratchFolder(folder_ / "missing")), Error);
}

}  // namespace
}  // namespace alidade
