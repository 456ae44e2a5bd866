// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "cloud/attributes.h"
#include "cloud/damage.h"

// The header of a PLY file, for points and meshes alike.
// Source: Turk, The PLY Polygon File Format, 1994.

namespace alidade {

/// The encodings of PLY 1.0.
enum class PlyFormat { ascii, binary_little_endian, binary_big_endian };

/// A property as the header declares it.
struct PlyProperty {
  std::string name;
  ScalarType type = ScalarType::float32;
  bool is_list = false;
  ScalarType count_type = ScalarType::uint8;  ///< of the number that precedes a list's values
};

/// An element: rows of the same properties.
struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  /// Fewest bytes of a row in a binary file: with empty lists.
  std::uint64_t smallest_size() const {
    std::uint64_t size = 0;
    for (const PlyProperty& property : properties)
      size += static_cast<std::uint64_t>(scalar_size(property.is_list ? property.count_type : property.type));
    return size;
  }
  bool has_lists() const { return std::ranges::any_of(properties, &PlyProperty::is_list); }
};

/// The lines between "ply" and "end_header".
struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::vector<PlyElement> elements;
  std::size_t vertex = 0;         ///< index of the element "vertex"
  std::uint64_t data_offset = 0;  ///< first byte after the header
  std::uint64_t line_count = 0;   ///< lines of the header
};

/// The value of the line "format", such as "binary_little_endian 1.0".
std::string ply_version(PlyFormat format);

/// Byte order of a binary format.
inline std::endian byte_order(PlyFormat format) {
  return format == PlyFormat::binary_big_endian ? std::endian::big : std::endian::little;
}

/// Reads and checks the header. Errors: anything that is not a PLY 1.0 header; a missing or duplicate element
/// "vertex"; vertices without properties. More vertices than the file has room for are damage.
PlyHeader read_ply_header(InputFile& input, Damage damage);

}  // namespace alidade
