// SPDX-License-Identifier: MIT
#include "octree/index_file/index_sections.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <type_traits>

#include "base/bytes.h"
#include "base/error.h"
#include "base/fingerprint.h"
#include "base/parallel.h"

namespace alidade {
namespace {

// So many blocks are summed between two reports: tens of milliseconds.
constexpr std::uint64_t k_blocks_per_report = 256;

[[noreturn]] void fail_in(const std::string& file, const SectionEntry& section, std::uint64_t byte,
                          const std::string& problem) {
  throw Error({.file = file,
               .location = fmt::format("byte {}", section.index + byte),
               .problem = fmt::format("corrupt section {}: {}", name(section.kind), problem)});
}

std::string wrong_sum(std::uint64_t bytes) {
  return fmt::format("checksum mismatch in the next {} bytes", bytes);
}

/// A section of a remote file, with the checksums of its blocks.
struct ArrivingSection {
  SectionEntry entry;
  std::vector<std::uint64_t> sums;

  std::pair<std::uint64_t, std::uint64_t> block_of(std::uint64_t offset) const {
    const std::uint64_t begin = entry.index + (offset - entry.index) / k_checksum_block * k_checksum_block;
    return {begin, std::min(begin + k_checksum_block, entry.end())};
  }

  void check(std::uint64_t offset, std::span<const std::byte> bytes, const IndexHeader& header,
             const std::string& file) const {
    const std::uint64_t from = offset - entry.index;
    const auto block =
        bytes.first(static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), entry.bytes - from)));
    if (checksum(block) != sums[static_cast<std::size_t>(from / k_checksum_block)])
      fail_in(file, entry, from, wrong_sum(block.size()));
    if (entry.kind != IndexSection::ids) return;
    for (std::size_t at = 0; at < block.size(); at += sizeof(std::uint32_t))
      if (const auto id = load<std::uint32_t>(block.data() + at); id >= header.tree.point_count)
        fail_in(file, entry, from + at,
                fmt::format("id out of range; expected less than {}, found {}", header.tree.point_count, id));
  }
};

/// The first page must be there before it is read: a map that failed is zero.
IndexHeader arrived_header(const MappedFile& map) {
  MappedFile::fetch(map.bytes().first(std::min(map.bytes().size(), k_index_page)));
  RemoteMap::check(map.bytes().data());
  return read_index_header(map.bytes(), map.name());
}

}  // namespace

IndexSections::IndexSections(const InputFile& file) : map_(file), header_(arrived_header(map_)) {
  if (const auto remote = RemoteMap::find(map_.bytes().data())) check_on_arrival(*remote);
}

void IndexSections::check_on_arrival(RemoteMap& map) {
  check(IndexSection::checksums);
  std::vector<ArrivingSection> sections;
  // Not the checksums, which are there.
  for (const SectionEntry& section : header_.sections) {
    if (section.kind == IndexSection::checksums || section.bytes == 0) continue;
    const auto sums = stored_checksums(section.kind);
    sections.push_back({section, {sums.begin(), sums.end()}});
  }
  const auto all = std::make_shared<const std::vector<ArrivingSection>>(std::move(sections));
  const auto section_of = [all](std::uint64_t offset) -> const ArrivingSection* {
    for (const ArrivingSection& section : *all)
      if (offset >= section.entry.index && offset < align_to_page(section.entry.end())) return &section;
    return nullptr;
  };
  map.set_blocks(
      [section_of](std::uint64_t offset) {
        const ArrivingSection* const section = section_of(offset);
        const std::uint64_t page = offset / k_index_page * k_index_page;
        return section != nullptr ? section->block_of(std::min(offset, section->entry.end() - 1))
                                  : std::pair(page, page + k_index_page);
      },
      [section_of, header = header_, name = map_.name()](std::uint64_t offset,
                                                         std::span<const std::byte> bytes) {
        if (const ArrivingSection* const section = section_of(offset))
          section->check(offset, bytes, header, name);
      });
  are_checked_on_arrival_ = true;
}

