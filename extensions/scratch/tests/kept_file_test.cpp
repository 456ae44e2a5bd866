// SPDX-License-Identifier: MIT
#include "extensions/scratch/kept_file.h"

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

namespace alidade {
namespace {

class KeptFileTest : public ::testing::Test {
 protected:
  KeptFileTest() : folder_(std::filesystem::path(testing::TempDir()) / "kept_file_test") {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directory(folder_);
  }
  ~KeptFileTest() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
};

TEST_F(KeptFileTest, with_a_name_stays_and_loses_nothing_to_its_map) {
  const std::filesystem::path path = folder_ / "rows";
  const std::vector<std::byte> sevens(10'000, std::byte{7});
  {
    KeptFile file(path, 0);
    file.append(sevens);
    file.sync();
  }
  {
    KeptFile file(path, 9'000);
    const std::span<std::byte> map = file.map();
    ASSERT_EQ(map.size(), 9'000u);
    discard_scratch_pages(map);
    EXPECT_EQ(map[5'000], std::byte{7});
  }
  EXPECT_EQ(std::filesystem::file_size(path), 9'000u);
  KeptFile file(path, 8'000), other(folder_);
  file.append_zeros(1);
  other = std::move(file);
  std::array<std::byte, 2> found{};
  other.read(7'999, found);
  EXPECT_EQ(found, (std::array<std::byte, 2>{std::byte{7}, std::byte{0}}));
  other.read(0, found);
  EXPECT_EQ(found[0], std::byte{7});
  EXPECT_THROW(KeptFile(path, 8'002), Error);
}

TEST_F(KeptFileTest, with_a_name_is_mapped_even_if_it_exceeds_the_memory) {
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
  KeptFile file(path, bytes);
  EXPECT_EQ(file.map().size(), bytes);
  EXPECT_EQ(file.map()[bytes - 1], std::byte{0});
}

TEST_F(KeptFileTest, with_a_name_has_a_checksum_of_its_bytes_however_they_came) {
  const std::vector<std::byte> sevens(3'000'000, std::byte{7});
  const std::filesystem::path path = folder_ / "a";
  KeptFile one(path, 0), other(folder_ / "b", 0);
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
  EXPECT_EQ(KeptFile(path, 5'000'000).checksum(), sum);
  {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(1'234'567).put('\0');
  }
  EXPECT_NE(KeptFile(path, 5'000'000).checksum(), sum);
}

TEST_F(KeptFileTest, with_a_name_follows_no_link) {
  std::ofstream(folder_ / "precious") << "text";
  std::filesystem::create_symlink("precious", folder_ / "rows");
  EXPECT_THROW(KeptFile(folder_ / "rows", 0), Error);
  EXPECT_EQ(std::filesystem::file_size(folder_ / "precious"), 4u);
}

}  // namespace
}  // namespace alidade
