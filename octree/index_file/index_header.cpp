// SPDX-License-Identifier: MIT
#include "octree/index_file/index_header.h"

#include <fmt/format.h>
#include <algorithm>
#include <bit>
#include <cmath>

#include "base/bytes.h"
#include "base/error.h"
#include "base/fingerprint.h"
#include "cloud/point_cloud.h"
#include "octree/spacing.h"

namespace alidade {

IndexSection column_section(Attribute attribute) {
  return static_cast<IndexSection>(static_cast<std::uint32_t>(IndexSection::first_column) +
                                   std::countr_zero(static_cast<std::uint32_t>(attribute)));
}

namespace {

/// The sections that are no columns.
constexpr struct {
  IndexSection kind;
  const char* name;
  std::uint32_t element_bytes;
} k_sections[] = {
    {IndexSection::nodes, "nodes", sizeof(Node)},
    {IndexSection::coordinates, "coordinates", sizeof(std::uint16_t)},
    {IndexSection::ids, "ids", sizeof(std::uint32_t)},
    {IndexSection::positions, "positions", sizeof(LatticePosition)},
    {IndexSection::spacings, "spacings", sizeof(std::uint16_t)},
    {IndexSection::slot_spacings, "slot spacings", sizeof(std::uint16_t)},
    {IndexSection::surfaces, "surfaces", sizeof(std::uint32_t)},
    {IndexSection::sheet_edges, "sheet edges", 1},
    {IndexSection::metadata, "metadata", 1},
    {IndexSection::record_data, "record data", 1},
    {IndexSection::checksums, "checksums", sizeof(std::uint64_t)},
};

std::uint32_t column_number(IndexSection kind) {
  return static_cast<std::uint32_t>(kind) - static_cast<std::uint32_t>(IndexSection::first_column);
}

// Offsets below are those of docs/index_file.md.

constexpr std::array<char, 8> k_magic = {'A', 'L', 'I', 'D', 'A', 'D', 'E', '\0'};
constexpr std::uint32_t k_byte_order = 0x01020304, k_other_byte_order = 0x04030201;
constexpr std::size_t k_section_table = 256, k_section_entry = 32;
constexpr std::uint32_t k_flag_standard_gps_time = 1;
constexpr std::uint64_t k_most_points = 0xfffffffeu;
constexpr std::uint32_t k_highest_level = 32;
constexpr auto k_last_organisation = static_cast<std::uint32_t>(Organisation::layered);

std::uint64_t page_checksum(std::span<const std::byte> page) {
  std::array<std::byte, k_index_page> copy;
  std::copy_n(page.begin(), copy.size(), copy.begin());
  store<std::uint64_t>(copy.data() + 32, 0);
  return checksum(copy);
}

/// What comes before all other fields may be trusted.
void check_identity(std::span<const std::byte> file, std::uint64_t file_bytes, const HeaderFields& page,
                    const std::string& file_name) {
  if (!is_index_file(file))
    throw Error({.file = file_name, .location = "byte 0", .problem = "not an Alidade index file"});
  if (file.size() < k_index_page) {
    throw Error({.file = file_name,
                 .location = fmt::format("byte {}", file.size()),
                 .problem = "truncated header",
                 .expected = fmt::format("at least {} bytes", k_index_page),
                 .found = std::to_string(file.size())});
  }
  const auto order = page.get<std::uint32_t>(8);
  page.require(order != k_other_byte_order, 8, "wrong byte order", "little endian", "big endian");
  page.require(order == k_byte_order, 8, "invalid byte order mark", fmt::format("{:#010x}", k_byte_order),
               fmt::format("{:#010x}", order));
  const auto version = page.get<std::uint32_t>(12);
  page.require(version == k_index_version, 12, "unsupported index file version",
               fmt::format("version {} (create the file again with 'alidade index')", k_index_version),
               fmt::format("version {}", version));
  const auto stored = page.get<std::uint64_t>(32), sum = page_checksum(file.first(k_index_page));
  page.require(stored == sum, 32, "corrupt header: wrong checksum", fmt::format("{:016x}", stored),
               fmt::format("{:016x}", sum));
  page.require(page.get<std::uint32_t>(16) == k_index_page, 16, "wrong header size",
               std::to_string(k_index_page), page.get<std::uint32_t>(16));
  page.require(page.get<std::uint64_t>(24) == file_bytes, 24,
               page.get<std::uint64_t>(24) > file_bytes ? "truncated file" : "the file is too long",
               fmt::format("{} bytes", page.get<std::uint64_t>(24)), file_bytes);
}

void read_lattice(const HeaderFields& page, TreeView& tree) {
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t scale_field = 72 + 8 * axis, offset_field = 96 + 8 * axis;
    const auto scale = page.get<double>(scale_field), offset = page.get<double>(offset_field);
    page.require(std::isfinite(scale) && scale > 0.0, scale_field, "invalid lattice scale",
                 "a positive number", scale);
    page.require(std::isfinite(std::abs(offset) + scale * 2147483648.0), offset_field,
                 "invalid lattice offset", "a finite number", offset);
    tree.lattice.scale[axis] = scale;
    tree.lattice.offset[axis] = offset;
    tree.base[axis] = page.get<std::int32_t>(120 + 4 * axis);
  }
}

void read_bounds(const HeaderFields& page, TreeView& tree) {
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t min_field = 136 + 8 * axis, max_field = 160 + 8 * axis;
    const auto min = page.get<double>(min_field), max = page.get<double>(max_field);
    if (tree.point_count > 0) {
      page.require(std::isfinite(min) && std::isfinite(max) && min <= max, min_field, "invalid bounds",
                   "finite numbers, the minimum first", fmt::format("{} to {}", min, max));
    }
    tree.bounds.min[axis] = min;
    tree.bounds.max[axis] = max;
  }
  if (tree.point_count == 0) tree.bounds = {};
}