std::span<const std::byte> IndexSections::bytes(IndexSection kind) const {
  const SectionEntry* const section = header_.find(kind);
  if (section == nullptr) return {};
  return map_.bytes().subspan(static_cast<std::size_t>(section->index),
                              static_cast<std::size_t>(section->bytes));
}

void IndexSections::fail(IndexSection kind, std::uint64_t byte, const std::string& problem) const {
  fail_in(map_.name(), entry(kind), byte, problem);
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
         fmt::format("wrong checksum of the checksums of section {}", alidade::name(kind)));
  }
  return run;
}

void IndexSections::check(IndexSection kind, const Progress& progress, const LookAtBlock& look) const {
  const SectionEntry* const section = header_.find(kind);
  if (section == nullptr) return;
  const std::span<const std::byte> all = bytes(kind);
  if (kind == IndexSection::checksums) {
    MappedFile::fetch(all);
    RemoteMap::check(all.data());
    if (checksum(all) != section->checksum) fail(kind, 0, "its checksum differs from the one in the header");
    return;
  }
  const std::span<const std::uint64_t> stored = stored_checksums(kind);
  for (std::uint64_t begin = 0; begin < stored.size(); begin += k_blocks_per_report) {
    const std::uint64_t end = std::min<std::uint64_t>(begin + k_blocks_per_report, stored.size());
    MappedFile::fetch(
        all.subspan(begin * k_checksum_block,
                    std::min<std::uint64_t>(end * k_checksum_block, all.size()) - begin * k_checksum_block));
    RemoteMap::check(all.data());
    const auto check_block = [&](std::uint64_t block) {
      const std::span<const std::byte> part = checksum_block(all, static_cast<std::size_t>(block));
      const std::uint64_t byte = block * k_checksum_block;
      if (checksum(part) != stored[static_cast<std::size_t>(block)]) fail(kind, byte, wrong_sum(part.size()));
      if (look) look(byte, byte + part.size());
    };
    // Calling for threads takes longer than a single block.
    if (end - begin == 1)
      check_block(begin);
    else
      at_once(begin, end, check_block);
    report(progress, std::min<std::uint64_t>(end * k_checksum_block, all.size()), all.size());
  }
}

void IndexSections::check_gaps() const {
  std::uint64_t index = k_index_page;
  for (const SectionEntry& section : header_.sections) {
    for (; index < section.index; ++index) {
      if (map_.bytes()[static_cast<std::size_t>(index)] == std::byte{0}) continue;
      throw Error(
          {.file = map_.name(),
           .location = fmt::format("byte {}", index),
           .problem = fmt::format("the gap before section {} is not zero", alidade::name(section.kind)),
           .expected = "zeros up to the next multiple of 4096"});
    }
    index = section.end();
  }
}

namespace {

// A point of a LAS file takes at most so many bytes, and so does what a point carries here.
constexpr std::uint32_t k_longest_extra_dimension = 65535;

// The metadata are described once, by functions that visit their fields in order: with a Writer and the cloud
// to store, or with a Reader and the cloud to fill. What a field may be is checked by the Reader only.

class Writer {
 public:
  template <class T>
  void value(const T& value) {
    add(std::as_bytes(std::span(&value, 1)));
  }
  void flag(bool flag) { value(static_cast<std::uint8_t>(flag)); }
  /// Number of values, then the values.
  template <class Values>
  void all(const Values& values) {
    value<std::uint64_t>(values.size());
    add(std::as_bytes(std::span(values)));
  }
  template <class Entries, class Visit>
  void list(const Entries& entries, std::size_t, const Visit& visit) {
    value<std::uint64_t>(entries.size());
    for (const auto& entry : entries) visit(entry);
  }
  template <class... Complaint>
  void require(bool, const Complaint&...) {}
  template <class Entries>
  bool at_end(const Entries& last_list) const {
    return last_list.empty();
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  void add(std::span<const std::byte> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }

  std::vector<std::byte> bytes_;
};

class Reader {
 public:
  Reader(std::span<const std::byte> bytes, std::uint64_t index, const std::string& file_name)
      : bytes_(bytes), index_(index), file_(file_name) {}

