// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cloud/cloud_pieces.h"
#include "cloud/point_cloud.h"
#include "cloud/point_table.h"

namespace alidade {

/// The second pass over the rows of a point table: puts them into the columns of a cloud.
class TableAppender {
 public:
  /// Makes new rows of zeros in `cloud` for the `count` rows to come, as far as a piece has room, and the
  /// columns that they need: those of `columns` that are in `wanted`. `pieces` must outlive the object.
  TableAppender(PointCloud& cloud, std::span<const TableColumn> columns, AttributeSet wanted,
                std::uint64_t count, const CloudPieces& pieces);

  void scale_colors(const ValueScaling& scaling) { colors_ = scaling; }
  void scale_near_infrared(const ValueScaling& scaling) { near_infrared_ = scaling; }
  void scale_intensities(const ValueScaling& scaling) { intensities_ = scaling; }

  /// Takes the next row; a position that is not finite is left out. Returns false if the cloud's lattice
  /// cannot hold the position or more rows come than were announced: the file is not what the first pass saw.
  bool add(std::span<const Cell> row);

  /// Whether as many rows came as were announced.
  bool complete() const { return next_ == cloud_.size() && left_ == 0; }

 private:
  struct Target {
    std::size_t column;
    ColumnRole role;
    ScalarType type;
    std::size_t dimension;  ///< of the cloud, for ColumnRole::extra
  };
  void make_rows();
  void put(const Target& target, const Cell& cell);

  PointCloud& cloud_;
  const CloudPieces& pieces_;
  AttributeSet filled_;
  PositionColumns positions_;
  std::vector<Target> targets_;
  ValueScaling colors_, near_infrared_, intensities_;
  std::size_t next_;
  std::uint64_t left_;  ///< rows that have not been made yet
};

}  // namespace alidade
