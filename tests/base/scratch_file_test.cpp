// SPDX-License-Identifier: MIT
#include "base/scratch_file.h"

#include <gtest/gtest.h>
#include <sys/sysinfo.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <system_error>
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

TEST_F(ScratchFileTest, with_a_name_stays_and_loses_nothing_to_its_map) {
  const std::filesystem::path path = folder_ / "rows";
  const std::vector<std::byte> sevens(10'000, std::byte{7});
  {
    ScratchFile file(path, 0);
    file.append(sevens);
    file.sync();
  }
  {
    ScratchFile file(path, 9'000);
    const std::span<std::byte> map = file.map();
    ASSERT_EQ(map.size(), 9'000u);
    discard_scratch_pages(map);
    EXPECT_EQ(map[5'000], std::byte{7});
  }
  EXPECT_EQ(std::filesystem::file_size(path), 9'000u);
  ScratchFile file(path, 8'000), other(folder_);
  file.append_zeros(1);
  other = std::move(file);
  std::array<std::byte, 2> found{};
  other.read(7'999, found);
  EXPECT_EQ(found, (std::array<std::byte, 2>{std::byte{7}, std::byte{0}}));
  other.read(0, found);
  EXPECT_EQ(found[0], std::byte{7});
  EXPECT_THROW(ScratchFile(path, 8'002), Error);
}

TEST_F(ScratchFileTest, with_a_name_is_mapped_even_if_it_exceeds_the_memory) {
  const std::filesystem::path path = folder_ / "rows";
  const auto memory = static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
                      static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  struct sysinfo system {};
  ASSERT_EQ(::sysinfo(&system), 0);
  const std::uint64_t bytes = 2 * (memory + system.totalswap * system.mem_unit);
  std::ofstream(path).close();
  std::error_code error;
  std::filesystem::resize_file(path, bytes, error);
  if (error) GTEST_SKIP() << "the file system has no sparse files of this size";
  ScratchFile file(path, bytes);
  EXPECT_EQ(file.map().size(), bytes);
  EXPECT_EQ(file.map()[bytes - 1], std::byte{0});
}

TEST_F(ScratchFileTest, with_a_name_has_a_checksum_of_its_bytes_however_they_came) {
  const std::vector<std::byte> sevens(3'000'000, std::byte{7});
  const std::filesystem::path path = folder_ / "a";
  ScratchFile one(path, 0), other(folder_ / "b", 0);
  one.append(sevens);
  one.append_zeros(2'000'000);
  const std::uint64_t sum = one.checksum();
  for (std::size_t i = 0; i < 10; ++i) other.append(std::span(sevens).subspan(i * 300'000, 300'000));
  const std::uint64_t half = other.checksum();
  EXPECT_NE(half, sum);
  other.append_zeros(2'000'000);
  EXPECT_EQ(other.checksum(), sum);
  other.append_zeros(5);
  other.cut(3'000'000);
  EXPECT_EQ(std::filesystem::file_size(folder_ / "b"), 3'000'000u);
  EXPECT_EQ(other.checksum(), half);
  EXPECT_EQ(ScratchFile(path, 5'000'000).checksum(), sum);
  {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(1'234'567).put('\0');
  }
  EXPECT_NE(ScratchFile(path, 5'000'000).checksum(), sum);
}

TEST_F(ScratchFileTest, with_a_name_follows_no_link) {
  std::ofstream(folder_ / "precious") << "text";
  std::filesystem::create_symlink("precious", folder_ / "rows");
  EXPECT_THROW(ScratchFile(folder_ / "rows", 0), Error);
  EXPECT_EQ(std::filesystem::file_size(folder_ / "precious"), 4u);
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