  template <class T>
  void value(T& value) {
    value = load<T>(take(sizeof(T)));
  }
  void flag(bool& flag) {
    std::uint8_t stored;
    value(stored);
    require(stored <= 1, 1, "invalid flag in the metadata", "0 or 1", stored);
    flag = stored == 1;
  }
  template <class Values>
  void all(Values& values) {
    using Value = typename Values::value_type;
    values.assign(static_cast<std::size_t>(count(sizeof(Value))), Value{});
    const std::size_t bytes = values.size() * sizeof(Value);
    const std::byte* const from = take(bytes);
    if (bytes > 0) std::memcpy(values.data(), from, bytes);
  }

  /// Entries that each take at least `least_bytes` of what is left.
  template <class Entries, class Visit>
  void list(Entries& entries, std::size_t least_bytes, const Visit& visit) {
    for (std::uint64_t left = count(least_bytes); left > 0; --left) visit(entries.emplace_back());
  }
  template <class Entries>
  bool at_end(const Entries&) const {
    return used_ == bytes_.size();
  }
  void finish() const {
    require(used_ == bytes_.size(), 0, "extra bytes after the metadata", std::to_string(used_),
            bytes_.size());
  }

  /// Rejects what is `back` bytes before the next one unless the condition holds.
  template <class Found>
  void require(bool holds, std::size_t back, const char* problem, const std::string& expected,
               const Found& found) const {
    if (holds) return;
    throw Error({.file = file_,
                 .location = fmt::format("byte {}", index_ + used_ - back),
                 .problem = problem,
                 .expected = expected,
                 .found = std::to_string(found)});
  }

 private:
  std::uint64_t count(std::size_t least_bytes) {
    std::uint64_t count;
    value(count);
    const std::uint64_t most = (bytes_.size() - used_) / least_bytes;
    require(count <= most, 8, "corrupt metadata: a list exceeds its section", fmt::format("at most {}", most),
            count);
    return count;
  }
  const std::byte* take(std::size_t count) {
    const std::size_t left = bytes_.size() - used_;
    require(count <= left, 0, "truncated metadata", fmt::format("{} more bytes", count), left);
    const std::byte* const at = bytes_.data() + used_;
    used_ += count;
    return at;
  }

