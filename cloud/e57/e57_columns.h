// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "cloud/cloud_pieces.h"
#include "cloud/e57/e57_points.h"
#include "cloud/e57/e57_scaling.h"
#include "cloud/point_cloud.h"

namespace alidade {

/// Puts the points of scans into new rows of a cloud. Attributes that a scan lacks stay 0.
class E57Appender {
 public:
  /// Makes rows of zeros for `count` points to come, as far as a piece has room, and the columns of `filled`.
  /// `pieces` must outlive the object.
  E57Appender(PointCloud& cloud, AttributeSet filled, std::uint64_t count, const CloudPieces& pieces);

  /// How the next scan's values are to be read: its scaling, its pose for normals, and what its time stamps
  /// count from.
  void begin_scan(const E57Scan& scan, const E57Scaling& scaling, double time_origin);

  /// Takes the next points, without those that are left out. False if the cloud's lattice cannot hold one or
  /// more come than were announced: the file is not what the first pass saw.
  bool add(const E57Points& points);

  /// Whether as many points came as were announced.
  bool complete() const { return next_ == cloud_.size() && left_ == 0; }
  /// Values that their flags call invalid and that became 0: colours, intensities, time stamps.
  const std::array<std::uint64_t, 3>& invalid() const { return invalid_; }

 private:
  void make_rows();
  void put(const E57Points& points, std::size_t i);
  bool is_invalid(const E57Points& points, E57Role flag, std::size_t i, std::size_t kind);
  void put_index(std::optional<std::size_t>& dimension, const char* name, const char* description,
                 double value);

  PointCloud& cloud_;
  AttributeSet filled_;
  const CloudPieces& pieces_;
  std::optional<std::size_t> row_dimension_{}, column_dimension_{};  ///< once a scan has one
  const E57Scan* scan_ = nullptr;
  const E57Scaling* scaling_ = nullptr;
  double time_origin_ = 0.0;
  std::size_t next_;
  std::uint64_t left_;  ///< rows that have not been made yet
  std::array<std::uint64_t, 3> invalid_{};
};

}  // namespace alidade
