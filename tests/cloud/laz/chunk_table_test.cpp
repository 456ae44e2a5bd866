// SPDX-License-Identifier: MIT
#include "cloud/laz/chunk_table.h"

#include <gtest/gtest.h>

#include <cstring>
#include <initializer_list>

#include "tests/cloud/cloud_test_support.h"

namespace alidade {
namespace {

constexpr std::uint32_t k_points = 100;  // where they begin

/// A file whose points are `chunks_size` bytes of anything, then `table`.
struct TableFile {
  std::vector<std::byte> bytes;
  LasHeader header;
  LazLayout layout;
  std::string missing;

  std::optional<std::vector<LazChunk>> read() {
    InputFile file(bytes, "file");
    missing.clear();
    return read_chunk_table(file, header, layout, missing);
  }
  std::string error() {
    return test::error_of([&] { read(); });
  }
  template <class T>
  void put(std::size_t offset, T value) {
    std::memcpy(bytes.data() + offset, &value, sizeof value);
  }
};

TableFile make_file(std::size_t chunks_size, std::uint64_t point_count, std::uint32_t chunk_size,
                    std::initializer_list<int> table) {
  TableFile file;
  file.bytes.resize(k_points + 8 + chunks_size);
  file.put(k_points, static_cast<std::int64_t>(file.bytes.size()));
  for (const int byte : table) file.bytes.push_back(static_cast<std::byte>(byte));
  file.header.points_offset = k_points;
  file.header.point_count = point_count;
  file.header.compressed = true;
  file.layout = standard_laz_layout(0, 20, chunk_size);
  return file;
}

/// Tables that another program wrote: chunks of 100 and 90 bytes, and of 5 points in 100 and 7 in 90 bytes.
TableFile fixed_file() {
  return make_file(190, 12, 7, {0, 0, 0, 0, 2, 0, 0, 0, 0x3c, 0x4d, 0x95, 0, 0, 0});
}
TableFile variable_file() {
  return make_file(190, 12, 0, {0, 0, 0, 0, 2, 0, 0, 0, 0x1b, 0x5f, 0x29, 0xc0, 0xc3, 0, 0, 0});
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(ChunkTableTest, lists_sizes_of_chunks_of_one_count) {
  const std::vector<LazChunk> expected = {{108, 100, 7}, {208, 90, 5}};
  EXPECT_EQ(fixed_file().read(), expected);
}

TEST(ChunkTableTest, lists_sizes_and_counts_of_others) {
  const std::vector<LazChunk> expected = {{108, 100, 5}, {208, 90, 7}};
  EXPECT_EQ(variable_file().read(), expected);
}

TEST(ChunkTableTest, offset_behind_the_table_is_found_before_extended_records_too) {
  for (const bool with_records : {false, true}) {
    TableFile file = fixed_file();
    const std::int64_t offset = 298;
    file.put(k_points, std::int64_t{-1});
    file.bytes.resize(file.bytes.size() + 8);
    file.put(file.bytes.size() - 8, offset);
    if (with_records) {
      file.header.extended_records_offset = file.bytes.size();
      file.bytes.resize(file.bytes.size() + 60);
    }
    EXPECT_EQ(file.read(), fixed_file().read());
  }
}

TEST(ChunkTableTest, no_offset_is_a_missing_table) {
  for (const std::int64_t offset :
       {std::int64_t{0}, std::int64_t{-1}, std::int64_t{-2}, std::int64_t{k_points}}) {
    TableFile file = fixed_file();
    file.put(k_points, offset);
    EXPECT_FALSE(file.read());
    EXPECT_TRUE(contains(file.missing, "missing offset of the chunk table"));
  }
}

TEST(ChunkTableTest, cut_tables_are_missing) {
  const std::size_t size = fixed_file().bytes.size();
  for (std::size_t length = 298; length < size; ++length) {
    TableFile file = fixed_file();
    file.bytes.resize(length);
    EXPECT_FALSE(file.read()) << length;
    EXPECT_FALSE(file.missing.empty());
  }
}

TEST(ChunkTableTest, file_without_points_needs_no_table) {
  TableFile file = make_file(0, 0, 7, {0, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(file.read(), std::vector<LazChunk>{});
  file.bytes.resize(k_points);
  EXPECT_EQ(file.read(), std::vector<LazChunk>{});
}

TEST(ChunkTableTest, tables_that_cannot_be_true_are_errors) {
  TableFile file = fixed_file();
  file.put(298, std::uint32_t{1});
  EXPECT_TRUE(contains(file.error(), "file:byte 298: unsupported version of the chunk table"));

  file = fixed_file();
  file.put(k_points, std::int64_t{k_points + 4});
  EXPECT_TRUE(contains(file.error(), "invalid offset of the chunk table"));

  for (const std::uint32_t count : {1u, 3u, 0u, 0xffffffffu}) {
    file = fixed_file();
    file.put(302, count);
    EXPECT_TRUE(contains(file.error(), "invalid number of chunks")) << count;
  }
  file = variable_file();
  file.put(302, std::uint32_t{13});
  EXPECT_TRUE(contains(file.error(), "invalid number of chunks")) << "more than points";

  file = variable_file();
  file.header.point_count = 13;
  EXPECT_TRUE(contains(file.error(), "the chunk table lists fewer points than the header"));
  file.header.point_count = 11;
  EXPECT_TRUE(contains(file.error(), "invalid number of points of chunk 1"));

  file = make_file(189, 12, 7, {0, 0, 0, 0, 2, 0, 0, 0, 0x3c, 0x4d, 0x95, 0, 0, 0});
  EXPECT_TRUE(contains(file.error(), "invalid size of chunk 1"));
  file = make_file(191, 12, 7, {0, 0, 0, 0, 2, 0, 0, 0, 0x3c, 0x4d, 0x95, 0, 0, 0});
  EXPECT_TRUE(contains(file.error(), "the chunks do not end at the chunk table"));
}

TEST(ChunkTableTest, chunks_have_no_more_points_than_their_bytes_can_hold) {
  TableFile file = make_file(190, 1'000'000, 500'000, {0, 0, 0, 0, 2, 0, 0, 0, 0x3c, 0x4d, 0x95, 0, 0, 0});
  EXPECT_TRUE(contains(file.error(), "invalid number of points of chunk 0"));
}

TEST(ChunkTableTest, chunks_are_at_least_a_record_and_the_start_of_a_stream) {
  EXPECT_EQ(smallest_chunk(standard_laz_layout(0, 20)), 24u);
  EXPECT_EQ(smallest_chunk(standard_laz_layout(8, 40)), 40u + 4 + 4 * (9 + 2 + 2));
  TableFile file = fixed_file();
  file.layout = standard_laz_layout(0, 90, 7);
  EXPECT_TRUE(contains(file.error(), "invalid size of chunk 1"))
      << "90 bytes hold no record of 90 and a stream";
}

std::vector<std::byte> bytes(std::initializer_list<int> values) {
  std::vector<std::byte> result;
  for (const int value : values) result.push_back(static_cast<std::byte>(value));
  return result;
}

// Tables that other programs wrote and read.

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

}  // namespace
}  // namespace alidade
