// SPDX-License-Identifier: MIT
#include "octree/boxed_points.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <utility>

#include "octree/morton.h"

namespace alidade {
namespace {

void grow(BoxedPoints::Box& box, const LatticePosition& min, const LatticePosition& max) {
  for (int axis = 0; axis < 3; ++axis) {
    box.min[axis] = std::min(box.min[axis], min[axis]);
    box.max[axis] = std::max(box.max[axis], max[axis]);
  }
}

struct SortedPoint {
  std::uint64_t key;
  std::uint32_t place;

  bool operator<(const SortedPoint& other) const {
    return key != other.key ? key < other.key : place < other.place;
  }
};

/// Order along the curve, on the finest grid of 2^21 cells per axis that holds all points.
std::vector<SortedPoint> morton_order(const std::vector<LatticePosition>& positions) {
  BoxedPoints::Box all{positions[0], positions[0]};
  for (const LatticePosition& position : positions) grow(all, position, position);
  std::uint32_t longest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    longest = std::max(longest,
                       static_cast<std::uint32_t>(all.max[axis]) - static_cast<std::uint32_t>(all.min[axis]));
  }
  const int shift = std::max(0, static_cast<int>(std::bit_width(longest)) - k_morton_bits);
  std::vector<SortedPoint> order(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const auto cell = [&](int axis) {
      return (static_cast<std::uint32_t>(positions[i][axis]) - static_cast<std::uint32_t>(all.min[axis])) >>
             shift;
    };
    order[i] = {morton_key(cell(0), cell(1), cell(2)), static_cast<std::uint32_t>(i)};
  }
  std::sort(order.begin(), order.end());
  return order;
}

}  // namespace

BoxedPoints::BoxedPoints(std::vector<LatticePosition> positions, std::vector<std::uint32_t> rows) {
  assert(positions.size() == rows.size());
  if (positions.empty()) return;
  positions_.reserve(positions.size());
  rows_.reserve(rows.size());
  for (const SortedPoint& point : morton_order(positions)) {
    positions_.push_back(positions[point.place]);
    rows_.push_back(rows[point.place]);
  }
  std::vector<Box>& blocks = boxes_.emplace_back();
  blocks.reserve((positions_.size() + k_block_points - 1) / k_block_points);
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    if (i % k_block_points == 0) blocks.push_back({positions_[i], positions_[i]});
    grow(blocks.back(), positions_[i], positions_[i]);
  }
  while (boxes_.back().size() > k_fan_out) {
    std::vector<Box> above;
    const std::vector<Box>& below = boxes_.back();
    above.reserve((below.size() + k_fan_out - 1) / k_fan_out);
    for (std::size_t i = 0; i < below.size(); ++i) {
      if (i % k_fan_out == 0) above.push_back(below[i]);
      grow(above.back(), below[i].min, below[i].max);
    }
    boxes_.push_back(std::move(above));
  }
}

std::size_t BoxedPoints::byte_count() const {
  std::size_t bytes = sizeof(BoxedPoints) + positions_.capacity() * sizeof(LatticePosition) +
                      rows_.capacity() * sizeof(std::uint32_t) + boxes_.capacity() * sizeof(boxes_[0]);
  for (const std::vector<Box>& level : boxes_) bytes += level.capacity() * sizeof(Box);
  return bytes;
}

}  // namespace alidade
