// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>

namespace alidade {

/// What the first record of a COPC file says: the root of an octree of chunks. Source: COPC 1.0.
struct CopcInfo {
  glm::dvec3 centre{0.0};            ///< of the root, world coordinates
  double half_size = 0.0;            ///< from the centre to each face: the root is a cube
  double spacing = 0.0;              ///< distance of points aimed at in the root; halved by every level
  std::uint64_t root_page = 0;       ///< where the hierarchy begins
  std::uint64_t root_page_size = 0;  ///< bytes
};

/// Reads the record's data. Errors: another size, numbers that are not finite or not positive, a cube whose
/// corners are no finite numbers.
CopcInfo parse_copc_info(std::span<const std::byte> data, const std::string& file_name, std::uint64_t place);

}  // namespace alidade