PointLayers read_layers(const HeaderFields& page) {
  PointLayers layers;
  const auto neighbours = page.get<std::uint32_t>(204);
  page.require(neighbours <= k_most_spacing_neighbours, 204, "invalid number of neighbours for spacings",
               fmt::format("at most {}", k_most_spacing_neighbours), neighbours);
  layers.spacing_neighbours = static_cast<int>(neighbours);
  layers.surface_unit = page.get<double>(208);
  page.require(std::isfinite(layers.surface_unit) && layers.surface_unit >= 0.0 &&
                   (layers.surface_unit == 0.0 || neighbours > 0),
               208, "invalid length unit of surfaces",
               neighbours > 0 ? "0 or a length" : "0 without spacings", layers.surface_unit);
  return layers;
}

TreeView read_tree(const HeaderFields& page) {
  TreeView tree;
  const auto points = page.get<std::uint64_t>(40), nodes = page.get<std::uint64_t>(48);
  page.require(points <= k_most_points, 40, "too many points", fmt::format("at most {}", k_most_points),
               points);
  page.require((points == 0) == (nodes == 0) && nodes <= 0xffffffffu, 48, "invalid number of nodes",
               points == 0 ? "0" : "1 to 4294967295", nodes);
  tree.point_count = static_cast<std::uint32_t>(points);
  tree.node_count = static_cast<std::uint32_t>(nodes);
  const auto level = page.get<std::uint32_t>(56);
  page.require(level >= k_min_frame_level && level <= k_highest_level, 56, "invalid root level",
               fmt::format("{} to {}", k_min_frame_level, k_highest_level), level);
  tree.root_level = static_cast<int>(level);
  const auto level_count = page.get<std::uint32_t>(60);
  page.require(points == 0 ? level_count == 0 : level_count >= 1 && level_count <= k_max_tree_depth, 60,
               "invalid number of levels", points == 0 ? "0" : fmt::format("1 to {}", k_max_tree_depth),
               level_count);
  tree.level_count = static_cast<int>(level_count);
  const auto organisation = page.get<std::uint32_t>(64);
  page.require(organisation <= k_last_organisation, 64, "unknown organisation",
               fmt::format("0 to {}", k_last_organisation), organisation);
  tree.organisation = static_cast<Organisation>(organisation);
  tree.first_exact = page.get<std::uint32_t>(132);
  page.require(tree.first_exact <= points, 132, "invalid storage index of the first exact position",
               fmt::format("at most {}", points), tree.first_exact);
  read_lattice(page, tree);
  read_bounds(page, tree);
  return tree;
}

