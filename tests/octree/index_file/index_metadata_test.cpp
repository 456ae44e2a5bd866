// SPDX-License-Identifier: MIT
// Metadata of an index file, as docs/index_file.md describes them, and the tables of that page.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>

#include "octree/index_file/index_metadata.h"
#include "tests/octree/index_file/index_layout.h"

namespace alidade {
namespace {

using test::at;
using test::Bytes;
using test::for_each_file;
using test::sections_of;

/// Reads the metadata value by value.
class MetadataReader {
 public:
  MetadataReader(const Bytes& file, std::uint64_t offset) : file_(file), offset_(offset) {}

  template <class T>
  T next() {
    const T value = at<T>(file_, offset_);
    offset_ += sizeof(T);
    return value;
  }
  template <class T>
  std::vector<T> list() {
    std::vector<T> values;
    for (std::uint64_t left = next<std::uint64_t>(); left > 0; --left) values.push_back(next<T>());
    return values;
  }
  std::string text() {
    const std::vector<char> characters = list<char>();
    return {characters.begin(), characters.end()};
  }
  std::uint64_t offset() const { return offset_; }

 private:
  const Bytes& file_;
  std::uint64_t offset_;
};

TEST(IndexMetadata, are_as_documented) {
  for_each_file([](const Bytes& file, const PointCloud& cloud, const Octree&) {
    const auto sections = sections_of(file);
    MetadataReader reader(file, sections.at(32).offset);
    EXPECT_EQ(reader.text(), cloud.crs.wkt);
    EXPECT_EQ(reader.list<std::uint16_t>(), cloud.crs.geotiff_keys);
    EXPECT_EQ(reader.list<double>(), cloud.crs.geotiff_doubles);
    EXPECT_EQ(reader.text(), cloud.crs.geotiff_ascii);
    ASSERT_EQ(reader.next<std::uint64_t>(), cloud.files.size());
    for (const CloudFile& source : cloud.files) {
      EXPECT_EQ(reader.text(), source.path.string());
      EXPECT_EQ(reader.text(), source.format);
      EXPECT_EQ(reader.text(), source.version);
      EXPECT_EQ(reader.next<std::int32_t>(), source.point_format.value_or(-1));
      EXPECT_EQ(reader.next<std::uint64_t>(), source.point_count);
      EXPECT_EQ(reader.next<std::uint64_t>(), source.dropped_count);
    }
    ASSERT_EQ(reader.next<std::uint64_t>(), cloud.warnings.size());
    for (const std::string& warning : cloud.warnings) EXPECT_EQ(reader.text(), warning);
    ASSERT_EQ(reader.next<std::uint64_t>(), cloud.extra_dimensions.size());
    for (const ExtraDimension& dimension : cloud.extra_dimensions) {
      EXPECT_EQ(reader.text(), dimension.name);
      EXPECT_EQ(reader.text(), dimension.description);
      EXPECT_EQ(reader.next<std::uint8_t>(), static_cast<std::uint8_t>(dimension.type));
      EXPECT_EQ(reader.next<std::uint32_t>(), static_cast<std::uint32_t>(dimension.byte_count));
      EXPECT_EQ(reader.next<double>(), dimension.scale);
      EXPECT_EQ(reader.next<double>(), dimension.offset);
      EXPECT_EQ(reader.next<std::uint8_t>(), dimension.has_scale);
      EXPECT_EQ(reader.next<std::uint8_t>(), dimension.has_offset);
      EXPECT_EQ(reader.next<std::uint8_t>(), dimension.no_data.has_value());
      EXPECT_EQ((reader.next<std::array<std::uint8_t, 8>>()),
                dimension.no_data.value_or(std::array<std::uint8_t, 8>{}));
    }
    std::uint64_t data = sections.at(33).offset;
    ASSERT_EQ(reader.next<std::uint64_t>(), cloud.records.size());
    for (const VariableLengthRecord& record : cloud.records) {
      EXPECT_EQ(reader.text(), record.user_id);
      EXPECT_EQ(reader.next<std::uint16_t>(), record.record_id);
      EXPECT_EQ(reader.text(), record.description);
      EXPECT_EQ(reader.next<std::uint8_t>(), record.extended);
      ASSERT_EQ(reader.next<std::uint64_t>(), record.data.size());
      if (!record.data.empty()) {
        EXPECT_EQ(std::memcmp(file.data() + data, record.data.data(), record.data.size()), 0);
      }
      data += record.data.size();
    }
    ASSERT_EQ(reader.next<std::uint64_t>(), cloud.scanner_positions.size());
    for (const ScannerPosition& scanner : cloud.scanner_positions) {
      EXPECT_EQ(reader.text(), scanner.scan);
      for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(reader.next<double>(), scanner.position[axis]);
    }
    ASSERT_EQ(reader.next<std::uint64_t>(), 1u);
    EXPECT_EQ(reader.next<std::uint64_t>(), 1u) << "the second is a depth camera";
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_EQ(reader.next<double>(), cloud.scanner_positions[1].axes->forward[axis]);
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_EQ(reader.next<double>(), cloud.scanner_positions[1].axes->down[axis]);
    EXPECT_EQ(reader.offset(), sections.at(32).offset + sections.at(32).bytes);
    EXPECT_EQ(data, sections.at(33).offset + sections.at(33).bytes);
  });
}

TEST(IndexMetadata, without_scanner_positions_have_no_list_of_them) {
  PointCloud cloud;
  const std::size_t without = encode_index_metadata(cloud).size();
  cloud.scanner_positions = {{"ab", {1, 2, 3}}};
  EXPECT_EQ(encode_index_metadata(cloud).size(), without + 8 + 8 + 2 + 24);
}

/// Bytes of a type as the page names it: "u32", "f64[3]", "u8[3][8]", "entry[32]".
std::uint64_t width(const std::string& type) {
  static const std::map<std::string, std::uint64_t> k_widths = {
      {"char", 1}, {"u8", 1}, {"u16", 2}, {"u32", 4}, {"i32", 4}, {"u64", 8}, {"f64", 8}, {"entry", 32}};
  const std::size_t bracket = std::min(type.find('['), type.size());
  std::uint64_t bytes = k_widths.at(type.substr(0, bracket));
  for (std::size_t open = bracket; open < type.size(); open = type.find('[', open + 1))
    bytes *= std::stoull(type.substr(open + 1));
  return bytes;
}

/// What is said of metadata whose bytes that differ between two clouds become `value`.
std::string problem_of_metadata(const PointCloud& cloud, const PointCloud& other, std::uint8_t value) {
  Bytes bytes = encode_index_metadata(cloud);
  const Bytes others = encode_index_metadata(other);
  EXPECT_EQ(bytes.size(), others.size());
  for (std::size_t i = 0; i < std::min(bytes.size(), others.size()); ++i)
    if (bytes[i] != others[i]) bytes[i] = std::byte{value};
  return test::error_of([&] { read_index_metadata(bytes, 0, "memory"); });
}

TEST(IndexMetadata, values_that_cannot_be_are_errors) {
  const auto expect = [](const std::string& message, const std::string& part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  PointCloud cloud;
  ExtraDimension& dimension = cloud.extra_dimensions.emplace_back();
  dimension.type = ScalarType::uint8;
  dimension.byte_count = 1;
  PointCloud other = cloud;
  other.extra_dimensions[0].has_scale = true;
  expect(problem_of_metadata(cloud, other, 2), "invalid flag in the metadata");
  other = cloud;
  other.extra_dimensions[0].type = ScalarType::int8;
  expect(problem_of_metadata(cloud, other, 11), "invalid type of an extra dimension");
  dimension.type = ScalarType::bytes;
  other = cloud;
  other.extra_dimensions[0].byte_count = 2;
  expect(problem_of_metadata(cloud, other, 0), "invalid size of an extra dimension");
}

TEST(IndexMetadata, depth_cameras_that_cannot_be_are_errors) {
  PointCloud cloud;
  cloud.scanner_positions = {{"", {1, 2, 3}, DepthCameraAxes{}}, {"", {4, 5, 6}, {}}};
  Bytes bytes = encode_index_metadata(cloud);
  EXPECT_EQ(read_index_metadata(bytes, 0, "memory").cloud.scanner_positions, cloud.scanner_positions);
  const std::size_t camera = bytes.size() - 56;
  const auto problem = [&](std::size_t byte, auto value) {
    Bytes changed = bytes;
    std::memcpy(changed.data() + camera + byte, &value, sizeof value);
    return test::error_of([&] { read_index_metadata(changed, 0, "memory"); });
  };
  EXPECT_NE(problem(0, std::uint64_t{2}).find("invalid scanner of a depth camera"), std::string::npos);
  for (const double value : {0.5, static_cast<double>(NAN), static_cast<double>(INFINITY)})
    for (std::size_t byte = 8; byte < 56; byte += 8)
      EXPECT_NE(problem(byte, value).find("invalid axes of a depth camera"), std::string::npos) << byte;
}

TEST(IndexMetadata, bytes_behind_the_last_list_are_an_error) {
  PointCloud cloud;
  cloud.scanner_positions.push_back({"scan", glm::dvec3(1.0), DepthCameraAxes{}});
  Bytes bytes = encode_index_metadata(cloud);
  EXPECT_NO_THROW(read_index_metadata(bytes, 0, "memory"));
  bytes.push_back(std::byte{0});
  const std::string message = test::error_of([&] { read_index_metadata(bytes, 0, "memory"); });
  EXPECT_NE(message.find("extra bytes after the metadata"), std::string::npos) << message;
}

TEST(IndexPage, tables_cover_every_byte_once) {
  std::ifstream stream(ALIDADE_SOURCE_FOLDER "/docs/index_file.md");
  ASSERT_TRUE(stream);
  std::vector<std::uint64_t> ends;
  bool in_table = false;
  std::uint64_t next = 0;
  for (std::string line; std::getline(stream, line);) {
    if (line == "| byte | type | meaning |") {
      in_table = true;
      next = 0;
    } else if (in_table && !line.starts_with("|")) {
      in_table = false;
      ends.push_back(next);
    } else if (in_table && !line.starts_with("|--")) {
      std::istringstream words(line);
      std::string bar, type;
      std::uint64_t offset = 0;
      words >> bar >> offset >> bar >> type;
      EXPECT_EQ(offset, next) << line;
      next = offset + width(type);
    }
  }
  EXPECT_EQ(ends, (std::vector<std::uint64_t>{4096, 32, 128}));
}

}  // namespace
}  // namespace alidade
