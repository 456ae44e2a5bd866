// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/error.h"
#include "cloud/las/write_las.h"
#include "image/color_points.h"
#include "octree/build.h"
#include "octree/index_file/save_index.h"
#include "tests/renderer/color_clouds.h"
#include "tests/renderer/tracer_scenes.h"

namespace alidade {

using namespace image;
using namespace renderer;

namespace {

namespace fs = std::filesystem;

class ColorFiles : public ::testing::Test {
 protected:
  ColorFiles()
      : folder_(std::filesystem::temp_directory_path() / ("color_files_" + std::to_string(::getpid()))) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~ColorFiles() override { fs::remove_all(folder_); }
  fs::path folder_;
};

/// Every attribute, with other values at every point.
PointCloud rich_cloud() {
  test::Random random("rich cloud");
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 5000; ++i)
    positions.emplace_back(random.between(0, 50), random.between(0, 50), random.between(90, 110));
  PointCloud cloud = test::make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0.0)});
  std::vector<float> values;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.colors.emplace_back(random.below(65536), random.below(65536), random.below(65536));
    cloud.near_infrared.push_back(static_cast<std::uint16_t>(random.below(65536)));
    cloud.intensities.push_back(static_cast<std::uint16_t>(random.below(65536)));
    cloud.classifications.push_back(static_cast<std::uint8_t>(random.below(256)));
    const auto count = static_cast<std::uint8_t>(1 + random.below(5));
    cloud.returns.push_back({static_cast<std::uint8_t>(1 + random.below(count)), count});
    cloud.flags.push_back(static_cast<std::uint8_t>(random.below(256)));
    cloud.scan_angles.push_back(static_cast<float>(0.006 * std::floor(random.between(-5000, 5000))));
    cloud.user_data.push_back(static_cast<std::uint8_t>(random.below(256)));
    cloud.point_source_ids.push_back(static_cast<std::uint16_t>(random.below(20)));
    cloud.gps_times.push_back(i % 50 == 0 ? NAN : random.between(3e8, 3e8 + 100));
    values.push_back(static_cast<float>(random.between(-40, 3)));
  }
  cloud.extra_dimensions = {test::extra<float>("Reflectance", ScalarType::float32, values)};
  return cloud;
}

TEST_F(ColorFiles, an_index_file_gives_the_colours_of_the_las_it_was_made_of) {
  write_las(folder_ / "site.las", rich_cloud());
  const PointCloud read = read_cloud(folder_ / "site.las");
  save_index(folder_ / "site.alidade", build(read), read);
  for (const std::string word : {"automatic", "rgb", "intensity", "height", "classification", "normal",
                                 "gps_time", "return_number", "number_of_returns", "near_infrared", "flags",
                                 "scan_angle", "user_data", "point_source_id", "Reflectance"}) {
    CloudSettings settings;
    settings.color = coloring_by(word);
    settings.files = {folder_ / "site.las"};
    const LoadedCloud of_las = load_cloud(settings);
    settings.files = {folder_ / "site.alidade"};
    const LoadedCloud of_index = load_cloud(settings);
    EXPECT_TRUE(std::ranges::equal(of_las.point_colors(), of_index.point_colors())) << word;
    EXPECT_EQ(of_las.point_colors().size(), word == "normal" ? 0u : 5000u) << word;
    EXPECT_EQ(scale_text(of_las.color), scale_text(of_index.color)) << word;
    EXPECT_EQ(of_las.color.swatches.size(), of_index.color.swatches.size()) << word;
    // Colours of the file are used where they lie.
    const bool is_rgb = of_index.color.by == PointColor::rgb;
    EXPECT_EQ(is_rgb, !of_index.mapped_colors.empty()) << word;
    EXPECT_EQ(is_rgb || word == "normal", of_index.colors.empty()) << word;
  }
}

TEST_F(ColorFiles, points_without_a_value_are_a_warning) {
  write_las(folder_ / "site.las", rich_cloud());
  CloudSettings settings;
  settings.color = coloring_by("gps_time");
  settings.files = {folder_ / "site.las"};
  const LoadedCloud cloud = load_cloud(settings);
  ASSERT_EQ(cloud.warnings.size(), 1u);
  EXPECT_TRUE(cloud.warnings[0].ends_with("site.las: 100 of 5000 points have no gps_time and are grey"));
}

TEST_F(ColorFiles, a_missing_attribute_is_an_error_before_points_are_read) {
  write_las(folder_ / "site.las", test::column(3));
  CloudSettings settings;
  settings.color = coloring_by("rgb");
  settings.files = {folder_ / "site.las"};
  bool has_read = false;
  try {
    load_cloud(settings, [&](std::uint64_t, std::uint64_t) { return has_read = true; });
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.parts().problem, "the cloud has no attribute \"rgb\"");
    EXPECT_EQ(error.parts().expected,
              "one of height, normal, intensity, classification, gps_time, return_number, "
              "number_of_returns, flags, scan_angle, user_data, point_source_id");
  }
  EXPECT_FALSE(has_read);
  settings.color = coloring_by("Reflectance");
  EXPECT_THROW(load_cloud(settings), Error);
}

}  // namespace
}  // namespace alidade
