// SPDX-License-Identifier: MIT
// Telling formats apart, and joining files to one cloud.
#include "cloud/read_cloud.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <string>
#include <vector>

#include "cloud/input_view.h"
#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/las/las_builder.h"

namespace alidade {
namespace {

using test::build_las;
using test::error_of;
using test::LasFile;
using test::warns;

/// A LAS file with one point per step given on the x axis.
LasFile las(std::vector<std::int32_t> steps, double offset = 0, double scale = 0.01) {
  LasFile file;
  file.point_format = 0;
  file.offset = {offset, 0, 0};
  file.scale = {scale, scale, scale};
  for (const std::int32_t x : steps) file.points.emplace_back().x = x;
  return file;
}

/// With a header whose box is close to the points: a lattice has to hold all of it.
std::vector<std::byte> tile(const std::vector<std::int32_t>& steps, double offset = 0, double scale = 0.01) {
  constexpr std::size_t k_box = 179;
  std::vector<std::byte> bytes = build_las(las(steps, offset, scale));
  const std::array<double, 6> box = {100, -100, 100, -100, 100, -100};
  std::memcpy(bytes.data() + k_box, box.data(), sizeof box);
  return bytes;
}

/// Files in memory, read as one cloud; called first, second, ...
PointCloud join(const std::vector<std::vector<std::byte>>& files, const ReadOptions& options = {}) {
  static const char* const k_names[] = {"first", "second", "third"};
  CloudInputs inputs;
  for (std::size_t i = 0; i < files.size(); ++i)
    inputs.inputs.push_back(cloud_in_memory(files[i], k_names[i]));
  return read_cloud(inputs, options);
}

std::vector<std::byte> text(const std::string& content) {
  const auto bytes = std::as_bytes(std::span(content));
  return {bytes.begin(), bytes.end()};
}

std::string format_of(const std::string& content) {
  return test::read_memory(text(content)).files.at(0).format;
}

TEST(OpenCloudTest, formats_are_detected_by_content) {
  EXPECT_EQ(test::read_memory(build_las(las({1}))).files.at(0).format, "LAS");
  EXPECT_EQ(
      format_of(
          "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
          "end_header\n1 2 3\n"),
      "PLY");
  const std::string pcd =
      "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1\nDATA ascii\n1 2 3\n";
  EXPECT_EQ(format_of(pcd), "PCD");
  EXPECT_EQ(format_of("# .PCD v.7 - Point Cloud Data\n" + pcd), "PCD");
  EXPECT_EQ(format_of("1\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 2 3 0.5\n"),
            "PTX");
  EXPECT_EQ(format_of("2\n1 2 3\n4 5 6\n"), "PTS");
  EXPECT_EQ(format_of("x,y,z\n1,2,3\n"), "CSV");
  EXPECT_EQ(format_of("1 2 3\n4 5 6\n"), "XYZ");
}

TEST(OpenCloudTest, a_byte_order_mark_hides_no_format) {
  const std::string mark = "\xEF\xBB\xBF";
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  EXPECT_EQ(format_of(mark + "ply\nformat ascii 1.0\nelement vertex 1\n" + xyz + "end_header\n1 2 3\n"),
            "PLY");
  EXPECT_EQ(format_of(mark + "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nDATA ascii\n1 2 3\n"), "PCD");
  const PointCloud scan = test::read_memory(
      text(mark + "1\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n10 0 0 1\n1.5 2 3 0.5\n"));
  EXPECT_EQ(scan.files.at(0).format, "PTX");
  ASSERT_EQ(scan.size(), 1u);
  EXPECT_NEAR(scan.world(0).x, 11.5, 1e-9);
  const PointCloud table = test::read_memory(text(mark + "x,y,z\n1.5,2,3\n"));
  EXPECT_EQ(table.files.at(0).format, "CSV");
  ASSERT_EQ(table.size(), 1u);
  EXPECT_NEAR(table.world(0).x, 1.5, 1e-9);
  EXPECT_EQ(format_of(mark + "1 2 3\n4 5 6\n"), "XYZ");
}

TEST(OpenCloudTest, an_empty_file_is_an_error) {
  EXPECT_NE(error_of([] { test::read_memory({}); }).find("memory: empty file"), std::string::npos);
}

TEST(OpenCloudTest, binary_of_no_known_format_is_an_error_that_lists_the_formats) {
  const std::string message = error_of([] {
    test::read_memory(
        text(std::string("\x7f"
                         "ELF\2\1\1\0\0\0\0",
                         11)));
  });
  EXPECT_NE(message.find("LAS, LAZ, PLY, PCD, E57, PTX, PTS, CSV, XYZ or an index file"), std::string::npos)
      << message;
}

TEST(OpenCloudTest, e57_is_detected_by_its_signature) {
  EXPECT_NE(error_of([] { test::read_memory(text("ASTM-E57 and so on")); }).find("header: truncated file"),
            std::string::npos);
}

TEST(OpenCloudTest, a_missing_file_is_an_error) {
  EXPECT_NE(error_of([] { read_cloud("/no/such/file.las"); }).find("/no/such/file.las: cannot open the file"),
            std::string::npos);
}

TEST(ReadCloudTest, no_files_make_an_empty_cloud) {
  EXPECT_EQ(read_cloud(std::span<const std::filesystem::path>()).size(), 0u);
}

TEST(ReadCloudTest, points_of_several_files_follow_in_the_order_given) {
  const PointCloud cloud = join({build_las(las({1, 2})), build_las(las({3})), build_las(las({4, 5}))});
  ASSERT_EQ(cloud.size(), 5u);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(cloud.positions[static_cast<std::size_t>(i)].x, i + 1);
  ASSERT_EQ(cloud.files.size(), 3u);
  EXPECT_EQ(cloud.files[2].path, "third");
  EXPECT_EQ(cloud.files[2].point_count, 2u);
  EXPECT_EQ(cloud.positions.capacity(), 5u) << "room is reserved once";
  EXPECT_EQ(cloud.intensities.capacity(), 5u);
}

TEST(ReadCloudTest, offsets_that_differ_by_whole_steps_share_the_first_lattice) {
  const PointCloud cloud = join({build_las(las({1}, 690000)), build_las(las({1}, 690012.34))});
  EXPECT_EQ(cloud.lattice.offset.x, 690000);
  EXPECT_EQ(cloud.positions[1].x, 1235);
}

TEST(ReadCloudTest, files_of_other_scales_and_offsets_are_joined_on_the_finest_lattice_without_loss) {
  for (const bool is_finer_first : {false, true}) {
    std::vector<std::vector<std::byte>> tiles = {tile({1, 7}), tile({1234, 5}, 10, 0.001)};
    if (is_finer_first) std::swap(tiles[0], tiles[1]);
    const PointCloud cloud = join(tiles);
    EXPECT_EQ(cloud.lattice.scale.x, 0.001);
    EXPECT_TRUE(cloud.warnings.empty());
    ASSERT_EQ(cloud.size(), 4u);
    const std::size_t coarse = is_finer_first ? 2 : 0, fine = 2 - coarse;
    EXPECT_NEAR(cloud.world(coarse).x - cloud.world(fine).x, 0.01 - 11.234, 1e-9);
    EXPECT_EQ(cloud.positions[coarse + 1].x - cloud.positions[coarse].x, 60);
    EXPECT_EQ(cloud.positions[fine].x - cloud.positions[fine + 1].x, 1229);
    for (const CloudFile& file : cloud.files) EXPECT_FALSE(file.is_rounded);
  }
  const PointCloud halves = join({build_las(las({1})), build_las(las({1}, 0.005))});
  EXPECT_EQ(halves.lattice.scale.x, 0.005);
  EXPECT_EQ(halves.positions[0].x, 2);
  EXPECT_EQ(halves.positions[1].x, 3);
}

TEST(ReadCloudTest, where_no_lattice_holds_all_files_the_rounding_is_stated) {
  const PointCloud cloud = join({tile({100}), tile({1000}, 0, 0.0013), tile({7})});
  EXPECT_EQ(cloud.lattice.scale.x, 0.0013);
  EXPECT_EQ(cloud.positions[1].x, 1000);
  EXPECT_NEAR(cloud.world(0).x, 1.0, 0.00065);
  ASSERT_EQ(cloud.warnings.size(), 1u);
  EXPECT_TRUE(
      cloud.warnings[0].starts_with("first and 1 more file: coordinates are rounded to steps of 0.0013"))
      << cloud.warnings[0];
  EXPECT_TRUE(cloud.files[0].is_rounded);
  EXPECT_FALSE(cloud.files[1].is_rounded);
}

TEST(ReadCloudTest, files_too_far_apart_for_32_bits_are_an_error) {
  const std::string message = error_of([] {
    join({build_las(las({2147483647})), build_las(las({2147483647}, 1))});
  });
  EXPECT_NE(message.find("second: too far"), std::string::npos) << message;
}

TEST(ReadCloudTest, the_lattice_of_a_file_without_points_binds_nobody) {
  const PointCloud cloud = join({build_las(las({}, 0, 0.3)), build_las(las({7}))});
  EXPECT_EQ(cloud.lattice.scale.x, 0.01);
  EXPECT_EQ(cloud.positions[0].x, 7);
  EXPECT_EQ(join({build_las(las({}, 5, 0.3))}).lattice.scale.x, 0.3);
}

TEST(ReadCloudTest, attributes_of_some_files_only_are_zeros_in_the_others_with_a_warning) {
  LasFile colored = las({1});
  colored.point_format = 2;
  colored.points[0].color = {300, 200, 100};
  const PointCloud cloud = join({build_las(las({1, 2})), build_las(colored), build_las(las({3}))});
  EXPECT_EQ(cloud.colors, (std::vector<Color16>{{0, 0, 0}, {0, 0, 0}, {300, 200, 100}, {0, 0, 0}}));
  EXPECT_TRUE(warns(cloud, "first and 1 more file: no color; using 0"));
  EXPECT_EQ(cloud.warnings.size(), 1u);
}

TEST(ReadCloudTest, extra_dimensions_are_joined_by_meaning) {
  LasFile one = test::sample_las(4, 6, 2), two = test::sample_las(4, 6, 3, 9);
  two.records = {
      test::las_extra_bytes_record({test::las_extra_bytes_entry(3, 1 | 8 | 16, "Range", 0.01, 100.0),
                                    test::las_extra_bytes_entry(0, 11, "Other")})};
  const PointCloud cloud = join({build_las(one), build_las(two)});
  ASSERT_EQ(cloud.extra_dimensions.size(), 5u);
  const ExtraDimension& range = cloud.extra_dimensions[1];
  ASSERT_EQ(range.values.size(), 10u);
  EXPECT_EQ(range.values[0], one.points[0].extra[4]);
  EXPECT_EQ(range.values[4], two.points[0].extra[0]);
  EXPECT_EQ(cloud.extra_dimensions[4].values.size(), 5u * 11);
  EXPECT_EQ(cloud.extra_dimensions[0].values[8], 0) << "the second file has no Deviation";
}

TEST(ReadCloudTest, records_that_tiles_repeat_are_kept_once) {
  LasFile one = las({1});
  one.records = {{"u", 1, "", {1}}, {"u", 1, "", {1}}, {"u", 2, "", {1}}};
  LasFile two = las({2});
  two.records = {{"u", 1, "", {1}}, {"u", 3, "", {1}}};
  EXPECT_EQ(join({build_las(one), build_las(two)}).records.size(), 4u);
}

TEST(ReadCloudTest, records_are_compared_with_those_of_all_files_before) {
  LasFile one = las({1}), two = las({2}), three = las({3});
  one.records = {{"u", 1, "", {1}}};
  two.records = {{"u", 1, "", {1, 0}}, {"u", 1, "d", {1}}, {"v", 1, "", {1}}, {"u", 2, "", {1}}};
  three.records = {{"v", 1, "", {1}}, {"w", 1, "", {1}}, {"u", 1, "", {1, 0}}, {"u", 1, "", {1}}};
  const PointCloud cloud = join({build_las(one), build_las(two), build_las(three)});
  ASSERT_EQ(cloud.records.size(), 6u);
  EXPECT_EQ(cloud.records[1].data.size(), 2u);
  EXPECT_EQ(cloud.records[5].user_id, "w");
}

TEST(ReadCloudTest, rounding_is_reported_only_where_it_costs_more_than_a_millionth_of_the_file) {
  const auto rounded = [](const std::string& content) {
    const PointCloud cloud = join({build_las(las({700})), text(content)});
    return warns(cloud, "second: coordinates are rounded");
  };
  EXPECT_TRUE(rounded("690000.123 2 3\n690100.456 5 6\n"));
  EXPECT_TRUE(rounded("0.125 2 3\n4999 5 6\n"));
  EXPECT_FALSE(rounded("0.125 2 3\n5001 5 6\n"));
  EXPECT_FALSE(rounded("0.12 2 3\n4.5 5 6\n"));
  const PointCloud fine = test::read_memory(text("0.1234567890123 2 3\n45.1234567890123 5 6\n"));
  EXPECT_EQ(fine.lattice.scale.x, 1e-7);
  EXPECT_TRUE(fine.warnings.empty()) << "32 bits are always fine enough for one file";
}

TEST(ReadCloudTest, thousands_of_files_need_few_handles) {
  const std::filesystem::path path = test::test_folder() / "tile.las";
  test::write_bytes(path, build_las(las({1})));
  rlimit before{};
  getrlimit(RLIMIT_NOFILE, &before);
  const rlimit few{64, before.rlim_max};
  setrlimit(RLIMIT_NOFILE, &few);
  const PointCloud cloud = read_cloud(std::vector<std::filesystem::path>(500, path));
  setrlimit(RLIMIT_NOFILE, &before);
  EXPECT_EQ(cloud.size(), 500u);
}

TEST(ReadCloudTest, free_coordinates_share_a_lattice_over_all_files) {
  const PointCloud cloud = join({text("690000.5 5325000.25 480\n"), text("690100 5325100 530.125\n")});
  EXPECT_EQ(cloud.lattice.scale, glm::dvec3(0.001));
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.world(0), glm::dvec3(690000.5, 5325000.25, 480));
  EXPECT_EQ(cloud.world(1), glm::dvec3(690100, 5325100, 530.125));
}

TEST(ReadCloudTest, coordinates_that_no_lattice_holds_are_an_error_that_names_their_file) {
  const std::vector<std::byte> near = text("1 2 3\n4 5 6\n"), far = text("1 2 3\n4 -1e301 6\n"),
                               odd = text("1 2 nan\n");
  const std::string problem = ": coordinates too large; expected at most 1e300, found ";
  EXPECT_TRUE(error_of([&] { join({far}); }).starts_with("first" + problem));
  EXPECT_TRUE(error_of([&] { join({text("1e301 0 0\n")}); }).ends_with("found 1e+301"));
  EXPECT_TRUE(error_of([&] { join({near, far, odd}); }).starts_with("second" + problem));
  // A view reads the file by itself.
  CloudInputs chosen{{cloud_in_memory(far, "far")}};
  const auto view = std::make_shared<InputView>();
  view->change_reference = [](const std::filesystem::path&, const FileFacts&) {
    return ReferenceChange{.crs = {}, .move = [](std::span<glm::dvec3>) {}};
  };
  chosen.inputs[0].view = view;
  EXPECT_TRUE(error_of([&] { read_cloud(chosen); }).starts_with("far" + problem));
}

TEST(ReadCloudTest, free_coordinates_beside_las_go_to_the_lattice_of_the_las_file) {
  const PointCloud cloud = join({text("1.25 2 3\n4.126 5 6\n"), build_las(las({700}))});
  EXPECT_EQ(cloud.lattice.scale, glm::dvec3(0.01));
  EXPECT_EQ(cloud.positions, (std::vector<LatticePosition>{{125, 200, 300}, {413, 500, 600}, {700, 0, 0}}));
  EXPECT_TRUE(warns(cloud, "first: coordinates are rounded to steps of 0.01"));
  const std::string message = error_of([] { join({build_las(las({700})), text("1e9 2 3\n")}); });
  EXPECT_NE(message.find("second: too far away for the lattice of first"), std::string::npos) << message;
}

TEST(ReadCloudTest, progress_runs_from_file_to_file_up_to_the_total) {
  const std::vector<std::vector<std::byte>> files = {build_las(las({1})), text("1 2 3\n4 5 6\n")};
  std::uint64_t last = 0, whole = 0;
  ReadOptions options;
  options.progress = [&](std::uint64_t done, std::uint64_t total) {
    EXPECT_GE(done, last);
    last = done;
    whole = total;
    return true;
  };
  join(files, options);
  // The text is read twice, which is no concern of who waits.
  EXPECT_EQ(whole, files[0].size() + files[1].size());
  EXPECT_EQ(last, whole);
}

/// The colours of a LAS file with these, read with a depth.
std::vector<Color16> colors_of(const std::vector<std::array<std::uint16_t, 3>>& colors, ColorDepth depth,
                               std::vector<std::string>* warnings = nullptr) {
  LasFile file;
  for (const auto& color : colors) file.points.emplace_back().color = color;
  ReadOptions options;
  options.color_depth = depth;
  PointCloud cloud = test::read_memory(build_las(file), options);
  if (warnings) *warnings = cloud.warnings;
  return cloud.colors;
}

TEST(ColorDepthTest, eight_bit_colours_are_found_and_spread_over_16_bits) {
  std::vector<std::string> warnings;
  EXPECT_EQ(colors_of({{1, 2, 3}, {254, 0, 0}}, ColorDepth::automatic, &warnings),
            (std::vector<Color16>{{257, 514, 771}, {65278, 0, 0}}));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0],
            "memory: assuming 8-bit colours (maximum 254); --color-depth 16 reads them as 16 bits");
}