/// The one size that a section can have; empty where that depends on its contents.
std::optional<std::uint64_t> expected_bytes(const IndexHeader& header, const SectionEntry& section) {
  const std::uint64_t points = header.tree.point_count;
  switch (section.kind) {
    case IndexSection::nodes:
      return std::uint64_t{header.tree.node_count} * sizeof(Node);
    case IndexSection::coordinates:
      return (3 * points + k_coordinate_padding) * sizeof(std::uint16_t);
    case IndexSection::positions:
      return (points - header.tree.first_exact) * sizeof(LatticePosition);
    case IndexSection::spacings:
      return (points + k_coordinate_padding) * sizeof(std::uint16_t);
    case IndexSection::slot_spacings:
      return std::uint64_t{header.tree.node_count} * k_node_width * sizeof(std::uint16_t);
    case IndexSection::checksums: {
      std::uint64_t blocks = 0;
      for (const SectionEntry& entry : header.sections) blocks += checksum_blocks(entry.bytes);
      return blocks * sizeof(std::uint64_t);
    }
    case IndexSection::extra_dimensions:
    case IndexSection::metadata:
    case IndexSection::record_data:
      return std::nullopt;
    default:
      return points * section.element_bytes;
  }
}

SectionEntry read_section(const HeaderFields& page, std::size_t number, const IndexHeader& header) {
  const std::size_t at = k_section_table + number * k_section_entry;
  const auto kind = page.get<std::uint32_t>(at);
  SectionEntry entry{static_cast<IndexSection>(kind), page.get<std::uint32_t>(at + 4),
                     page.get<std::uint64_t>(at + 8), page.get<std::uint64_t>(at + 16),
                     page.get<std::uint64_t>(at + 24)};
  const std::uint32_t element = element_bytes(entry.kind, header.color_factor > 1);
  page.require(element != 0, at, "unknown section", "a kind of version 2", kind);
  page.require(header.sections.empty() || header.sections.back().kind < entry.kind, at,
               "sections out of order", "ascending kinds", kind);
  page.require(entry.element_bytes == element, at + 4,
               fmt::format("wrong element size of {}", name(entry.kind)),
               fmt::format("{} bytes each", element), entry.element_bytes);
  const std::uint64_t begin =
      align_to_page(header.sections.empty() ? k_index_page : header.sections.back().end());
  page.require(entry.offset == begin, at + 8, fmt::format("wrong offset of {}", name(entry.kind)),
               fmt::format("byte {}", begin), fmt::format("byte {}", entry.offset));
  // Offsets stay within the file, since every section before this one did.
  const std::uint64_t room = header.file_bytes - std::min(begin, header.file_bytes);
  page.require(entry.bytes <= room, at + 16, fmt::format("{} exceed the file", name(entry.kind)),
               fmt::format("at most {} bytes", room), entry.bytes);
  const auto expected = expected_bytes(header, entry);
  page.require(!expected || entry.bytes == *expected, at + 16,
               fmt::format("wrong size of {}", name(entry.kind)),
               fmt::format("{} bytes", expected.value_or(0)), entry.bytes);
  return entry;
}

void check_sections(const HeaderFields& page, const IndexHeader& header) {
  for (const IndexSection needed : {IndexSection::nodes, IndexSection::coordinates, IndexSection::metadata,
                                    IndexSection::record_data, IndexSection::checksums}) {
    page.require(header.find(needed) != nullptr, k_section_table,
                 fmt::format("missing section {}", name(needed)), "", "");
  }
  const auto agree = [&](IndexSection kind, bool is_said, const char* section) {
    const bool is_there = header.find(kind) != nullptr;
    page.require(is_there == is_said, k_section_table,
                 fmt::format("the sections do not match the header: {}", name(kind)),
                 is_said ? section : "none", is_there ? "the section" : "none");
  };
  for (const IndexSection kind : {IndexSection::spacings, IndexSection::slot_spacings})
    agree(kind, header.layers.spacing_neighbours > 0, "the section");
  for (const IndexSection kind : {IndexSection::surfaces, IndexSection::sheet_edges})
    agree(kind, header.layers.surface_unit > 0.0, "the section, as 'alidade index --surfaces' writes it");
  agree(column_section(Attribute::color),
        header.color_factor > 1 || header.find(column_section(Attribute::color)) != nullptr, "the section");
  page.require(header.sections.back().end() == header.file_bytes, 24, "extra bytes after the last section",
               fmt::format("{} bytes", header.sections.back().end()), header.file_bytes);
}

}  // namespace

std::uint32_t element_bytes(IndexSection kind, bool colors_are_shallow) {
  if (kind == column_section(Attribute::color) && colors_are_shallow) return 3;
  constexpr std::array<std::uint32_t, 12> k_columns = {6, 2, 2, 1, 2, 1, 4, 1, 2, 8, 12, 1};
  for (const auto& section : k_sections)
    if (section.kind == kind) return section.element_bytes;
  return column_number(kind) < k_columns.size() ? k_columns[column_number(kind)] : 0;
}

