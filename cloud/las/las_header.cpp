// SPDX-License-Identifier: MIT
#include "cloud/las/las_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "base/bytes.h"
#include "base/words.h"
#include "cloud/laz/chunk_table.h"

// Byte offsets below are those of the public header block: LAS Specification 1.4 R15, table 3.

namespace alidade {
namespace {

constexpr std::size_t k_shortest_header = 227;    // versions 1.0 to 1.2
constexpr std::uint8_t k_laz_mark = 0x80;         // as it is written
constexpr std::uint8_t k_compressed_bits = 0xc0;  // of the point format: LASzip's marks of LAZ

Lattice read_lattice(const HeaderFields& fields) {
  Lattice lattice;
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t step = 8 * static_cast<std::size_t>(axis), scale_field = 131 + step,
                      offset_field = 155 + step;
    const double scale = fields.get<double>(scale_field), offset = fields.get<double>(offset_field);
    fields.require(std::isfinite(scale) && scale > 0, scale_field,
                   fmt::format("invalid scale of the {} coordinates", "xyz"[axis]), "a positive number",
                   scale);
    fields.require(std::isfinite(std::abs(offset) + scale * 2147483648.0), offset_field,
                   fmt::format("invalid offset of the {} coordinates", "xyz"[axis]), "a finite number",
                   offset);
    lattice.scale[axis] = scale;
    lattice.offset[axis] = offset;
  }
  return lattice;
}

Bounds read_bounds(const HeaderFields& fields) {
  Bounds bounds;
  for (int axis = 0; axis < 3; ++axis) {
    bounds.max[axis] = fields.get<double>(179 + 16 * static_cast<std::size_t>(axis));
    bounds.min[axis] = fields.get<double>(187 + 16 * static_cast<std::size_t>(axis));
    if (!(std::isfinite(bounds.min[axis]) && std::isfinite(bounds.max[axis])) ||
        bounds.min[axis] > bounds.max[axis])
      return {};
  }
  return bounds;
}

std::size_t count_field(const LasHeader& header) {
  return header.version_minor >= 4 ? 247 : 107;
}

void read_point_count(LasHeader& header, const InputFile& file, const HeaderFields& fields,
                      std::vector<std::string>& warnings, Damage damage) {
  const auto legacy_count = fields.get<std::uint32_t>(107);
  header.point_count = legacy_count;
  if (header.version_minor >= 4) {
    const auto count = fields.get<std::uint64_t>(247);
    if (count != 0) header.point_count = count;
    if (legacy_count != 0 && legacy_count != count) {
      warnings.push_back(fmt::format("{}: the header has two numbers of points, {} and {}; reading {}",
                                     file.name(), legacy_count, count, header.point_count));
    }
  }
  if (header.compressed) {
    const std::uint64_t stream_bytes = file.size() - header.points_offset;
    fields.require(header.point_count <= most_laz_points(stream_bytes), count_field(header),
                   "the number of points exceeds the file",
                   fmt::format("at most {} in {} bytes", most_laz_points(stream_bytes), stream_bytes),
                   header.point_count);
    return;
  }
  keep_points_inside(file, header, damage);
}

/// Checks that the extended records begin behind the points; otherwise the file is damaged.
void check_extended_offset(const InputFile& file, LasHeader& header, std::vector<std::string>& warnings,
                           Damage damage) {
  if (header.extended_record_count == 0 || header.extended_records_offset >= header.points_end()) return;
  const Error::Parts parts{.file = file.name(),
                           .location = "byte 235",
                           .problem = "invalid offset of the extended records",
                           .expected = fmt::format("an offset of at least {}", header.points_end()),
                           .found = std::to_string(header.extended_records_offset)};
  if (damage == Damage::reject) throw DamagedFile(parts);
  warnings.push_back(fmt::format("{}; its {} extended records are skipped", Error(parts).what(),
                                 header.extended_record_count));
  header.extended_record_count = 0;
}

}  // namespace

