// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

// LAS files of every version and point format for tests and fuzz seeds, put together field by field from the
// tables of the specification and without the library's own code, so that a mistake there does not cancel out
// here.

namespace alidade::test {

/// One point with every field that any format has, as stored (steps, raw angle).
struct LasPoint {
  std::int32_t x = 0, y = 0, z = 0;
  std::uint16_t intensity = 0;
  int return_number = 1, return_count = 1;  ///< 0..7 in formats 0-5, 0..15 in 6-10
  bool scan_direction = false, edge = false;
  bool synthetic = false, key_point = false, withheld = false;
  bool overlap = false;     ///< formats 6-10
  int scanner_channel = 0;  ///< formats 6-10
  int classification = 0;   ///< 0..31 in formats 0-5
  int scan_angle = 0;       ///< degrees in formats 0-5, steps of 0.006 degrees in 6-10
  int user_data = 0, point_source_id = 0;
  double gps_time = 0;
  std::array<std::uint16_t, 3> color{};
  std::uint16_t near_infrared = 0;
  std::vector<std::uint8_t> extra;  ///< as many bytes as LasFile::extra_bytes
};

struct LasRecord {
  std::string user_id;
  int record_id = 0;
  std::string description;
  std::vector<std::uint8_t> data;
};

struct LasFile {
  int version_minor = 2;
  int point_format = 2;
  std::array<double, 3> scale{0.01, 0.01, 0.01}, offset{690000, 5325000, 500};
  int global_encoding = 0;
  int file_source_id = 0;
  std::vector<LasPoint> points;
  int extra_bytes = 0;
  std::vector<LasRecord> records, extended_records;
  bool spare_bytes = false;  ///< the two bytes DD CC before the points of LAS 1.0
};

/// Bytes of a record of each point format, without extra bytes.
inline constexpr std::array<int, 11> k_las_point_sizes = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};

inline bool las_format_has_time(int format) {
  return format != 0 && format != 2;
}
inline bool las_format_has_color(int format) {
  return format == 2 || format == 3 || format == 5 || format == 7 || format == 8 || format == 10;
}
inline bool las_format_has_near_infrared(int format) {
  return format == 8 || format == 10;
}
inline bool las_format_has_waves(int format) {
  return format == 4 || format == 5 || format >= 9;
}