std::string name(IndexSection kind) {
  for (const auto& section : k_sections)
    if (section.kind == kind) return section.name;
  AttributeSet attribute;
  attribute.bits = 1u << column_number(kind);
  return "column " + attribute_names(attribute).front();
}

const SectionEntry* IndexHeader::find(IndexSection kind) const {
  const auto found = std::ranges::find(sections, kind, &SectionEntry::kind);
  return found == sections.end() ? nullptr : &*found;
}

bool is_index_file(std::span<const std::byte> start) {
  return start.size() >= k_magic.size() && std::memcmp(start.data(), k_magic.data(), k_magic.size()) == 0;
}

IndexHeader read_index_header(std::span<const std::byte> first_page, std::uint64_t file_bytes,
                              const std::string& file_name) {
  const HeaderFields page(first_page, file_name);
  check_identity(first_page, file_bytes, page, file_name);
  IndexHeader header;
  header.file_bytes = file_bytes;
  header.tree = read_tree(page);
  header.layers = read_layers(page);
  const auto flags = page.get<std::uint32_t>(68);
  page.require(flags <= k_flag_standard_gps_time, 68, "unknown flags", "0 or 1", flags);
  header.gps_time_is_standard = (flags & k_flag_standard_gps_time) != 0;
  header.project_id = page.get<std::array<std::uint8_t, 16>>(184);
  header.file_source_id = page.get<std::uint16_t>(200);
  const auto factor = page.get<std::uint16_t>(216);
  page.require(factor == 0 || std::ranges::find(k_color_factors, factor) != k_color_factors.end(), 216,
               "invalid factor of colours", "0, 256 or 257", factor);
  header.color_factor = std::max<std::uint16_t>(factor, 1);
  const auto section_count = page.get<std::uint32_t>(20);
  page.require(section_count <= k_most_index_sections, 20, "too many sections",
               fmt::format("at most {}", k_most_index_sections), section_count);
  for (std::size_t i = 0; i < section_count; ++i) header.sections.push_back(read_section(page, i, header));
  check_sections(page, header);
  return header;
}

std::array<std::byte, k_index_page> encode_index_header(const IndexHeader& header) {
  std::array<std::byte, k_index_page> page{};
  std::byte* const at = page.data();
  const TreeView& tree = header.tree;
  store(at, k_magic);
  store(at + 8, k_byte_order);
  store(at + 12, k_index_version);
  store<std::uint32_t>(at + 16, k_index_page);
  store(at + 20, static_cast<std::uint32_t>(header.sections.size()));
  store(at + 24, header.file_bytes);
  store<std::uint64_t>(at + 40, tree.point_count);
  store<std::uint64_t>(at + 48, tree.node_count);
  store(at + 56, static_cast<std::uint32_t>(tree.root_level));
  store(at + 60, static_cast<std::uint32_t>(tree.level_count));
  store(at + 64, static_cast<std::uint32_t>(tree.organisation));
  store<std::uint32_t>(at + 68, header.gps_time_is_standard ? k_flag_standard_gps_time : 0);
  store(at + 132, tree.point_count - tree.exact_count());
  for (int axis = 0; axis < 3; ++axis) {
    store(at + 72 + 8 * axis, tree.lattice.scale[axis]);
    store(at + 96 + 8 * axis, tree.lattice.offset[axis]);
    store(at + 120 + 4 * axis, tree.base[axis]);
    store(at + 136 + 8 * axis, tree.point_count > 0 ? tree.bounds.min[axis] : 0.0);
    store(at + 160 + 8 * axis, tree.point_count > 0 ? tree.bounds.max[axis] : 0.0);
  }
  store(at + 184, header.project_id);
  store(at + 200, header.file_source_id);
  store(at + 204, static_cast<std::uint32_t>(header.layers.spacing_neighbours));
  store(at + 208, header.layers.surface_unit);
  store<std::uint16_t>(at + 216, header.color_factor > 1 ? header.color_factor : 0);
  for (std::size_t i = 0; i < header.sections.size(); ++i) {
    const SectionEntry& entry = header.sections[i];
    std::byte* const row = at + k_section_table + i * k_section_entry;
    store(row, entry.kind);
    store(row + 4, entry.element_bytes);
    store(row + 8, entry.offset);
    store(row + 16, entry.bytes);
    store(row + 24, entry.checksum);
  }
  store(at + 32, page_checksum(page));
  return page;
}

}  // namespace alidade
