// SPDX-License-Identifier: MIT
#include "cloud/point_table.h"

#include <cmath>

namespace alidade {

namespace {

bool is_float(ScalarType type) {
  return type == ScalarType::float32 || type == ScalarType::float64;
}

}  // namespace

ValueScaling color_scaling(ScalarType type, const ValueRange& range) {
  if (range.max <= 0.0) return {};
  if (type == ScalarType::uint8 || type == ScalarType::int8) return {.factor = 257.0, .assumption = {}};
  if (is_float(type) && range.max <= 1.0)
    return {.factor = 65535.0, .assumption = "colours go from 0 to 1 since none is larger"};
  if (range.max <= 255.0) {
    const bool usual = type != ScalarType::uint16 && type != ScalarType::int16;
    return {.factor = 257.0, .assumption = usual ? "" : "colours are 8-bit values since none exceeds 255"};
  }
  return {};
}

ValueScaling intensity_scaling(ScalarType type, const ValueRange& range, IntensityScale scale) {
  if (type == ScalarType::uint8) return {.factor = 257.0, .assumption = {}};
  if (type == ScalarType::uint16 || !(range.min <= range.max)) return {};
  if (range.min >= 0.0) {
    if (range.max == 0.0) return {};
    if (is_float(type) && range.max <= 1.0)
      return {.factor = 65535.0,
              .assumption =
                  scale == IntensityScale::unit ? "" : "intensities go from 0 to 1 since none is larger"};
    if (range.max <= 255.0)
      return {.factor = 257.0, .assumption = "intensities go from 0 to 255 since none is larger"};
    if (range.max <= 65535.0) return {};
  }
  if (scale == IntensityScale::signed_12_bit && range.min >= -2048.0 && range.max <= 2047.0)
    return {.origin = -2048.0,
            .factor = 65535.0 / 4095.0,
            .assumption = "intensities go from -2048 to 2047 since some are negative"};
  const double spread = range.max - range.min;
  const bool usable = std::isfinite(spread) && spread > 0.0;
  return {.origin = usable ? range.min : 0.0,
          .factor = usable ? 65535.0 / spread : 0.0,
          .assumption = "intensities were stretched from their own smallest and largest value to 0 .. 65535"};
}

double type_resolution(ScalarType type, double largest) {
  if (type == ScalarType::float64) return 0.0;
  if (type != ScalarType::float32) return 0.5;
  const float next = std::nextafter(static_cast<float>(largest), std::numeric_limits<float>::infinity());
  const double half = 0.5 * (static_cast<double>(next) - largest);
  return std::isfinite(half) ? half : 0.0;
}

PositionColumns::PositionColumns(std::span<const TableColumn> columns)
    : x_(find_role(columns, ColumnRole::x).value()),
      y_(find_role(columns, ColumnRole::y).value()),
      z_(find_role(columns, ColumnRole::z).value_or(0)),
      flat_(!find_role(columns, ColumnRole::z)) {}

TableSurvey::TableSurvey(std::span<const TableColumn> columns) : positions_(columns) {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    switch (columns[i].role) {
      case ColumnRole::red:
      case ColumnRole::green:
      case ColumnRole::blue:
        watched_.push_back({i, &TableSurvey::colors_});
        break;
      case ColumnRole::near_infrared:
        watched_.push_back({i, &TableSurvey::near_infrared_});
        break;
      case ColumnRole::intensity:
        watched_.push_back({i, &TableSurvey::intensities_});
        break;
      default:
        break;
    }
  }
}

bool TableSurvey::add(std::span<const Cell> row) {
  const glm::dvec3 position = positions_.position(row);
  if (!(std::isfinite(position.x) && std::isfinite(position.y) && std::isfinite(position.z))) {
    ++dropped_count_;
    return false;
  }
  ++finite_count_;
  bounds_.grow(position);
  for (const Watched& watched : watched_) (this->*watched.range).grow(row[watched.column].number);
  return true;
}

}  // namespace alidade
