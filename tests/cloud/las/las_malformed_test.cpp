// SPDX-License-Identifier: MIT
// Damaged LAS files: an Error that says where and what, or a clean read; never a crash or memory beyond the
// file's size.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/las/las_builder.h"
#include "tests/support/random.h"

namespace alidade {
namespace {

using test::build_las;
using test::error_of;
using test::read_memory;
using test::sample_las;

template <class T>
std::vector<std::byte> with(std::vector<std::byte> bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof(T));
  return bytes;
}

/// The Error for a valid file of version 1.4, format 7, after one field was changed.
template <class T>
std::string error_with(std::size_t offset, T value) {
  return error_of([&] { read_memory(with(build_las(sample_las(4, 7)), offset, value)); });
}

/// Reads bytes that may be anything; counts the clean reads.
int read_or_error(std::span<const std::byte> bytes) {
  try {
    const PointCloud cloud = read_memory(bytes);
    EXPECT_LE(cloud.size() * 20, bytes.size());
    return 1;
  } catch (const Error&) {
    return 0;
  }
}

TEST(LasMalformedTest, a_truncation_anywhere_is_an_error_or_a_clean_read) {
  for (int format = 0; format < 11; ++format) {
    for (int version = test::oldest_las_version(format); version <= 4; ++version) {
      const std::vector<std::byte> bytes = build_las(sample_las(version, format));
      int clean = 0;
      for (std::size_t size = 0; size < bytes.size(); ++size) {
        // An exact copy, so that the address sanitizer sees any byte read beyond the end.
        const std::vector<std::byte> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
        clean += read_or_error(cut);
      }
      EXPECT_EQ(clean, 0) << "nothing of the sample can be left out: version 1." << version << ", format "
                          << format;
      EXPECT_EQ(read_or_error(bytes), 1);
    }
  }
}

TEST(LasMalformedTest, any_byte_changed_is_an_error_or_a_clean_read) {
  test::Random random;
  for (int format = 0; format < 11; ++format) {
    const std::vector<std::byte> bytes = build_las(sample_las(4, format, 3));
    int clean = 0;
    for (std::size_t offset = 0; offset < bytes.size(); ++offset) {
      for (const int change : {0x01, 0x80, 0xff, static_cast<int>(random.below(256))}) {
        std::vector<std::byte> changed = bytes;
        changed[offset] ^= static_cast<std::byte>(change);
        clean += read_or_error(changed);
      }
    }
    EXPECT_GT(clean, 0);
  }
}

TEST(LasMalformedTest, a_bad_scale_is_an_error) {
  const double bad[] = {0.0, -0.01, std::nan(""), std::numeric_limits<double>::infinity()};
  for (const double scale : bad) {
    for (const std::size_t axis : {0u, 1u, 2u}) {
      const std::string message = error_with(131 + 8 * axis, scale);
      EXPECT_NE(message.find("byte " + std::to_string(131 + 8 * axis)), std::string::npos) << message;
      EXPECT_NE(message.find("scale"), std::string::npos) << message;
    }
  }
}

TEST(LasMalformedTest, a_bad_offset_is_an_error) {
  EXPECT_NE(error_with(155, std::nan("")).find("offset of the x"), std::string::npos);
  EXPECT_NE(error_with(171, std::numeric_limits<double>::infinity()).find("offset of the z"),
            std::string::npos);
}

TEST(LasMalformedTest, points_inside_the_header_or_beyond_the_file_are_an_error) {
  for (const std::uint32_t offset : {0u, 227u, 374u, 1000000u, 0xffffffffu}) {
    const std::string message = error_with(96, offset);
    EXPECT_NE(message.find("byte 96: invalid offset of the points"), std::string::npos) << message;
  }
}

TEST(LasMalformedTest, a_header_too_short_for_its_version_is_an_error) {
  for (const std::uint16_t size : {0, 226, 374, 65535}) {
    EXPECT_NE(error_with(94, size).find("invalid header size"), std::string::npos);
  }
}

TEST(LasMalformedTest, a_record_that_runs_past_the_points_is_an_error) {
  const std::string message = error_with(375 + 20, std::uint16_t{60000});
  EXPECT_NE(message.find("byte 375: a variable length record exceeds its section"), std::string::npos)
      << message;
}

TEST(LasMalformedTest, more_records_than_there_is_room_for_are_an_error) {
  EXPECT_NE(error_with(100, 1069128089u).find("variable length record"), std::string::npos);
  EXPECT_NE(error_with(243, 0xffffffffu).find("variable length record"), std::string::npos);
}

TEST(LasMalformedTest, an_extended_record_that_runs_past_the_file_is_an_error) {
  const std::vector<std::byte> bytes = build_las(sample_las(4, 7));
  const std::size_t offset = bytes.size() - 4 - 60;
  for (const std::uint64_t size : {std::uint64_t{5}, ~std::uint64_t{0}, ~std::uint64_t{0} - 60}) {
    const std::string message = error_of([&] { read_memory(with(bytes, offset + 20, size)); });
    EXPECT_NE(message.find("byte " + std::to_string(offset)), std::string::npos) << message;
  }
}

TEST(LasMalformedTest, extended_records_among_the_points_are_an_error) {
  EXPECT_NE(error_with(235, std::uint64_t{400}).find("byte 235: invalid offset of the extended records"),
            std::string::npos);
}

TEST(LasMalformedTest, more_points_than_the_file_holds_are_an_error) {
  for (const std::uint64_t count : {std::uint64_t{23}, std::uint64_t{1} << 40, ~std::uint64_t{0}}) {
    const std::string message = error_with(247, count);
    EXPECT_NE(message.find("byte 247: truncated file: it ends before its last point"), std::string::npos)
        << message;
  }
}

TEST(LasMalformedTest, points_too_short_for_their_format_are_an_error) {
  EXPECT_NE(error_with(105, std::uint16_t{35}).find("expected at least 36 bytes, found 35"),
            std::string::npos);
  EXPECT_NE(error_with(105, std::uint16_t{0}).find("too short"), std::string::npos);
}

TEST(LasMalformedTest, unknown_versions_and_formats_are_an_error) {
  EXPECT_NE(error_with(24, std::uint8_t{2}).find("expected 1.0 to 1.4, found 2.4"), std::string::npos);
  EXPECT_NE(error_with(25, std::uint8_t{5}).find("found 1.5"), std::string::npos);
  EXPECT_NE(error_with(104, std::uint8_t{11}).find("unsupported point format"), std::string::npos);
}

TEST(LasMalformedTest, compressed_points_without_a_record_that_says_how_are_an_error) {
  EXPECT_NE(error_with(104, std::uint8_t{7 | 128}).find("compressed points without a laszip record"),
            std::string::npos);
  EXPECT_NE(error_with(104, std::uint8_t{7 | 64}).find("compressed points without a laszip record"),
            std::string::npos);
}

TEST(LasMalformedTest, records_of_packing_that_differ_are_an_error) {
  test::LasFile file = sample_las(4, 7);
  file.records.push_back({"laszip encoded", 22204, "", std::vector<std::uint8_t>(34)});
  file.records.push_back({"laszip encoded", 22204, "", std::vector<std::uint8_t>(40)});
  EXPECT_NE(error_of([&] { read_memory(build_las(file)); }).find("the laszip record differs"),
            std::string::npos);
}

TEST(LasMalformedTest, points_packed_by_compressor_none_are_plain_points) {
  test::LasFile file = sample_las(2, 3);
  const PointCloud plain = read_memory(build_las(file));
  file.records.push_back({"laszip encoded", 22204, "", std::vector<std::uint8_t>(34)});
  const std::vector<std::byte> bytes = with(build_las(file), 104, std::uint8_t{3 | 128});
  const PointCloud cloud = read_memory(bytes);
  EXPECT_EQ(cloud.positions, plain.positions);
  EXPECT_EQ(cloud.records, plain.records) << "the record says nothing about the points themselves";
  const std::vector<std::byte> cut(bytes.begin(), bytes.end() - 200);
  EXPECT_NE(error_of([&] { read_memory(cut); }).find("truncated file: it ends before its last point"),
            std::string::npos);
}

TEST(LasMalformedTest, records_of_copc_are_not_handed_on) {
  test::LasFile file = sample_las(4, 7);
  const PointCloud plain = read_memory(build_las(file));
  file.records.insert(file.records.begin(), {"copc", 1, "", std::vector<std::uint8_t>(160)});
  file.extended_records.push_back({"copc", 1000, "", std::vector<std::uint8_t>(32)});
  EXPECT_EQ(read_memory(build_las(file)).records, plain.records);
}

TEST(LasMalformedTest, damaged_geotiff_keys_are_a_warning) {
  const std::vector<std::vector<std::uint8_t>> damaged = {
      {1, 0, 1, 0},                                      // no head
      {1, 0, 1, 0, 0, 0, 9, 0},                          // nine keys, none there
      {1, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0},  // a key without name
      {1, 0, 1, 0, 0, 0, 1, 0, 0, 4, 0xb1, 0x87, 5, 0, 0xff, 0xff,
       0xee},  // text that is not there, an odd byte
  };
  for (const std::vector<std::uint8_t>& keys : damaged) {
    test::LasFile file = sample_las(2, 1);
    file.records = {{"LASF_Projection", 34735, "", keys}};
    const PointCloud cloud = read_memory(build_las(file));
    EXPECT_TRUE(test::warns(cloud, "); they are kept unchanged"));
    EXPECT_EQ(cloud.size(), 20u);
  }
}

TEST(LasMalformedTest, extra_dimensions_beyond_the_341_of_one_record_are_kept_as_undocumented_bytes) {
  const auto read = [](int count) {
    test::LasFile file = sample_las(4, 6, 2);
    file.records.clear();
    file.extra_bytes = 600;
    file.points = test::random_las_points(6, 2, 600, 5);
    const std::vector<std::vector<std::uint8_t>> entries(static_cast<std::size_t>(count),
                                                         test::las_extra_bytes_entry(1, 0, "same"));
    file.extended_records = {test::las_extra_bytes_record(entries)};
    const PointCloud cloud = read_memory(build_las(file));
    for (std::size_t row = 0; row < 2; ++row) {
      std::vector<std::uint8_t> joined;
      for (const ExtraDimension& dimension : cloud.extra_dimensions) {
        const auto first = dimension.values.begin() + static_cast<std::ptrdiff_t>(row) * dimension.byte_count;
        joined.insert(joined.end(), first, first + dimension.byte_count);
      }
      EXPECT_EQ(joined, file.points[row].extra);
    }
    return cloud;
  };
  const PointCloud full = read(341), more = read(342);
  for (const PointCloud* cloud : {&full, &more}) {
    ASSERT_EQ(cloud->extra_dimensions.size(), 343u);
    EXPECT_EQ(cloud->extra_dimensions[340].name, "same");
    EXPECT_EQ(cloud->extra_dimensions[341].name, "undocumented");
    EXPECT_EQ(cloud->extra_dimensions[341].byte_count, 255);
    EXPECT_EQ(cloud->extra_dimensions[342].byte_count, 4);
  }
  EXPECT_FALSE(test::warns(full, "describes more than"));
  EXPECT_TRUE(test::warns(more, "describes more than 341 dimensions"));
}

TEST(LasMalformedTest, extra_bytes_of_unknown_type_are_a_warning) {
  test::LasFile file = sample_las(4, 6, 2);
  file.records = {test::las_extra_bytes_record({test::las_extra_bytes_entry(31, 0, "odd")})};
  EXPECT_TRUE(test::warns(read_memory(build_las(file)), "extra-bytes record"));
}

}  // namespace
}  // namespace alidade
