// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "cloud/attributes.h"
#include "cloud/damage.h"

namespace alidade {

/// Decodes LZF, the compression inside PCD's binary_compressed. A control byte c below 32 precedes c + 1
/// literal bytes. Any other refers back: its upper three bits are length - 2 (7: the next byte is added), its
/// lower five bits and the byte behind the length are distance - 1.
/// Fills `output` from `input`. Returns false unless both are used up exactly and every reference points into
/// the decoded bytes. Cost: linear in the output.
bool decode_lzf(std::span<const std::byte> input, std::span<std::byte> output);

/// Most decoded bytes per byte of an LZF stream: three bytes decode to at most 264.
constexpr std::size_t k_lzf_largest_ratio = 88;

enum class PcdFormat { ascii, binary, binary_compressed };

struct PcdField {
  std::string name;
  ScalarType type = ScalarType::float32;
  std::uint64_t count = 1;  ///< values per point

  std::uint64_t size() const { return count * static_cast<std::uint64_t>(scalar_size(type)); }
};

/// The pose of the sensor of a PCD file.
struct PcdViewpoint {
  glm::dvec3 position{0.0};
  glm::dmat3 rotation{1.0};  ///< from the sensor's axes to those of the file
};

/// The header of a PCD file, version 0.5 to 0.7.
struct PcdHeader {
  std::string version;
  std::vector<PcdField> fields;
  std::uint64_t point_count = 0;
  std::uint64_t width = 0, height = 1;    ///< of a grid in rows, if height is above 1
  std::optional<PcdViewpoint> viewpoint;  ///< empty if it is missing or invalid
  bool has_invalid_viewpoint = false;
  PcdFormat format = PcdFormat::ascii;
  std::uint64_t data_offset = 0;  ///< first byte after the header
  std::uint64_t line_count = 0;   ///< lines of the header

  /// Bytes of a point in a binary file.
  std::uint64_t point_size() const;
  /// Values of a point.
  std::uint64_t value_count() const;
};

/// Reads and checks the header. Errors: anything that is not a PCD header, points without values; more points
/// than the file has room for are damage. A VIEWPOINT that is not seven finite numbers, or whose quaternion
/// has a length beyond 1e-100 to 1e100, is invalid; other quaternions are normalized.
PcdHeader read_pcd_header(InputFile& input, Damage damage = Damage::reject);

}  // namespace alidade
