// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "cloud/point_cloud.h"
#include "octree/build.h"
#include "octree/index_file/index_file.h"
#include "tests/cloud/cloud_test_support.h"
#include "tests/support/random.h"

namespace alidade::test {

/// The clouds of these names, index files among them.
inline CloudInputs clouds_of(std::initializer_list<std::filesystem::path> names) {
  return resolve_clouds(std::span(names.begin(), names.size()), index_and_file_formats());
}

/// Opens the index file with these bytes like a file named "memory".
inline IndexFile index_in_memory(std::span<const std::byte> bytes) {
  return IndexFile(InputFile(bytes, "memory"));
}

/// Gives a cloud every attribute with values of any bits, two extra dimensions of one name among them, and
/// everything that a file can say about itself.
inline void fill_everything(PointCloud& cloud, Random& random) {
  const auto fill = [&](Attribute, auto& column, auto&) {
    column.resize(cloud.size());
    for (auto& value : column) {
      std::uint64_t bits[2] = {random.bits(), random.bits()};
      std::memcpy(static_cast<void*>(&value), bits, sizeof value);
    }
  };
  for_each_column(cloud, cloud, fill);
  for (const ScalarType type :
       {ScalarType::uint16, ScalarType::bytes, ScalarType::float64, ScalarType::uint16}) {
    ExtraDimension& dimension = cloud.extra_dimensions.emplace_back();
    dimension.name = type == ScalarType::bytes ? "three bytes" : "value";
    dimension.description = "made up";
    dimension.type = type;
    dimension.byte_count = type == ScalarType::bytes ? 3 : scalar_size(type);
    dimension.has_scale = type == ScalarType::float64;
    dimension.scale = dimension.has_scale ? 0.25 : 1.0;
    if (type == ScalarType::float64) dimension.no_data = {1, 2, 3, 4, 5, 6, 7, 8};
    dimension.values.resize(cloud.size() * static_cast<std::size_t>(dimension.byte_count));
    for (std::uint8_t& value : dimension.values) value = static_cast<std::uint8_t>(random.bits());
  }
  cloud.crs = {.wkt = "PROJCS[\"made up\"]",
               .geotiff_keys = {1, 1, 0, 1, 3072, 0, 1, 25832},
               .geotiff_doubles = {0.5, -1e300},
               .geotiff_ascii = std::string("a|b\0c", 5)};
  cloud.records = {{"somebody", 17, "short", {1, 2, 3}, false},
                   {"", 65535, "", {}, true},
                   {"somebody", 17, "long", std::vector<std::uint8_t>(70000, 9), true}};
  cloud.gps_time_is_standard = true;
  for (std::uint8_t& byte : cloud.project_id) byte = static_cast<std::uint8_t>(random.bits());
  cloud.file_source_id = 513;
  cloud.files = {{"folder/a.las", "LAS", "1.4", 7, cloud.size(), 0, 0, std::nullopt, 0},
                 {"b.xyz", "XYZ", "", std::nullopt, 0, 3, 0, std::nullopt, 0}};
  cloud.scanner_positions = {{"north side", {690000.25, 5325000.5, 601.75}},
                             {"", {-1.0, 0.0, 1e300}, DepthCameraAxes{}}};
  cloud.warnings = {"a.las: is odd", ""};
}

/// Same length and bits, NaNs included.
template <class ColumnA, class ColumnB>
bool equal_bits(const ColumnA& a, const ColumnB& b) {
  return a.size() == b.size() &&
         (a.size() == 0 || std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0);
}

inline bool equal_bits(const ColorColumn& a, const ColorColumn& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

inline void expect_same_dimension(const ExtraDimension& a, const ExtraDimension& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.description, b.description);
  EXPECT_EQ(a.type, b.type);
  EXPECT_EQ(a.byte_count, b.byte_count);
  EXPECT_EQ(a.scale, b.scale);
  EXPECT_EQ(a.offset, b.offset);
  EXPECT_EQ(a.has_scale, b.has_scale);
  EXPECT_EQ(a.has_offset, b.has_offset);
  EXPECT_EQ(a.no_data, b.no_data);
}

inline void expect_same_columns(const AttributeColumns& a, const AttributeColumns& b) {
  for_each_column(a, b, [](Attribute attribute, const auto& column, const auto& other) {
    EXPECT_TRUE(equal_bits(column, other)) << attribute_names(attribute).front();
  });
  ASSERT_EQ(a.extra_dimensions.size(), b.extra_dimensions.size());
  for (std::size_t i = 0; i < a.extra_dimensions.size(); ++i) {
    expect_same_dimension(a.extra_dimensions[i].description, b.extra_dimensions[i].description);
    EXPECT_TRUE(equal_bits(a.extra_dimensions[i].values, b.extra_dimensions[i].values)) << i;
  }
}

/// What two clouds say about themselves beside points, files, warnings and records.
inline void expect_same_facts(const PointCloud& a, const PointCloud& b) {
  EXPECT_EQ(a.lattice, b.lattice);
  EXPECT_EQ(a.crs, b.crs);
  EXPECT_EQ(a.gps_time_is_standard, b.gps_time_is_standard);
  EXPECT_EQ(a.project_id, b.project_id);
  EXPECT_EQ(a.file_source_id, b.file_source_id);
  EXPECT_EQ(a.scanner_positions, b.scanner_positions);
}

}  // namespace alidade::test
