// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "cloud/laz/entropy_coder.h"
#include "cloud/laz/layered_codec.h"
#include "cloud/laz/laz_layout.h"
#include "cloud/laz/pointwise_codec.h"
#include "cloud/laz/shared_models.h"
#include "tests/cloud/las/las_builder.h"

// LAZ files of every kind a writer may choose, for tests. Header, records and table are put together by hand;
// only the chunks come from the library's encoders, which have tests of their own.

namespace alidade::test {

/// Data of the record "laszip encoded" 22204, field by field.
inline std::vector<std::uint8_t> laszip_data(const LazLayout& layout) {
  ByteSink sink;
  sink.add<std::uint16_t>(static_cast<std::uint16_t>(layout.compressor)).add<std::uint16_t>(0);
  sink.add<std::uint8_t>(3).add<std::uint8_t>(4).add<std::uint16_t>(3).add<std::uint32_t>(0);
  sink.add<std::uint32_t>(layout.chunk_size == 0 ? 0xffffffff : layout.chunk_size);
  sink.add<std::int64_t>(-1).add<std::int64_t>(-1);
  sink.add<std::uint16_t>(static_cast<std::uint16_t>(layout.items.size()));
  for (const LazItem& item : layout.items) {
    sink.add<std::uint16_t>(static_cast<std::uint16_t>(item.kind));
    sink.add<std::uint16_t>(item.size).add<std::uint16_t>(item.version);
  }
  const std::vector<std::byte> bytes = sink.take();
  const auto* const first = reinterpret_cast<const std::uint8_t*>(bytes.data());
  return {first, first + bytes.size()};
}

enum class TableLocation {
  at_start,  ///< the offset of the table is before the chunks
  at_end,    ///< -1 is before the chunks, the offset follows the table
  unknown,   ///< as a writer that was interrupted leaves it; there is no table
};

struct LazOptions {
  /// Points of every chunk. The last number may exceed the points left. Compressor 1 does not use them.
  std::vector<std::uint32_t> chunk_sizes = {7};
  bool variable = false;    ///< the table lists the counts
  bool one_stream = false;  ///< compressor 1
  TableLocation table = TableLocation::at_start;
};

struct PackedChunk {
  std::uint32_t byte_count, point_count;
};

/// The chunk table: version, number of chunks, and their sizes as one arithmetic stream.
inline std::vector<std::byte> laz_chunk_table(const std::vector<PackedChunk>& chunks, bool variable) {
  ByteSink sink;
  sink.add<std::uint32_t>(0).add<std::uint32_t>(static_cast<std::uint32_t>(chunks.size()));
  std::vector<std::byte> table = sink.take();
  if (chunks.empty()) return table;
  ArithmeticEncoder encoder;
  IntegerCompressor numbers(32, 2);
  PackedChunk before{0, 0};
  const auto add = [&](std::uint32_t last, std::uint32_t now, int context) {
    numbers.encode(encoder, static_cast<std::int32_t>(last), static_cast<std::int32_t>(now), context);
  };
  for (const PackedChunk& chunk : chunks) {
    if (variable) add(before.point_count, chunk.point_count, 0);
    add(before.byte_count, chunk.byte_count, 1);
    before = chunk;
  }
  const std::vector<std::byte> stream = encoder.finish();
  table.insert(table.end(), stream.begin(), stream.end());
  return table;
}

/// The bytes of the LAZ file that holds what `file` holds.
inline std::vector<std::byte> build_laz(LasFile file, const LazOptions& options = {}) {
  const int size = k_las_point_sizes[static_cast<std::size_t>(file.point_format)] + file.extra_bytes;
  const std::size_t point_size = static_cast<std::size_t>(size);
  LazLayout layout =
      standard_laz_layout(file.point_format, point_size, options.variable ? 0 : options.chunk_sizes.front());
  if (options.one_stream) layout.compressor = LazCompressor::pointwise;
  file.records.push_back({"laszip encoded", 22204, "http://laszip.org", laszip_data(layout)});
  std::vector<std::byte> las = build_las(file);
  las[104] |= std::byte{128};
  std::uint32_t points_offset = 0;
  std::memcpy(&points_offset, las.data() + 96, 4);
  const std::size_t points_bytes = file.points.size() * point_size;
  std::vector<std::byte> laz(las.begin(), las.begin() + points_offset);
  const std::span<const std::byte> points(las.data() + points_offset, points_bytes);
  const auto put = [&laz](std::size_t offset, auto value) {
    std::memcpy(laz.data() + offset, &value, sizeof value);
  };

  if (options.one_stream) {
    if (!points.empty()) {
      PointwiseEncoder encoder(layout);
      const std::vector<std::byte> stream = encoder.encode(points);
      laz.insert(laz.end(), stream.begin(), stream.end());
    }
  } else {
    laz.resize(laz.size() + 8);
    put(points_offset, std::int64_t{0});
    std::vector<PackedChunk> chunks;
    for (std::size_t first = 0; first < file.points.size();) {
      const std::size_t wanted = options.chunk_sizes[std::min(chunks.size(), options.chunk_sizes.size() - 1)];
      const std::size_t count = std::min(wanted, file.points.size() - first);
      const std::span<const std::byte> records = points.subspan(first * point_size, count * point_size);
      std::vector<std::byte> chunk;
      if (layout.compressor == LazCompressor::layered) {
        chunk = LayeredEncoder(layout).encode(records);
      } else {
        chunk = PointwiseEncoder(layout).encode(records);
      }
      laz.insert(laz.end(), chunk.begin(), chunk.end());
      chunks.push_back({static_cast<std::uint32_t>(chunk.size()), static_cast<std::uint32_t>(count)});
      first += count;
    }
    const std::int64_t offset = static_cast<std::int64_t>(laz.size());
    if (options.table != TableLocation::unknown) {
      const std::vector<std::byte> table = laz_chunk_table(chunks, options.variable);
      laz.insert(laz.end(), table.begin(), table.end());
    }
    if (options.table == TableLocation::at_start) put(points_offset, offset);
    if (options.table == TableLocation::at_end) {
      put(points_offset, std::int64_t{-1});
      laz.resize(laz.size() + 8);
      put(laz.size() - 8, offset);
    }
  }
  if (file.version_minor >= 4 && !file.extended_records.empty()) put(235, std::uint64_t{laz.size()});
  laz.insert(laz.end(), las.begin() + static_cast<std::ptrdiff_t>(points_offset + points_bytes), las.end());
  return laz;
}

}  // namespace alidade::test
