// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace alidade {

/// What a point can have beside its position. Values are bits of an AttributeSet.
enum class Attribute : std::uint32_t {
  color = 1u << 0,
  near_infrared = 1u << 1,
  intensity = 1u << 2,
  classification = 1u << 3,
  returns = 1u << 4,
  flags = 1u << 5,
  scan_angle = 1u << 6,
  user_data = 1u << 7,
  point_source_id = 1u << 8,
  gps_time = 1u << 9,
  normal = 1u << 10,
  extra_dimensions = 1u << 11,
};

/// A set of attributes.
struct AttributeSet {
  std::uint32_t bits = 0;

  constexpr AttributeSet() = default;
  constexpr AttributeSet(Attribute attribute)
      : bits(static_cast<std::uint32_t>(attribute)) {}  // NOLINT(google-explicit-constructor)
  static constexpr AttributeSet all() {
    AttributeSet set;
    set.bits = (1u << 12) - 1;
    return set;
  }
  constexpr bool contains(Attribute attribute) const {
    return (bits & static_cast<std::uint32_t>(attribute)) != 0;
  }
  constexpr AttributeSet operator|(AttributeSet other) const {
    other.bits |= bits;
    return other;
  }
  constexpr AttributeSet operator&(AttributeSet other) const {
    other.bits &= bits;
    return other;
  }
  constexpr bool operator==(const AttributeSet&) const = default;
};

constexpr AttributeSet operator|(Attribute a, Attribute b) {
  return AttributeSet(a) | AttributeSet(b);
}

/// Colour over the full 16-bit range: 65535 is full, for files of any depth. Display-referred (sRGB).
using Color16 = glm::u16vec3;

/// Which return of its pulse a point is, and how many there were; 1-based, up to 15. 0 if the file does not
/// state it.
struct ReturnNumbers {
  std::uint8_t number = 0;
  std::uint8_t count = 0;
  bool operator==(const ReturnNumbers&) const = default;
};

/// The single bits and the scanner channel of a LAS point, packed as in LAS 1.4 point format 6 (byte 15):
/// bit 0 synthetic, 1 key point, 2 withheld, 3 overlap, 4-5 scanner channel, 6 scan direction, 7 edge of
/// flight line.
using PointFlags = std::uint8_t;

/// Type of a value of an extra dimension; numbers are those of the LAS 1.4 extra-bytes record (0 =
/// `byte_count` undocumented bytes).
enum class ScalarType : std::uint8_t {
  bytes = 0,
  uint8 = 1,
  int8 = 2,
  uint16 = 3,
  int16 = 4,
  uint32 = 5,
  int32 = 6,
  uint64 = 7,
  int64 = 8,
  float32 = 9,
  float64 = 10,
};

/// Bytes of one value; 0 for ScalarType::bytes, whose length is a property of the dimension.
constexpr int scalar_size(ScalarType type) {
  constexpr int sizes[] = {0, 1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return sizes[static_cast<int>(type)];
}

/// A column of values that is not one of the standard attributes: LAS extra bytes, or another PLY property.
struct ExtraDimension {
  std::string name;         ///< at most 32 bytes in LAS
  std::string description;  ///< at most 32 bytes in LAS
  ScalarType type = ScalarType::float64;
  int byte_count = 8;  ///< bytes per point
  double scale = 1.0;  ///< meaning of a value: offset + scale * stored
  double offset = 0.0;
  bool has_scale = false;  ///< whether the file stated a scale
  bool has_offset = false;
  /// The nodata value, if the file has one; as in the LAS record, widened to 8 bytes.
  std::optional<std::array<std::uint8_t, 8>> no_data{};
  std::vector<std::uint8_t> values;  ///< byte_count bytes per point, little endian, in point order
};

/// A dimension of unscaled numbers, without values. Requires a type other than ScalarType::bytes.
inline ExtraDimension plain_dimension(std::string name, ScalarType type, std::string description = {}) {
  return {.name = std::move(name),
          .description = std::move(description),
          .type = type,
          .byte_count = scalar_size(type),
          .values = {}};
}

}  // namespace alidade
