// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "cloud/las/las_header.h"
#include "cloud/laz/chunk_codec.h"
#include "cloud/laz/laz_layout.h"
#include "tests/fuzz/write_seeds.h"

// What the fuzz targets of both LAZ codecs share: their input, what is expected of it, and seeds.

namespace alidade::test {

/// Point formats of a codec.
struct LazFormats {
  int first, count;
  std::uint16_t lowest_version;  ///< of items; the next is tried, too
};
inline constexpr LazFormats k_pointwise_formats{0, 6, 1}, k_layered_formats{6, 5, 3};

/// Input: four bytes that say format, extra bytes, versions of the items and number of points, then a chunk.
struct LazCase {
  std::array<unsigned, 4> head;
  std::size_t point_count;  ///< at least 1
  std::span<const std::byte> chunk;

  LazLayout layout(const LazFormats& formats) const {
    const int format = formats.first + static_cast<int>(head[0]) % formats.count;
    const auto base = static_cast<std::size_t>(k_las_point_layouts[static_cast<std::size_t>(format)].size);
    LazLayout layout = standard_laz_layout(format, base + head[1] % 3);
    for (LazItem& item : layout.items)
      if (item.kind != LazItemKind::wave_packet13)
        item.version = static_cast<std::uint16_t>(formats.lowest_version + head[2] % 2);
    return layout;
  }
};

inline constexpr std::size_t k_laz_case_head = 4;

/// Requires k_laz_case_head bytes or more.
inline LazCase laz_case(std::span<const std::byte> input) {
  LazCase laz{.head = {}, .point_count = 0, .chunk = input.subspan(k_laz_case_head)};
  for (std::size_t i = 0; i < k_laz_case_head; ++i) laz.head[i] = std::to_integer<unsigned>(input[i]);
  laz.point_count = std::max(laz.head[3], 1u);
  return laz;
}

struct LazCodecs {
  explicit LazCodecs(const LazLayout& layout)
      : decoder(layout, {}), of_positions(layout, LazLayers::positions()), encoder(layout) {}

  ChunkDecoder decoder, of_positions;
  ChunkEncoder encoder;
};

/// Codecs take longer to make than to use, and have to be as good as new for every chunk.
inline LazCodecs& codecs_for(const LazLayout& layout) {
  static std::vector<std::pair<LazLayout, std::unique_ptr<LazCodecs>>> known;
  for (const auto& [of, codecs] : known)
    if (of == layout) return *codecs;
  known.emplace_back(layout, std::make_unique<LazCodecs>(layout));
  return *known.back().second;
}

/// The records of a chunk, and how many bytes it took.
inline std::pair<std::vector<std::byte>, std::size_t> unpacked(ChunkDecoder& decoder, const LazLayout& layout,
                                                               std::span<const std::byte> chunk,
                                                               std::size_t point_count) {
  std::vector<std::byte> all;
  const std::size_t used =
      decoder.decode(chunk, point_count, [&](const std::byte* records, std::size_t count, std::uint64_t) {
        all.insert(all.end(), records, records + count * layout.record_size());
      });
  return {std::move(all), used};
}

/// Any bytes as a chunk: CorruptChunk, or records whose positions alone are the same, and that are the same
/// once packed and unpacked again.
inline void fuzz_laz(const std::uint8_t* data, std::size_t size, const LazFormats& formats) {
  if (size < k_laz_case_head) return;
  const LazCase laz = laz_case(std::as_bytes(std::span(data, size)));
  const LazLayout layout = laz.layout(formats);
  LazCodecs& codecs = codecs_for(layout);
  std::vector<std::byte> records;
  try {
    std::size_t used = 0;
    std::tie(records, used) = unpacked(codecs.decoder, layout, laz.chunk, laz.point_count);
    if (used > laz.chunk.size()) std::abort();
  } catch (const CorruptChunk&) {
    return;
  }
  const std::vector<std::byte> positions =
      unpacked(codecs.of_positions, layout, laz.chunk, laz.point_count).first;
  for (std::size_t at = 0; at < records.size(); at += layout.record_size())
    if (std::memcmp(records.data() + at, positions.data() + at, 12) != 0) std::abort();
  const std::vector<std::byte> chunk = codecs.encoder.encode(records);
  const auto [again, used] = unpacked(codecs.decoder, layout, chunk, laz.point_count);
  if (again != records || used != chunk.size()) std::abort();
}

/// Writes small chunks of all formats: every record repeats most of the one before.
inline int write_laz_seeds(const std::string& folder, const LazFormats& formats) {
  std::mt19937 random(1);
  std::vector<std::string> seeds;
  for (char format = 0; format < formats.count; ++format)
    for (char version = 0; version < 2; ++version)
      for (const char points : {1, 2, 40}) {
        std::string seed{format, static_cast<char>(format % 3), version, points};
        const LazCase laz = laz_case(std::as_bytes(std::span(seed)));
        const LazLayout layout = laz.layout(formats);
        const std::size_t size = layout.record_size();
        std::vector<std::byte> records(laz.point_count * size);
        for (std::size_t i = size; i < records.size(); ++i) {
          records[i] = records[i - size];
          if (random() % 8 == 0) records[i] = static_cast<std::byte>(random() >> 8);
        }
        for (const std::byte byte : ChunkEncoder(layout).encode(records)) seed += static_cast<char>(byte);
        seeds.push_back(seed);
      }
  return write_seeds(folder, seeds);
}

}  // namespace alidade::test