LasHeader read_las_header(InputFile& file, std::vector<std::string>& warnings, Damage damage) {
  std::array<std::byte, k_las_header_size> copy{};
  const std::byte* const bytes = copy.data();
  const std::span<const std::byte> start = file.view_up_to(0, copy.size());
  std::copy(start.begin(), start.end(), copy.begin());
  const HeaderFields fields(copy, file.name());
  fields.require(las_text(bytes, 4) == "LASF", 0, "not a LAS file", "the signature LASF", "");
  fields.require(start.size() >= k_shortest_header, 0, "truncated header",
                 fmt::format("at least {} bytes", k_shortest_header), start.size());

  LasHeader header;
  const int major = fields.get<std::uint8_t>(24);
  header.version_minor = fields.get<std::uint8_t>(25);
  fields.require(major == 1 && header.version_minor <= 4, 24, "unsupported LAS version", "1.0 to 1.4",
                 fmt::format("{}.{}", major, header.version_minor));

  header.header_size = fields.get<std::uint16_t>(94);
  const std::size_t smallest = header.version_minor >= 4 ? k_las_header_size : k_shortest_header;
  fields.require(header.header_size >= smallest && header.header_size <= file.size(), 94,
                 "invalid header size", fmt::format("at least {}, inside the file", smallest),
                 header.header_size);
  // Before versions 1.1 and 1.2 these fields are reserved space with any content.
  if (header.version_minor >= 1) header.file_source_id = fields.get<std::uint16_t>(4);
  if (header.version_minor >= 2) header.global_encoding = fields.get<std::uint16_t>(6);
  std::copy_n(reinterpret_cast<const std::uint8_t*>(bytes + 8), 16, header.project_id.begin());
  header.system_identifier = las_text(bytes + 26, 32);
  header.generating_software = las_text(bytes + 58, 32);
  header.creation_day = fields.get<std::uint16_t>(90);
  header.creation_year = fields.get<std::uint16_t>(92);

  header.points_offset = fields.get<std::uint32_t>(96);
  fields.require(header.points_offset >= header.header_size && header.points_offset <= file.size(), 96,
                 "invalid offset of the points",
                 fmt::format("an offset from {} to {}", header.header_size, file.size()),
                 header.points_offset);
  header.record_count = fields.get<std::uint32_t>(100);
  const auto point_format = fields.get<std::uint8_t>(104);
  header.compressed = (point_format & k_compressed_bits) != 0;
  header.point_format = point_format & ~k_compressed_bits;
  fields.require(header.point_format < k_las_point_formats, 104, "unsupported point format", "0 to 10",
                 header.point_format);
  header.point_size = fields.get<std::uint16_t>(105);
  fields.require(header.point_size >= header.layout().size, 105,
                 fmt::format("record length too short for point format {}", header.point_format),
                 fmt::format("at least {} bytes", header.layout().size), header.point_size);
  header.lattice = read_lattice(fields);
  header.bounds = read_bounds(fields);
  read_point_count(header, file, fields, warnings, damage);

  if (header.version_minor >= 4) {
    header.extended_records_offset = fields.get<std::uint64_t>(235);
    header.extended_record_count = fields.get<std::uint32_t>(243);
    // They followed the lost points.
    if (header.lost_count > 0 && header.extended_record_count > 0) {
      warnings.push_back(fmt::format("{}: the extended records after the points are lost", file.name()));
      header.extended_record_count = 0;
    }
    check_extended_offset(file, header, warnings, damage);
  }
  return header;
}

void keep_points_inside(const InputFile& file, LasHeader& header, Damage damage) {
  const std::uint64_t room = (file.size() - header.points_offset) / header.point_size;
  if (header.point_count <= room) return;
  if (damage == Damage::reject) {
    throw DamagedFile({.file = file.name(),
                       .location = fmt::format("byte {}", count_field(header)),
                       .problem = "truncated file: it ends before its last point",
                       .expected = fmt::format("{} points of {} bytes at byte {}", header.point_count,
                                               header.point_size, header.points_offset),
                       .found = fmt::format("{}", room)});
  }
  header.lost_count = header.point_count - room;
  header.point_count = room;
}

std::array<std::byte, k_las_header_size> encode_las_header(const LasHeader& header) {
  assert(header.point_format >= 6);
  std::array<std::byte, k_las_header_size> copy{};
  std::byte* const bytes = copy.data();
  store_las_text(bytes, 4, "LASF");
  store(bytes + 4, header.file_source_id);
  store(bytes + 6, header.global_encoding);
  store(bytes + 8, header.project_id);
  store<std::uint8_t>(bytes + 24, 1);
  store<std::uint8_t>(bytes + 25, 4);
  store_las_text(bytes + 26, 32, header.system_identifier);
  store_las_text(bytes + 58, 32, header.generating_software);
  store(bytes + 90, header.creation_day);
  store(bytes + 92, header.creation_year);
  store<std::uint16_t>(bytes + 94, k_las_header_size);
  store(bytes + 96, header.points_offset);
  store(bytes + 100, header.record_count);
  store(bytes + 104, static_cast<std::uint8_t>(header.point_format | (header.compressed ? k_laz_mark : 0)));
  store(bytes + 105, header.point_size);
  const bool empty = header.bounds.empty();
  for (int axis = 0; axis < 3; ++axis) {
    store(bytes + 131 + 8 * axis, header.lattice.scale[axis]);
    store(bytes + 155 + 8 * axis, header.lattice.offset[axis]);
    store(bytes + 179 + 16 * axis, empty ? 0.0 : header.bounds.max[axis]);
    store(bytes + 187 + 16 * axis, empty ? 0.0 : header.bounds.min[axis]);
  }
  store(bytes + 235, header.extended_records_offset);
  store(bytes + 243, header.extended_record_count);
  store(bytes + 247, header.point_count);
  store(bytes + 255, header.points_by_return);
  return copy;
}

std::string las_text(const std::byte* field, std::size_t length) {
  const char* const text = reinterpret_cast<const char*>(field);
  return {text, std::find(text, text + length, '\0')};
}

std::string cut_las_text(const std::string& text, std::size_t length) {
  std::size_t count = std::min(length, text.size());
  while (count > 0 && count < text.size() && is_continuation(text[count])) --count;
  return text.substr(0, count);
}

void store_las_text(std::byte* field, std::size_t length, const std::string& text) {
  const std::string kept = cut_las_text(text, length);
  std::memcpy(field, kept.data(), kept.size());
}

}  // namespace alidade
