// SPDX-License-Identifier: MIT
#include "cloud/laz/chunk_table.h"

#include <gtest/gtest.h>

#include "cloud/laz/laz_layout.h"

namespace alidade {
namespace {

std::vector<std::byte> bytes(std::initializer_list<int> values) {
  std::vector<std::byte> result;
  for (const int value : values) result.push_back(static_cast<std::byte>(value));
  return result;
}

// Vectors that other programs wrote and read.

TEST(ChunkTableTest, chunks_of_one_size_are_listed_by_their_bytes) {
  const std::vector<LazChunk> chunks = {{.byte_count = 100, .point_count = 5},
                                        {.byte_count = 90, .point_count = 3}};
  EXPECT_EQ(encode_chunk_table(chunks, standard_laz_layout(0, 20, 5)),
            bytes({0, 0, 0, 0, 2, 0, 0, 0, 0x3c, 0x4d, 0x95, 0, 0, 0}));
}

TEST(ChunkTableTest, chunks_of_different_sizes_are_listed_by_points_and_bytes) {
  const std::vector<LazChunk> chunks = {{.byte_count = 100, .point_count = 5},
                                        {.byte_count = 90, .point_count = 7}};
  EXPECT_EQ(encode_chunk_table(chunks, standard_laz_layout(0, 20, 0)),
            bytes({0, 0, 0, 0, 2, 0, 0, 0, 0x1b, 0x5f, 0x29, 0xc0, 0xc3, 0, 0, 0}));
}

TEST(ChunkTableTest, the_table_of_a_file_without_points_has_no_stream) {
  EXPECT_EQ(encode_chunk_table({}, standard_laz_layout(6, 30)), bytes({0, 0, 0, 0, 0, 0, 0, 0}));
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

}  // namespace
}  // namespace alidade
