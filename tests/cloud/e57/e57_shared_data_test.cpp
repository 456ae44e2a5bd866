// SPDX-License-Identifier: MIT
// E57 files that other programs wrote. Expected values were taken from the files' bytes with a few lines of
// Python.
#include <algorithm>
#include <array>
#include <cmath>

#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/read_alone.h"

namespace alidade {
namespace {

using test::error_of;
using test::expect_near;
using test::k_no_shared_data;
using test::shared_data;
using test::warns;

TEST(E57SharedFiles, bunny_has_30571_points_within_its_bounds) {
  const std::filesystem::path path = shared_data("e57/bunnyDouble.e57");
  if (path.empty()) GTEST_SKIP() << k_no_shared_data;
  const PointCloud cloud = read_cloud(path);
  ASSERT_EQ(cloud.size(), 30571u);
  EXPECT_EQ(cloud.files[0].format, "E57");
  EXPECT_EQ(cloud.files[0].dropped_count, 0u);
  // Six decimals, written as doubles.
  expect_near(cloud.bounds().min, {-0.094689, 0.040011, -0.061873}, 1e-10);
  expect_near(cloud.bounds().max, {0.061009, 0.187321, 0.058799}, 1e-10);
  EXPECT_TRUE(cloud.warnings.empty());
}

TEST(E57SharedFiles, bunny_is_the_bunny_of_the_text_file) {
  const std::filesystem::path path = shared_data("e57/bunnyDouble.e57"),
                              text = shared_data("text/bunnyData.pts");
  if (path.empty() || text.empty()) GTEST_SKIP() << k_no_shared_data;
  const PointCloud cloud = read_cloud(path), other = read_cloud(text);
  ASSERT_EQ(cloud.size(), other.size());
  // The order differs; both have six decimals.
  const auto sorted = [](const PointCloud& points) {
    std::vector<std::array<long, 3>> millionths;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const glm::dvec3 world = points.world(i);
      millionths.push_back(
          {std::lround(1e6 * world.x), std::lround(1e6 * world.y), std::lround(1e6 * world.z)});
    }
    std::sort(millionths.begin(), millionths.end());
    return millionths;
  };
  EXPECT_EQ(sorted(cloud), sorted(other));
}

TEST(E57SharedFiles, cube_has_7680_coloured_points) {
  const std::filesystem::path path = shared_data("e57/ColouredCubeFloat.e57");
  if (path.empty()) GTEST_SKIP() << k_no_shared_data;
  const PointCloud cloud = read_cloud(path);
  ASSERT_EQ(cloud.size(), 7680u);
  expect_near(cloud.bounds().min, glm::dvec3(-0.5), 1e-7);
  expect_near(cloud.bounds().max, glm::dvec3(0.5), 1e-7);
  ASSERT_EQ(cloud.colors.size(), 7680u);
  EXPECT_EQ(cloud.colors.front(), Color16(0, 0, 65535));
  EXPECT_EQ(cloud.colors.back(), Color16(65535, 0, 0));
  expect_near(cloud.world(0), {-0.5, -0.4990559220314026, 0.07136291265487671}, 1e-7);
  expect_near(cloud.world(7679), {0.16827905178070068, -0.00394439697265625, 0.5}, 1e-7);
}

TEST(E57SharedFiles, half_of_the_spherical_points_are_directions_only) {
  const std::filesystem::path path = shared_data("e57/tiny_spherical.e57");
  if (path.empty()) GTEST_SKIP() << k_no_shared_data;
  const PointCloud cloud = read_cloud(path);
  EXPECT_EQ(cloud.size(), 180u);
  EXPECT_EQ(cloud.files[0].dropped_count, 180u);
  EXPECT_TRUE(warns(cloud, "skipped 180 points with a direction only"));
}

TEST(E57SharedFiles, two_scans_are_one_cloud) {
  const std::filesystem::path path = shared_data("e57/A_moved_B.e57");
  if (path.empty()) GTEST_SKIP() << k_no_shared_data;
  const PointCloud cloud = read_cloud(path);
  ASSERT_EQ(cloud.size(), 6u);
  expect_near(cloud.bounds().min, {-44.119438171386719, 0.70530283451080322, -0.60769999027252197}, 2e-6);
  expect_near(cloud.bounds().max, {-42.639499664306641, 2.0578000545501709, 0.66670000553131104}, 2e-6);
  EXPECT_TRUE(cloud.scanner_positions.empty()) << "the file has no poses";
  EXPECT_EQ(*std::max_element(cloud.intensities.begin(), cloud.intensities.begin() + 2), 65535);
  EXPECT_EQ(*std::max_element(cloud.intensities.begin() + 2, cloud.intensities.end()), 65535);
}

TEST(E57SharedFiles, a_damaged_page_is_named) {
  const std::filesystem::path path = shared_data("malformed/corrupt_crc.e57");
  if (path.empty()) GTEST_SKIP() << k_no_shared_data;
  const std::string error = error_of([&] { read_cloud(path); });
  EXPECT_NE(error.find("corrupt_crc.e57:page 33: corrupt page: wrong checksum"), std::string::npos) << error;
}

/// Damage of every kind to a sample is an Error, or hits bytes that are not read.
void expect_rejection(const std::string& name) {
  const std::filesystem::path path = shared_data("e57/" + name);
  if (path.empty()) GTEST_SKIP() << k_no_shared_data;
  const std::vector<std::byte> file = test::read_bytes(path);
  const std::string whole(reinterpret_cast<const char*>(file.data()), file.size());
  const PointCloud sound = test::read_alone(open_e57, whole);
  for (std::size_t i = 0; i < 300; ++i) {
    std::string flipped = whole;
    const std::size_t offset = (i * 2654435761u + i * i * 97) % whole.size();
    flipped[offset] = static_cast<char>(flipped[offset] ^ (1 << i % 8));
    EXPECT_NE(test::reading_error(open_e57, flipped), "") << "byte " << offset;
  }
  for (std::size_t i = 0; i < 40; ++i) {
    EXPECT_NE(test::reading_error(open_e57, whole.substr(0, i * whole.size() / 40)), "");
    EXPECT_NE(test::reading_error(open_e57, whole.substr(0, (i * whole.size() / 40) / 1024 * 1024)), "");
  }
  EXPECT_NE(test::reading_error(open_e57, whole + std::string(1024, '\0')), "");
  EXPECT_GT(sound.size(), 0u);
}

TEST(E57SharedFiles, flipped_bits_and_lost_ends_of_bunny_are_errors) {
  expect_rejection("bunnyDouble.e57");
}
TEST(E57SharedFiles, flipped_bits_and_lost_ends_of_cube_are_errors) {
  expect_rejection("ColouredCubeFloat.e57");
}
TEST(E57SharedFiles, flipped_bits_and_lost_ends_of_spherical_points_are_errors) {
  expect_rejection("tiny_spherical.e57");
}
TEST(E57SharedFiles, flipped_bits_and_lost_ends_of_two_scans_are_errors) {
  expect_rejection("A_moved_B.e57");
}

}  // namespace
}  // namespace alidade
