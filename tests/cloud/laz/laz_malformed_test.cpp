// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cstring>
#include <optional>
#include <vector>

#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/laz/laz_builder.h"
#include "tests/cloud/laz/laz_records.h"

namespace alidade {
namespace {

using test::build_laz;
using test::LazOptions;
using test::read_laz;
using test::ReadLaz;
using test::sample_las;
using test::TableLocation;

std::uint32_t points_offset(const std::vector<std::byte>& bytes) {
  std::uint32_t offset = 0;
  std::memcpy(&offset, bytes.data() + 96, sizeof offset);
  return offset;
}

constexpr std::size_t k_points = 30;

/// Files of every kind, small enough to damage them everywhere.
std::vector<std::vector<std::byte>> samples() {
  std::vector<std::vector<std::byte>> files;
  for (const int format : {3, 7}) {
    const test::LasFile file = sample_las(test::oldest_las_version(format), format, k_points);
    files.push_back(build_laz(file));
    files.push_back(build_laz(file, {.chunk_sizes = {3, 9, 1, 17}, .variable = true}));
    files.push_back(build_laz(file, {.table = TableLocation::at_end}));
    files.push_back(build_laz(file, {.table = TableLocation::unknown}));
    if (format < 6) files.push_back(build_laz(file, {.one_stream = true}));
  }
  return files;
}

/// The points that a file of k_points gives; empty for an Error, which must name the file.
std::optional<std::size_t> points_read(std::span<const std::byte> bytes, bool partial) {
  try {
    const PointCloud cloud = test::read_memory(bytes, {.partial = partial});
    const std::uint64_t lost = cloud.files.at(0).lost_count;
    EXPECT_TRUE(lost == 0 || (partial && test::warns(cloud, " lost")));
    return cloud.size();
  } catch (const Error& error) {
    EXPECT_EQ(error.parts().file, "memory") << error.what();
    return std::nullopt;
  }
}

/// Reads a file in both ways: an Error or a cloud, never anything else. The intact part of a file without
/// damage is the whole. Returns whether the file as a whole gave a cloud.
bool reads(std::span<const std::byte> bytes) {
  const std::optional<std::size_t> some = points_read(bytes, true), all = points_read(bytes, false);
  if (all) EXPECT_EQ(some, all);
  return all.has_value();
}

TEST(LazMalformedTest, a_prefix_is_an_error_or_a_clean_read) {
  for (const std::vector<std::byte>& sample : samples()) {
    for (std::size_t length = 0; length < sample.size(); length += length < 227 ? 50 : 11) {
      // A copy of exactly this length, so that the address sanitizer sees every byte read beyond it.
      const bool is_read =
          reads(std::vector<std::byte>(sample.begin(), sample.begin() + static_cast<std::ptrdiff_t>(length)));
      // Records behind the points may be gone.
      EXPECT_FALSE(is_read && length < sample.size() / 2) << length;
    }
    EXPECT_TRUE(reads(sample));
    EXPECT_EQ(points_read(sample, false), k_points);
  }
}

TEST(LazMalformedTest, a_flipped_bit_is_an_error_or_a_clean_read) {
  for (const std::vector<std::byte>& sample : samples()) {
    std::vector<std::byte> bytes = sample;
    int read = 0, rejected = 0;
    for (std::size_t offset = 94; offset < bytes.size(); offset += offset < 375 ? 3 : 19) {
      SCOPED_TRACE(offset);
      const std::byte flipped = static_cast<std::byte>(1u << (offset * 5 % 8));
      bytes[offset] ^= flipped;
      ++(reads(bytes) ? read : rejected);
      bytes[offset] ^= flipped;
    }
    EXPECT_GT(read, 10);
    EXPECT_GT(rejected, 10);
  }
}

TEST(LazMalformedTest, errors_name_file_chunk_and_point) {
  std::vector<std::byte> bytes = build_laz(sample_las(2, 3, 40), {.chunk_sizes = {10}});
  const std::vector<LazChunk> chunks = [&] {
    InputFile file(bytes, "memory");
    std::vector<std::string> warnings;
    const LasHeader header = read_las_header(file, warnings);
    std::string missing;
    return *read_chunk_table(file, header, standard_laz_layout(3, 34 + 13, 10), missing);
  }();
  ASSERT_EQ(chunks.size(), 4u);
  // All ones never occur in a stream.
  std::memset(bytes.data() + chunks[2].offset + 47, 0xff, 60);
  const std::string error = test::error_of([&] { test::read_memory(bytes); });
  EXPECT_NE(error.find("memory:chunk 2, point 2"), std::string::npos) << error;
  EXPECT_NE(error.find("corrupt compressed points"), std::string::npos);
  EXPECT_NE(error.find("--partial reads the intact part"), std::string::npos);
}

TEST(LazMalformedTest, chunks_that_are_whole_are_kept_if_damage_is_read_over) {
  for (const int format : {3, 7}) {
    const test::LasFile file = sample_las(4, format, 40);
    std::vector<std::byte> bytes = build_laz(file, {.chunk_sizes = {10}});
    const ReadLaz whole = read_laz(bytes);
    InputFile input(bytes, "memory");
    std::string missing;
    const LazLayout layout = standard_laz_layout(format, whole.header.point_size, 10);
    const std::vector<LazChunk> chunks = *read_chunk_table(input, whole.header, layout, missing);
    // The count of a layered chunk, or the start of a stream.
    std::memset(bytes.data() + chunks[1].offset + whole.header.point_size, 0xff, 4);
    const ReadLaz rest = read_laz(bytes, Damage::read_over);
    const std::size_t chunk_bytes = 10u * whole.header.point_size;
    std::vector<std::byte> expected(whole.records.begin(),
                                    whole.records.begin() + static_cast<std::ptrdiff_t>(chunk_bytes));
    expected.insert(expected.end(), whole.records.begin() + static_cast<std::ptrdiff_t>(2 * chunk_bytes),
                    whole.records.end());
    EXPECT_EQ(rest.records, expected);
    ASSERT_EQ(rest.lost.size(), 1u);
    EXPECT_EQ(rest.lost[0].count, 10u);
    EXPECT_NE(rest.lost[0].location.find("chunk 1"), std::string::npos);
    const PointCloud cloud = test::read_memory(bytes, {.partial = true});
    EXPECT_EQ(cloud.size(), 30u);
    EXPECT_EQ(cloud.files.at(0).point_count, 30u);
    EXPECT_EQ(cloud.files.at(0).lost_count, 10u);
  }
}

TEST(LazMalformedTest, files_cut_within_a_chunk_keep_those_before) {
  for (const int format : {3, 7}) {
    const std::vector<std::byte> whole = build_laz(sample_las(4, format, 40), {.chunk_sizes = {10}});
    std::vector<std::byte> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(
                                                                  (points_offset(whole) + whole.size()) / 2));
    const ReadLaz rest = read_laz(cut, Damage::read_over);
    const std::size_t rows = rest.records.size() / rest.header.point_size;
    EXPECT_GE(rows, 10u);
    std::uint64_t lost = 0;
    for (const LostPoints& points : rest.lost) lost += points.count;
    EXPECT_EQ(rows + lost, 40u);
  }
}

TEST(LazMalformedTest, counts_no_file_of_that_size_can_hold_are_errors) {
  std::vector<std::byte> bytes = build_laz(sample_las(4, 7));
  const std::uint64_t count = 4'000'000'000;
  std::memcpy(bytes.data() + 247, &count, sizeof count);
  EXPECT_NE(test::error_of([&] { test::read_memory(bytes); }).find("the number of points exceeds the file"),
            std::string::npos);
}

TEST(LazMalformedTest, points_that_a_chunk_only_claims_take_no_memory) {
  // One chunk that claims as many points as its bytes might hold at the very most.
  for (const int format : {1, 6}) {
    std::vector<std::byte> bytes = build_laz(sample_las(4, format, 2000), {.chunk_sizes = {0x7fffffff}});
    const std::uint64_t count = most_laz_points(bytes.size() / 2);
    std::memcpy(bytes.data() + 247, &count, sizeof count);
    std::memset(bytes.data() + 107, 0, 4);
    InputFile file(bytes, "memory");
    class Meter final : public LazSink {
     public:
      void make_room(std::uint64_t points) override { rows += points; }
      void take(const std::byte*, std::size_t, std::uint64_t) override {}
      std::uint64_t rows = 0;
    } meter;
    std::vector<std::string> warnings;
    const LasHeader header = read_las_header(file, warnings);
    ASSERT_GT(header.point_count, 50'000'000u);
    const LazLayout layout = standard_laz_layout(format, header.point_size, 0x7fffffff);
    LazPoints points(file, header, layout, Damage::reject);
    EXPECT_THROW(points.read({}, meter, {}), DamagedFile);
    EXPECT_LE(meter.rows, 2000u + 4096u);
  }
}

}  // namespace
}  // namespace alidade
