// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>

#include "cloud/sorted_points.h"
#include "tests/support/point_families.h"

namespace alidade {
namespace {

/// Positions by (wide Morton key, row), the slow way.
std::vector<std::pair<WideMortonKey, std::uint32_t>> expected_order(
    const KeySpace& space, const std::vector<LatticePosition>& positions) {
  std::vector<std::pair<WideMortonKey, std::uint32_t>> order;
  for (std::uint32_t row = 0; row < positions.size(); ++row) {
    Steps steps;
    for (int axis = 0; axis < 3; ++axis) {
      steps[axis] =
          static_cast<std::uint32_t>(positions[row][axis]) - static_cast<std::uint32_t>(space.base[axis]);
    }
    order.emplace_back(wide_morton_key(steps[0], steps[1], steps[2]), row);
  }
  std::ranges::sort(order);
  return order;
}

template <class Entry>
void expect_order(const SortedPoints<Entry>& sorted,
                  const std::vector<std::pair<WideMortonKey, std::uint32_t>>& order) {
  ASSERT_EQ(sorted.size(), order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    ASSERT_TRUE(WideMortonKey{sorted[i].key()} == order[i].first) << i;
    ASSERT_EQ(sorted[i].id, order[i].second) << i;
  }
}

/// The positions from a scratch file, in chunks of a few thousand.
template <class Entry>
SortedPoints<Entry> sorted_in_scratch(const KeySpace& space, const std::vector<LatticePosition>& positions) {
  ScratchFile file(testing::TempDir());
  file.append(std::as_bytes(std::span(positions)));
  const std::span<std::byte> bytes = file.map();
  return sort_points<Entry>(space, {reinterpret_cast<LatticePosition*>(bytes.data()), positions.size()},
                            {testing::TempDir(), 1 << 18});
}

void check(const std::vector<LatticePosition>& positions) {
  const KeySpace space = key_space(positions);
  const auto order = expected_order(space, positions);
  expect_order(sort_points<WideEntry>(space, positions), order);
  std::vector<LatticePosition> given = positions;
  expect_order(sort_points<WideEntry>(space, std::move(given)), order);
  EXPECT_TRUE(given.empty());  // NOLINT(bugprone-use-after-move): that is the contract
  expect_order(sorted_in_scratch<WideEntry>(space, positions), order);
  if (!space.is_narrow()) return;
  expect_order(sorted_in_scratch<NarrowEntry>(space, positions), order);
  expect_order(sort_points<NarrowEntry>(space, positions), order);
  given = positions;
  expect_order(sort_points<NarrowEntry>(space, std::move(given)), order);
  EXPECT_TRUE(given.empty());  // NOLINT(bugprone-use-after-move)
}

TEST(SortedPoints, stand_in_the_order_of_key_and_row_on_every_family) {
  for (const test::PointFamily& family : test::point_families()) {
    SCOPED_TRACE(family.name);
    if (family.cloud.size() > 0) check(family.cloud.positions);
  }
}

TEST(SortedPoints, stand_in_order_however_they_are_distributed) {
  constexpr int k_count = 300000;  // many chunks and buckets
  test::Random random;
  const auto sorted = [&](const char* name, const auto& position) {
    SCOPED_TRACE(name);
    std::vector<LatticePosition> positions;
    for (int i = 0; i < k_count; ++i) positions.push_back(position(i));
    check(positions);
  };
  const auto below = [&](std::uint64_t limit) { return static_cast<std::int32_t>(random.below(limit)); };
  sorted("uniform", [&](int) { return LatticePosition(below(400000), below(400000), below(400000)); });
  sorted("wide", [&](int) { return LatticePosition(below(9000000), below(9000000), below(50)); });
  sorted("whole lattice", [&](int) { return LatticePosition(random.bits(), random.bits(), random.bits()); });
  sorted("one position", [&](int) { return LatticePosition(7, 8, 9); });
  sorted("mostly one position", [&](int i) {
    return i % 10 != 0 ? LatticePosition(500, 500, 500)
                       : LatticePosition(below(1000), below(1000), below(1000));
  });
  sorted("three positions", [&](int) { return LatticePosition(below(3), 0, 0); });
  sorted("an outlier", [&](int i) {
    return i == 5 ? LatticePosition(2000000000, -2000000000, 0)
                  : LatticePosition(below(3000), below(3000), 0);
  });
  sorted("already in order", [&](int i) { return LatticePosition(i, 0, 0); });
  sorted("in opposite order", [&](int i) { return LatticePosition(-i, -i, 0); });
  // The evenly spaced samples are not representative of the others.
  sorted("hidden from the samples", [&](int i) {
    return i % (k_count / 144) == 0 ? LatticePosition(i, 0, 0)
                                    : LatticePosition(below(100), below(100), 1 << 20);
  });
}

}  // namespace
}  // namespace alidade
