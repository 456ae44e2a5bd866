// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "camera/projection.h"
#include "cloud/las/write_las.h"
#include "octree/spacing.h"
#include "renderer/overview.h"
#include "tests/renderer/tracer_scenes.h"

namespace alidade {

using namespace image;
using namespace camera;
using namespace renderer;

namespace {

namespace fs = std::filesystem;

/// A LAS file of 1000 points in a 10 m cube with the attributes that `fill` adds; gone with the test.
class LoadCloud : public ::testing::Test {
 protected:
  LoadCloud()
      : folder_(std::filesystem::temp_directory_path() /
                (std::string("load_cloud_") +
                 ::testing::UnitTest::GetInstance()->current_test_info()->name() + "_" +
                 std::to_string(::getpid()))) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~LoadCloud() override { fs::remove_all(folder_); }

  template <class Fill>
  CloudSettings settings_for(const Fill& fill) {
    test::Random random("load cloud");
    std::vector<glm::dvec3> positions;
    for (int i = 0; i < 1000; ++i)
      positions.push_back({random.between(0, 10), random.between(0, 10), 0.01 * i});
    PointCloud cloud = test::make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0.0)});
    fill(cloud);
    CloudSettings settings;
    settings.files = {folder_ / "site.las"};
    write_las(settings.files[0], cloud);
    return settings;
  }

  static bool warns_of(const LoadedCloud& cloud, const std::string& text) {
    return std::any_of(cloud.warnings.begin(), cloud.warnings.end(),
                       [&](const std::string& warning) { return warning.find(text) != std::string::npos; });
  }

  fs::path folder_;
};

void add_colors(PointCloud& cloud) {
  for (std::size_t id = 0; id < cloud.size(); ++id) {
    cloud.colors.push_back(Color16(static_cast<std::uint16_t>(id * 60), 1000, 65535));
  }
}

void add_intensities(PointCloud& cloud) {
  for (std::size_t id = 0; id < cloud.size(); ++id)
    cloud.intensities.push_back(static_cast<std::uint16_t>(id));
}

TEST_F(LoadCloud, automatic_takes_colours_first) {
  const LoadedCloud cloud = load_cloud(settings_for([](PointCloud& points) {
    add_colors(points);
    add_intensities(points);
  }));
  EXPECT_EQ(cloud.color.by, PointColor::rgb);
  ASSERT_EQ(cloud.colors.size(), 1000u);
  EXPECT_EQ(cloud.colors[7], Color16(420, 1000, 65535));
  EXPECT_EQ(cloud.octree.size(), 1000u);
  EXPECT_EQ(cloud.radius, automatic_radius(cloud.octree));
  ASSERT_EQ(cloud.files.size(), 1u);
  EXPECT_EQ(cloud.files[0].format, "LAS");
}

/// Classes 2 and 6 in turn, of as many points; the others are unclassified.
void classify(PointCloud& cloud, std::size_t count) {
  cloud.classifications.assign(cloud.size(), 1);
  for (std::size_t id = 0; id < count; ++id) cloud.classifications[id] = id % 2 == 0 ? 2 : 6;
}

TEST_F(LoadCloud, automatic_takes_classes_where_colour_is_missing_or_black_with_a_warning) {
  const LoadedCloud plain = load_cloud(settings_for([](PointCloud& points) { classify(points, 500); }));
  EXPECT_EQ(plain.color.by, PointColor::classification);
  EXPECT_TRUE(warns_of(plain, "site.las has no colours: coloured by classification"));
  fs::remove(folder_ / "site.las");
  const LoadedCloud black = load_cloud(settings_for([](PointCloud& points) {
    points.colors.assign(points.size(), Color16(0));
    classify(points, 1000);
  }));
  EXPECT_EQ(black.color.by, PointColor::classification);
  EXPECT_TRUE(warns_of(black, "has only black colours: coloured by classification"));
}

TEST_F(LoadCloud, automatic_takes_height_where_most_points_have_no_class) {
  const LoadedCloud cloud = load_cloud(settings_for([](PointCloud& points) {
    classify(points, 499);
    add_intensities(points);
  }));
  EXPECT_EQ(cloud.color.by, PointColor::height);
  fs::remove(folder_ / "site.las");
  const LoadedCloud noisy = load_cloud(settings_for([](PointCloud& points) {
    classify(points, 499);
    for (std::size_t id = 499; id < points.size(); ++id) points.classifications[id] = id % 2 == 0 ? 7 : 18;
  }));
  EXPECT_EQ(noisy.color.by, PointColor::height) << "low and high noise";
}

