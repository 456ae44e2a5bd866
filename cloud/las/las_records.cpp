// SPDX-License-Identifier: MIT
#include "cloud/las/las_records.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cassert>
#include <map>
#include <set>

#include "base/bytes.h"
#include "base/error.h"

namespace alidade {
namespace {

constexpr const char* k_copc_user_id = "copc";
constexpr std::uint16_t k_copc_info_id = 1;
constexpr std::size_t k_las_name_bytes = 32;
constexpr int k_longest_undocumented = 255;  ///< bytes that one entry of the extra-bytes record can describe

/// A record's header, with offset and size of its data in the file.
struct RecordHeader {
  std::string user_id;
  std::uint16_t record_id;
  std::string description;
  std::uint64_t offset;
  std::uint64_t size;
  bool extended;

  bool is(const char* user, std::uint16_t record) const { return record_id == record && user_id == user; }
};

/// Reads the header of the record at `offset`; its data must end at `end` or before.
RecordHeader read_record_header(InputFile& file, std::uint64_t offset, std::uint64_t end, bool extended) {
  const std::size_t header_size = extended ? k_las_extended_record_head : k_las_record_head;
  const auto fail = [&](std::uint64_t wanted) {
    fail_at_byte(file.name(), offset, "a variable length record exceeds its section",
                 fmt::format("at most {} bytes up to byte {}", end - std::min(offset, end), end),
                 std::to_string(wanted));
  };
  if (offset > end || end - offset < header_size) fail(header_size);
  const std::byte* const at = file.view(offset, header_size).data();
  RecordHeader record{.user_id = las_text(at + 2, 16),
                      .record_id = load<std::uint16_t>(at + 18),
                      .description = las_text(at + (extended ? 28 : 22), 32),
                      .offset = offset + header_size,
                      .size = extended ? load<std::uint64_t>(at + 20) : load<std::uint16_t>(at + 20),
                      .extended = extended};
  if (record.size > end - record.offset) fail(record.size);
  return record;
}

template <class T = std::uint8_t>
std::vector<T> read_values(InputFile& file, const RecordHeader& record) {
  std::vector<T> values(static_cast<std::size_t>(record.size / sizeof(T)));
  file.read_at(record.offset, std::as_writable_bytes(std::span(values)));
  return values;
}

/// The text of a WKT record; empty, with `problem` set, if it is invalid.
std::string read_wkt(InputFile& file, const RecordHeader& record, bool& problem) {
  const std::vector<std::uint8_t> data = read_values(file, record);
  std::string wkt(data.begin(), std::find(data.begin(), data.end(), 0));
  problem = !wkt.empty() && wkt.find('[') == std::string::npos;
  return problem ? std::string() : wkt;
}

/// The problem of GeoTIFF keys; empty if they are valid. Source: GeoTIFF 1.0, section 2.4: a head of four
/// numbers, then four per key: its name, the tag that contains its value (0 = here), the number of values,
/// and their index (or the value itself).
std::string geotiff_problem(const Crs& crs) {
  const std::vector<std::uint16_t>& keys = crs.geotiff_keys;
  if (keys.size() < 4 || keys[0] != 1) return "missing directory header";
  if (keys.size() / 4 - 1 < keys[3])
    return fmt::format("{} keys expected, {} found", keys[3], keys.size() / 4 - 1);
  for (std::size_t i = 1; i <= keys[3]; ++i) {
    const std::uint16_t* const key = keys.data() + 4 * i;
    const std::size_t end = static_cast<std::size_t>(key[2]) + key[3];
    if (key[0] == 0) return fmt::format("key {} is missing", i);
    if (key[1] == 34736 && end > crs.geotiff_doubles.size())
      return fmt::format("key {} lacks its values", key[0]);
    if (key[1] == 34737 && end > crs.geotiff_ascii.size())
      return fmt::format("key {} lacks its text", key[0]);
  }
  return {};
}

/// One entry of the extra-bytes record (LAS Specification 1.4 R15, table 24); byte_count 0 if its type is
/// unknown.
ExtraDimension read_extra_bytes_entry(const std::byte* at) {
  const int type = load<std::uint8_t>(at + 2), options = load<std::uint8_t>(at + 3);
  ExtraDimension dimension;
  dimension.name = las_text(at + 4, 32);
  dimension.description = las_text(at + 160, 32);
  if (type == 0) {
    dimension.type = ScalarType::bytes;
    dimension.byte_count = options;
  } else if (type <= 10) {
    dimension.type = static_cast<ScalarType>(type);
    dimension.byte_count = scalar_size(dimension.type);
    if (options & 1) dimension.no_data = load<std::array<std::uint8_t, 8>>(at + 40);
    dimension.has_scale = (options & 8) != 0;
    dimension.has_offset = (options & 16) != 0;
    if (dimension.has_scale) dimension.scale = load<double>(at + 112);
    if (dimension.has_offset) dimension.offset = load<double>(at + 136);
  } else if (type <= 30) {
    // Pairs and triples, which the standard has withdrawn, are kept as bytes.
    const int values = 1 + (type - 1) / 10;
    dimension.type = ScalarType::bytes;
    dimension.byte_count = values * scalar_size(static_cast<ScalarType>(1 + (type - 1) % 10));
  } else {
    dimension.byte_count = 0;
  }
  return dimension;
}

void append_undocumented(std::vector<ExtraDimension>& dimensions, int bytes) {
  for (int part = 1; bytes > 0; ++part) {
    ExtraDimension& dimension = dimensions.emplace_back();
    dimension.name = part == 1 ? "undocumented" : fmt::format("undocumented {}", part);
    dimension.type = ScalarType::bytes;
    dimension.byte_count = std::min(bytes, k_longest_undocumented);
    bytes -= dimension.byte_count;
  }
}

std::vector<ExtraDimension> read_extra_dimensions(const std::string& file_name,
                                                  const std::vector<std::uint8_t>& data, int extra_bytes,
                                                  std::vector<std::string>& warnings) {
  std::vector<ExtraDimension> dimensions;
  const std::byte* const bytes = reinterpret_cast<const std::byte*>(data.data());
  int described = 0;
  for (std::size_t offset = 0; offset + k_extra_bytes_entry <= data.size(); offset += k_extra_bytes_entry) {
    if (dimensions.size() == k_most_extra_dimensions) {
      warnings.push_back(
          fmt::format("{}: the extra-bytes record describes more than {} dimensions; the others are kept as "
                      "undocumented bytes",
                      file_name, k_most_extra_dimensions));
      break;
    }
    const ExtraDimension& dimension = dimensions.emplace_back(read_extra_bytes_entry(bytes + offset));
    described += dimension.byte_count;
    if (dimension.byte_count == 0 || described > extra_bytes) {
      warnings.push_back(fmt::format(
          "{}: the extra-bytes record does not match the {} extra bytes of a point ('{}'); they are kept as "
          "undocumented bytes",
          file_name, extra_bytes, dimension.name));
      dimensions.clear();
      described = 0;
      break;
    }
  }
  append_undocumented(dimensions, extra_bytes - described);
  return dimensions;
}

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
  unsigned options = static_cast<unsigned>(byte_count);  // the meaning of the field for undocumented bytes
  if (dimension.type != ScalarType::bytes) {
    options =
        (dimension.no_data ? 1u : 0u) | (dimension.has_scale ? 8u : 0u) | (dimension.has_offset ? 16u : 0u);
    if (dimension.no_data) store(at + 40, *dimension.no_data);
    if (dimension.has_scale) store(at + 112, dimension.scale);
    if (dimension.has_offset) store(at + 136, dimension.offset);
  }
  store(at + 2, static_cast<std::uint8_t>(dimension.type));
  store(at + 3, static_cast<std::uint8_t>(options));
  store_las_text(at + 4, k_las_name_bytes, dimension.name);
  store_las_text(at + 160, 32, dimension.description);
  return entry;
}

}  // namespace

