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
  static constexpr const char* k_names[] = {
      "color",      "near_infrared", "intensity",       "classification", "returns", "flags",
      "scan_angle", "user_data",     "point_source_id", "gps_time",       "normal",  "extra_dimensions"};
  std::vector<std::string> names;
  for (std::size_t bit = 0; bit < std::size(k_names); ++bit) {
    if (attributes.bits >> bit & 1) names.emplace_back(k_names[bit]);
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