TEST(ColorDepthTest, sixteen_bit_and_black_colours_stay) {
  std::vector<std::string> warnings;
  EXPECT_EQ(colors_of({{1, 2, 3}, {256, 0, 0}}, ColorDepth::automatic, &warnings),
            (std::vector<Color16>{{1, 2, 3}, {256, 0, 0}}));
  EXPECT_EQ(colors_of({{0, 0, 0}}, ColorDepth::automatic, &warnings), (std::vector<Color16>{{0, 0, 0}}));
  EXPECT_TRUE(warnings.empty());
}

TEST(ColorDepthTest, the_caller_may_decide) {
  EXPECT_EQ(colors_of({{1, 2, 3}}, ColorDepth::bits_16), (std::vector<Color16>{{1, 2, 3}}));
  std::vector<std::string> warnings;
  EXPECT_EQ(colors_of({{1, 2, 300}}, ColorDepth::bits_8, &warnings),
            (std::vector<Color16>{{257, 514, 65535}}));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("above 255"), std::string::npos);
}

/// A LAS file with one point of this colour.
std::vector<std::byte> las_of_color(std::uint16_t red, std::uint16_t green, std::uint16_t near_infrared = 0) {
  LasFile file;
  file.version_minor = 4;
  file.point_format = 8;
  file.points.emplace_back().color = {red, green, 0};
  file.points[0].near_infrared = near_infrared;
  return build_las(file);
}

