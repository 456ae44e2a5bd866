// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "cloud/cloud_reader.h"
#include "cloud/e57/e57_file.h"
#include "cloud/e57/e57_points.h"
#include "cloud/point_cloud.h"
#include "cloud/point_table.h"

namespace alidade {

/// How the values of one scan become 0 .. 65535.
struct E57Scaling {
  std::array<ValueScaling, 3> colors;  ///< red, green, blue
  ValueScaling intensities;
};

/// What the first pass met in one scan, without what is flagged as invalid.
struct E57Values {
  ColumnRange colors, intensities;
};

/// Decides for every scan. Each has a scale of its own:
/// - limits of the scan (colorLimits, intensityLimits), where the largest is above the smallest;
/// - otherwise of intensities the range that the field itself states; of colours as integers 0 to the next of
///   255 and 65535, or to the field's maximum if that is one less than a power of two above 255, because
///   fields state what occurs as often as what can occur; of colours as floats that range where it is 0 to 1,
///   255 or 65535;
/// - otherwise what color_scaling() and intensity_scaling() say of all such scans together.
/// Where values go beyond the range, it is widened to the next of 255 and 65535 that holds them (colours) or
/// to the values (intensities); but colours between -1 and 2 are held at the ends of 0 to 1, because that
/// much is what filters leave. What was assumed, widened or held is added to `oddities`.
std::vector<E57Scaling> e57_scalings(const std::vector<E57Scan>& scans, const std::vector<E57Roles>& roles,
                                     const std::vector<E57Values>& values, AttributeSet wanted,
                                     E57Oddities& oddities);

/// Puts the points of scans into new rows of a cloud. Attributes that a scan lacks stay 0.
class E57Appender : public RowsToFill {
 public:
  /// Makes rows of zeros for `count` points to come, as far as a piece has room, and the columns of `filled`.
  /// `pieces` must outlive the object.
  E57Appender(PointCloud& cloud, AttributeSet filled, std::uint64_t count, const CloudPieces& pieces)
      : RowsToFill(cloud, filled, count, pieces) {
    make_rows();
  }

  /// How the next scan's values are to be read: its scaling, its pose for normals, and what its time stamps
  /// count from.
  void begin_scan(const E57Scan& scan, const E57Scaling& scaling, double time_origin);

  /// Takes the next points, without those that are left out. False as begin_row().
  bool add(const E57Points& points);

  /// Values that their flags call invalid and that became 0: colours, intensities, time stamps.
  const std::array<std::uint64_t, 3>& invalid() const { return invalid_; }

 private:
  void put(const E57Points& points, std::size_t i);
  bool is_invalid(const E57Points& points, E57Role flag, std::size_t i, std::size_t kind);
  void put_index(std::optional<std::size_t>& dimension, const char* name, const char* description,
                 double value);

  std::optional<std::size_t> row_dimension_{}, column_dimension_{};  ///< once a scan has one
  const E57Scan* scan_ = nullptr;
  const E57Scaling* scaling_ = nullptr;
  double time_origin_ = 0.0;
  std::array<std::uint64_t, 3> invalid_{};
};

}  // namespace alidade
