// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "cloud/attributes.h"
#include "cloud/point_cloud.h"

namespace alidade {

/// A column of values that is not one of the standard attributes, wherever it lies.
struct ExtraColumn {
  ExtraDimension description;            ///< its `values` are empty
  std::span<const std::uint8_t> values;  ///< byte_count bytes per point, little endian, in point order
};

/// The attribute columns of a cloud, wherever they lie: in a PointCloud, or in an index file that is mapped
/// into memory. Row = point id. A column is empty if the cloud does not have it. Names and meaning are those
/// of PointCloud.
struct AttributeColumns {
  std::span<const Color16> colors;
  std::span<const std::uint16_t> near_infrared;
  std::span<const std::uint16_t> intensities;
  std::span<const std::uint8_t> classifications;
  std::span<const ReturnNumbers> returns;
  std::span<const PointFlags> flags;
  std::span<const float> scan_angles;
  std::span<const std::uint8_t> user_data;
  std::span<const std::uint16_t> point_source_ids;
  std::span<const double> gps_times;
  std::span<const glm::vec3> normals;
  std::vector<ExtraColumn> extra_dimensions;

  /// The attributes that are present.
  AttributeSet attributes() const;
};

/// Calls visit(attribute, column of a, column of b) for every column but the extra dimensions; a and b are
/// each a PointCloud or AttributeColumns.
template <class CloudA, class CloudB, class Visit>
void for_each_column(CloudA& a, CloudB& b, const Visit& visit) {
  visit(Attribute::color, a.colors, b.colors);
  visit(Attribute::near_infrared, a.near_infrared, b.near_infrared);
  visit(Attribute::intensity, a.intensities, b.intensities);
  visit(Attribute::classification, a.classifications, b.classifications);
  visit(Attribute::returns, a.returns, b.returns);
  visit(Attribute::flags, a.flags, b.flags);
  visit(Attribute::scan_angle, a.scan_angles, b.scan_angles);
  visit(Attribute::user_data, a.user_data, b.user_data);
  visit(Attribute::point_source_id, a.point_source_ids, b.point_source_ids);
  visit(Attribute::gps_time, a.gps_times, b.gps_times);
  visit(Attribute::normal, a.normals, b.normals);
}

/// The columns of a cloud, which must outlive them and keep its size.
AttributeColumns columns_of(const PointCloud& cloud);

}  // namespace alidade
