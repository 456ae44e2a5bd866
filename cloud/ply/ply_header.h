// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "cloud/attributes.h"
#include "cloud/damage.h"

namespace alidade {

enum class PlyFormat { ascii, binary_little_endian, binary_big_endian };

struct PlyProperty {
  std::string name;
  ScalarType type = ScalarType::float32;
  bool is_list = false;
  ScalarType count_type = ScalarType::uint8;  ///< of the number that precedes a list's values
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  /// Bytes one instance takes in a binary file, at least: lists count as empty ones.
  std::uint64_t smallest_size() const;
  bool has_lists() const;
};

/// What stands between "ply" and "end_header".
struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::vector<PlyElement> elements;
  std::size_t vertex = 0;        ///< place of the element "vertex"
  std::uint64_t data_place = 0;  ///< first byte after the header
  std::uint64_t line_count = 0;  ///< lines of the header
};

/// Reads and checks the header. Errors: anything that is not a PLY 1.0 header, no element "vertex" or two of
/// them, vertices without properties; more vertices than the file has room for are damage.
PlyHeader read_ply_header(InputFile& input, Damage damage = Damage::refuse);

/// "binary_little_endian 1.0" and the like.
std::string ply_version(PlyFormat format);

}  // namespace alidade
