// SPDX-License-Identifier: MIT
#pragma once

#include <cstring>
#include <string>
#include <vector>

#include "cloud/point_cloud.h"
#include "tests/support/point_families.h"

namespace alidade::test {

/// An extra dimension with these values.
template <class Value>
ExtraDimension extra(const std::string& name, ScalarType type, const std::vector<Value>& values) {
  ExtraDimension dimension{
      .name = name, .description = "", .type = type, .byte_count = scalar_size(type), .values = {}};
  dimension.values.resize(values.size() * sizeof(Value));
  std::memcpy(dimension.values.data(), values.data(), dimension.values.size());
  return dimension;
}

/// Points over one another, 1 m apart, the lowest first.
inline PointCloud column(std::size_t count) {
  std::vector<glm::dvec3> positions;
  for (std::size_t i = 0; i < count; ++i) positions.emplace_back(0.0, 0.0, static_cast<double>(i));
  return make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0.0)});
}

}  // namespace alidade::test
