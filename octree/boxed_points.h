// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/bounds.h"
#include "cloud/lattice.h"

namespace alidade {

/// Points sorted along a Morton curve in blocks of 16 with a box around each, boxes around 8 of these, and so
/// on: what makes the many points of one node quick to ask. Rows are the numbers the points had before.
class BoxedPoints {
 public:
  static constexpr std::size_t k_block_points = 16;
  static constexpr std::size_t k_fan_out = 8;

  /// positions[i] is the point of row rows[i]. Cost: n log n.
  BoxedPoints(std::vector<LatticePosition> positions, std::vector<std::uint32_t> rows);

  struct Box {
    LatticePosition min, max;  ///< inclusive
  };

  std::size_t size() const { return positions_.size(); }
  /// Levels of boxes: 0 are the blocks. None if there are no points.
  int levels() const { return static_cast<int>(boxes_.size()); }
  /// The boxes of a level; those of the highest are at most 8.
  const std::vector<Box>& boxes(int level) const { return boxes_[static_cast<std::size_t>(level)]; }
  const std::vector<LatticePosition>& positions() const { return positions_; }
  const std::vector<std::uint32_t>& rows() const { return rows_; }
  /// Memory that the object takes.
  std::size_t byte_count() const;

 private:
  std::vector<LatticePosition> positions_;
  std::vector<std::uint32_t> rows_;
  std::vector<std::vector<Box>> boxes_;
};

}  // namespace alidade
