// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "cloud/attributes.h"
#include "octree/octree.h"

// What is in the sections of an index file (docs/index_file.md).

namespace alidade {

/// What a section holds. Attribute columns have the number k_first_column plus the attribute's bit number.
enum class IndexSection : std::uint32_t {
  nodes = 1,
  coordinates = 2,
  ids = 3,
  positions = 4,
  spacings = 5,
  slot_spacings = 6,
  surfaces = 7,
  sheet_edges = 8,
  first_column = 16,
  extra_dimensions = 27,
  metadata = 32,
  record_data = 33,
  checksums = 34,
};

/// The section with the column of an attribute.
IndexSection column_section(Attribute attribute);

/// "nodes", "column gps_time": what messages call a section.
std::string name(IndexSection section);

/// Bytes of one element of a section; 1 where elements have no fixed size. Colours of 8 bits have 3.
std::uint32_t element_bytes(IndexSection kind, bool colors_are_shallow = false);

/// What can be the factor of colours of 8 bits: 65535 = 257 * 255; many LAS files have 256 times 8 bits.
inline constexpr std::array<std::uint16_t, 2> k_color_factors = {257, 256};

// The first page of an index file; docs/index_file.md has it byte by byte.

inline constexpr std::size_t k_index_page = 4096;  ///< the header's size, and what sections are aligned to
inline constexpr std::uint32_t k_index_version = 2;
inline constexpr std::size_t k_most_index_sections = 32;

/// A row of the section table.
struct SectionEntry {
  IndexSection kind = IndexSection::nodes;
  std::uint32_t element_bytes = 1;
  std::uint64_t offset = 0;  ///< byte of the file
  std::uint64_t bytes = 0;
  std::uint64_t checksum = 0;  ///< of its block checksums; of the section itself for IndexSection::checksums

  std::uint64_t end() const { return offset + bytes; }
};

/// The header, field by field.
struct IndexHeader {
  std::uint64_t file_bytes = 0;
  /// Without their arrays: those pointers are null.
  TreeView tree;
  PointLayers layers;
  bool gps_time_is_standard = false;
  std::array<std::uint8_t, 16> project_id{};
  std::uint16_t file_source_id = 0;
  std::uint16_t color_factor = 1;  ///< of colours of 8 bits: 256 or 257 (ColorColumn); 1: they have 16 bits
  std::vector<SectionEntry> sections;  ///< in the order of their kinds, which is that of their offsets

  const SectionEntry* find(IndexSection kind) const;
};

/// Reads the header of a file from its first page, or from the whole of a shorter file. Every count, size and
/// offset is checked against the file's size, the section table for order, gaps and overlaps, and the page
/// against its own checksum. Cost: constant; nothing behind the first page is read. Errors: name the byte; a
/// file of another byte order or version is distinguished from a damaged one.
IndexHeader read_index_header(std::span<const std::byte> page, std::uint64_t file_bytes,
                              const std::string& file_name);

/// The page, checksum included.
std::array<std::byte, k_index_page> encode_index_header(const IndexHeader& header);

/// Whether a file that starts so claims to be an index file.
bool is_index_file(std::span<const std::byte> start);

/// The first offset from this one on where a section may begin.
constexpr std::uint64_t align_to_page(std::uint64_t offset) {
  return (offset + k_index_page - 1) / k_index_page * k_index_page;
}

}  // namespace alidade
