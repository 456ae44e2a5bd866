// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <vector>

#include "base/bytes.h"
#include "cloud/laz/laz_layout.h"
#include "cloud/laz/shared_models.h"
#include "tests/cloud/cloud_test_support.h"

namespace alidade::test {

/// The chunks of a LAZ file that is known to be sound, found without the library's reader of LAZ files, so
/// that codecs are tested alone.
struct SampleChunks {
  struct Chunk {
    std::span<const std::byte> bytes;
    std::size_t point_count;
  };

  std::vector<std::byte> file;
  LazLayout layout;
  std::vector<Chunk> chunks;
};

inline SampleChunks sample_chunks(const std::filesystem::path& path) {
  SampleChunks sample{.file = read_bytes(path), .layout = {}, .chunks = {}};
  const std::byte* const bytes = sample.file.data();
  std::size_t at = load<std::uint16_t>(bytes + 94);
  for (std::uint32_t record = load<std::uint32_t>(bytes + 100); record > 0; --record) {
    if (std::memcmp(bytes + at + 2, "laszip encoded", 15) == 0) {
      const std::byte* const packing = bytes + at + 54;
      sample.layout.compressor = static_cast<LazCompressor>(load<std::uint16_t>(packing));
      sample.layout.chunk_size = load<std::uint32_t>(packing + 12);
      for (std::size_t i = 0; i < load<std::uint16_t>(packing + 32); ++i) {
        const std::byte* const item = packing + 34 + 6 * i;
        sample.layout.items.push_back({.kind = static_cast<LazItemKind>(load<std::uint16_t>(item)),
                                       .size = load<std::uint16_t>(item + 2),
                                       .version = load<std::uint16_t>(item + 4)});
      }
    }
    at += 54 + load<std::uint16_t>(bytes + at + 20);
  }
  const bool variable = sample.layout.chunk_size == 0 || sample.layout.chunk_size == UINT32_MAX;
  if (variable) sample.layout.chunk_size = 0;

  std::uint64_t left = load<std::uint32_t>(bytes + 107);
  if (load<std::uint8_t>(bytes + 25) >= 4 && load<std::uint64_t>(bytes + 247) != 0)
    left = load<std::uint64_t>(bytes + 247);
  const std::size_t points = load<std::uint32_t>(bytes + 96);
  if (sample.layout.compressor == LazCompressor::pointwise) {
    sample.chunks.push_back({.bytes = std::span(sample.file).subspan(points), .point_count = left});
    return sample;
  }
  const std::size_t table = load<std::uint64_t>(bytes + points);
  ArithmeticDecoder decoder(std::span(sample.file).subspan(table + 8));
  IntegerCompressor numbers(32, 2);
  std::int32_t count = 0, size = 0;
  std::size_t offset = points + 8;
  for (std::uint32_t chunk = load<std::uint32_t>(bytes + table + 4); chunk > 0; --chunk) {
    if (variable) count = numbers.decode(decoder, count, 0);
    size = numbers.decode(decoder, size, 1);
    const std::size_t point_count =
        static_cast<std::size_t>(variable ? static_cast<std::uint32_t>(count)
                                          : std::min<std::uint64_t>(left, sample.layout.chunk_size));
    sample.chunks.push_back(
        {.bytes = std::span(sample.file).subspan(offset, static_cast<std::uint32_t>(size)),
         .point_count = point_count});
    offset += static_cast<std::uint32_t>(size);
    left -= point_count;
  }
  return sample;
}

}  // namespace alidade::test