TEST(ColorDepthTest, a_dark_file_among_files_of_16_bits_stays_dark_and_is_named) {
  const PointCloud cloud = join({las_of_color(255, 3), las_of_color(65535, 255), las_of_color(0, 0)});
  EXPECT_EQ(cloud.colors, (std::vector<Color16>{{255, 3, 0}, {65535, 255, 0}, {0, 0, 0}}));
  EXPECT_TRUE(warns(cloud, "first: reading colours as 16 bits like those of other files"));
  EXPECT_EQ(cloud.warnings.size(), 1u);
}

TEST(ColorDepthTest, files_of_8_bits_are_spread_together_and_rows_of_other_formats_are_left_alone) {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n1 2 3 1 2 3\n";
  const PointCloud cloud = join({las_of_color(255, 3), text(ply), las_of_color(2, 1)}, {});
  EXPECT_EQ(cloud.colors, (std::vector<Color16>{{65535, 771, 0}, {257, 514, 771}, {514, 257, 0}}));
  EXPECT_TRUE(warns(cloud, "first and 1 more file: assuming 8-bit colours (maximum 255)"));
}

TEST(ColorDepthTest, near_infrared_is_spread_in_all_files_or_in_no_file) {
  const auto near_infrared = [](std::uint16_t first, std::uint16_t second) {
    return join({las_of_color(255, 0, first), las_of_color(7, 0, second)}).near_infrared;
  };
  EXPECT_EQ(near_infrared(1, 255), (std::vector<std::uint16_t>{257, 65535}));
  EXPECT_EQ(near_infrared(1, 256), (std::vector<std::uint16_t>{1, 256}));
}

TEST(ColorDepthTest, a_coloured_file_without_points_does_not_count) {
  LasFile empty;
  const PointCloud cloud = join({text("1 2 3\n"), build_las(empty)});
  EXPECT_TRUE(cloud.colors.empty());
}

TEST(ColorDepthTest, near_infrared_follows_the_colours_if_it_is_no_deeper) {
  LasFile file;
  file.version_minor = 4;
  file.point_format = 8;
  file.points.resize(2);
  file.points[0].color = {200, 0, 0};
  file.points[0].near_infrared = 100;
  const auto read = [&] { return test::read_memory(build_las(file)); };
  EXPECT_EQ(read().near_infrared[0], 25700);
  file.points[1].near_infrared = 1000;
  EXPECT_EQ(read().near_infrared[0], 100);
  EXPECT_EQ(read().colors[0].x, 51400);
}

}  // namespace
}  // namespace alidade
