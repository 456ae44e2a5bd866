// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "base/huge_memory.h"
#include "tests/support/random.h"

namespace alidade {
namespace {

TEST(HugeArray, is_aligned_and_holds_what_is_written) {
  for (const std::size_t size : {std::size_t{1}, std::size_t{1000}, (std::size_t{1} << 18) - 1,
                                 std::size_t{1} << 18, (std::size_t{1} << 20) + 17}) {
    HugeArray<std::uint64_t> array(size);
    const auto address = reinterpret_cast<std::uintptr_t>(array.data());
    EXPECT_EQ(address % (size * 8 >= std::size_t{1} << 21 ? std::size_t{1} << 21 : 64), 0u) << size;
    for (std::size_t i = 0; i < size; ++i) array[i] = i * i;
    HugeArray<std::uint64_t> moved = std::move(array);
    EXPECT_EQ(moved.size(), size);
    EXPECT_EQ(array.size(), 0u);  // NOLINT(bugprone-use-after-move): that is the contract
    for (std::size_t i = 0; i < size; ++i) ASSERT_EQ(moved[i], i * i);
    moved = HugeArray<std::uint64_t>(3);
    EXPECT_EQ(moved.size(), 3u);
  }
}

TEST(HugeArray, without_values_has_no_memory) {
  EXPECT_EQ(HugeArray<int>().data(), nullptr);
  EXPECT_EQ(HugeArray<int>(0).data(), nullptr);
}

TEST(PageRelease, leaves_alone_what_is_not_used_up) {
  constexpr std::size_t k_block = std::size_t{1} << 16, k_piece = 1000;
  test::Random random;
  // Begins and ends inside a block, as a vector's memory does.
  HugeArray<std::uint8_t> array(40 * k_block);
  std::uint8_t* const memory = array.data() + 4096;
  const std::size_t size = 40 * k_block - 8192;
  for (std::size_t i = 0; i < size; ++i) memory[i] = static_cast<std::uint8_t>(i % 251 + 1);
  PageRelease release(memory, size, k_block);
  std::vector<std::size_t> pieces;
  for (std::size_t first = 0; first < size; first += k_piece) pieces.push_back(first);
  std::vector<bool> used(size);
  const auto use_up = [&](std::size_t first) {
    const std::size_t count = std::min(k_piece, size - first);
    release.use_up(first, count);
    for (std::size_t i = first; i < first + count; ++i) used[i] = true;
  };
  while (pieces.size() > 200) {
    const std::size_t i = random.below(pieces.size());
    std::swap(pieces[i], pieces.back());
    use_up(pieces.back());
    pieces.pop_back();
  }
  for (std::size_t i = 0; i < size; ++i) {
    if (!used[i]) {
      ASSERT_EQ(memory[i], i % 251 + 1);
    }
  }
  for (const std::size_t first : pieces) use_up(first);
  // Whole blocks have gone back to the system, which gives zeros when they are touched again.
  EXPECT_EQ(memory[20 * k_block], 0);
  EXPECT_EQ(memory[0], 1);
}

TEST(PageRelease, smaller_memory_than_a_block_stays) {
  std::vector<std::uint8_t> memory(5000, 3);
  PageRelease release(memory.data(), memory.size(), std::size_t{1} << 16);
  release.use_up(0, memory.size());
  EXPECT_EQ(memory, std::vector<std::uint8_t>(5000, 3));
}

}  // namespace
}  // namespace alidade
