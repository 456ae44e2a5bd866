// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "base/fingerprint.h"

// Gives index files that were tampered with right checksums. Without this a checksum would catch every
// change, and the other checks would never be tested. Offsets are those of docs/index_file.md.

namespace alidade::test {

template <class T>
T get(std::span<const std::byte> bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

template <class T>
void put(std::span<std::byte> bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
}

/// A row of the section table.
struct SectionRow {
  std::size_t row = 0;  ///< byte of the header
  std::uint32_t kind = 0;
  std::uint64_t offset = 0, bytes = 0;
};

/// Rows whose sections lie inside the file.
inline std::vector<SectionRow> section_rows(std::span<const std::byte> file) {
  std::vector<SectionRow> rows;
  if (file.size() < 4096) return rows;
  const std::uint32_t count = std::min<std::uint32_t>(get<std::uint32_t>(file, 20), 32);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::size_t row = 256 + 32 * std::size_t{i};
    const SectionRow section{row, get<std::uint32_t>(file, row), get<std::uint64_t>(file, row + 8),
                             get<std::uint64_t>(file, row + 16)};
    if (section.offset <= file.size() && section.bytes <= file.size() - section.offset)
      rows.push_back(section);
  }
  return rows;
}

/// Gives the header the checksum of its bytes.
inline void seal_header(std::span<std::byte> file) {
  if (file.size() < 4096) return;
  put<std::uint64_t>(file, 32, 0);
  put(file, 32, checksum(file.first(4096)));
}

/// Gives every section its checksums, as far as there is room for them, and seals the header.
inline void seal(std::span<std::byte> file) {
  const std::vector<SectionRow> rows = section_rows(file);
  const auto sums = std::ranges::find(rows, 34u, &SectionRow::kind);
  if (sums != rows.end()) {
    const std::span<std::byte> room = file.subspan(sums->offset, sums->bytes);
    std::size_t used = 0;
    for (const SectionRow& section : rows) {
      if (section.kind == 34) break;
      const std::size_t first = used;
      const std::span<const std::byte> bytes = file.subspan(section.offset, section.bytes);
      for (std::uint64_t block = 0; block < checksum_blocks(section.bytes) && used + 8 <= room.size();
           ++block, used += 8)
        put(room, used, checksum(checksum_block(bytes, block)));
      put(file, section.row + 24, checksum(room.subspan(first, used - first)));
    }
    put(file, sums->row + 24, checksum(room));
  }
  seal_header(file);
}

}  // namespace alidade::test
