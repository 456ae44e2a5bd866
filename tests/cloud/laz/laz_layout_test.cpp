// SPDX-License-Identifier: MIT
#include "cloud/laz/laz_layout.h"

#include <gtest/gtest.h>

#include "cloud/las/las_header.h"
#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/laz/laz_builder.h"

namespace alidade {
namespace {

using test::error_of;

constexpr std::uint64_t k_offset = 281;

std::vector<std::byte> data_of(const LazLayout& layout) {
  const std::vector<std::uint8_t> data = test::laszip_data(layout);
  const auto bytes = std::as_bytes(std::span(data));
  return {bytes.begin(), bytes.end()};
}

LazLayout parse(const std::vector<std::byte>& data, int format = 7, std::size_t size = 38) {
  return parse_laszip_record(data, "file", k_offset, format, size);
}

/// The Error when a field of a good record of format 7 with two extra bytes is overwritten.
template <class T>
std::string error_with(std::size_t offset, T value) {
  std::vector<std::byte> data = data_of(standard_laz_layout(7, 38));
  std::memcpy(data.data() + offset, &value, sizeof value);
  return error_of([&] { parse(data); });
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(LaszipRecordTest, what_writers_write_is_read) {
  for (int format = 0; format < k_las_point_formats; ++format) {
    const LazLayout layout = standard_laz_layout(format, 100, 1234);
    EXPECT_EQ(parse(data_of(layout), format, 100), layout) << format;
  }
}

TEST(LaszipRecordTest, all_bits_set_or_none_are_chunks_of_different_sizes) {
  LazLayout layout = standard_laz_layout(7, 38);
  std::vector<std::byte> data = data_of(layout);
  for (const std::uint32_t size : {0u, 0xffffffffu}) {
    std::memcpy(data.data() + 12, &size, sizeof size);
    EXPECT_EQ(parse(data).chunk_size, 0u);
  }
}

TEST(LaszipRecordTest, older_versions_of_items_are_known) {
  LazLayout layout = standard_laz_layout(3, 35);
  for (LazItem& item : layout.items) item.version = 1;
  EXPECT_EQ(parse(data_of(layout), 3, 35), layout);
  layout.compressor = LazCompressor::pointwise;
  EXPECT_EQ(parse(data_of(layout), 3, 35), layout);
  LazLayout layered = standard_laz_layout(7, 38);
  for (const int version : {2, 4}) {
    for (LazItem& item : layered.items) item.version = static_cast<std::uint16_t>(version);
    EXPECT_EQ(parse(data_of(layered)), layered);
  }
}

TEST(LaszipRecordTest, with_compressor_none_nothing_else_is_checked) {
  std::vector<std::byte> data(34, std::byte{0xee});
  data[0] = data[1] = std::byte{0};
  EXPECT_EQ(parse(data).compressor, LazCompressor::none);
}

TEST(LaszipRecordTest, errors_name_file_and_offset) {
  EXPECT_TRUE(contains(error_with(0, std::uint16_t{4}), "file:byte 281: unsupported compressor"));
  EXPECT_TRUE(contains(error_with(2, std::uint16_t{1}), "file:byte 283: unsupported entropy coder"));
}

TEST(LaszipRecordTest, items_must_be_those_of_the_format) {
  const std::string wrong = "do not match point format 7 with 38 bytes";
  EXPECT_TRUE(contains(error_with(34, std::uint16_t{6}), wrong)) << "an old item";
  EXPECT_TRUE(contains(error_with(34, std::uint16_t{99}), wrong)) << "an unknown item";
  EXPECT_TRUE(contains(error_with(36, std::uint16_t{31}), wrong)) << "another size";
  EXPECT_TRUE(contains(error_with(40, std::uint16_t{12}), wrong)) << "the infrared of format 8";
  EXPECT_TRUE(contains(error_with(48, std::uint16_t{0}), wrong)) << "no extra bytes";
  EXPECT_TRUE(
      contains(error_of([] { parse(data_of(standard_laz_layout(7, 38)), 7, 39); }), "7 with 39 bytes"));
}

TEST(LaszipRecordTest, sizes_of_the_record_must_agree) {
  EXPECT_TRUE(contains(error_with(32, std::uint16_t{0}), "invalid number of items"));
  EXPECT_TRUE(contains(error_with(32, std::uint16_t{6}), "invalid number of items"));
  EXPECT_TRUE(contains(error_with(32, std::uint16_t{4}), "wrong size of the laszip record"));
  EXPECT_TRUE(contains(error_of([] { parse(std::vector<std::byte>(33)); }), "truncated laszip record"));
}

TEST(LaszipRecordTest, versions_must_exist) {
  EXPECT_TRUE(contains(error_with(38, std::uint16_t{1}), "byte 319: unsupported version of item 10"));
  EXPECT_TRUE(contains(error_with(38, std::uint16_t{5}), "expected 2 to 4, found 5"));
  LazLayout layout = standard_laz_layout(4, 57);
  layout.items.back().version = 2;
  EXPECT_TRUE(contains(error_of([&] { parse(data_of(layout), 4, 57); }), "expected 1 to 1, found 2"));
}

TEST(LaszipRecordTest, extra_bytes_are_as_many_as_can_be_described_and_no_more) {
  for (const int format : {3, 7}) {
    const std::size_t base = format == 3 ? 34 : 36;
    const LazLayout most = standard_laz_layout(format, base + 8192);
    EXPECT_EQ(parse(data_of(most), format, base + 8192), most);
    EXPECT_TRUE(contains(
        error_of([&] { parse(data_of(standard_laz_layout(format, base + 8193)), format, base + 8193); }),
        "file:byte 315: too many extra bytes per point for LAZ; expected at most 8192, found 8193"));
  }
}

TEST(LaszipRecordTest, old_formats_are_pointwise_and_new_ones_layered) {
  EXPECT_TRUE(contains(error_with(0, std::uint16_t{2}), "the compressor does not support point format 7"));
  EXPECT_TRUE(contains(error_with(0, std::uint16_t{1}), "the compressor does not support point format 7"));
  LazLayout layout = standard_laz_layout(1, 28);
  layout.compressor = LazCompressor::layered;
  EXPECT_TRUE(contains(error_of([&] { parse(data_of(layout), 1, 28); }),
                       "the compressor does not support point format 1"));
}

TEST(LaszipRecordTest, says_compressor_chunk_size_and_items) {
  const VariableLengthRecord record = laszip_record(standard_laz_layout(7, 40));
  EXPECT_EQ(record.user_id, "laszip encoded");
  EXPECT_EQ(record.record_id, 22204);
  EXPECT_FALSE(record.extended);
  EXPECT_EQ(record.data,
            (std::vector<std::uint8_t>{3,    0,    0,    0,    2,    2,    0,    0,    0,    0,
                                       0,    0,    0x50, 0xc3, 0,    0,  // compressor ... chunk size
                                       0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff,
                                       0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 3,    0,  // special records, items
                                       10,   0,    30,   0,    3,    0,    11,   0,    6,    0,
                                       3,    0,    14,   0,    4,    0,    3,    0}));
}

TEST(LaszipRecordTest, chunks_of_different_sizes_have_their_mark) {
  const VariableLengthRecord record = laszip_record(standard_laz_layout(0, 20, 0));
  EXPECT_EQ(std::vector<std::uint8_t>(record.data.begin() + 12, record.data.begin() + 16),
            std::vector<std::uint8_t>(4, 0xff));
}

TEST(LazLayoutTest, items_cover_the_record_of_every_format) {
  for (int format = 0; format < k_las_point_formats; ++format) {
    const std::size_t size =
        static_cast<std::size_t>(k_las_point_layouts[static_cast<std::size_t>(format)].size);
    EXPECT_EQ(standard_laz_layout(format, size).record_size(), size) << format;
    EXPECT_EQ(standard_laz_layout(format, size + 7).record_size(), size + 7) << format;
  }
}

TEST(LazLayoutTest, old_formats_are_pointwise_and_new_ones_layered) {
  for (int format = 0; format < k_las_point_formats; ++format) {
    EXPECT_EQ(standard_laz_layout(format, 100).compressor,
              format < 6 ? LazCompressor::pointwise_chunked : LazCompressor::layered);
  }
}

TEST(LazLayoutTest, items_are_those_that_writers_agree_on) {
  const std::vector<LazItem> of_5 = {{LazItemKind::point10, 20, 2},
                                     {LazItemKind::gps_time11, 8, 2},
                                     {LazItemKind::rgb12, 6, 2},
                                     {LazItemKind::wave_packet13, 29, 1},
                                     {LazItemKind::byte, 2, 2}};
  EXPECT_EQ(standard_laz_layout(5, 65).items, of_5);
  const std::vector<LazItem> of_10 = {{LazItemKind::point14, 30, 3},
                                      {LazItemKind::rgb_nir14, 8, 3},
                                      {LazItemKind::wave_packet14, 29, 3},
                                      {LazItemKind::byte14, 1, 3}};
  EXPECT_EQ(standard_laz_layout(10, 68).items, of_10);
  const std::vector<LazItem> of_7 = {{LazItemKind::point14, 30, 3}, {LazItemKind::rgb14, 6, 3}};
  EXPECT_EQ(standard_laz_layout(7, 36).items, of_7);
}

TEST(LazLayoutTest, chunks_have_50000_points_unless_a_writer_decides_otherwise) {
  EXPECT_EQ(standard_laz_layout(0, 20).chunk_size, 50000u);
  EXPECT_EQ(standard_laz_layout(0, 20, 256).chunk_size, 256u);
}

}  // namespace
}  // namespace alidade