  std::span<const std::byte> bytes_;
  std::uint64_t index_;
  const std::string& file_;
  std::size_t used_ = 0;
};

template <class Stream, class Dimension>
void visit_extra_dimension(Stream& stream, Dimension& dimension) {
  stream.all(dimension.name);
  stream.all(dimension.description);
  stream.value(dimension.type);
  stream.require(dimension.type <= ScalarType::float64, 1, "invalid type of an extra dimension", "0 to 10",
                 static_cast<int>(dimension.type));
  auto bytes = static_cast<std::uint32_t>(dimension.byte_count);
  stream.value(bytes);
  const auto size = static_cast<std::uint32_t>(scalar_size(dimension.type));
  stream.require(size == 0 ? bytes >= 1 && bytes <= k_longest_extra_dimension : bytes == size, 4,
                 "invalid size of an extra dimension",
                 size == 0 ? fmt::format("1 to {}", k_longest_extra_dimension) : std::to_string(size), bytes);
  stream.value(dimension.scale);
  stream.value(dimension.offset);
  stream.flag(dimension.has_scale);
  stream.flag(dimension.has_offset);
  bool has_no_data = dimension.no_data.has_value();
  auto no_data = dimension.no_data.value_or(std::array<std::uint8_t, 8>{});
  stream.flag(has_no_data);
  stream.value(no_data);
  if constexpr (!std::is_const_v<Dimension>) {
    dimension.byte_count = static_cast<int>(bytes);
    if (has_no_data) dimension.no_data = no_data;
  }
}

template <class Stream, class File>
void visit_file(Stream& stream, File& file) {
  std::string path = file.path.string();
  std::int32_t point_format = file.point_format.value_or(-1);
  stream.all(path);
  stream.all(file.format);
  stream.all(file.version);
  stream.value(point_format);
  stream.value(file.point_count);
  stream.value(file.dropped_count);
  if constexpr (!std::is_const_v<File>) {
    file.path = path;
    if (point_format >= 0) file.point_format = point_format;
  }
}

/// The axes of a depth camera, and which of the scanners it is.
struct DepthCamera {
  std::uint64_t scanner = 0;
  DepthCameraAxes axes;
};

std::vector<DepthCamera> depth_cameras_of(std::span<const ScannerPosition> scanners) {
  std::vector<DepthCamera> cameras;
  for (std::size_t i = 0; i < scanners.size(); ++i)
    if (scanners[i].axes) cameras.push_back({i, *scanners[i].axes});
  return cameras;
}

bool are_at_right_angles(const DepthCameraAxes& axes) {
  constexpr double k_error = 1e-6;
  return std::abs(glm::length(axes.forward) - 1.0) <= k_error &&
         std::abs(glm::length(axes.down) - 1.0) <= k_error &&
         std::abs(glm::dot(axes.forward, axes.down)) <= k_error;
}

/// visit_record_bytes(bytes): the size of a record's data.
template <class Stream, class Cloud, class VisitRecordBytes>
void visit_metadata(Stream& stream, Cloud& cloud, const VisitRecordBytes& visit_record_bytes) {
  // The fewest bytes that an entry of each list takes.
  constexpr std::size_t k_file = 44, k_warning = 8, k_extra_dimension = 48, k_record = 27, k_scanner = 32,
                        k_depth_camera = 56;
  stream.all(cloud.crs.wkt);
  stream.all(cloud.crs.geotiff_keys);
  stream.all(cloud.crs.geotiff_doubles);
  stream.all(cloud.crs.geotiff_ascii);
  stream.list(cloud.files, k_file, [&](auto& file) { visit_file(stream, file); });
  stream.list(cloud.warnings, k_warning, [&](auto& warning) { stream.all(warning); });
  stream.list(cloud.extra_dimensions, k_extra_dimension,
              [&](auto& dimension) { visit_extra_dimension(stream, dimension); });
  stream.list(cloud.records, k_record, [&](auto& record) {
    stream.all(record.user_id);
    stream.value(record.record_id);
    stream.all(record.description);
    stream.flag(record.extended);
    std::uint64_t bytes = record.data.size();
    stream.value(bytes);
    visit_record_bytes(bytes);
  });
  // A cloud without scanner positions has no list of them, as the first index files had none.
  if (stream.at_end(cloud.scanner_positions)) return;
  stream.list(cloud.scanner_positions, k_scanner, [&](auto& scanner) {
    stream.all(scanner.scan);
    for (int axis = 0; axis < 3; ++axis) stream.value(scanner.position[axis]);
  });
  std::vector<DepthCamera> cameras = depth_cameras_of(cloud.scanner_positions);
  if (stream.at_end(cameras)) return;
  stream.list(cameras, k_depth_camera, [&](auto& camera) {
    stream.value(camera.scanner);
    stream.require(camera.scanner < cloud.scanner_positions.size(), 8, "invalid scanner of a depth camera",
                   fmt::format("less than {}", cloud.scanner_positions.size()), camera.scanner);
    stream.value(camera.axes.forward);
    stream.value(camera.axes.down);
    stream.require(are_at_right_angles(camera.axes), 48, "invalid axes of a depth camera",
                   "unit vectors at right angles", glm::dot(camera.axes.forward, camera.axes.down));
    if constexpr (!std::is_const_v<Cloud>) cloud.scanner_positions[camera.scanner].axes = camera.axes;
  });
}

}  // namespace

std::vector<std::byte> encode_index_metadata(const PointCloud& cloud) {
  Writer writer;
  visit_metadata(writer, cloud, [](std::uint64_t) {});
  return writer.take();
}

IndexMetadata read_index_metadata(std::span<const std::byte> section, std::uint64_t index,
                                  const std::string& file_name) {
  Reader reader(section, index, file_name);
  IndexMetadata metadata;
  visit_metadata(reader, metadata.cloud,
                 [&](std::uint64_t bytes) { metadata.record_bytes.push_back(bytes); });
  reader.finish();
  return metadata;
}

}  // namespace alidade
