// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "base/bytes.h"
#include "cloud/las/write_las.h"
#include "tests/cloud/chosen_points.h"

namespace alidade {
namespace {

using test::expect_same_columns;
using test::full_cloud;
using test::read_bytes;

/// A cloud whose attributes LAS can hold without change: flags of 8 bits, returns up to 15, no more.
PointCloud las_cloud(std::size_t count, std::uint64_t seed) {
  PointCloud cloud = full_cloud(count, 5000, seed);
  for (ReturnNumbers& returns : cloud.returns) {
    returns.number &= 15;
    returns.count &= 15;
  }
  cloud.scan_angles.assign(count, 1.5f);
  cloud.crs.wkt = "PROJCS[\"y\"]";
  cloud.records.push_back(
      {.user_id = "a survey", .record_id = 3, .description = {}, .data = {1, 2}, .extended = false});
  cloud.records.push_back(
      {.user_id = "a survey", .record_id = 4, .description = {}, .data = {3}, .extended = true});
  return cloud;
}

void expect_same_cloud(const PointCloud& a, const PointCloud& b) {
  expect_same_columns(a, b);
  EXPECT_EQ(a.crs, b.crs);
  EXPECT_EQ(a.records, b.records);
}

TEST(LazWriteTest, what_is_read_from_laz_is_what_is_read_from_las) {
  const std::filesystem::path folder = test::test_folder();
  // None, one, a chunk, one more, and several with a rest.
  for (const std::size_t count : {0u, 1u, 50000u, 50001u, 123456u}) {
    for (const int kind : {6, 7, 8}) {
      PointCloud cloud = las_cloud(count, count + static_cast<std::size_t>(kind));
      if (kind < 8) cloud.near_infrared.clear();
      if (kind < 7) cloud.colors.clear();
      write_las(folder / "out.las", cloud, {.overwrite = true});
      write_las(folder / "out.laz", cloud, {.overwrite = true});
      const PointCloud packed = read_cloud(folder / "out.laz");
      EXPECT_EQ(packed.size(), count);
      EXPECT_EQ(packed.files[0].point_format, count == 0 ? 6 : kind);
      expect_same_cloud(packed, read_cloud(folder / "out.las"));
      EXPECT_TRUE(packed.warnings.empty());
    }
  }
}

TEST(LazWriteTest, the_extension_of_the_name_decides_in_lower_and_upper_case) {
  EXPECT_TRUE(is_laz_name("a.laz"));
  EXPECT_TRUE(is_laz_name("a/b.c.LaZ"));
  EXPECT_FALSE(is_laz_name("a.las"));
  EXPECT_FALSE(is_laz_name("laz"));
  EXPECT_FALSE(is_laz_name("a.laz/b"));
  const std::filesystem::path folder = test::test_folder();
  for (const auto& [name, format] : {std::pair("OUT.LAZ", 0x86), std::pair("out.las", 0x06)}) {
    PointCloud cloud;
    cloud.positions = {{1, 2, 3}};
    write_las(folder / name, cloud);
    EXPECT_EQ(load<std::uint8_t>(read_bytes(folder / name).data() + 104), format);
  }
}

TEST(LazWriteTest, points_are_packed_in_chunks_of_50000) {
  const std::filesystem::path path = test::test_folder() / "out.laz";
  PointCloud cloud;
  cloud.positions.resize(120000);
  write_las(path, cloud);
  const std::vector<std::byte> bytes = read_bytes(path);
  const auto points_offset = load<std::uint32_t>(bytes.data() + 96);
  const auto table_offset = load<std::int64_t>(bytes.data() + points_offset);
  ASSERT_LT(static_cast<std::size_t>(table_offset) + 8, bytes.size());
  EXPECT_EQ(load<std::uint32_t>(bytes.data() + table_offset), 0u);
  EXPECT_EQ(load<std::uint32_t>(bytes.data() + table_offset + 4), 3u);
  // A layered chunk has its number of points after its first record.
  EXPECT_EQ(load<std::uint32_t>(bytes.data() + points_offset + 8 + 30), 50000u);
  EXPECT_EQ(load<std::uint64_t>(bytes.data() + 247), 120000u);
}

TEST(LazWriteTest, the_bytes_depend_neither_on_threads_nor_on_batches) {
  const std::filesystem::path folder = test::test_folder();
  const PointCloud cloud = las_cloud(160000, 5);
  write_las(folder / "many.laz", cloud);
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    write_las(folder / "one.laz", cloud);
  }
  PointCloud like = cloud;
  like.resize(0);
  LasWriter writer(folder / "parts.laz", like, cloud.attributes());
  for (std::size_t first = 0; first < cloud.size(); first += 33333) {
    std::vector<std::size_t> rows;
    for (std::size_t row = first; row < std::min(first + 33333, cloud.size()); ++row) rows.push_back(row);
    writer.write(test::rows_of(cloud, rows));
  }
  writer.finish();
  const std::vector<std::byte> many = read_bytes(folder / "many.laz");
  EXPECT_EQ(many, read_bytes(folder / "one.laz"));
  EXPECT_EQ(many, read_bytes(folder / "parts.laz"));
}

TEST(LazWriteTest, without_finish_no_file_is_left) {
  const std::filesystem::path folder = test::test_folder();
  {
    const PointCloud cloud = las_cloud(60000, 6);
    LasWriter writer(folder / "out.laz", cloud, {});
    writer.write(cloud);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

TEST(LazWriteTest, writing_stops_when_requested_and_leaves_no_file) {
  const std::filesystem::path folder = test::test_folder();
  LasWriteOptions options;
  options.progress = [](std::uint64_t done, std::uint64_t) { return done < 30000; };
  EXPECT_THROW(write_las(folder / "out.laz", las_cloud(60000, 7), options), Cancelled);
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

}  // namespace
}  // namespace alidade
