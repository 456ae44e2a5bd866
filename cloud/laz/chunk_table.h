// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/input_file.h"
#include "cloud/las/las_header.h"
#include "cloud/laz/laz_layout.h"

namespace alidade {

/// One chunk of a LAZ file.
struct LazChunk {
  std::uint64_t offset = 0;  ///< first byte in the file
  std::uint64_t byte_count = 0;
  std::uint64_t point_count = 0;

  bool operator==(const LazChunk&) const = default;
};

/// Bytes before the first chunk that contain the offset of the chunk table.
inline constexpr std::size_t k_laz_table_offset_bytes = 8;

/// Most points that so many bytes can encode: any point costs one symbol of 64 or more and three of 33 (two
/// with compressor 3). No symbol is ever more probable than 1 - (symbols - 1) / 2^15. That is above 0.007
/// bit, or fewer than 1200 points per byte; counts beyond 2048 per byte are rejected.
constexpr std::uint64_t most_laz_points(std::uint64_t byte_count) {
  constexpr std::uint64_t k_most_per_byte = 2048;
  return byte_count > UINT64_MAX / k_most_per_byte ? UINT64_MAX : byte_count * k_most_per_byte;
}

/// Fewest bytes a chunk can have.
std::uint64_t smallest_chunk(const LazLayout& layout);

/// The chunks as the table of the file lists them, in the order of the file. Their sizes fill the space
/// between the start of the points and the table, their counts add up to the header's. Empty, with the reason
/// in `missing` (one clause), if the file has no table or it is truncated. Errors: the table contradicts the
/// file or the header. Requires compressor 2 or 3. Memory: in proportion to the table's part of the file.
std::optional<std::vector<LazChunk>> read_chunk_table(InputFile& file, const LasHeader& header,
                                                      const LazLayout& layout, std::string& missing);

/// The chunks of a layered file, found by the sizes in their own heads, for files without a table.
struct WalkedChunks {
  std::vector<LazChunk> chunks;
  std::optional<Error> problem;  ///< why there are not as many points as the header counts
};

/// Walks from chunk to chunk until all points of the header are found or a chunk is invalid. Cost: reads only
/// the head of every chunk.
WalkedChunks walk_layered_chunks(InputFile& file, const LasHeader& header, const LazLayout& layout);

/// The chunk table of a LAZ file, which follows the chunks: how many bytes each takes and, for chunks of
/// different sizes (LazLayout::chunk_size 0), how many points. Requires the chunks in the order of the file,
/// sizes below 2^32 and less than 2^32 chunks.
std::vector<std::byte> encode_chunk_table(std::span<const LazChunk> chunks, const LazLayout& layout);

}  // namespace alidade