TEST_F(LoadCloud, automatic_takes_height_where_there_are_no_classes_with_a_warning) {
  const LoadedCloud cloud =
      load_cloud(settings_for([](PointCloud& points) { points.intensities.assign(points.size(), 7); }));
  EXPECT_EQ(cloud.color.by, PointColor::height);
  EXPECT_TRUE(warns_of(cloud, "coloured by height"));
  EXPECT_NE(cloud.colors[0], cloud.colors[500]);
  EXPECT_NE(cloud.colors[500], cloud.colors[999]);
}

TEST_F(LoadCloud, intensity_is_stretched_between_percentiles_1_and_99) {
  CloudSettings settings = settings_for([](PointCloud& points) {
    add_intensities(points);
    points.intensities[999] = 65535;  // glare
  });
  settings.color.by = PointColor::intensity;
  const LoadedCloud cloud = load_cloud(settings);
  EXPECT_TRUE(cloud.warnings.empty());
  // Ranks 9.99 and 989.01, rounded away from the middle.
  EXPECT_EQ(cloud.color.scale->range, (ValueRange{9, 990}));
  // Dark grey to nearly white.
  EXPECT_EQ(cloud.colors[9], Color16(13107));
  EXPECT_EQ(cloud.colors[990], Color16(62258));
  EXPECT_EQ(cloud.colors[999], Color16(62258));
  EXPECT_NEAR(cloud.colors[500].r, 37720, 50);
  EXPECT_EQ(cloud.colors[500].r, cloud.colors[500].b);
}

TEST_F(LoadCloud, height_can_be_requested) {
  CloudSettings settings = settings_for(add_colors);
  settings.color.by = PointColor::height;
  const LoadedCloud cloud = load_cloud(settings);
  EXPECT_EQ(cloud.color.by, PointColor::height);
  EXPECT_EQ(cloud.colors[3], cloud.colors[9]);  // both in the lowest hundredth
  EXPECT_NE(cloud.colors[100], cloud.colors[900]);
}

TEST_F(LoadCloud, a_missing_named_attribute_is_an_error) {
  CloudSettings settings = settings_for(add_intensities);
  settings.color.by = PointColor::rgb;
  EXPECT_THROW(load_cloud(settings), Error);
  settings.color.by = PointColor::intensity;
  EXPECT_NO_THROW(load_cloud(settings));
}

TEST_F(LoadCloud, radius_of_the_settings_is_kept_and_checked) {
  CloudSettings settings = settings_for(add_colors);
  settings.radius = 0.123;
  EXPECT_EQ(load_cloud(settings).radius, 0.123);
  for (const double bad : {0.0, -1.0, static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
    settings.radius = bad;
    EXPECT_THROW(load_cloud(settings), Error);
  }
}

TEST_F(LoadCloud, odd_clouds_are_rendered) {
  const glm::dvec3 position(690000.0, 5325000.0, 500.0);
  const std::vector<glm::dvec3> shapes[] = {
      {}, {position}, std::vector<glm::dvec3>(100, position), {position, position + glm::dvec3(1, 0, 0)}};
  int number = 0;
  for (const std::vector<glm::dvec3>& positions : shapes) {
    CloudSettings settings;
    settings.files = {folder_ / (std::to_string(number++) + ".las")};
    write_las(settings.files[0], test::make_cloud(positions, {glm::dvec3(0.001), position}));
    const LoadedCloud cloud = load_cloud(settings);
    EXPECT_EQ(warns_of(cloud, "has no points"), positions.empty());
    for (const NormalMode normals : {NormalMode::sphere, NormalMode::smooth}) {
      settings.normals = normals;
      Scene scene;
      scene.cloud = settings;
      scene.sun.emplace();
      scene.camera = overview_camera(visible_bounds(cloud), 60, 40);
      scene.render.samples = 2;
      const Film film = render(scene, &cloud);
      const auto seen =
          std::count_if(film.id.begin(), film.id.end(), [](std::uint32_t id) { return id != 0; });
      EXPECT_EQ(seen > 0, !positions.empty()) << positions.size();
      for (const Rgb& color : film.color) ASSERT_TRUE(std::isfinite(color.r) && color.r >= 0.0f);
    }
  }
}

TEST_F(LoadCloud, strays_do_not_widen_what_is_shown) {
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 10000; ++i) positions.emplace_back(i % 100, i / 100, 0.01 * (i % 7));
  CloudSettings settings;
  settings.radius = 0.5;
  settings.files = {folder_ / "plain.las"};
  write_las(settings.files[0], test::make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0.0)}));
  const Bounds plain = visible_bounds(load_cloud(settings));
  EXPECT_EQ(plain.min, glm::dvec3(-0.5, -0.5, -0.5));
  EXPECT_EQ(plain.max, glm::dvec3(99.5, 99.5, 0.56));

  for (int i = 0; i < 20; ++i) positions.emplace_back(2000.0, 3000.0 + i, 500.0);
  settings.files = {folder_ / "strays.las"};
  write_las(settings.files[0], test::make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0.0)}));
  const LoadedCloud cloud = load_cloud(settings);
  EXPECT_EQ(stray_count(cloud), 20u);
  const Bounds strays = visible_bounds(cloud);
  EXPECT_EQ(strays.min, plain.min);
  for (int axis = 0; axis < 3; ++axis) EXPECT_LT(strays.max[axis], plain.max[axis] + 5.0) << axis;

  for (int i = 0; i < 20; ++i) positions.emplace_back(-2000.0, -3000.0 - i, -500.0);
  settings.files = {folder_ / "more.las"};
  write_las(settings.files[0], test::make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0.0)}));
  EXPECT_EQ(stray_count(load_cloud(settings)), 40u) << "once each, though far away along all axes";
}

