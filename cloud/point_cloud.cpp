// SPDX-License-Identifier: MIT
#include "cloud/point_cloud.h"

#include <algorithm>

#include "cloud/rows.h"

namespace alidade {

AttributeSet PointCloud::attributes() const {
  AttributeSet set;
  const auto add = [&](Attribute attribute, bool present) {
    if (present) set = set | attribute;
  };
  add(Attribute::color, !colors.empty());
  add(Attribute::near_infrared, !near_infrared.empty());
  add(Attribute::intensity, !intensities.empty());
  add(Attribute::classification, !classifications.empty());
  add(Attribute::returns, !returns.empty());
  add(Attribute::flags, !flags.empty());
  add(Attribute::scan_angle, !scan_angles.empty());
  add(Attribute::user_data, !user_data.empty());
  add(Attribute::point_source_id, !point_source_ids.empty());
  add(Attribute::gps_time, !gps_times.empty());
  add(Attribute::normal, !normals.empty());
  add(Attribute::extra_dimensions, !extra_dimensions.empty());
  return set;
}

Bounds PointCloud::bounds() const {
  if (positions.empty()) return {};
  // World coordinates grow with the steps (the scale is positive and rounding keeps order), so the box of the
  // steps is the box of the points.
  LatticePosition low = positions.front(), high = positions.front();
  for (const LatticePosition& position : positions) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], position[axis]);
      high[axis] = std::max(high[axis], position[axis]);
    }
  }
  Bounds bounds;
  bounds.grow(to_world(lattice, low));
  bounds.grow(to_world(lattice, high));
  return bounds;
}

void PointCloud::resize(std::size_t count) {
  const auto resize_present = [count](auto& column) {
    if (!column.empty()) column.resize(count);
  };
  positions.resize(count);
  resize_present(colors);
  resize_present(near_infrared);
  resize_present(intensities);
  resize_present(classifications);
  resize_present(returns);
  resize_present(flags);
  resize_present(scan_angles);
  resize_present(user_data);
  resize_present(point_source_ids);
  resize_present(gps_times);
  resize_present(normals);
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
  AttributeSet set;
  for_each_column(*this, *this, [&](Attribute attribute, const auto& column, const auto&) {
    if (!column.empty()) set = set | attribute;
  });
  return extra_dimensions.empty() ? set : set | Attribute::extra_dimensions;
}

AttributeColumns columns_of(const PointCloud& cloud) {
  AttributeColumns columns;
  for_each_column(columns, cloud, [](Attribute, auto& view, const auto& column) { view = column; });
  for (const ExtraDimension& dimension : cloud.extra_dimensions)
    columns.extra_dimensions.push_back({description_of(dimension), dimension.values});
  return columns;
}

}  // namespace alidade
