// SPDX-License-Identifier: MIT
#include "cloud/laz/chunk_table.h"

#include <fmt/format.h>
#include <algorithm>
#include <cassert>
#include <utility>

#include "base/bytes.h"
#include "cloud/laz/entropy_coder.h"
#include "cloud/laz/layered_codec.h"
#include "cloud/laz/shared_models.h"

// Source: the chunk table as laszip 2 and 3 write it. The eight bytes at the start of the points hold the
// offset of the table, or -1 if the writer could not seek; then the last eight bytes before the extended
// records or before the end of the file hold it.

namespace alidade {
namespace {

constexpr std::uint64_t k_table_head_bytes = 8;
constexpr std::uint64_t k_stream_start_bytes = 4;  // what every arithmetic stream begins with

std::uint64_t first_chunk(const LasHeader& header) {
  return header.points_offset + k_laz_table_offset_bytes;
}

/// The offset of the table; 0 if the file does not contain it.
std::uint64_t find_table(InputFile& file, const LasHeader& header) {
  if (file.size() < first_chunk(header)) return 0;
  std::int64_t offset = load<std::int64_t>(file.view(header.points_offset, k_laz_table_offset_bytes).data());
  if (offset == -1) {
    for (const std::uint64_t end : {file.size(), header.extended_records_offset}) {
      if (end < first_chunk(header) + k_laz_table_offset_bytes || end > file.size()) continue;
      offset = load<std::int64_t>(file.view(end - k_laz_table_offset_bytes, k_laz_table_offset_bytes).data());
      const bool inside = offset >= static_cast<std::int64_t>(first_chunk(header)) &&
                          static_cast<std::uint64_t>(offset) + k_table_head_bytes <= end;
      if (inside) return static_cast<std::uint64_t>(offset);
    }
    return 0;
  }
  // A writer that was interrupted leaves an offset that no table can have.
  if (offset <= static_cast<std::int64_t>(header.points_offset)) return 0;
  return static_cast<std::uint64_t>(offset);
}

/// Checks the sums of the table against header and file.
struct TableCheck {
  const InputFile& file;
  const LasHeader& header;
  const LazLayout& layout;
  std::uint64_t table;  // its offset
  std::uint64_t smallest = smallest_chunk(layout);
  std::uint64_t next_offset = first_chunk(header);
  std::uint64_t points_left = header.point_count;

  LazChunk next(std::uint32_t byte_count, std::uint32_t point_count, std::size_t number) {
    const LazChunk chunk{
        next_offset, byte_count,
        layout.chunk_size != 0 ? std::min<std::uint64_t>(layout.chunk_size, points_left) : point_count};
    if (chunk.byte_count < smallest || chunk.byte_count > table - next_offset) {
      fail(fmt::format("invalid size of chunk {} in the chunk table", number),
           fmt::format("{} to {} bytes", smallest, table - next_offset), std::to_string(byte_count));
    }
    const std::uint64_t most = std::min(points_left, most_laz_points(chunk.byte_count));
    if (chunk.point_count == 0 || chunk.point_count > most) {
      fail(fmt::format("invalid number of points of chunk {} in the chunk table", number),
           fmt::format("1 to {}", most), std::to_string(chunk.point_count));
    }
    next_offset += chunk.byte_count;
    points_left -= chunk.point_count;
    return chunk;
  }

  void finish() const {
    if (points_left != 0)
      fail("the chunk table lists fewer points than the header", "all points",
           fmt::format("{} missing", points_left));
    if (next_offset != table)
      fail("the chunks do not end at the chunk table", fmt::format("byte {}", table),
           fmt::format("byte {}", next_offset));
  }