TEST_F(LoadCloud, pylons_and_far_walls_are_in_the_frame_of_an_overview) {
  std::vector<glm::dvec3> positions;
  // A wide field, and beside it a few points of a wall.
  for (int i = 0; i < 90'000; ++i) positions.emplace_back(i % 300, i / 300, 0.01 * (i % 7));
  for (int i = 0; i < 30; ++i) positions.emplace_back(330.0, 5.0 * i, 0.5 * (i % 10));
  // Pylons of 60 m: fewer points than half a percent, and their tips than are sampled.
  for (int pylon = 0; pylon < 4; ++pylon)
    for (int i = 0; i < 60; ++i) positions.emplace_back(40.0 + 60.0 * pylon, 250.0 - 40.0 * pylon, 1.0 + i);
  CloudSettings settings;
  settings.radius = 0.5;
  settings.files = {folder_ / "field.las"};
  write_las(settings.files[0], test::make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0.0)}));
  LoadedCloud cloud = load_cloud(settings);
  EXPECT_EQ(stray_count(cloud), 0u);
  for (const double azimuth : {30.0, 135.0, 260.0}) {
    const camera::Projection frame(overview_camera(visible_positions(cloud), cloud.radius, 60, 40, azimuth));
    for (const glm::dvec3& position : positions) {
      const std::optional<glm::dvec2> film = frame.project(position);
      ASSERT_TRUE(film && film->x >= 0.0 && film->x <= 60.0 && film->y >= 0.0 && film->y <= 40.0)
          << position.x << " " << position.y << " " << position.z;
    }
  }
  positions.emplace_back(150.0, 150.0, 1000.0);
  positions.emplace_back(150.0, -1000.0, 0.0);
  settings.files = {folder_ / "birds.las"};
  write_las(settings.files[0], test::make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0.0)}));
  cloud = load_cloud(settings);
  EXPECT_EQ(stray_count(cloud), 2u);
  EXPECT_NEAR(visible_bounds(cloud).max.z, 60.5, 1e-9);
}

TEST(AutomaticExposure, is_that_of_the_surfaces_alone) {
  // A ball that shines, small before nothing: its luminance times a quarter is the medium of 0.187.
  Scene scene;
  scene.objects.emplace_back(
      Sphere{.center = {0, 0, 0}, .radius = 1.5, .material = Emissive{Rgb(4.0f * 0.187f)}});
  const Camera view = camera::pinhole_from_fov(60, 40, 60.0, camera::look_at({0, -10, 0}, {0, 0, 0}));
  EXPECT_NEAR(automatic_exposure(scene, nullptr, view), -2.0, 1e-9);
  scene.sky = ConstantSky{Rgb(50.0f)};
  EXPECT_NEAR(automatic_exposure(scene, nullptr, view), -2.0, 1e-9) << "however bright the sky is";
  // Most pixels of a ball of some two pixels show the sky, too, which is not part of its light.
  scene.objects.front() =
      Sphere{.center = {0, 0, 0}, .radius = 0.26, .material = Emissive{Rgb(4.0f * 0.187f)}};
  EXPECT_NEAR(automatic_exposure(scene, nullptr, view), -2.0, 1e-9);
  EXPECT_EQ(
      automatic_exposure(scene, nullptr,
                         camera::pinhole_from_fov(60, 40, 60.0, camera::look_at({0, -10, 0}, {0, -20, 0}))),
      0.0);
}

