// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

// How a LAZ file packs its point data records: what the record "laszip encoded" 22204 of the file says.

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

/// Most extra bytes of a point in LAZ: as many as the 341 descriptions that fit into a LAS file can describe,
/// at up to 24 bytes each, and some. Every byte has models of its own, up to 7 KB, which are 50 MB in all;
/// without a limit a small file could take ten times as much of every thread.
inline constexpr std::size_t k_most_laz_extra_bytes = 8192;

/// Errors: a point has more extra bytes than that. They name `file_name` and, unless it is empty, `place`.
void check_laz_extra_bytes(const LazLayout& layout, const std::string& file_name, std::string place = {});

/// The packing that is written today for a point data record format: compressor 2 with items of version 2 for
/// formats 0-5, compressor 3 with items of version 3 for formats 6-10; wave packets of formats 4 and 5 have
/// version 1. What the record is longer than the format demands are extra bytes. Requires a format of 0 to 10
/// and a record at least as long as the format's, at most 65535 bytes.
LazLayout standard_laz_layout(int point_format, std::size_t record_size,
                              std::uint32_t chunk_size = k_laz_chunk_size);

}  // namespace alidade