  [[noreturn]] void fail(std::string problem, std::string expected, std::string found) const {
    fail_at_byte(file.name(), table, std::move(problem), std::move(expected), std::move(found));
  }
};

}  // namespace

std::uint64_t smallest_chunk(const LazLayout& layout) {
  if (layout.compressor == LazCompressor::layered) return LayeredChunkHead(layout).size();
  return layout.record_size() + k_stream_start_bytes;
}

std::optional<std::vector<LazChunk>> read_chunk_table(InputFile& file, const LasHeader& header,
                                                      const LazLayout& layout, std::string& missing) {
  const std::uint64_t table = find_table(file, header);
  if (table == 0) {
    if (header.point_count == 0) return std::vector<LazChunk>{};
    missing = "missing offset of the chunk table";
    return std::nullopt;
  }
  if (table < first_chunk(header)) {
    fail_at_byte(file.name(), header.points_offset, "invalid offset of the chunk table",
                 fmt::format("byte {} or later", first_chunk(header)), std::to_string(table));
  }
  if (table > file.size() || file.size() - table < k_table_head_bytes) {
    missing = fmt::format("truncated file: the chunk table at byte {} is missing", table);
    return std::nullopt;
  }
  const std::byte* const head = file.view(table, k_table_head_bytes).data();
  const std::uint32_t version = load<std::uint32_t>(head), count = load<std::uint32_t>(head + 4);
  if (version != 0)
    fail_at_byte(file.name(), table, "unsupported version of the chunk table", "0", std::to_string(version));
  const std::uint64_t room = (table - first_chunk(header)) / smallest_chunk(layout);
  if (count > std::min(room, header.point_count)) {
    fail_at_byte(file.name(), table + 4, "invalid number of chunks",
                 fmt::format("at most {}", std::min(room, header.point_count)), std::to_string(count));
  }
  if (layout.chunk_size != 0) {
    const std::uint64_t needed =
        header.point_count / layout.chunk_size + (header.point_count % layout.chunk_size != 0 ? 1 : 0);
    if (count != needed) {
      fail_at_byte(
          file.name(), table + 4, "invalid number of chunks",
          fmt::format("{} for {} points in chunks of {}", needed, header.point_count, layout.chunk_size),
          std::to_string(count));
    }
  }

  TableCheck check{file, header, layout, table};
  std::vector<LazChunk> chunks;
  if (count > 0) {
    // Two numbers of 32 bits take less than twelve bytes, each in their worst case.
    constexpr std::uint64_t k_most_bytes = 24;
    const std::uint64_t offset = table + k_table_head_bytes;
    const auto bytes = file.view_up_to(offset, count * k_most_bytes + 16);
    if (bytes.size() < k_stream_start_bytes) {
      missing = "truncated chunk table";
      return std::nullopt;
    }
    ArithmeticDecoder decoder(bytes);
    IntegerCompressor numbers(32, 2);
    std::int32_t points = 0, byte_count = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (layout.chunk_size == 0) points = numbers.decode(decoder, points, 0);
      byte_count = numbers.decode(decoder, byte_count, 1);
      if (decoder.failed()) {
        missing = "truncated or corrupt chunk table";
        return std::nullopt;
      }
      chunks.push_back(
          check.next(static_cast<std::uint32_t>(byte_count), static_cast<std::uint32_t>(points), i));
    }
  }
  check.finish();
  return chunks;
}

WalkedChunks walk_layered_chunks(InputFile& file, const LasHeader& header, const LazLayout& layout) {
  LayeredChunkHead head(layout);
  WalkedChunks walked;
  std::uint64_t offset = first_chunk(header), points_left = header.point_count;
  try {
    while (points_left > 0) {
      const std::size_t number = walked.chunks.size();
      try {
        head.read(file.view(offset, head.size()));
      } catch (const CorruptChunk& problem) {
        fail_at_byte(file.name(), offset, fmt::format("chunk {}: {}", number, problem.what()));
      }
      const LazChunk chunk{offset, head.chunk_size(), head.point_count()};
      if (chunk.byte_count > file.size() - offset) {
        fail_at_byte(file.name(), offset, fmt::format("chunk {} exceeds the file", number),
                     fmt::format("at most {} bytes", file.size() - offset), std::to_string(chunk.byte_count));
      }
      const std::uint64_t most = std::min(points_left, most_laz_points(chunk.byte_count));
      if (chunk.point_count > most) {
        fail_at_byte(file.name(), offset + layout.record_size(),
                     fmt::format("invalid number of points of chunk {}", number),
                     fmt::format("1 to {}", most), std::to_string(chunk.point_count));
      }
      points_left -= chunk.point_count;
      offset += chunk.byte_count;
      walked.chunks.push_back(chunk);
    }
  } catch (const Error& error) {
    walked.problem = error;
  }
  return walked;
}

std::vector<std::byte> encode_chunk_table(std::span<const LazChunk> chunks, const LazLayout& layout) {
  assert(chunks.size() <= UINT32_MAX);
  std::vector<std::byte> table(8);  // version 0, number of chunks
  store(table.data() + 4, static_cast<std::uint32_t>(chunks.size()));
  if (chunks.empty()) return table;

  constexpr int k_point_counts = 0, k_byte_counts = 1;  // contexts
  ArithmeticEncoder encoder;
  IntegerCompressor numbers(32, 2);
  std::int32_t points = 0, bytes = 0;  // of the chunk before
  const auto encode = [&](std::int32_t& before, std::uint64_t number, int context) {
    assert(number <= UINT32_MAX);
    const auto value = static_cast<std::int32_t>(static_cast<std::uint32_t>(number));
    numbers.encode(encoder, before, value, context);
    before = value;
  };
  for (const LazChunk& chunk : chunks) {
    if (layout.chunk_size == 0) encode(points, chunk.point_count, k_point_counts);
    encode(bytes, chunk.byte_count, k_byte_counts);
  }
  const std::vector<std::byte> stream = encoder.finish();
  table.insert(table.end(), stream.begin(), stream.end());
  return table;
}

}  // namespace alidade