/// Bytes that are appended field by field, little endian.
class ByteSink {
 public:
  template <class T>
  ByteSink& add(std::type_identity_t<T> value) {
    std::array<std::byte, sizeof(T)> bytes;
    std::memcpy(bytes.data(), &value, sizeof(T));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return *this;
  }
  ByteSink& text(const std::string& text, std::size_t length) {
    for (std::size_t i = 0; i < length; ++i) add<char>(i < text.size() ? text[i] : '\0');
    return *this;
  }
  ByteSink& raw(const std::vector<std::uint8_t>& values) {
    for (const std::uint8_t value : values) add<std::uint8_t>(value);
    return *this;
  }
  std::size_t size() const { return bytes_.size(); }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

inline void add_las_point(ByteSink& sink, int format, const LasPoint& point) {
  sink.add<std::int32_t>(point.x).add<std::int32_t>(point.y).add<std::int32_t>(point.z);
  sink.add<std::uint16_t>(point.intensity);
  if (format <= 5) {
    sink.add<std::uint8_t>(static_cast<std::uint8_t>(point.return_number | point.return_count << 3 |
                                                     (point.scan_direction ? 64 : 0) |
                                                     (point.edge ? 128 : 0)));
    sink.add<std::uint8_t>(static_cast<std::uint8_t>(point.classification | (point.synthetic ? 32 : 0) |
                                                     (point.key_point ? 64 : 0) |
                                                     (point.withheld ? 128 : 0)));
    sink.add<std::int8_t>(static_cast<std::int8_t>(point.scan_angle));
    sink.add<std::uint8_t>(static_cast<std::uint8_t>(point.user_data));
    sink.add<std::uint16_t>(static_cast<std::uint16_t>(point.point_source_id));
  } else {
    sink.add<std::uint8_t>(static_cast<std::uint8_t>(point.return_number | point.return_count << 4));
    sink.add<std::uint8_t>(static_cast<std::uint8_t>(
        (point.synthetic ? 1 : 0) | (point.key_point ? 2 : 0) | (point.withheld ? 4 : 0) |
        (point.overlap ? 8 : 0) | point.scanner_channel << 4 | (point.scan_direction ? 64 : 0) |
        (point.edge ? 128 : 0)));
    sink.add<std::uint8_t>(static_cast<std::uint8_t>(point.classification));
    sink.add<std::uint8_t>(static_cast<std::uint8_t>(point.user_data));
    sink.add<std::int16_t>(static_cast<std::int16_t>(point.scan_angle));
    sink.add<std::uint16_t>(static_cast<std::uint16_t>(point.point_source_id));
  }
  if (las_format_has_time(format)) sink.add<double>(point.gps_time);
  if (las_format_has_color(format)) {
    for (const std::uint16_t channel : point.color) sink.add<std::uint16_t>(channel);
  }
  if (las_format_has_near_infrared(format)) sink.add<std::uint16_t>(point.near_infrared);
  if (las_format_has_waves(format)) {
    for (int i = 0; i < 29; ++i) sink.add<std::uint8_t>(0xee);
  }
  sink.raw(point.extra);
}

inline void add_las_record(ByteSink& sink, const LasRecord& record, bool extended) {
  sink.add<std::uint16_t>(0)
      .text(record.user_id, 16)
      .add<std::uint16_t>(static_cast<std::uint16_t>(record.record_id));
  if (extended) {
    sink.add<std::uint64_t>(record.data.size());
  } else {
    sink.add<std::uint16_t>(static_cast<std::uint16_t>(record.data.size()));
  }
  sink.text(record.description, 32).raw(record.data);
}

/// The bytes of the file.
inline std::vector<std::byte> build_las(const LasFile& file) {
  const int header_size = file.version_minor <= 2 ? 227 : file.version_minor == 3 ? 235 : 375;
  const int point_size = k_las_point_sizes[static_cast<std::size_t>(file.point_format)] + file.extra_bytes;
  std::size_t points_offset = static_cast<std::size_t>(header_size) + (file.spare_bytes ? 2 : 0);
  for (const LasRecord& record : file.records) points_offset += 54 + record.data.size();
  const bool legacy_counts = file.point_format <= 5 || file.version_minor < 4;
  const auto legacy_count = static_cast<std::uint32_t>(legacy_counts ? file.points.size() : 0);

  ByteSink sink;
  sink.text("LASF", 4);
  sink.add<std::uint16_t>(static_cast<std::uint16_t>(file.file_source_id));
  sink.add<std::uint16_t>(static_cast<std::uint16_t>(file.global_encoding));
  for (int i = 0; i < 16; ++i) sink.add<std::uint8_t>(static_cast<std::uint8_t>(i));  // project id
  sink.add<std::uint8_t>(1).add<std::uint8_t>(static_cast<std::uint8_t>(file.version_minor));
  sink.text("a test", 32).text("las_builder.h", 32).add<std::uint16_t>(1).add<std::uint16_t>(2024);
  sink.add<std::uint16_t>(static_cast<std::uint16_t>(header_size));
  sink.add<std::uint32_t>(static_cast<std::uint32_t>(points_offset));
  sink.add<std::uint32_t>(static_cast<std::uint32_t>(file.records.size()));
  sink.add<std::uint8_t>(static_cast<std::uint8_t>(file.point_format));
  sink.add<std::uint16_t>(static_cast<std::uint16_t>(point_size));
  sink.add<std::uint32_t>(legacy_count);
  for (int i = 0; i < 5; ++i) sink.add<std::uint32_t>(i == 0 ? legacy_count : 0);
  for (const double scale : file.scale) sink.add<double>(scale);
  for (const double offset : file.offset) sink.add<double>(offset);
  for (int i = 0; i < 6; ++i) sink.add<double>(i % 2 == 0 ? 1e7 : -1e7);  // a box looser than the points
  if (file.version_minor >= 3) sink.add<std::uint64_t>(0);
  if (file.version_minor >= 4) {
    const std::size_t points_end = points_offset + file.points.size() * static_cast<std::size_t>(point_size);
    sink.add<std::uint64_t>(file.extended_records.empty() ? 0 : points_end);
    sink.add<std::uint32_t>(static_cast<std::uint32_t>(file.extended_records.size()));
    sink.add<std::uint64_t>(file.points.size());
    for (int i = 0; i < 15; ++i) sink.add<std::uint64_t>(i == 0 ? file.points.size() : 0);
  }
  for (const LasRecord& record : file.records) add_las_record(sink, record, false);
  if (file.spare_bytes) sink.add<std::uint8_t>(0xdd).add<std::uint8_t>(0xcc);
  for (const LasPoint& point : file.points) add_las_point(sink, file.point_format, point);
  if (file.version_minor >= 4) {
    for (const LasRecord& record : file.extended_records) add_las_record(sink, record, true);
  }
  return sink.take();
}

/// An entry of the extra-bytes record. `options`: bit 0 no data, 3 scale, 4 offset; for type 0 the number of
/// bytes.
inline std::vector<std::uint8_t> las_extra_bytes_entry(int type, int options, const std::string& name,
                                                       double scale = 0, double offset = 0) {
  ByteSink sink;
  sink.add<std::uint16_t>(0).add<std::uint8_t>(static_cast<std::uint8_t>(type));
  sink.add<std::uint8_t>(static_cast<std::uint8_t>(options)).text(name, 32).add<std::uint32_t>(0);
  sink.add<std::uint64_t>((options & 1) != 0 && type != 0 ? 0x1122334455667788u : 0);  // the "no data" value
  for (int i = 0; i < 8; ++i) sink.add<std::uint64_t>(0);  // the rest of no data, minimum and maximum
  sink.add<double>(scale).add<double>(0).add<double>(0).add<double>(offset).add<double>(0).add<double>(0);
  sink.text("about " + name, 32);
  const std::vector<std::byte> bytes = sink.take();
  const auto* const first = reinterpret_cast<const std::uint8_t*>(bytes.data());
  return {first, first + bytes.size()};
}

inline LasRecord las_extra_bytes_record(const std::vector<std::vector<std::uint8_t>>& entries) {
  LasRecord record{"LASF_Spec", 4, "the extra-bytes record does not match the", {}};
  for (const auto& entry : entries) record.data.insert(record.data.end(), entry.begin(), entry.end());
  return record;
}

/// `count` points with every field the format has set to anything it can hold; 16-bit colours.
inline std::vector<LasPoint> random_las_points(int format, std::size_t count, int extra_bytes,
                                               std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  const auto below = [&](int end) { return static_cast<int>(engine() % static_cast<std::uint64_t>(end)); };
  const bool legacy = format <= 5;
  std::vector<LasPoint> points(count);
  for (LasPoint& point : points) {
    point.x = static_cast<std::int32_t>(engine());
    point.y = static_cast<std::int32_t>(engine());
    point.z = static_cast<std::int32_t>(engine());
    point.intensity = static_cast<std::uint16_t>(engine());
    point.return_number = below(legacy ? 8 : 16);
    point.return_count = below(legacy ? 8 : 16);
    point.scan_direction = below(2) == 1;
    point.edge = below(2) == 1;
    point.synthetic = below(2) == 1;
    point.key_point = below(2) == 1;
    point.withheld = below(2) == 1;
    point.overlap = !legacy && below(2) == 1;
    point.scanner_channel = legacy ? 0 : below(4);
    point.classification = below(legacy ? 32 : 256);
    point.scan_angle = legacy ? below(256) - 128 : below(65536) - 32768;
    point.user_data = below(256);
    point.point_source_id = below(65536);
    point.gps_time = std::bit_cast<double>(engine());  // any bits, also NaN and infinities
    point.color = {static_cast<std::uint16_t>(engine()), static_cast<std::uint16_t>(engine()),
                   static_cast<std::uint16_t>(engine())};
    point.near_infrared = static_cast<std::uint16_t>(engine());
    for (int i = 0; i < extra_bytes; ++i) point.extra.push_back(static_cast<std::uint8_t>(engine()));
  }
  return points;
}

/// The oldest version that allows a point format.
inline int oldest_las_version(int format) {
  if (format <= 1) return 0;
  if (format <= 3) return 2;
  return format <= 5 ? 3 : 4;
}

/// A small file with a bit of everything a version and format can hold: CRS, other records, extra bytes.
inline LasFile sample_las(int version_minor, int format, std::size_t count = 20, std::uint64_t seed = 1) {
  LasFile file;
  file.version_minor = version_minor;
  file.point_format = format;
  file.extra_bytes = 13;
  file.points = random_las_points(format, count, file.extra_bytes, seed);
  file.records.push_back(
      {"LASF_Projection", 2112, "WKT", {'P', 'R', 'O', 'J', 'C', 'S', '[', '"', 'x', '"', ']', 0}});
  file.records.push_back({"a survey", 77, "kept as it is", {1, 2, 3, 4, 5}});
  file.records.push_back(las_extra_bytes_record({las_extra_bytes_entry(9, 0, "Deviation"),
                                                 las_extra_bytes_entry(3, 1 | 8 | 16, "Range", 0.01, 100.0),
                                                 las_extra_bytes_entry(0, 5, "Blob")}));
  if (version_minor >= 4) file.extended_records.push_back({"a survey", 78, "at the end", {6, 7, 8, 9}});
  if (version_minor == 0) file.spare_bytes = true;
  return file;
}

}  // namespace alidade::test