LasRecords read_las_records(InputFile& file, const LasHeader& header, std::vector<std::string>& warnings,
                            Damage damage) {
  LasRecords result;
  std::vector<std::uint8_t> extra_bytes_data;
  std::string liblas_wkt;
  const auto take = [&](const RecordHeader& record) {
    if (record.is("LASF_Projection", 2112)) {
      bool problem = false;
      std::string wkt = read_wkt(file, record, problem);
      if (problem)
        warnings.push_back(fmt::format("{}: the WKT record contains no WKT and is ignored", file.name()));
      if (result.crs.wkt.empty()) result.crs.wkt = std::move(wkt);
    } else if (record.is("LASF_Projection", 34735)) {
      result.crs.geotiff_keys = read_values<std::uint16_t>(file, record);
    } else if (record.is("LASF_Projection", 34736)) {
      result.crs.geotiff_doubles = read_values<double>(file, record);
    } else if (record.is("LASF_Projection", 34737)) {
      const std::vector<std::uint8_t> data = read_values(file, record);
      result.crs.geotiff_ascii.assign(data.begin(), data.end());
    } else if (record.is("LASF_Spec", 4)) {
      extra_bytes_data = read_values(file, record);
    } else if (record.is("LASF_Spec", 65535)) {
      warnings.push_back(fmt::format("{}: wave packets are skipped", file.name()));
    } else if (record.is(k_laszip_user_id, k_laszip_record_id)) {
      StorageRecord laszip{record.offset, read_values<std::byte>(file, record)};
      if (result.laszip && result.laszip->data != laszip.data) {
        fail_at_byte(file.name(), record.offset,
                     fmt::format("the laszip record differs from the one at byte {}", result.laszip->offset));
      }
      if (!result.laszip) result.laszip = std::move(laszip);
    } else if (record.user_id == k_copc_user_id) {
      const bool first = record.offset == k_las_header_size + k_las_record_head;
      if (first && record.record_id == k_copc_info_id)
        result.copc_info = {record.offset, read_values<std::byte>(file, record)};
    } else {
      // libLAS wrote WKT before the standard had a record for it. The record is kept, too.
      bool problem = false;
      if (record.is("liblas", 2112)) liblas_wkt = read_wkt(file, record, problem);
      result.others.push_back({.user_id = record.user_id,
                               .record_id = record.record_id,
                               .description = record.description,
                               .data = read_values(file, record),
                               .extended = record.extended});
    }
  };

  std::uint64_t offset = header.header_size;
  for (std::uint32_t i = 0; i < header.record_count; ++i) {
    const RecordHeader record = read_record_header(file, offset, header.points_offset, false);
    take(record);
    offset = record.offset + record.size;
  }
  offset = header.extended_records_offset;
  for (std::uint32_t i = 0; i < header.extended_record_count; ++i) {
    std::optional<RecordHeader> record;
    try {
      record = read_record_header(file, offset, file.size(), true);
    } catch (const Error& error) {
      if (damage == Damage::reject) throw DamagedFile(error.parts());
      warnings.push_back(fmt::format("{}; this record and those after it are skipped", error.what()));
      break;
    }
    take(*record);
    offset = record->offset + record->size;
  }

  if (result.crs.wkt.empty()) result.crs.wkt = std::move(liblas_wkt);
  if (!result.crs.geotiff_keys.empty()) {
    if (const std::string problem = geotiff_problem(result.crs); !problem.empty()) {
      warnings.push_back(
          fmt::format("{}: corrupt GeoTIFF keys ({}); they are kept unchanged", file.name(), problem));
    }
  }
  const int extra_bytes = header.point_size - header.layout().size;
  result.extra_dimensions = read_extra_dimensions(file.name(), extra_bytes_data, extra_bytes, warnings);
  return result;
}

