// SPDX-License-Identifier: MIT
#include "octree/index_file/index_sections.h"

#include <algorithm>
#include <atomic>
#include <fmt/format.h>
#include <limits>
#include <mutex>
#include <tbb/parallel_for.h>

#include "base/bytes.h"
#include "base/error.h"
#include "base/fingerprint.h"

namespace alidade {
namespace {

constexpr std::uint64_t k_none = std::numeric_limits<std::uint64_t>::max();

// So many blocks are summed between two reports: tens of milliseconds.
constexpr std::uint64_t k_blocks_per_report = 256;

}  // namespace

std::span<const std::byte> IndexSections::bytes(IndexSection kind) const {
  const SectionEntry* const section = header_.find(kind);
  if (section == nullptr) return {};
  return map_.bytes().subspan(static_cast<std::size_t>(section->place),
                              static_cast<std::size_t>(section->bytes));
}

void IndexSections::fail(IndexSection kind, std::uint64_t byte, const std::string& problem) const {
  throw Error({.file = map_.name(),
               .place = fmt::format("byte {}", entry(kind).place + byte),
               .problem = fmt::format("section {} is damaged: {}", alidade::name(kind), problem)});
}

std::span<const std::uint64_t> IndexSections::stored_checksums(IndexSection kind) const {
  std::uint64_t first = 0;
  for (const SectionEntry& section : header_.sections) {
    if (section.kind == kind) break;
    first += checksum_blocks(section.bytes);
  }
  const auto run = values<std::uint64_t>(IndexSection::checksums)
                       .subspan(static_cast<std::size_t>(first),
                                static_cast<std::size_t>(checksum_blocks(entry(kind).bytes)));
  if (checksum(std::as_bytes(run)) != entry(kind).checksum) {
    fail(IndexSection::checksums, first * sizeof(std::uint64_t),
         fmt::format("the checksums of section {} do not have the checksum in the header",
                     alidade::name(kind)));
  }
  return run;
}

void IndexSections::check(IndexSection kind, const Progress& progress, const LookAtBlock& look) const {
  const SectionEntry* const section = header_.find(kind);
  if (section == nullptr) return;
  const std::span<const std::byte> all = bytes(kind);
  if (kind == IndexSection::checksums) {
    if (checksum(all) != section->checksum) fail(kind, 0, "its checksum is not the one in the header");
    return;
  }
  const std::span<const std::uint64_t> stored = stored_checksums(kind);
  for (std::uint64_t begin = 0; begin < stored.size(); begin += k_blocks_per_report) {
    const std::uint64_t end = std::min<std::uint64_t>(begin + k_blocks_per_report, stored.size());
    std::atomic<std::uint64_t> first_bad = k_none;
    const auto check_block = [&](std::uint64_t block) {
      const std::span<const std::byte> part = checksum_block(all, static_cast<std::size_t>(block));
      if (checksum(part) != stored[static_cast<std::size_t>(block)]) {
        std::uint64_t bad = first_bad;
        while (block < bad && !first_bad.compare_exchange_weak(bad, block)) {
        }
      } else if (look) {
        look(block * k_checksum_block, block * k_checksum_block + part.size());
      }
    };
    // Calling for threads takes longer than a single block.
    if (end - begin == 1) {
      check_block(begin);
    } else {
      tbb::parallel_for(begin, end, check_block);
    }
    if (first_bad != k_none) {
      const std::uint64_t byte = first_bad * k_checksum_block;
      fail(kind, byte,
           fmt::format("the checksum of the {} bytes from here on is wrong",
                       std::min<std::uint64_t>(all.size() - byte, k_checksum_block)));
    }
    report(progress, std::min<std::uint64_t>(end * k_checksum_block, all.size()), all.size());
  }
}

void IndexSections::check_gaps() const {
  std::uint64_t place = k_index_page;
  for (const SectionEntry& section : header_.sections) {
    for (; place < section.place; ++place) {
      if (map_.bytes()[static_cast<std::size_t>(place)] == std::byte{0}) continue;
      throw Error({.file = map_.name(),
                   .place = fmt::format("byte {}", place),
                   .problem = fmt::format("something stands before section {}", alidade::name(section.kind)),
                   .expected = "zeros up to the next multiple of 4096"});
    }
    place = section.end();
  }
}

namespace {

// A point of a LAS file takes at most so many bytes, and so does what a point carries here.
constexpr std::uint32_t k_longest_extra_dimension = 65535;

class Writer {
 public:
  template <class T>
  void add(const T& value) {
    const auto bytes = std::as_bytes(std::span(&value, 1));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  /// Number of values, then the values.
  template <class Values>
  void add_all(const Values& values) {
    add<std::uint64_t>(values.size());
    const auto bytes = std::as_bytes(std::span(values));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

class Reader {
 public:
  Reader(std::span<const std::byte> bytes, std::uint64_t place, const std::string& file_name)
      : bytes_(bytes), place_(place), file_(file_name) {}

  template <class T>
  T get() {
    return load<T>(take(sizeof(T)));
  }
  /// A number of things that each take at least `least_bytes` of what is left.
  std::uint64_t count(std::size_t least_bytes) {
    const std::uint64_t count = get<std::uint64_t>();
    if (count > (bytes_.size() - used_) / least_bytes)
      fail(8, "a list does not fit into the metadata",
           fmt::format("at most {}", (bytes_.size() - used_) / least_bytes), std::to_string(count));
    return count;
  }
  template <class Values>
  Values all() {
    using Value = typename Values::value_type;
    Values values(static_cast<std::size_t>(count(sizeof(Value))), Value{});
    const std::size_t bytes = values.size() * sizeof(Value);
    const std::byte* const from = take(bytes);
    if (bytes > 0) std::memcpy(values.data(), from, bytes);
    return values;
  }
  std::string text() { return all<std::string>(); }
  bool flag() {
    const auto value = get<std::uint8_t>();
    if (value > 1) fail(1, "bad flag in the metadata", "0 or 1", std::to_string(value));
    return value == 1;
  }
  bool at_end() const { return used_ == bytes_.size(); }
  void finish() const {
    if (used_ != bytes_.size())
      fail(0, "bytes behind the metadata", std::to_string(used_), std::to_string(bytes_.size()));
  }
  /// Complains about what stands `back` bytes before the next one.
  [[noreturn]] void fail(std::size_t back, std::string problem, std::string expected,
                         std::string found) const {
    throw Error({.file = file_,
                 .place = fmt::format("byte {}", place_ + used_ - back),
                 .problem = std::move(problem),
                 .expected = std::move(expected),
                 .found = std::move(found)});
  }

 private:
  const std::byte* take(std::size_t count) {
    if (count > bytes_.size() - used_) {
      fail(0, "the metadata end early", fmt::format("{} bytes from here", count),
           std::to_string(bytes_.size() - used_));
    }
    const std::byte* const at = bytes_.data() + used_;
    used_ += count;
    return at;
  }

  std::span<const std::byte> bytes_;
  std::uint64_t place_;
  const std::string& file_;
  std::size_t used_ = 0;
};

void write_extra_dimension(Writer& writer, const ExtraDimension& dimension) {
  writer.add_all(dimension.name);
  writer.add_all(dimension.description);
  writer.add(static_cast<std::uint8_t>(dimension.type));
  writer.add(static_cast<std::uint32_t>(dimension.byte_count));
  writer.add(dimension.scale);
  writer.add(dimension.offset);
  writer.add<std::uint8_t>(dimension.has_scale);
  writer.add<std::uint8_t>(dimension.has_offset);
  writer.add<std::uint8_t>(dimension.no_data.has_value());
  writer.add(dimension.no_data.value_or(std::array<std::uint8_t, 8>{}));
}

ExtraDimension read_extra_dimension(Reader& reader) {
  ExtraDimension dimension;
  dimension.name = reader.text();
  dimension.description = reader.text();
  const auto type = reader.get<std::uint8_t>();
  if (type > static_cast<std::uint8_t>(ScalarType::float64))
    reader.fail(1, "bad type of an extra dimension", "0 to 10", std::to_string(type));
  dimension.type = static_cast<ScalarType>(type);
  const auto bytes = reader.get<std::uint32_t>();
  const auto size = static_cast<std::uint32_t>(scalar_size(dimension.type));
  if (size == 0 ? bytes < 1 || bytes > k_longest_extra_dimension : bytes != size) {
    reader.fail(4, "bad size of an extra dimension",
                size == 0 ? fmt::format("1 to {}", k_longest_extra_dimension) : std::to_string(size),
                std::to_string(bytes));
  }
  dimension.byte_count = static_cast<int>(bytes);
  dimension.scale = reader.get<double>();
  dimension.offset = reader.get<double>();
  dimension.has_scale = reader.flag();
  dimension.has_offset = reader.flag();
  const bool has_no_data = reader.flag();
  const auto no_data = reader.get<std::array<std::uint8_t, 8>>();
  if (has_no_data) dimension.no_data = no_data;
  return dimension;
}

void write_file(Writer& writer, const CloudFile& file) {
  writer.add_all(file.path.string());
  writer.add_all(file.format);
  writer.add_all(file.version);
  writer.add<std::int32_t>(file.point_format.value_or(-1));
  writer.add(file.point_count);
  writer.add(file.dropped_count);
}

CloudFile read_file(Reader& reader) {
  CloudFile file;
  file.path = reader.text();
  file.format = reader.text();
  file.version = reader.text();
  const auto point_format = reader.get<std::int32_t>();
  if (point_format >= 0) file.point_format = point_format;
  file.point_count = reader.get<std::uint64_t>();
  file.dropped_count = reader.get<std::uint64_t>();
  return file;
}

}  // namespace

std::vector<std::byte> encode_index_metadata(const PointCloud& cloud) {
  Writer writer;
  writer.add_all(cloud.crs.wkt);
  writer.add_all(cloud.crs.geotiff_keys);
  writer.add_all(cloud.crs.geotiff_doubles);
  writer.add_all(cloud.crs.geotiff_ascii);
  writer.add<std::uint64_t>(cloud.files.size());
  for (const CloudFile& file : cloud.files) write_file(writer, file);
  writer.add<std::uint64_t>(cloud.warnings.size());
  for (const std::string& warning : cloud.warnings) writer.add_all(warning);
  writer.add<std::uint64_t>(cloud.extra_dimensions.size());
  for (const ExtraDimension& dimension : cloud.extra_dimensions) write_extra_dimension(writer, dimension);
  writer.add<std::uint64_t>(cloud.records.size());
  for (const VariableLengthRecord& record : cloud.records) {
    writer.add_all(record.user_id);
    writer.add(record.record_id);
    writer.add_all(record.description);
    writer.add<std::uint8_t>(record.extended);
    writer.add<std::uint64_t>(record.data.size());
  }
  if (cloud.scanner_positions.empty()) return writer.take();
  writer.add<std::uint64_t>(cloud.scanner_positions.size());
  for (const ScannerPosition& scanner : cloud.scanner_positions) {
    writer.add_all(scanner.scan);
    for (int axis = 0; axis < 3; ++axis) writer.add(scanner.position[axis]);
  }
  return writer.take();
}

IndexMetadata read_index_metadata(std::span<const std::byte> section, std::uint64_t place,
                                  const std::string& file_name) {
  // The fewest bytes that an entry of each list takes.
  constexpr std::size_t k_file = 44, k_warning = 8, k_extra_dimension = 48, k_record = 27, k_scanner = 32;
  Reader reader(section, place, file_name);
  IndexMetadata metadata;
  PointCloud& cloud = metadata.cloud;
  cloud.crs.wkt = reader.text();
  cloud.crs.geotiff_keys = reader.all<std::vector<std::uint16_t>>();
  cloud.crs.geotiff_doubles = reader.all<std::vector<double>>();
  cloud.crs.geotiff_ascii = reader.text();
  for (std::uint64_t left = reader.count(k_file); left > 0; --left) cloud.files.push_back(read_file(reader));
  for (std::uint64_t left = reader.count(k_warning); left > 0; --left)
    cloud.warnings.push_back(reader.text());
  for (std::uint64_t left = reader.count(k_extra_dimension); left > 0; --left)
    cloud.extra_dimensions.push_back(read_extra_dimension(reader));
  for (std::uint64_t left = reader.count(k_record); left > 0; --left) {
    VariableLengthRecord& record = cloud.records.emplace_back();
    record.user_id = reader.text();
    record.record_id = reader.get<std::uint16_t>();
    record.description = reader.text();
    record.extended = reader.flag();
    metadata.record_bytes.push_back(reader.get<std::uint64_t>());
  }
  // A cloud without scanner positions has no list of them, as the first index files had none.
  if (!reader.at_end()) {
    for (std::uint64_t left = reader.count(k_scanner); left > 0; --left) {
      ScannerPosition& scanner = cloud.scanner_positions.emplace_back();
      scanner.scan = reader.text();
      for (int axis = 0; axis < 3; ++axis) scanner.position[axis] = reader.get<double>();
    }
  }
  reader.finish();
  return metadata;
}

}  // namespace alidade
