// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>

#include "base/bytes.h"
#include "base/error.h"
#include "cloud/las/las_records.h"

namespace alidade {
namespace {

template <class T>
std::vector<std::uint8_t> bytes_of(const std::vector<T>& values) {
  std::vector<std::uint8_t> bytes(values.size() * sizeof(T));
  if (!bytes.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

VariableLengthRecord projection_record(std::uint16_t id, std::string description,
                                       std::vector<std::uint8_t> data) {
  return {.user_id = "LASF_Projection",
          .record_id = id,
          .description = std::move(description),
          .data = std::move(data),
          .extended = false};
}

/// One entry of the extra-bytes record: LAS Specification 1.4 R15, table 24.
std::array<std::byte, k_extra_bytes_entry> extra_bytes_entry(const ExtraDimension& dimension,
                                                             int byte_count) {
  std::array<std::byte, k_extra_bytes_entry> entry{};
  std::byte* const at = entry.data();
  unsigned options = static_cast<unsigned>(byte_count);  // what the field means for undocumented bytes
  if (dimension.type != ScalarType::bytes) {
    options =
        (dimension.no_data ? 1u : 0u) | (dimension.has_scale ? 8u : 0u) | (dimension.has_offset ? 16u : 0u);
    if (dimension.no_data) store(at + 40, *dimension.no_data);
    if (dimension.has_scale) store(at + 112, dimension.scale);
    if (dimension.has_offset) store(at + 136, dimension.offset);
  }
  store(at + 2, static_cast<std::uint8_t>(dimension.type));
  store(at + 3, static_cast<std::uint8_t>(options));
  store_las_text(at + 4, 32, dimension.name);
  store_las_text(at + 160, 32, dimension.description);
  return entry;
}

}  // namespace

std::vector<VariableLengthRecord> las_crs_records(const Crs& crs) {
  std::vector<VariableLengthRecord> records;
  if (!crs.wkt.empty()) {
    std::vector<std::uint8_t> data(crs.wkt.begin(), crs.wkt.end());
    data.push_back(0);
    records.push_back(projection_record(2112, "OGC WKT", std::move(data)));
  }
  // The standard wants WKT beside the point formats from 6 on. To turn GeoTIFF keys into WKT takes a register
  // of reference systems, which Alidade does not have; the keys as they came lose nothing, and readers accept
  // them.
  if (!crs.geotiff_keys.empty()) {
    records.push_back(projection_record(34735, "GeoKeyDirectoryTag", bytes_of(crs.geotiff_keys)));
    if (!crs.geotiff_doubles.empty()) {
      records.push_back(projection_record(34736, "GeoDoubleParamsTag", bytes_of(crs.geotiff_doubles)));
    }
    if (!crs.geotiff_ascii.empty()) {
      std::vector<std::uint8_t> data(crs.geotiff_ascii.begin(), crs.geotiff_ascii.end());
      records.push_back(projection_record(34737, "GeoAsciiParamsTag", std::move(data)));
    }
  }
  return records;
}

VariableLengthRecord las_extra_bytes_record(std::span<const ExtraDimension> dimensions,
                                            const std::string& file_name) {
  VariableLengthRecord record{.user_id = "LASF_Spec",
                              .record_id = 4,
                              .description = "Extra Bytes Record",
                              .data = {},
                              .extended = false};
  for (const ExtraDimension& dimension : dimensions) {
    // The length of undocumented bytes is an 8-bit field: longer ones take several entries.
    for (int rest = dimension.byte_count; rest > 0; rest -= 255) {
      const auto entry = extra_bytes_entry(dimension, std::min(rest, 255));
      const auto* const first = reinterpret_cast<const std::uint8_t*>(entry.data());
      record.data.insert(record.data.end(), first, first + entry.size());
    }
  }
  if (record.data.size() > k_longest_las_record) {
    throw Error({.file = file_name,
                 .problem = "too many extra dimensions for LAS",
                 .expected = fmt::format("{} or fewer", k_most_extra_dimensions),
                 .found = std::to_string(record.data.size() / k_extra_bytes_entry)});
  }
  return record;
}

std::vector<std::byte> las_record_head(const VariableLengthRecord& record, bool extended) {
  assert(extended || record.data.size() <= k_longest_las_record);
  std::vector<std::byte> head(extended ? 60 : 54);
  std::byte* const at = head.data();
  store_las_text(at + 2, 16, record.user_id);
  store(at + 18, record.record_id);
  if (extended) {
    store<std::uint64_t>(at + 20, record.data.size());
  } else {
    store(at + 20, static_cast<std::uint16_t>(record.data.size()));
  }
  store_las_text(at + (extended ? 28 : 22), 32, record.description);
  return head;
}

void write_las_record(OutputFile& file, const VariableLengthRecord& record, bool extended) {
  file.write(las_record_head(record, extended));
  file.write(std::as_bytes(std::span(record.data)));
}

}  // namespace alidade
