// SPDX-License-Identifier: MIT
#include "cloud/las/las_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "base/bytes.h"
#include "base/error.h"
#include "cloud/laz/chunk_table.h"

// Byte positions below are those of the public header block: LAS Specification 1.4 R15, table 3.

namespace alidade {
namespace {

constexpr std::size_t k_shortest_header = 227;    // versions 1.0 to 1.2
constexpr std::uint8_t k_laz_mark = 0x80;         // what is written
constexpr std::uint8_t k_compressed_bits = 0xc0;  // of the point format: how LASzip marks its files

/// What a header field must be, and an Error if it is not.
void require(bool holds, const InputFile& file, int byte, std::string problem, std::string expected,
             std::string found) {
  if (holds) return;
  throw Error({.file = file.name(),
               .place = fmt::format("byte {}", byte),
               .problem = std::move(problem),
               .expected = std::move(expected),
               .found = std::move(found)});
}

Lattice read_lattice(const InputFile& file, const std::byte* bytes) {
  Lattice lattice;
  for (int axis = 0; axis < 3; ++axis) {
    const int scale_place = 131 + 8 * axis, offset_place = 155 + 8 * axis;
    const double scale = load<double>(bytes + scale_place), offset = load<double>(bytes + offset_place);
    require(std::isfinite(scale) && scale > 0, file, scale_place,
            fmt::format("bad scale of the {} coordinates", "xyz"[axis]), "a positive number",
            fmt::format("{}", scale));
    require(std::isfinite(std::abs(offset) + scale * 2147483648.0), file, offset_place,
            fmt::format("bad offset of the {} coordinates", "xyz"[axis]), "a finite number",
            fmt::format("{}", offset));
    lattice.scale[axis] = scale;
    lattice.offset[axis] = offset;
  }
  return lattice;
}

Bounds read_bounds(const std::byte* bytes) {
  Bounds bounds;
  for (int axis = 0; axis < 3; ++axis) {
    bounds.max[axis] = load<double>(bytes + 179 + 16 * axis);
    bounds.min[axis] = load<double>(bytes + 187 + 16 * axis);
    if (!(std::isfinite(bounds.min[axis]) && std::isfinite(bounds.max[axis])) ||
        bounds.min[axis] > bounds.max[axis])
      return {};
  }
  return bounds;
}

int place_of_count(const LasHeader& header) {
  return header.version_minor >= 4 ? 247 : 107;
}

void read_point_count(LasHeader& header, const InputFile& file, const std::byte* bytes,
                      std::vector<std::string>& warnings, Damage damage) {
  const std::uint32_t legacy_count = load<std::uint32_t>(bytes + 107);
  header.point_count = legacy_count;
  if (header.version_minor >= 4) {
    const std::uint64_t count = load<std::uint64_t>(bytes + 247);
    if (count != 0) header.point_count = count;
    if (legacy_count != 0 && legacy_count != count) {
      warnings.push_back(
          fmt::format("{}: the header counts {} points in one place and {} in another; {} are read",
                      file.name(), legacy_count, count, header.point_count));
    }
  }
  if (header.compressed) {
    const std::uint64_t stream_bytes = file.size() - header.points_place;
    require(header.point_count <= most_laz_points(stream_bytes), file, place_of_count(header),
            "the file is too small for the points it counts",
            fmt::format("at most {} in {} bytes", most_laz_points(stream_bytes), stream_bytes),
            std::to_string(header.point_count));
    return;
  }
  keep_points_inside(file, header, damage);
}

}  // namespace

LasHeader read_las_header(InputFile& file, std::vector<std::string>& warnings, Damage damage) {
  std::array<std::byte, k_las_header_size> copy{};
  const std::byte* const bytes = copy.data();
  const std::span<const std::byte> start = file.view_up_to(0, copy.size());
  std::copy(start.begin(), start.end(), copy.begin());
  require(las_text(bytes, 4) == "LASF", file, 0, "is not a LAS file", "the letters LASF", "something else");
  require(start.size() >= k_shortest_header, file, 0, "the file ends inside its header",
          fmt::format("at least {} bytes", k_shortest_header), std::to_string(start.size()));

  LasHeader header;
  const int major = load<std::uint8_t>(bytes + 24);
  header.version_minor = load<std::uint8_t>(bytes + 25);
  require(major == 1 && header.version_minor <= 4, file, 24, "unknown LAS version", "1.0 to 1.4",
          fmt::format("{}.{}", major, header.version_minor));

  header.header_size = load<std::uint16_t>(bytes + 94);
  const std::size_t smallest = header.version_minor >= 4 ? k_las_header_size : k_shortest_header;
  require(header.header_size >= smallest && header.header_size <= file.size(), file, 94,
          "bad size of the header", fmt::format("{} or more, inside the file", smallest),
          std::to_string(header.header_size));
  // The fields before version 1.1 and 1.2 are reserved space with any content.
  if (header.version_minor >= 1) header.file_source_id = load<std::uint16_t>(bytes + 4);
  if (header.version_minor >= 2) header.global_encoding = load<std::uint16_t>(bytes + 6);
  std::copy_n(reinterpret_cast<const std::uint8_t*>(bytes + 8), 16, header.project_id.begin());
  header.system_identifier = las_text(bytes + 26, 32);
  header.generating_software = las_text(bytes + 58, 32);
  header.creation_day = load<std::uint16_t>(bytes + 90);
  header.creation_year = load<std::uint16_t>(bytes + 92);

  header.points_place = load<std::uint32_t>(bytes + 96);
  require(header.points_place >= header.header_size && header.points_place <= file.size(), file, 96,
          "bad place of the points", fmt::format("a byte from {} to {}", header.header_size, file.size()),
          std::to_string(header.points_place));
  header.record_count = load<std::uint32_t>(bytes + 100);
  const std::uint8_t point_format = load<std::uint8_t>(bytes + 104);
  header.compressed = (point_format & k_compressed_bits) != 0;
  header.point_format = point_format & ~k_compressed_bits;
  require(header.point_format < k_las_point_formats, file, 104, "unknown point format", "0 to 10",
          std::to_string(header.point_format));
  header.point_size = load<std::uint16_t>(bytes + 105);
  require(header.point_size >= header.layout().size, file, 105,
          fmt::format("points of format {} are too short", header.point_format),
          fmt::format("{} bytes or more", header.layout().size), std::to_string(header.point_size));
  header.lattice = read_lattice(file, bytes);
  header.bounds = read_bounds(bytes);
  read_point_count(header, file, bytes, warnings, damage);

  if (header.version_minor >= 4) {
    header.extended_records_place = load<std::uint64_t>(bytes + 235);
    header.extended_record_count = load<std::uint32_t>(bytes + 243);
    // They stood behind the points that are gone.
    if (header.lost_count > 0 && header.extended_record_count > 0) {
      warnings.push_back(fmt::format("{}: the extended records behind the points are lost", file.name()));
      header.extended_record_count = 0;
    }
    require(header.extended_record_count == 0 || header.extended_records_place >= header.points_end(), file,
            235, "bad place of the extended records", fmt::format("a byte from {} on", header.points_end()),
            std::to_string(header.extended_records_place));
  }
  return header;
}

void keep_points_inside(const InputFile& file, LasHeader& header, Damage damage) {
  const std::uint64_t room = (file.size() - header.points_place) / header.point_size;
  if (header.point_count <= room) return;
  if (damage == Damage::refuse) {
    throw DamagedFile({.file = file.name(),
                       .place = fmt::format("byte {}", place_of_count(header)),
                       .problem = "the file ends before its last point",
                       .expected = fmt::format("{} points of {} bytes from byte {} on", header.point_count,
                                               header.point_size, header.points_place),
                       .found = fmt::format("room for {}", room)});
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
  store(bytes + 96, header.points_place);
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
  store(bytes + 235, header.extended_records_place);
  store(bytes + 243, header.extended_record_count);
  store(bytes + 247, header.point_count);
  store(bytes + 255, header.points_by_return);
  return copy;
}

std::string las_text(const std::byte* field, std::size_t length) {
  const char* const text = reinterpret_cast<const char*>(field);
  return {text, std::find(text, text + length, '\0')};
}

void store_las_text(std::byte* field, std::size_t length, const std::string& text) {
  std::size_t count = std::min(length, text.size());
  const auto continues_character = [&](std::size_t at) {
    return (static_cast<unsigned char>(text[at]) & 0xc0) == 0x80;
  };
  while (count > 0 && count < text.size() && continues_character(count)) --count;
  std::memcpy(field, text.data(), count);
}

}  // namespace alidade
