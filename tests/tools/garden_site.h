// SPDX-License-Identifier: MIT
#pragma once

#include <cstring>

#include "cloud/las/write_las.h"
#include "cloud/read_cloud.h"
#include "tests/tools/program_words.h"
#include "tests/tools/run_program.h"

namespace alidade::test {

/// A wall between two patches of ground, with attributes of all kinds: rows of the wall have class 6.
inline PointCloud garden() {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(0.001), .offset = {690000, 5325000, 600}};
  for (int x = 0; x <= 80; ++x) {
    for (int y = 0; y <= 80; ++y) cloud.positions.emplace_back(250 * x, 250 * y, 0);
  }
  for (int y = 0; y <= 80; ++y) {
    for (int z = 1; z <= 12; ++z) cloud.positions.emplace_back(10000, 250 * y, 250 * z);
  }
  ExtraDimension own;
  own.name = "Own";
  own.type = ScalarType::uint16;
  own.byte_count = 2;
  for (std::size_t id = 0; id < cloud.size(); ++id) {
    cloud.classifications.push_back(cloud.positions[id].z > 0 ? 6 : 2);
    cloud.intensities.push_back(static_cast<std::uint16_t>(7 * id));
    cloud.gps_times.push_back(0.5 * static_cast<double>(id));
    cloud.colors.emplace_back(static_cast<std::uint16_t>(id), 257, 65535);
    own.values.push_back(static_cast<std::uint8_t>(id));
    own.values.push_back(3);
  }
  cloud.extra_dimensions.push_back(own);
  cloud.crs.wkt = R"(LOCAL_CS["garden",UNIT["metre",1]])";
  cloud.records.push_back({.user_id = "garden", .record_id = 77, .description = "kept", .data = {1, 2, 3}});
  return cloud;
}

inline const ExtraDimension* find_dimension(const PointCloud& cloud, const std::string& name) {
  for (const ExtraDimension& dimension : cloud.extra_dimensions) {
    if (dimension.name == name) return &dimension;
  }
  return nullptr;
}

template <class Value>
std::vector<Value> values(const PointCloud& cloud, const std::string& name, ScalarType type) {
  const ExtraDimension* const dimension = find_dimension(cloud, name);
  if (dimension == nullptr || dimension->type != type) {
    ADD_FAILURE() << name << " is missing, or of another type";
    return std::vector<Value>(cloud.size());
  }
  std::vector<Value> all(cloud.size());
  std::memcpy(all.data(), dimension->values.data(), all.size() * sizeof(Value));
  return all;
}

/// A test of `visibility points`.
class VisibilityPointsTest : public ProgramTest {
 protected:
  void write_garden() { write_las(folder / "garden.las", garden()); }
  PointCloud read_output(const std::string& name) const { return read_cloud(folder / name); }
};

inline const Words k_points = {"visibility", "points", "garden.las"};
inline const std::string k_eye = "690005,5325010,601.7";

}  // namespace alidade::test
