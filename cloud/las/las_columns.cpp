// SPDX-License-Identifier: MIT
#include "cloud/las/las_columns.h"

#include <cstdint>
#include <cstring>
#include <utility>

#include "base/bytes.h"
#include "cloud/rows.h"

namespace alidade {
namespace {

/// column[row] = value(at) for all points of a block, where `at` points to byte `offset` of the record.
template <class Column, class Value>
void fill(const RecordBlock& block, int offset, Column& column, Value value) {
  const std::byte* at = block.bytes + offset;
  for (std::size_t i = 0; i < block.count; ++i, at += block.point_size)
    column[block.first_row + i] = value(at);
}

template <class T>
constexpr auto k_plain = [](const std::byte* at) { return load<T>(at); };

constexpr auto k_legacy_returns = [](const std::byte* at) -> ReturnNumbers {
  const unsigned bits = load<std::uint8_t>(at);
  return {.number = static_cast<std::uint8_t>(bits & 7), .count = static_cast<std::uint8_t>(bits >> 3 & 7)};
};

constexpr auto k_returns = [](const std::byte* at) -> ReturnNumbers {
  const unsigned bits = load<std::uint8_t>(at);
  return {.number = static_cast<std::uint8_t>(bits & 15), .count = static_cast<std::uint8_t>(bits >> 4)};
};

/// Scan direction and edge of flight line are bits of the returns' byte; synthetic, key point and withheld
/// the upper bits of the classification behind it.
constexpr auto k_legacy_flags = [](const std::byte* at) -> PointFlags {
  return static_cast<PointFlags>((load<std::uint8_t>(at) & 0xc0) | load<std::uint8_t>(at + 1) >> 5);
};

constexpr auto k_legacy_classification = [](const std::byte* at) -> std::uint8_t {
  return load<std::uint8_t>(at) & 31;
};

constexpr auto k_legacy_scan_angle = [](const std::byte* at) -> float { return load<std::int8_t>(at); };

constexpr auto k_scan_angle = [](const std::byte* at) -> float {
  return static_cast<float>(load<std::int16_t>(at) * k_las_scan_angle_step);
};

/// Index of the first of three dimensions that hold a normal as LasWriter writes it; empty if missing.
std::optional<std::size_t> find_normal(const std::vector<ExtraDimension>& dimensions) {
  const auto is = [](const ExtraDimension& dimension, const char* name) {
    return dimension.name == name && dimension.type == ScalarType::float32 && !dimension.has_scale &&
           !dimension.has_offset;
  };
  for (std::size_t i = 0; i + 2 < dimensions.size(); ++i) {
    if (is(dimensions[i], "NormalX") && is(dimensions[i + 1], "NormalY") && is(dimensions[i + 2], "NormalZ"))
      return i;
  }
  return std::nullopt;
}

/// Fills positions, in steps of the cloud's lattice.
void take_positions(const RecordBlock& block, const LatticeShift& shift, PointCloud& cloud) {
  if (shift.is_none()) {
    fill(block, 0, cloud.positions, k_plain<LatticePosition>);
  } else {
    fill(block, 0, cloud.positions, [&](const std::byte* at) { return shift(load<LatticePosition>(at)); });
  }
}

}  // namespace

LasColumns::LasColumns(std::string file_name, const LasHeader& header,
                       const std::vector<ExtraDimension>& extra_dimensions)
    : file_name_(std::move(file_name)), lattice_(header.lattice), layout_(header.layout()) {
  const std::optional<std::size_t> normal = find_normal(extra_dimensions);
  int offset = layout_.size;
  for (std::size_t i = 0; i < extra_dimensions.size(); ++i) {
    const ExtraDimension& dimension = extra_dimensions[i];
    if (normal && i == *normal) normal_offset_ = offset;
    const bool part_of_normal = normal && i >= *normal && i < *normal + 3;
    if (!part_of_normal) extra_dimensions_.push_back({dimension, offset});
    offset += dimension.byte_count;
  }
}

AttributeSet LasColumns::attributes() const {
  AttributeSet set = Attribute::intensity | Attribute::classification | Attribute::returns |
                     Attribute::flags | Attribute::scan_angle | Attribute::user_data |
                     Attribute::point_source_id;
  if (layout_.gps_time >= 0) set = set | Attribute::gps_time;
  if (layout_.color >= 0) set = set | Attribute::color;
  if (layout_.near_infrared >= 0) set = set | Attribute::near_infrared;
  if (normal_offset_) set = set | Attribute::normal;
  if (!extra_dimensions_.empty()) set = set | Attribute::extra_dimensions;
  return set;
}

LasColumns::Choice LasColumns::choose(AttributeSet wanted, PointCloud& cloud) const {
  Choice choice{attributes() & wanted, LatticeShift(lattice_, cloud.lattice, file_name_), {}};
  if (!choice.kept.contains(Attribute::extra_dimensions)) return choice;
  for (std::size_t i = 0; i < extra_dimensions_.size(); ++i) {
    const std::size_t occurrence = occurrence_of(extra_dimensions_, i, &PlacedDimension::description);
    choice.extra_columns.push_back(find_extra_dimension(cloud, extra_dimensions_[i].description, occurrence));
  }
  return choice;
}

void LasColumns::take(const RecordBlock& block, const Choice& choice, PointCloud& cloud) const {
  take_positions(block, choice.shift, cloud);
  take_attributes(block, choice.kept, cloud);
  for (std::size_t i = 0; i < choice.extra_columns.size(); ++i) {
    ExtraDimension& column = cloud.extra_dimensions[choice.extra_columns[i]];
    const std::size_t bytes = static_cast<std::size_t>(column.byte_count);
    for (std::size_t row = 0; row < block.count; ++row) {
      std::memcpy(column.values.data() + (block.first_row + row) * bytes,
                  block.bytes + row * block.point_size + extra_dimensions_[i].offset, bytes);
    }
  }
}

void LasColumns::take_attributes(const RecordBlock& block, AttributeSet kept, PointCloud& cloud) const {
  const auto keep = [&](Attribute attribute, int offset, auto& column, auto value) {
    if (kept.contains(attribute)) fill(block, offset, column, value);
  };
  keep(Attribute::intensity, 12, cloud.intensities, k_plain<std::uint16_t>);
  if (layout_.legacy) {
    keep(Attribute::returns, 14, cloud.returns, k_legacy_returns);
    keep(Attribute::flags, 14, cloud.flags, k_legacy_flags);
    keep(Attribute::classification, 15, cloud.classifications, k_legacy_classification);
    keep(Attribute::scan_angle, 16, cloud.scan_angles, k_legacy_scan_angle);
  } else {
    keep(Attribute::returns, 14, cloud.returns, k_returns);
    keep(Attribute::flags, 15, cloud.flags, k_plain<PointFlags>);
    keep(Attribute::classification, 16, cloud.classifications, k_plain<std::uint8_t>);
    keep(Attribute::scan_angle, 18, cloud.scan_angles, k_scan_angle);
  }
  keep(Attribute::user_data, 17, cloud.user_data, k_plain<std::uint8_t>);
  keep(Attribute::point_source_id, layout_.legacy ? 18 : 20, cloud.point_source_ids, k_plain<std::uint16_t>);
  keep(Attribute::gps_time, layout_.gps_time, cloud.gps_times, k_plain<double>);
  keep(Attribute::color, layout_.color, cloud.colors, k_plain<Color16>);
  keep(Attribute::near_infrared, layout_.near_infrared, cloud.near_infrared, k_plain<std::uint16_t>);
  keep(Attribute::normal, normal_offset_.value_or(0), cloud.normals, k_plain<glm::vec3>);
}

}  // namespace alidade
