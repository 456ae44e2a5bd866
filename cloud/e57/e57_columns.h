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

/// Ranges of the values of one scan in the first pass, without those flagged as invalid.
struct E57Values {
  ColumnRange colors, intensities;
};

/// Determines the scales of every scan, each by the first of these that applies:
/// - the limits of the scan (colorLimits, intensityLimits), if the largest is above the smallest;
/// - for intensities, the range that the field itself states; for integer colours, 0 to the next of 255 and
///   65535, or to the field's maximum if that is one less than a power of two above 255, because fields often
///   state the values that occur instead of those that can occur; for colours as floats, the range of the
///   field if it is 0 to 1, 255 or 65535;
/// - the result of color_scaling() and intensity_scaling() for all remaining scans together.
/// If values exceed the range, it is widened to the next of 255 and 65535 that holds them (colours) or to the
/// values (intensities); but colours between -1 and 2 are clamped to 0 to 1, because filters overshoot that
/// much. All that is assumed, widened or clamped is added to `oddities`.
std::vector<E57Scaling> e57_scalings(const std::vector<E57Scan>& scans, const std::vector<E57Roles>& roles,
                                     const std::vector<E57Values>& values, AttributeSet wanted,
                                     E57Oddities& oddities);

/// Appends the points of scans to a cloud. Attributes that a scan lacks are 0.
class E57Appender : public RowsToFill {
 public:
  /// Appends rows of zeros for the next `count` points, as far as a piece has room, and the columns of
  /// `filled`. `pieces` must outlive the object.
  E57Appender(PointCloud& cloud, AttributeSet filled, std::uint64_t count, const CloudPieces& pieces)
      : RowsToFill(cloud, filled, count, pieces) {
    make_rows();
  }

  /// Sets how values of the next scan are read: its scaling, its pose (for normals), and the origin of its
  /// time stamps.
  void begin_scan(const E57Scan& scan, const E57Scaling& scaling, double time_origin);

  /// Takes the next points, without those that are left out. Returns false as begin_row() does.
  bool add(const E57Points& points);

  /// Numbers of values that are flagged as invalid and became 0: colours, intensities, time stamps.
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
