// SPDX-License-Identifier: MIT
#include "base/reorder_records.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <numeric>
#include <random>
#include <vector>

namespace alidade {
namespace {

constexpr std::size_t k_record = 5;

/// Its number in the first four bytes.
std::vector<std::byte> records_of(std::size_t count) {
  std::vector<std::byte> bytes(count * k_record, std::byte{9});
  for (std::uint32_t i = 0; i < count; ++i) std::memcpy(bytes.data() + i * k_record, &i, sizeof i);
  return bytes;
}

void expect_order(std::size_t count, std::uint64_t memory) {
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::shuffle(order, std::mt19937(3));
  ScratchFile file(testing::TempDir());
  file.append(records_of(count));
  std::vector<std::byte> found;
  reorder_records(file, k_record, order, {testing::TempDir(), memory}, [&](std::span<const std::byte> piece) {
    ASSERT_EQ(piece.size() % k_record, 0u);
    found.insert(found.end(), piece.begin(), piece.end());
  });
  ASSERT_EQ(found.size(), count * k_record);
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t number;
    std::memcpy(&number, found.data() + i * k_record, sizeof number);
    ASSERT_EQ(number, order[i]);
    ASSERT_EQ(found[i * k_record + 4], std::byte{9});
  }
}

TEST(ReorderRecords, come_in_the_new_order_whatever_the_memory) {
  // All at once; in parts of 52,428 records; in parts of 3,276, with the rows in three lots; in 367 parts of
  // 409.
  for (const std::uint64_t memory : {1 << 24, 1 << 19, 1 << 15, 1 << 12}) expect_order(150'000, memory);
}

TEST(ReorderRecords, may_be_few_or_none) {
  for (const std::size_t count : {0, 1, 2, 7}) {
    expect_order(count, 0);
    expect_order(count, 1 << 20);
  }
}

}  // namespace
}  // namespace alidade
