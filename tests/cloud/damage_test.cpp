// SPDX-License-Identifier: MIT
// What is left of damaged files: ReadOptions::partial.
#include "cloud/damage.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/las/las_builder.h"

namespace alidade {
namespace {

using test::build_las;
using test::error_of;
using test::LasFile;
using test::warns;

const ReadOptions k_partial{.partial = true};

/// A LAS file of `count` points on the x axis, the first at `first`, less its last `bytes_less` bytes.
std::vector<std::byte> cut_las(int count, std::size_t bytes_less, int first = 0) {
  LasFile file;
  for (int i = 0; i < count; ++i) file.points.emplace_back().x = first + i;
  std::vector<std::byte> bytes = build_las(file);
  bytes.resize(bytes.size() - bytes_less);
  return bytes;
}

TEST(DamageTest, the_message_of_damage_ends_with_the_option_that_reads_over_it) {
  const auto ends = [](const Error& error) {
    return std::string(error.what()).ends_with("; --partial reads the intact part");
  };
  EXPECT_TRUE(ends(DamagedFile({.file = "f", .problem = "p", .expected = "e", .found = "g"})));
  EXPECT_TRUE(ends(DamagedFile({.file = "f", .problem = "p", .expected = "e"})));
  EXPECT_TRUE(ends(DamagedFile({.file = "f", .problem = "p"})));
  EXPECT_TRUE(
      error_of([] { test::read_memory(cut_las(3, 1)); }).ends_with("--partial reads the intact part"));
}

TEST(DamageTest, whole_points_of_a_file_that_ends_early_are_read_and_the_others_counted) {
  const PointCloud cloud = test::read_memory(cut_las(5, 27), k_partial);
  ASSERT_EQ(cloud.size(), 3u);
  EXPECT_EQ(cloud.positions[2].x, 2);
  EXPECT_EQ(cloud.files.at(0).point_count, 3u);
  EXPECT_EQ(cloud.files.at(0).lost_count, 2u);
  EXPECT_EQ(cloud.warnings,
            (std::vector<std::string>{fmt::format(
                "memory:byte {}: truncated file: it ends before its last point; 2 points are lost",
                cut_las(5, 27).size())}));
}

TEST(DamageTest, intact_files_give_no_warning) {
  const PointCloud cloud = test::read_memory(cut_las(5, 0), k_partial);
  EXPECT_EQ(cloud.size(), 5u);
  EXPECT_EQ(cloud.files.at(0).lost_count, 0u);
  EXPECT_TRUE(cloud.warnings.empty());
}

TEST(DamageTest, losses_are_reported_file_by_file) {
  std::vector<std::vector<std::byte>> bytes = {cut_las(2, 1), cut_las(2, 0, 2), cut_las(2, 1, 4)};
  CloudInputs files;
  for (std::size_t i = 0; i < bytes.size(); ++i)
    files.inputs.push_back(cloud_in_memory(bytes[i], "tile_" + std::to_string(i)));
  const PointCloud cloud = read_cloud(files, k_partial);
  ASSERT_EQ(cloud.size(), 4u);
  EXPECT_EQ(cloud.positions[3].x, 4);
  EXPECT_TRUE(warns(cloud, "tile_0:byte"));
  EXPECT_FALSE(warns(cloud, "tile_1"));
  EXPECT_TRUE(warns(cloud, "tile_2:byte"));
  EXPECT_TRUE(warns(cloud, "1 point is lost"));
}

TEST(DamageTest, extended_records_behind_lost_points_are_lost_too) {
  LasFile file = test::sample_las(4, 6, 3);
  file.extended_records = {{"u", 7, "", {1, 2, 3}}};
  std::vector<std::byte> bytes = build_las(file);
  const std::size_t record_size = 60 + 3;
  bytes.resize(bytes.size() - 1);
  const PointCloud all = test::read_memory(bytes, k_partial);
  EXPECT_EQ(all.size(), 3u);
  EXPECT_TRUE(warns(all, "skipped"));
  bytes.resize(bytes.size() - record_size);
  const PointCloud two = test::read_memory(bytes, k_partial);
  EXPECT_EQ(two.size(), 2u);
  EXPECT_TRUE(warns(two, "the extended records after the points are lost"));
}

TEST(DamageTest, extended_records_at_an_impossible_offset_are_left_out) {
  LasFile file = test::sample_las(4, 6, 3);
  file.extended_records = {{"u", 7, "", {1, 2, 3}}};
  for (const std::uint64_t offset : {std::uint64_t{0}, std::uint64_t{380}, UINT64_MAX}) {
    std::vector<std::byte> bytes = build_las(file);
    std::memcpy(bytes.data() + 235, &offset, sizeof offset);
    EXPECT_NE(error_of([&] { test::read_memory(bytes); }).find("--partial reads the intact part"),
              std::string::npos);
    const PointCloud cloud = test::read_memory(bytes, k_partial);
    EXPECT_EQ(cloud.size(), 3u);
    EXPECT_EQ(cloud.files.at(0).lost_count, 0u);
    EXPECT_TRUE(warns(cloud, "skipped")) << offset;
  }
}

TEST(DamageTest, a_las_file_that_was_transferred_as_text_is_an_error) {
  LasFile file = test::sample_las(2, 1, 500);
  for (test::LasPoint& point : file.points) point.intensity = 10;
  const std::vector<std::byte> bytes = build_las(file);
  std::uint32_t points = 0;
  std::memcpy(&points, bytes.data() + 96, sizeof points);
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    if (i >= points && bytes[i] == std::byte{'\n'}) text += '\r';
    text += static_cast<char>(bytes[i]);
  }
  for (const bool partial : {false, true}) {
    const std::string message = error_of(
        [&] { test::read_memory(std::as_bytes(std::span(text)), {.partial = partial, .region = {}}); });
    EXPECT_NE(message.find("the binary data were changed by a transfer as text"), std::string::npos)
        << message;
  }
}

TEST(DamageTest, a_header_that_makes_no_sense_stays_an_error) {
  std::vector<std::byte> bytes = cut_las(2, 0);
  bytes.resize(100);
  EXPECT_NE(error_of([&] { test::read_memory(bytes, k_partial); }).find("truncated header"),
            std::string::npos);
}

TEST(DamageTest, a_real_file_that_was_cut_off_gives_its_whole_points) {
  const std::filesystem::path path = test::shared_data("malformed/1.2-with-color-clipped.las");
  if (path.empty()) GTEST_SKIP() << test::k_no_shared_data;
  const PointCloud cloud = read_cloud(path, k_partial);
  EXPECT_EQ(cloud.size(), 1064u);
  EXPECT_EQ(cloud.files.at(0).lost_count, 1u);
  EXPECT_TRUE(warns(cloud, "1 point is lost"));
}

PointCloud partial_text(const std::string& content) {
  return test::read_memory(std::as_bytes(std::span(content)), k_partial);
}

TEST(DamageTest, tables_are_read_up_to_the_first_row_that_makes_no_sense) {
  const PointCloud csv = partial_text("x,y,z\n1,2,3\n4,5,6\n7,8\n9,9,9\n");
  EXPECT_EQ(csv.size(), 2u);
  EXPECT_EQ(
      csv.warnings,
      (std::vector<std::string>{"memory:line 4: too few columns; an unknown number of points is lost"}));
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const PointCloud ply =
      partial_text("ply\nformat ascii 1.0\nelement vertex 4\n" + xyz + "end_header\n1 2 3\n4 5 6\n7 8 9\n");
  EXPECT_EQ(ply.size(), 3u);
  EXPECT_TRUE(warns(ply, "1 point is lost"));
  EXPECT_EQ(ply.files.at(0).lost_count, 1u);
  EXPECT_EQ(partial_text("3\n1 2 3\n4 5 6\n").size(), 2u) << "PTS";
  const std::string scan = "2\n2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
  EXPECT_EQ(partial_text(scan + "1 2 3 0.5\n4 5 6 0.5\n").size(), 2u) << "PTX";
}

TEST(DamageTest, binary_tables_that_end_early_give_their_whole_rows) {
  const std::string floats(3 * 12 + 5, '\1');
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const PointCloud ply = partial_text("ply\nformat binary_little_endian 1.0\nelement vertex 10\n" + xyz +
                                      "end_header\n" + floats);
  EXPECT_EQ(ply.size(), 3u);
  EXPECT_TRUE(warns(ply, "7 points are lost"));
  const PointCloud pcd = partial_text(
      "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 10\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 10\nDATA binary\n" +
      floats);
  EXPECT_EQ(pcd.size(), 3u);
  EXPECT_TRUE(warns(pcd, "7 points are lost"));
}

TEST(DamageTest, vertices_without_properties_stay_an_error_however_many_there_are) {
  EXPECT_FALSE(error_of([] {
                 partial_text("ply\nformat ascii 1.0\nelement vertex 1000000000000000000\nend_header\n");
               }).empty());
}

TEST(DamageTest, every_beginning_of_a_file_is_an_error_or_a_cloud_with_fewer_points) {
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::string floats(5 * 12, '\1');
  const auto of_text = [](const std::string& content) {
    const auto bytes = std::as_bytes(std::span(content));
    return std::vector<std::byte>(bytes.begin(), bytes.end());
  };
  LasFile las = test::sample_las(4, 7, 5);
  las.extended_records = {{"u", 7, "", {1, 2, 3}}};
  for (const std::vector<std::byte>& whole :
       {build_las(las),
        of_text("ply\nformat binary_little_endian 1.0\nelement vertex 5\n" + xyz + "end_header\n" + floats),
        of_text("VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 5\nHEIGHT 1\n"
                "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 5\nDATA binary\n" +
                floats),
        of_text("5\n1 2 3\n4 5 6\n7 8 9\n1 2 3\n4 5 6\n")}) {
    std::size_t last = 0;
    for (std::size_t length = 0; length <= whole.size(); ++length) {
      // A copy of exactly this length, so that the address sanitizer sees every byte read beyond it.
      const std::vector<std::byte> prefix(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
      try {
        const std::size_t size = test::read_memory(prefix, k_partial).size();
        EXPECT_GE(size, last) << length;
        last = size;
      } catch (const Error&) {
      }
    }
    EXPECT_EQ(last, 5u);
  }
}

TEST(DamageTest, a_point_that_fits_on_no_lattice_is_no_damage) {
  std::vector<std::byte> las = cut_las(1, 0);
  const std::string far = "x,y,z\n1e9,2,3\n";
  CloudInputs files;
  files.inputs.push_back(cloud_in_memory(las, "las"));
  files.inputs.push_back(cloud_in_memory(std::as_bytes(std::span(far)), "far"));
  EXPECT_NE(error_of([&] { read_cloud(files, k_partial); }).find("too far away for the lattice of"),
            std::string::npos);
}

}  // namespace
}  // namespace alidade
