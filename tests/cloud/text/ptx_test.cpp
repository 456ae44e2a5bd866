// SPDX-License-Identifier: MIT
#include <cmath>

#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/read_alone.h"

namespace alidade::test {
namespace {

PointCloud read_ptx(std::string_view text) {
  return read_alone(open_ptx, text);
}

const std::string k_pose = "10 20 30\n1 0 0\n0 1 0\n0 0 1\n";
const std::string k_identity = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";

std::string scan(const std::string& size, const std::string& transform, const std::string& points) {
  return size + k_pose + transform + points;
}

TEST(Ptx, the_transform_takes_row_vectors_and_has_the_translation_in_its_last_row) {
  // A quarter turn about z (x to y, y to -x) and a far translation.
  const PointCloud cloud = read_ptx(scan("1\n2\n", "0 1 0 0\n-1 0 0 0\n0 0 1 0\n690000.5 5325000.25 500 1\n",
                                         "1.125 2.25 3 0.5\n-4 5 6 1\n"));
  ASSERT_EQ(cloud.size(), 2u);
  expect_near(cloud.world(0), {690000.5 - 2.25, 5325000.25 + 1.125, 503}, 1e-9);
  expect_near(cloud.world(1), {690000.5 - 5, 5325000.25 - 4, 506}, 1e-9);
  EXPECT_EQ(cloud.intensities, (std::vector<std::uint16_t>{32768, 65535}));
  EXPECT_EQ(cloud.files[0].format, "PTX");
}

TEST(Ptx, translations_are_scanner_positions_unless_the_transform_is_the_identity) {
  const std::string moved = "0 1 0 0\n-1 0 0 0\n0 0 1 0\n690000.5 5325000.25 500 1\n";
  const PointCloud cloud = read_ptx(scan("0\n5\n", moved, "") + scan("1\n1\n", moved, "1 2 3 0.5\n") +
                                    scan("1\n1\n", k_identity, "1 2 3 0.5\n") +
                                    scan("1\n1\n", "0 -1 0 7\n1 0 0 8\n0 0 1 9\n0 0 0 1\n", "1 2 3 0.5\n"));
  EXPECT_EQ(cloud.scanner_positions,
            (std::vector<ScannerPosition>{{"", {690000.5, 5325000.25, 500}, {}}, {"", {7, 8, 9}, {}}}));
}

TEST(Ptx, a_transform_written_by_columns_is_transposed_with_a_warning) {
  const PointCloud cloud =
      read_ptx(scan("1\n1\n", "0 -1 0 100\n1 0 0 200\n0 0 1 300\n0 0 0 1\n", "1 2 3 0.5\n"));
  expect_near(cloud.world(0), {98, 201, 303}, 1e-9);
  EXPECT_TRUE(warns(cloud, "transposed"));
}

TEST(Ptx, the_resolution_is_that_of_the_written_digits_once_they_are_read) {
  const std::string text = scan("1\n1\n", k_identity, "1.25 2.5 3 0.5\n");
  const auto reader = open_ptx(InputFile(std::as_bytes(std::span(text)), "memory"), Damage::reject);
  EXPECT_EQ(reader->facts().resolution(Bounds(glm::dvec3(0), glm::dvec3(9))), glm::dvec3(0.0));
  EXPECT_EQ(reader->survey({}).resolution, glm::dvec3(0.005, 0.05, 0.5));
}

TEST(Ptx, cells_without_a_return_are_dropped_and_counted) {
  const PointCloud cloud = read_ptx(
      scan("2\n2\n", "1 0 0 0\n0 1 0 0\n0 0 1 0\n7 7 7 1\n", "0 0 0 0.5\n1 2 3 0.5\n0 0 0 0\n0 0 1 1\n"));
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.files[0].dropped_count, 2u);
  expect_near(cloud.world(1), {7, 7, 8}, 1e-9);
  EXPECT_TRUE(warns(cloud, "2 points without a return"));
}

TEST(Ptx, several_scans_with_and_without_colour_make_one_cloud) {
  const PointCloud cloud =
      read_ptx(scan("0\n5\n", k_identity, "") + scan("1\n1\n", k_identity, "1 2 3 0.5 255 1 0\n") + "\n" +
               scan("1\n2\n", k_identity, "4 5 6 0.5\n7 8 9 0.5 1 2 3\n"));
  ASSERT_EQ(cloud.size(), 3u);
  EXPECT_EQ(cloud.colors[0], Color16(65535, 257, 0));
  EXPECT_EQ(cloud.colors[1], Color16(0));
  EXPECT_EQ(cloud.colors[2], Color16(257, 514, 771));
  expect_near(cloud.world(2), {7, 8, 9}, 1e-9);
}

TEST(Ptx, the_lattice_follows_the_scale_of_the_transform) {
  const PointCloud cloud = read_ptx(
      scan("1\n2\n", "0.001 0 0 0\n0 0.001 0 0\n0 0 0.001 0\n0 0 0 1\n", "1234 5 6 0.5\n1 2 3 0.5\n"));
  expect_near(cloud.world(0), {1.234, 0.005, 0.006}, 1e-9);
}

TEST(Ptx, errors_name_file_line_expectation_and_finding) {
  const auto expect = [](const std::string& text, const char* message) {
    const std::string found = reading_error(open_ptx, text);
    EXPECT_NE(found.find(message), std::string::npos) << found << "\nfor\n" << text.substr(0, 300);
  };
  const std::string good = scan("1\n1\n", k_identity, "1 2 3 0.5\n");
  expect("1 2 3\n",
         "memory:line 1: invalid number of columns of a scan; expected one integer, found 3 words");
  expect("-1\n1\n", "memory:line 1: invalid number of columns of a scan; expected one integer, found \"-1\"");
  expect("1\nmany\n", "memory:line 2: invalid number of rows of a scan");
  expect("1\n1\n1 2 3 4\n", "memory:line 3: invalid PTX header: missing the scanner's position");
  expect("1\n1\n" + k_pose + "1 0 0\n", "memory:line 7: invalid PTX header: missing the transform");
  expect("1\n1\n" + k_pose + "1 0 0 nan\n", "memory:line 7: invalid value; expected a finite number");
  expect("1\n1\n" + k_pose + "1 0 0 zero\n", "memory:line 7: invalid value; expected a number");
  expect("1\n1\n" + k_pose, "truncated file");
  expect(scan("1\n1\n", "1 0 0 1\n0 1 0 0\n0 0 1 0\n0 0 5 1\n", "1 2 3 0.5\n"),
         "memory:line 10: the transform is not");
  expect(scan("1\n1\n", k_identity, "1 2\n"), "memory:line 11: invalid point");
  expect(scan("1\n1\n", k_identity, "1 2 3 x\n"), "memory:line 11: invalid value; expected a number");
  expect(scan("1\n2\n", k_identity, "1 2 3 0.5\n"), "truncated file");
  expect(scan("4294967296\n4294967296\n", k_identity, "1 2 3 0.5\n"),
         "memory:line 2: truncated file: too short for the points of the scan; expected at most 11, found "
         "4294967296 times 4294967296; --partial reads the intact part");
  expect(good + "4 5 6 0.5\n", "memory:line 12: invalid number of columns of a scan");
}

TEST(Ptx, every_truncation_is_an_error_or_a_clean_read) {
  const std::string sample = scan("1\n2\n", k_identity, "1 2 3 0.5 10 20 30\n0 0 0 0 0 0 0\n") +
                             scan("1\n1\n", k_identity, "4 5 6 0.5 10 20 30\n");
  EXPECT_EQ(read_ptx(sample).size(), 2u);
  // Ends of the first scan and of the last row, also of such as are complete without colours or some digits.
  EXPECT_LE(count_readable_prefixes(open_ptx, sample), 15u);
}

TEST(Ptx, reads_a_file_of_another_program) {
  const std::filesystem::path path = shared_data("text/1.2-with-color.ptx");
  if (path.empty()) GTEST_SKIP() << k_no_shared_data;
  const PointCloud cloud = read_alone(open_ptx, InputFile(path));
  ASSERT_EQ(cloud.size(), 1065u);
  EXPECT_EQ(cloud.files[0].dropped_count, 0u);
  expect_near(cloud.bounds().min, {635619.85, 848899.7, 406.59}, 1e-6);
  expect_near(cloud.bounds().max, {638982.55, 853535.43, 586.38}, 1e-6);
  EXPECT_EQ(cloud.colors.front(), Color16(68, 77, 88) * std::uint16_t{257});
  EXPECT_EQ(cloud.colors.back(), Color16(138, 107, 136) * std::uint16_t{257});
  EXPECT_EQ(cloud.intensities.front(), static_cast<std::uint16_t>(std::lround(0.034912 * 65535)));
}

}  // namespace
}  // namespace alidade::test
