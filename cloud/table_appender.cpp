// SPDX-License-Identifier: MIT
#include "cloud/table_appender.h"

#include <cmath>
#include <limits>

#include "base/bytes.h"
#include "cloud/append_rows.h"

namespace alidade {

namespace {

/// Nearest value of an integer type, held at its ends; NaN becomes 0.
template <class Integer>
Integer nearest(double value) {
  constexpr double k_low = static_cast<double>(std::numeric_limits<Integer>::min());
  constexpr double k_high = static_cast<double>(std::numeric_limits<Integer>::max());
  if (!(value > k_low)) return value <= k_low ? std::numeric_limits<Integer>::min() : Integer{0};
  return value >= k_high ? std::numeric_limits<Integer>::max() : static_cast<Integer>(std::nearbyint(value));
}

/// Nearest float; too large a number becomes infinite, as in IEEE 754.
float to_float(double value) {
  constexpr double k_largest = std::numeric_limits<float>::max();
  if (!(std::abs(value) > k_largest)) return static_cast<float>(value);
  return static_cast<float>(std::copysign(std::numeric_limits<double>::infinity(), value));
}

void store_as(ScalarType type, const Cell& cell, std::byte* place) {
  switch (type) {
    case ScalarType::uint8:
      return store(place, nearest<std::uint8_t>(cell.number));
    case ScalarType::int8:
      return store(place, nearest<std::int8_t>(cell.number));
    case ScalarType::uint16:
      return store(place, nearest<std::uint16_t>(cell.number));
    case ScalarType::int16:
      return store(place, nearest<std::int16_t>(cell.number));
    case ScalarType::uint32:
      return store(place, nearest<std::uint32_t>(cell.number));
    case ScalarType::int32:
      return store(place, nearest<std::int32_t>(cell.number));
    case ScalarType::uint64:
    case ScalarType::int64:
      return store(place, cell.integer);
    case ScalarType::float32:
      return store(place, to_float(cell.number));
    case ScalarType::float64:
      return store(place, cell.number);
    case ScalarType::bytes:
      return;
  }
}

std::uint8_t bits_from(double value, int mask, int shift) {
  return static_cast<std::uint8_t>((nearest<std::uint8_t>(value) & mask) << shift);
}

}  // namespace

TableAppender::TableAppender(PointCloud& cloud, std::span<const TableColumn> columns, AttributeSet wanted,
                             std::uint64_t count, const CloudPieces& pieces)
    : cloud_(cloud),
      pieces_(pieces),
      filled_(attributes_of(columns) & wanted),
      positions_(columns),
      next_(cloud.size()),
      left_(count) {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const TableColumn& column = columns[i];
    const auto attribute = attribute_of(column.role);
    if (!attribute || !wanted.contains(*attribute)) continue;
    Target target{i, column.role, column.type, 0};
    if (column.role == ColumnRole::extra) {
      ExtraDimension dimension;
      dimension.name = column.name;
      dimension.type = column.type;
      dimension.byte_count = scalar_size(column.type);
      target.dimension = find_extra_dimension(cloud, dimension);
    }
    targets_.push_back(target);
  }
  make_rows();
}

void TableAppender::make_rows() {
  const std::size_t count = room_in_piece(cloud_, filled_, left_, pieces_);
  next_ = cloud_.size();
  left_ -= count;
  append_rows(cloud_, filled_, count);
}

bool TableAppender::add(std::span<const Cell> row) {
  const glm::dvec3 world = positions_.position(row);
  if (!(std::isfinite(world.x) && std::isfinite(world.y) && std::isfinite(world.z))) return true;
  const auto position = to_lattice(cloud_.lattice, world);
  if (!position || complete()) return false;
  if (next_ == cloud_.size()) make_rows();
  cloud_.positions[next_] = *position;
  for (const Target& target : targets_) put(target, row[target.column]);
  ++next_;
  return true;
}

void TableAppender::put(const Target& target, const Cell& cell) {
  const double number = cell.number;
  switch (target.role) {
    case ColumnRole::red:
      cloud_.colors[next_].x = colors_.apply(number);
      return;
    case ColumnRole::green:
      cloud_.colors[next_].y = colors_.apply(number);
      return;
    case ColumnRole::blue:
      cloud_.colors[next_].z = colors_.apply(number);
      return;
    case ColumnRole::packed_color:
      cloud_.colors[next_] = {(cell.integer >> 16 & 255) * 257, (cell.integer >> 8 & 255) * 257,
                              (cell.integer & 255) * 257};
      return;
    case ColumnRole::normal_x:
      cloud_.normals[next_].x = to_float(number);
      return;
    case ColumnRole::normal_y:
      cloud_.normals[next_].y = to_float(number);
      return;
    case ColumnRole::normal_z:
      cloud_.normals[next_].z = to_float(number);
      return;
    case ColumnRole::near_infrared:
      cloud_.near_infrared[next_] = near_infrared_.apply(number);
      return;
    case ColumnRole::intensity:
      cloud_.intensities[next_] = intensities_.apply(number);
      return;
    case ColumnRole::classification:
      cloud_.classifications[next_] = nearest<std::uint8_t>(number);
      return;
    case ColumnRole::return_number:
      cloud_.returns[next_].number = nearest<std::uint8_t>(number);
      return;
    case ColumnRole::return_count:
      cloud_.returns[next_].count = nearest<std::uint8_t>(number);
      return;
    case ColumnRole::class_flags:
      cloud_.flags[next_] |= bits_from(number, 15, 0);
      return;
    case ColumnRole::scanner_channel:
      cloud_.flags[next_] |= bits_from(number, 3, 4);
      return;
    case ColumnRole::scan_direction:
      cloud_.flags[next_] |= bits_from(number, 1, 6);
      return;
    case ColumnRole::edge_of_flight_line:
      cloud_.flags[next_] |= bits_from(number, 1, 7);
      return;
    case ColumnRole::scan_angle:
      cloud_.scan_angles[next_] = to_float(number);
      return;
    case ColumnRole::user_data:
      cloud_.user_data[next_] = nearest<std::uint8_t>(number);
      return;
    case ColumnRole::point_source_id:
      cloud_.point_source_ids[next_] = nearest<std::uint16_t>(number);
      return;
    case ColumnRole::gps_time:
      cloud_.gps_times[next_] = number;
      return;
    case ColumnRole::extra: {
      ExtraDimension& dimension = cloud_.extra_dimensions[target.dimension];
      const std::size_t bytes = static_cast<std::size_t>(dimension.byte_count);
      store_as(target.type, cell, reinterpret_cast<std::byte*>(dimension.values.data() + next_ * bytes));
      return;
    }
    case ColumnRole::x:
    case ColumnRole::y:
    case ColumnRole::z:
    case ColumnRole::ignored:
      return;
  }
}

}  // namespace alidade
