// SPDX-License-Identifier: MIT
#include "cloud/e57/e57_columns.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/bytes.h"
#include "cloud/append_rows.h"

namespace alidade {
namespace {

std::size_t index_dimension(PointCloud& cloud, const char* name, const char* description) {
  ExtraDimension dimension;
  dimension.name = name;
  dimension.description = description;
  dimension.type = ScalarType::uint32;
  dimension.byte_count = scalar_size(ScalarType::uint32);
  return find_extra_dimension(cloud, dimension);
}

/// Nearest whole number, held at the ends of the type; NaN becomes 0.
template <class Integer>
Integer nearest(double value) {
  constexpr double k_most = static_cast<double>(std::numeric_limits<Integer>::max());
  if (!(value > 0.0)) return 0;
  return value >= k_most ? std::numeric_limits<Integer>::max() : static_cast<Integer>(value + 0.5);
}

/// Nearest float; what is too large for one becomes 0, as no part of a normal is.
float to_float(double value) {
  return std::abs(value) <= std::numeric_limits<float>::max() ? static_cast<float>(value) : 0.0f;
}

}  // namespace

E57Appender::E57Appender(PointCloud& cloud, AttributeSet filled, std::uint64_t count,
                         const CloudPieces& pieces)
    : cloud_(cloud), filled_(filled), pieces_(pieces), next_(cloud.size()), left_(count) {
  make_rows();
}

void E57Appender::make_rows() {
  const std::size_t count = room_in_piece(cloud_, filled_, left_, pieces_);
  next_ = cloud_.size();
  left_ -= count;
  append_rows(cloud_, filled_, count);
}

void E57Appender::begin_scan(const E57Scan& scan, const E57Scaling& scaling, double time_origin) {
  scan_ = &scan;
  scaling_ = &scaling;
  time_origin_ = time_origin;
}

bool E57Appender::add(const E57Points& points) {
  for (std::size_t i = 0; i < points.positions.size(); ++i) {
    if (points.is_left_out(i)) continue;
    const auto position = to_lattice(cloud_.lattice, points.positions[i]);
    if (!position || complete()) return false;
    if (next_ == cloud_.size()) make_rows();
    cloud_.positions[next_] = *position;
    put(points, i);
    ++next_;
  }
  return true;
}

bool E57Appender::is_invalid(const E57Points& points, E57Role flag, std::size_t i, std::size_t kind) {
  if (!points.is_flagged(flag, i)) return false;
  ++invalid_[kind];
  return true;
}

void E57Appender::put_index(std::optional<std::size_t>& dimension, const char* name, const char* description,
                            double value) {
  if (!dimension) dimension = index_dimension(cloud_, name, description);
  auto* const bytes = reinterpret_cast<std::byte*>(cloud_.extra_dimensions[*dimension].values.data());
  store(bytes + next_ * sizeof(std::uint32_t), nearest<std::uint32_t>(value));
}

void E57Appender::put(const E57Points& points, std::size_t i) {
  const auto value = [&](E57Role role) { return points.value(role, i); };
  if (points.has(E57Role::red) && !is_invalid(points, E57Role::color_invalid, i, 0)) {
    cloud_.colors[next_] = {scaling_->colors[0].apply(value(E57Role::red)),
                            scaling_->colors[1].apply(value(E57Role::green)),
                            scaling_->colors[2].apply(value(E57Role::blue))};
  }
  if (points.has(E57Role::intensity) && !is_invalid(points, E57Role::intensity_invalid, i, 1))
    cloud_.intensities[next_] = scaling_->intensities.apply(value(E57Role::intensity));
  if (points.has(E57Role::time) && !is_invalid(points, E57Role::time_invalid, i, 2))
    cloud_.gps_times[next_] = time_origin_ + value(E57Role::time);
  if (points.has(E57Role::row))
    put_index(row_dimension_, "rowIndex", "row of the scanner's grid", value(E57Role::row));
  if (points.has(E57Role::column))
    put_index(column_dimension_, "columnIndex", "column of the scanner's grid", value(E57Role::column));
  // Counted from 0 in the file.
  if (points.has(E57Role::return_index))
    cloud_.returns[next_].number = nearest<std::uint8_t>(value(E57Role::return_index) + 1.0);
  if (points.has(E57Role::return_count))
    cloud_.returns[next_].count = nearest<std::uint8_t>(value(E57Role::return_count));
  if (points.has(E57Role::normal_x)) {
    glm::dvec3 normal(value(E57Role::normal_x), value(E57Role::normal_y), value(E57Role::normal_z));
    if (scan_->pose && scan_->pose->is_rotated) normal = scan_->pose->rotation * normal;
    cloud_.normals[next_] = {to_float(normal.x), to_float(normal.y), to_float(normal.z)};
  }
}

}  // namespace alidade
