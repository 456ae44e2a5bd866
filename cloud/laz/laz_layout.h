// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "cloud/point_cloud.h"

// How a LAZ file packs its point data records: the content of its record "laszip encoded" 22204.

namespace alidade {

enum class LazCompressor : std::uint16_t {
  none = 0,               ///< plain LAS records
  pointwise = 1,          ///< one stream of all points
  pointwise_chunked = 2,  ///< formats 0-5: chunks, each one stream
  layered = 3,            ///< formats 6-10: chunks, each attribute its own stream
};

/// Part of a point data record that is packed by rules of its own.
enum class LazItemKind : std::uint16_t {
  byte = 0,  ///< the extra bytes of formats 0-5
  point10 = 6,
  gps_time11 = 7,
  rgb12 = 8,
  wave_packet13 = 9,
  point14 = 10,
  rgb14 = 11,
  rgb_nir14 = 12,
  wave_packet14 = 13,
  byte14 = 14,  ///< the extra bytes of formats 6-10
};

struct LazItem {
  LazItemKind kind = LazItemKind::byte;
  std::uint16_t size = 0;     ///< bytes in the record
  std::uint16_t version = 0;  ///< of the rules

  bool operator==(const LazItem&) const = default;
};

struct LazLayout {
  LazCompressor compressor = LazCompressor::none;
  std::uint32_t chunk_size = 0;  ///< points of every chunk but the last; 0 = chunks of different sizes
  std::vector<LazItem> items;    ///< in the order of their bytes in the record

  /// Bytes of a point data record: the sum of its items.
  std::size_t record_size() const;

  bool operator==(const LazLayout&) const = default;
};

/// Points of a chunk unless a writer decides otherwise.
inline constexpr std::uint32_t k_laz_chunk_size = 50000;

/// Most extra bytes of a point in LAZ: slightly more than the 341 descriptions that fit into a LAS file can
/// describe, at up to 24 bytes each. Every byte has models of its own, up to 7 KB, which are 50 MB in all;
/// without a limit a small file could take ten times as much memory in every thread.
inline constexpr std::size_t k_most_laz_extra_bytes = 8192;

/// Errors: a point has more extra bytes than k_most_laz_extra_bytes. They name `file_name` and, unless it is
/// empty, `location`.
void check_laz_extra_bytes(const LazLayout& layout, const std::string& file_name, std::string location = {});

/// The packing that is written today for a point data record format: compressor 2 with items of version 2 for
/// formats 0-5, compressor 3 with items of version 3 for formats 6-10; wave packets of formats 4 and 5 have
/// version 1. Bytes of the record beyond those of the format are extra bytes. Requires a format of 0 to 10
/// and a record at least as long as the format's, at most 65535 bytes.
LazLayout standard_laz_layout(int point_format, std::size_t record_size,
                              std::uint32_t chunk_size = k_laz_chunk_size);

/// Which attributes of a layered LAZ chunk are wanted; those that the point format lacks are ignored. x, y,
/// returns and scanner channel are always decoded, as all others need them. Attributes left out cost nothing.
struct LazLayers {
  bool z = true;
  bool classification = true;
  bool flags = true;  ///< of the classification, scan direction and edge of flight line
  bool intensity = true;
  bool scan_angle = true;
  bool user_data = true;
  bool point_source = true;
  bool gps_time = true;
  bool color = true;
  bool near_infrared = true;
  bool wave_packet = true;
  bool extra_bytes = true;

  /// Positions and returns, nothing else.
  static constexpr LazLayers positions();
};

/// Layers of a compressed file that hold the attributes that are kept.
constexpr LazLayers layers_of(AttributeSet kept) {
  return {.z = true,
          .classification = kept.contains(Attribute::classification),
          .flags = kept.contains(Attribute::flags),
          .intensity = kept.contains(Attribute::intensity),
          .scan_angle = kept.contains(Attribute::scan_angle),
          .user_data = kept.contains(Attribute::user_data),
          .point_source = kept.contains(Attribute::point_source_id),
          .gps_time = kept.contains(Attribute::gps_time),
          .color = kept.contains(Attribute::color),
          .near_infrared = kept.contains(Attribute::near_infrared),
          .wave_packet = false,
          .extra_bytes = kept.contains(Attribute::extra_dimensions) || kept.contains(Attribute::normal)};
}

constexpr LazLayers LazLayers::positions() {
  return layers_of({});
}

/// Thrown by LAZ decoders for a chunk that no encoder can have written. Contains neither file nor location:
/// the reader of the file turns it into an Error that names file, chunk and point.
struct CorruptChunk : std::runtime_error {
  /// `problem` is one clause in lower case, without full stop; `in_point` counts from 0 within the chunk and
  /// is empty if no point is the cause.
  explicit CorruptChunk(const std::string& problem, std::optional<std::uint64_t> in_point = std::nullopt)
      : std::runtime_error(problem), point(in_point) {}

  std::optional<std::uint64_t> point;
};

inline constexpr const char* k_laszip_user_id = "laszip encoded";
inline constexpr std::uint16_t k_laszip_record_id = 22204;

/// The content of a record "laszip encoded". The items are checked: they are those of the point format in
/// their order, cover a record of `point_size` bytes, and have versions of rules that exist; formats 0-5 are
/// pointwise and formats 6-10 layered. With compressor none, only the compressor is checked. Errors: anything
/// else, and more than k_most_laz_extra_bytes; they name `file_name` and the byte, as the data begin at
/// `offset` of the file.
LazLayout parse_laszip_record(std::span<const std::byte> data, const std::string& file_name,
                              std::uint64_t offset, int point_format, std::size_t point_size);

/// The variable length record "laszip encoded" 22204, which describes how points are packed.
VariableLengthRecord laszip_record(const LazLayout& layout);

}  // namespace alidade
