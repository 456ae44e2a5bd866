// SPDX-License-Identifier: MIT
#include "octree/index_file/index_metadata.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "base/error.h"

namespace alidade {
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
  Reader(std::span<const std::byte> bytes, std::uint64_t offset, const std::string& file_name)
      : bytes_(bytes), offset_(offset), file_(file_name) {}

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
                 .location = fmt::format("byte {}", offset_ + used_ - back),
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
  std::uint64_t offset_;  ///< of the section in the file
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

IndexMetadata read_index_metadata(std::span<const std::byte> section, std::uint64_t offset,
                                  const std::string& file_name) {
  Reader reader(section, offset, file_name);
  IndexMetadata metadata;
  visit_metadata(reader, metadata.cloud,
                 [&](std::uint64_t bytes) { metadata.record_bytes.push_back(bytes); });
  reader.finish();
  return metadata;
}

}  // namespace alidade
