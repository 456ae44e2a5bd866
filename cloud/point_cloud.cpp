// SPDX-License-Identifier: MIT
#include "cloud/point_cloud.h"

#include "cloud/rows.h"

namespace alidade {

namespace {

AttributeSet present_in(const auto& cloud) {
  AttributeSet set;
  for_each_column(cloud, [&](Attribute attribute, const auto& column) {
    if (!column.empty()) set = set | attribute;
  });
  return cloud.extra_dimensions.empty() ? set : set | Attribute::extra_dimensions;
}

}  // namespace

AttributeSet PointCloud::attributes() const {
  return present_in(*this);
}

Bounds PointCloud::bounds() const {
  return bounds_of(lattice, positions);
}

void PointCloud::resize(std::size_t count) {
  positions.resize(count);
  for_each_column(*this, [count](Attribute, auto& column) {
    if (!column.empty()) column.resize(count);
  });
  for (ExtraDimension& dimension : extra_dimensions) {
    dimension.values.resize(count * static_cast<std::size_t>(dimension.byte_count));
  }
}

std::vector<std::string> attribute_names(AttributeSet attributes) {
  static constexpr std::pair<Attribute, const char*> k_names[] = {
      {Attribute::color, "color"},
      {Attribute::near_infrared, "near_infrared"},
      {Attribute::intensity, "intensity"},
      {Attribute::classification, "classification"},
      {Attribute::returns, "return_number"},
      {Attribute::returns, "number_of_returns"},
      {Attribute::flags, "flags"},
      {Attribute::scan_angle, "scan_angle"},
      {Attribute::user_data, "user_data"},
      {Attribute::point_source_id, "point_source_id"},
      {Attribute::gps_time, "gps_time"},
      {Attribute::normal, "normal"},
      {Attribute::extra_dimensions, "extra_dimensions"}};
  std::vector<std::string> names;
  for (const auto& [attribute, name] : k_names) {
    if (attributes.contains(attribute)) names.emplace_back(name);
  }
  return names;
}

AttributeSet AttributeColumns::attributes() const {
  return present_in(*this);
}

AttributeColumns columns_of(const PointCloud& cloud) {
  AttributeColumns columns;
  for_each_column(columns, cloud, [](Attribute, auto& view, const auto& column) { view = column; });
  for (const ExtraDimension& dimension : cloud.extra_dimensions)
    columns.extra_dimensions.push_back({description_of(dimension), dimension.values});
  return columns;
}

PointColumns points_of(const PointCloud& cloud) {
  return {cloud.lattice, cloud.positions, columns_of(cloud)};
}

Bounds bounds_of(const Lattice& lattice, std::span<const LatticePosition> positions) {
  if (positions.empty()) return {};
  // World coordinates grow with the steps (the scale is positive and rounding keeps order), so the box of the
  // steps is the box of the points.
  LatticeExtent extent;
  for (const LatticePosition& position : positions) extent.grow(position);
  Bounds bounds;
  bounds.grow(to_world(lattice, extent.low));
  bounds.grow(to_world(lattice, extent.high));
  return bounds;
}

}  // namespace alidade