TEST_F(LoadCloud, overviews_are_from_the_side_of_the_scanners_unless_they_are_amid_the_points) {
  LoadedCloud cloud = load_cloud(settings_for(add_colors));
  const CameraPose plain = overview_camera(cloud, 60, 40).pose;
  cloud.scanner_positions = {{"", {4, 30, 2}, {}}, {"", {6, 40, 2}, {}}};
  const CameraPose pose = overview_camera(cloud, 60, 40).pose;
  EXPECT_NEAR(pose.forward.x, 0.0, 0.02);
  EXPECT_LT(pose.forward.y, -0.8);
  EXPECT_GT(pose.position.y, 10.0);
  for (const std::vector<ScannerPosition>& scanners :
       {std::vector<ScannerPosition>{{"", {4, 6, 2}, {}}},
        std::vector<ScannerPosition>{{"", {-20, 5, 2}, {}}, {"", {30, 5, 2}, {}}},
        std::vector<ScannerPosition>{{"", {NAN, 5, 2}, {}}},
        std::vector<ScannerPosition>{{"", {1e308, 5, 2}, {}}}}) {
    cloud.scanner_positions = scanners;
    EXPECT_EQ(overview_camera(cloud, 60, 40).pose.position, plain.position);
  }
}

TEST_F(LoadCloud, the_frame_of_a_depth_camera_is_seen_from_its_position_under_a_sun_behind_it) {
  LoadedCloud cloud = load_cloud(settings_for(add_colors));
  Scene scene = daylight_scene({});
  const glm::dvec2 sun(scene.sun->azimuth, scene.sun->elevation);
  light_from_scanners(scene, cloud, overview_camera(cloud, 60, 40));
  EXPECT_EQ(glm::dvec2(scene.sun->azimuth, scene.sun->elevation), sun) << "no scanner position is known";

  // From below, as frames stored in the axes of their camera lie.
  cloud.scanner_positions = {{"", {5, 5, -20}, DepthCameraAxes{.forward = {0, 0, 1}, .down = {0, 1, 0}}}};
  const Camera camera = overview_camera(cloud, 60, 40);
  EXPECT_EQ(camera.pose.position, glm::dvec3(5, 5, -20));
  EXPECT_EQ(camera.pose.right, glm::dvec3(1, 0, 0));
  light_from_scanners(scene, cloud, camera);
  EXPECT_LT(scene.sun->elevation, -30.0);
  EXPECT_GE(scene.sun->elevation, -89.0);
  EXPECT_EQ(scene.sun->azimuth, 140.0) << "to the right, and up in the picture, where south is";

  // It cannot be where some points are beside it or behind it.
  cloud.scanner_positions[0].position.z = 5.0;
  EXPECT_NE(overview_camera(cloud, 60, 40).pose.position, glm::dvec3(5, 5, 5));
}

TEST_F(LoadCloud, can_be_stopped_after_reading_too_and_progress_never_goes_back) {
  const CloudSettings settings = settings_for(add_colors);
  std::vector<std::uint64_t> reports;
  std::uint64_t bytes = 0;
  load_cloud(settings, [&](std::uint64_t done, std::uint64_t total) {
    reports.push_back(done);
    bytes = total;
    return true;
  });
  EXPECT_TRUE(std::ranges::is_sorted(reports));
  EXPECT_EQ(reports.back(), bytes);
  // The end of reading, three times in build, once behind the radius.
  EXPECT_GE(std::ranges::count(reports, bytes), 5);
  for (std::size_t last = 1; last <= reports.size(); ++last) {
    std::size_t calls = 0;
    EXPECT_THROW(load_cloud(settings, [&](std::uint64_t, std::uint64_t) { return ++calls < last; }),
                 Cancelled);
    EXPECT_EQ(calls, last);
  }
}

TEST_F(LoadCloud, reading_can_be_stopped) {
  EXPECT_THROW(load_cloud(settings_for(add_colors), [](std::uint64_t, std::uint64_t) { return false; }),
               Cancelled);
}

}  // namespace
}  // namespace alidade