std::optional<LazLayout> read_packing(const InputFile& file, LasHeader& header, const LasRecords& records,
                                      Damage damage) {
  if (!header.compressed) return std::nullopt;
  if (!records.laszip) {
    fail_at_byte(file.name(), 104, "compressed points without a laszip record",
                 fmt::format("a record '{}' {}", k_laszip_user_id, k_laszip_record_id));
  }
  LazLayout layout = parse_laszip_record(records.laszip->data, file.name(), records.laszip->offset,
                                         header.point_format, header.point_size);
  if (layout.compressor != LazCompressor::none) return layout;
  header.compressed = false;
  keep_points_inside(file, header, damage);
  return std::nullopt;
}

std::vector<VariableLengthRecord> las_crs_records(const Crs& crs) {
  std::vector<VariableLengthRecord> records;
  if (!crs.wkt.empty()) {
    std::vector<std::uint8_t> data(crs.wkt.begin(), crs.wkt.end());
    data.push_back(0);
    records.push_back(projection_record(2112, "OGC WKT", std::move(data)));
  }
  // The standard requires WKT for point formats of 6 and more. Converting GeoTIFF keys to WKT takes a
  // register of reference systems, which this library does not have; unchanged keys lose nothing, and readers
  // accept them.
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

std::string shorten_names(std::vector<ExtraDimension>& dimensions) {
  std::set<std::string> taken;
  for (const ExtraDimension& dimension : dimensions) {
    if (dimension.name.size() <= k_las_name_bytes) taken.insert(dimension.name);
  }
  std::map<std::string, std::string> shorter;
  std::string changes;
  for (ExtraDimension& dimension : dimensions) {
    if (dimension.name.size() <= k_las_name_bytes) continue;
    const auto [known, is_new] =
        shorter.try_emplace(dimension.name, cut_las_text(dimension.name, k_las_name_bytes));
    std::string& name = known->second;
    for (int number = 2; is_new && !taken.insert(name).second; ++number) {
      const std::string end = fmt::format("_{}", number);
      name = cut_las_text(dimension.name, k_las_name_bytes - end.size()) + end;
    }
    if (is_new)
      changes += fmt::format("{}'{}' becomes '{}'", changes.empty() ? "" : ", ", dimension.name, name);
    dimension.name = name;
  }
  return changes;
}

VariableLengthRecord las_extra_bytes_record(std::span<const ExtraDimension> dimensions,
                                            const std::string& file_name) {
  VariableLengthRecord record{.user_id = "LASF_Spec",
                              .record_id = 4,
                              .description = "Extra Bytes Record",
                              .data = {},
                              .extended = false};
  for (const ExtraDimension& dimension : dimensions) {
    // The length of undocumented bytes is an 8-bit field: more bytes take several entries.
    for (int rest = dimension.byte_count; rest > 0; rest -= 255) {
      const auto entry = extra_bytes_entry(dimension, std::min(rest, 255));
      const auto* const first = reinterpret_cast<const std::uint8_t*>(entry.data());
      record.data.insert(record.data.end(), first, first + entry.size());
    }
  }
  if (record.data.size() > k_longest_las_record) {
    throw Error({.file = file_name,
                 .problem = "too many extra dimensions for LAS",
                 .expected = fmt::format("at most {}", k_most_extra_dimensions),
                 .found = std::to_string(record.data.size() / k_extra_bytes_entry)});
  }
  return record;
}

std::vector<std::byte> las_record_head(const VariableLengthRecord& record, bool extended) {
  assert(extended || record.data.size() <= k_longest_las_record);
  std::vector<std::byte> head(extended ? k_las_extended_record_head : k_las_record_head);
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
