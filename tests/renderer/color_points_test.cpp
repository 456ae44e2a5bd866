// SPDX-License-Identifier: MIT
#include "image/color_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/color.h"
#include "base/error.h"
#include "image/point_color.h"
#include "image/srgb.h"
#include "octree/build.h"
#include "renderer/load_cloud.h"
#include "renderer/world.h"
#include "tests/renderer/color_clouds.h"
#include "tests/renderer/tracer_scenes.h"

namespace alidade {

using namespace image;
using namespace renderer;

namespace {

/// The colours of a cloud and their meaning, as load_cloud has them made.
ColoredPoints colored(const PointCloud& cloud, const PointColoring& coloring) {
  std::vector<std::string> warnings;
  const AttributeColumns columns = columns_of(cloud);
  const PointColoring chosen =
      choose_color(coloring, {columns, cloud.attributes(), cloud.size(), "site.las"}, warnings);
  const Octree octree = build(cloud);
  return color_points(chosen, columns, cloud, heights(octree.view()));
}

std::string error_of(const PointCloud& cloud, const PointColoring& coloring) {
  try {
    colored(cloud, coloring);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

Color16 shade(ColorMap map, double share) {
  return to_color16(map_color(map, share));
}

TEST(ColorPoints, heights_go_from_the_first_to_the_last_colour_of_the_range) {
  PointColoring coloring{.by = PointColor::height, .map = ColorMap::viridis, .range = ValueRange{1.0, 3.0}};
  const ColoredPoints points = colored(test::column(5), coloring);
  ASSERT_EQ(points.colors.size(), 5u);
  EXPECT_EQ(points.colors[0], shade(ColorMap::viridis, 0.0));
  EXPECT_EQ(points.colors[1], shade(ColorMap::viridis, 0.0));
  EXPECT_EQ(points.colors[2], shade(ColorMap::viridis, 0.5));
  EXPECT_EQ(points.colors[3], shade(ColorMap::viridis, 1.0));
  EXPECT_EQ(points.colors[4], shade(ColorMap::viridis, 1.0));
  EXPECT_EQ(points.key.scale->extent, (ValueRange{0.0, 4.0}));
  EXPECT_FALSE(points.key.scale->percentiles);
}

TEST(ColorPoints, range_is_that_of_the_percentiles_unless_it_is_given) {
  const ColoredPoints points = colored(test::column(1001), {.by = PointColor::height});
  EXPECT_EQ(points.key.scale->range, (ValueRange{10.0, 990.0}));
  EXPECT_EQ(points.key.scale->map, ColorMap::terrain);
  EXPECT_EQ(points.colors[10], points.colors[0]);
  EXPECT_EQ(points.colors[500], shade(ColorMap::terrain, 0.5));
  const ColoredPoints all = colored(test::column(1001), {.by = PointColor::height, .percentiles = {0, 100}});
  EXPECT_EQ(all.key.scale->range, (ValueRange{0.0, 1000.0}));
}

TEST(ColorPoints, one_stray_point_does_not_flatten_the_heights) {
  PointCloud cloud = test::column(1000);
  cloud.positions.push_back({0, 0, 2'000'000'000});
  EXPECT_LT(colored(cloud, {.by = PointColor::height}).key.scale->range.high, 1000.0);
}

TEST(ColorPoints, equal_values_have_the_middle_colour) {
  PointCloud cloud = test::column(7);
  cloud.intensities.assign(7, 1234);
  const ColoredPoints points = colored(cloud, {.by = PointColor::intensity});
  for (const Color16& color : points.colors) EXPECT_EQ(color, shade(ColorMap::grey, 0.5));
  EXPECT_EQ(points.key.scale->range, (ValueRange{1234, 1234}));
}

TEST(ColorPoints, intensities_up_to_65535_are_shown_in_grey) {
  PointCloud cloud = test::column(3);
  cloud.intensities = {0, 32768, 65535};
  const ColoredPoints points = colored(cloud, {.by = PointColor::intensity});
  EXPECT_EQ(points.colors[0], Color16(13107));
  EXPECT_EQ(points.colors[1], shade(ColorMap::grey, 32768.0 / 65535.0));
  EXPECT_EQ(points.colors[2], Color16(62258));
}

TEST(ColorPoints, points_without_a_value_are_grey_and_counted) {
  PointCloud cloud = test::column(5);
  const double infinity = std::numeric_limits<double>::infinity();
  cloud.gps_times = {10.0, NAN, 20.0, infinity, 30.0};
  const ColoredPoints points = colored(cloud, {.by = PointColor::gps_time});
  EXPECT_EQ(points.key.missing_count, 2u);
  EXPECT_EQ(points.key.point_count, 5u);
  EXPECT_EQ(points.colors[1], k_no_value_color);
  EXPECT_EQ(points.colors[3], k_no_value_color);
  EXPECT_EQ(points.colors[2], shade(ColorMap::viridis, 0.5));
  EXPECT_EQ(points.key.scale->range, (ValueRange{10.0, 30.0}));
}

TEST(ColorPoints, nothing_but_nan_is_no_crash) {
  PointCloud cloud = test::column(3);
  cloud.gps_times.assign(3, NAN);
  const ColoredPoints points = colored(cloud, {.by = PointColor::gps_time});
  EXPECT_EQ(points.key.missing_count, 3u);
  for (const Color16& color : points.colors) EXPECT_EQ(color, k_no_value_color);
}

TEST(ColorPoints, classes_have_their_colours_and_are_counted) {
  PointCloud cloud = test::column(6);
  cloud.classifications = {2, 6, 2, 2, 70, 255};
  PointColoring coloring{.by = PointColor::classification};
  coloring.classes = {{6, Color16(257, 514, 771), "House"}};
  const ColoredPoints points = colored(cloud, coloring);
  EXPECT_EQ(points.colors[1], Color16(257, 514, 771));
  EXPECT_EQ(points.colors[0], points.colors[3]);
  ASSERT_EQ(points.key.swatches.size(), 4u);
  const Swatch &ground = points.key.swatches[0], &house = points.key.swatches[1];
  EXPECT_EQ(ground.number + ground.label, "2Ground");
  EXPECT_EQ(ground.count, 3u);
  EXPECT_EQ(ground.color, points.colors[0]);
  EXPECT_EQ(house.number + house.label, "6House");
  EXPECT_EQ(points.key.swatches[2].number, "70");
  EXPECT_EQ(points.key.swatches[3].number, "255");
  EXPECT_FALSE(points.key.scale);
}

TEST(ColorPoints, numbers_of_returns_are_integers_and_zero_is_nodata) {
  PointCloud cloud = test::column(5);
  cloud.returns = {{1, 3}, {2, 3}, {3, 3}, {1, 1}, {0, 0}};
  const ColoredPoints number = colored(cloud, {.by = PointColor::return_number});
  EXPECT_EQ(number.colors[0], shade(ColorMap::viridis, 0.0));
  EXPECT_EQ(number.colors[1], shade(ColorMap::viridis, 0.5));
  EXPECT_EQ(number.colors[2], shade(ColorMap::viridis, 1.0));
  EXPECT_EQ(number.colors[4], k_no_value_color);
  ASSERT_EQ(number.key.swatches.size(), 3u);
  EXPECT_EQ(number.key.swatches[0].number, "1");
  EXPECT_EQ(number.key.swatches[0].count, 2u);
  EXPECT_EQ(number.key.missing_count, 1u);
  const ColoredPoints count = colored(cloud, {.by = PointColor::number_of_returns, .map = ColorMap::turbo});
  EXPECT_EQ(count.colors[0], shade(ColorMap::turbo, 1.0));
  EXPECT_EQ(count.colors[3], shade(ColorMap::turbo, 0.0));
}

TEST(ColorPoints, any_numeric_attribute_can_be_named) {
  PointCloud cloud = test::column(3);
  cloud.near_infrared = {5, 10, 15};
  cloud.flags = {0, 1, 2};
  cloud.scan_angles = {-30.0f, 0.0f, 30.0f};
  cloud.user_data = {7, 8, 9};
  cloud.point_source_ids = {100, 200, 300};
  for (const std::string name : {"near_infrared", "flags", "scan_angle", "user_data", "point_source_id"}) {
    PointColoring coloring = coloring_by(name);
    coloring.map = ColorMap::viridis;
    const ColoredPoints points = colored(cloud, coloring);
    EXPECT_EQ(points.colors[0], shade(ColorMap::viridis, 0.0)) << name;
    EXPECT_EQ(points.colors[1], shade(ColorMap::viridis, 0.5)) << name;
    EXPECT_EQ(points.colors[2], shade(ColorMap::viridis, 1.0)) << name;
    EXPECT_EQ(points.key.word, name);
  }
  EXPECT_EQ(title_text(colored(cloud, coloring_by("scan_angle")).key), "Scan angle (degrees)");
  EXPECT_EQ(title_text(colored(cloud, coloring_by("point_source_id")).key), "Point source id");
}

TEST(ColorPoints, extra_dimensions_count_with_scale_offset_and_no_data_in_every_type) {
  PointCloud cloud = test::column(3);
  cloud.extra_dimensions = {test::extra<std::uint8_t>("a", ScalarType::uint8, {1, 2, 3}),
                            test::extra<std::int8_t>("b", ScalarType::int8, {-1, 0, 1}),
                            test::extra<std::uint16_t>("c", ScalarType::uint16, {1, 2, 3}),
                            test::extra<std::int16_t>("d", ScalarType::int16, {-500, 0, 500}),
                            test::extra<std::uint32_t>("e", ScalarType::uint32, {0, 1u << 30, 1u << 31}),
                            test::extra<std::int32_t>("f", ScalarType::int32, {-7, 0, 7}),
                            test::extra<std::uint64_t>("g", ScalarType::uint64, {0, 1ull << 62, 1ull << 63}),
                            test::extra<std::int64_t>("h", ScalarType::int64, {-(1ll << 40), 0, 1ll << 40}),
                            test::extra<float>("i", ScalarType::float32, {0.5f, 1.0f, 1.5f}),
                            test::extra<double>("j", ScalarType::float64, {-1e200, 0.0, 1e200})};
  for (const ExtraDimension& dimension : cloud.extra_dimensions) {
    PointColoring along_map = coloring_by(dimension.name);
    along_map.map = ColorMap::viridis;
    const ColoredPoints points = colored(cloud, along_map);
    EXPECT_EQ(points.colors[0], shade(ColorMap::viridis, 0.0)) << dimension.name;
    EXPECT_EQ(points.colors[1], shade(ColorMap::viridis, 0.5)) << dimension.name;
    EXPECT_EQ(points.colors[2], shade(ColorMap::viridis, 1.0)) << dimension.name;
  }
  ExtraDimension& scaled = cloud.extra_dimensions[3];
  scaled.scale = 0.25;
  scaled.offset = 10.0;
  EXPECT_EQ(colored(cloud, coloring_by("d")).key.scale->extent, (ValueRange{-115.0, 135.0}));
  const std::int64_t none = -500;
  std::memcpy(scaled.no_data.emplace().data(), &none, sizeof none);
  const ColoredPoints points = colored(cloud, coloring_by("d"));
  EXPECT_EQ(points.key.missing_count, 1u);
  ASSERT_EQ(points.key.swatches.size(), 2u);
  EXPECT_EQ(points.key.swatches[0].number, "10");
  EXPECT_EQ(points.key.swatches[1].number, "135");
}

TEST(ColorPoints, values_beyond_1e300_are_nodata) {
  PointCloud cloud = test::column(4);
  cloud.extra_dimensions = {
      test::extra<double>("j", ScalarType::float64, {-1e300, 1e300, 1.5e300, -1.7e308})};
  const ColoredPoints points = colored(cloud, coloring_by("j"));
  EXPECT_EQ(points.key.missing_count, 2u);
  EXPECT_EQ(points.colors[0], shade(ColorMap::viridis, 0.0));
  EXPECT_EQ(points.colors[1], shade(ColorMap::viridis, 1.0));
}

TEST(ColorPoints, empty_clouds_have_no_colours_and_no_errors) {
  for (const NamedPointColor& each : k_point_colors) {
    const ColoredPoints points = colored(PointCloud(), coloring_by(each.name));
    EXPECT_TRUE(points.colors.empty());
    EXPECT_EQ(points.key.point_count, 0u);
  }
  EXPECT_TRUE(colored(PointCloud(), coloring_by("anything")).colors.empty());
}

TEST(ColorPoints, a_missing_attribute_is_an_error_that_lists_what_there_is) {
  PointCloud cloud = test::column(2);
  cloud.intensities = {1, 2};
  cloud.extra_dimensions = {test::extra<float>("Reflectance", ScalarType::float32, {1, 2})};
  ExtraDimension bytes = test::extra<std::uint8_t>("blob", ScalarType::uint8, {1, 2});
  bytes.type = ScalarType::bytes;
  bytes.byte_count = 1;
  cloud.extra_dimensions.push_back(bytes);
  EXPECT_EQ(error_of(cloud, coloring_by("reflectance")),
            "site.las: the cloud has no attribute \"reflectance\", did you mean \"Reflectance\"?; "
            "expected one of height, normal, "
            "intensity, Reflectance");
  EXPECT_EQ(error_of(cloud, coloring_by("blob")),
            "site.las: the cloud has no attribute \"blob\"; expected one of height, normal, "
            "intensity, Reflectance");
  for (const char* const word : {"rgb", "classification", "gps_time", "return_number", "number_of_returns"})
    EXPECT_TRUE(error_of(cloud, coloring_by(word)).starts_with("site.las: the cloud has no attribute"))
        << word;
}

TEST(ColorPoints, wishes_that_would_change_nothing_are_errors) {
  PointCloud cloud = test::column(2);
  cloud.classifications = {1, 2};
  cloud.colors.assign(2, Color16(9));
  EXPECT_EQ(error_of(cloud, {.by = PointColor::classification, .map = ColorMap::turbo}),
            "site.las: a colour map or range requires a numeric attribute; expected height, intensity, "
            "gps_time or another attribute, found classification");
  EXPECT_NE(error_of(cloud, {.map = ColorMap::turbo}), "no error");  // automatic: rgb
  EXPECT_NE(error_of(cloud, {.by = PointColor::normal, .range = ValueRange{0, 1}}), "no error");
  EXPECT_EQ(error_of(cloud, {.by = PointColor::height, .classes = {{2, Color16(0)}}}),
            "site.las: class colours require classification; found height");
}

TEST(ColorPoints, times_are_printed_with_their_date) {
  PointCloud cloud = test::column(2);
  cloud.gps_times = {346413933.25, 346414033.25};
  cloud.files.resize(1);
  cloud.files[0].format = "LAS";
  cloud.gps_time_is_standard = true;
  const ColorKey standard = colored(cloud, {.by = PointColor::gps_time}).key;
  EXPECT_EQ(title_text(standard), "GPS time (s)");
  EXPECT_EQ(standard.scale->origin, 346413934.0);
  EXPECT_EQ(standard.scale->origin_text, "0 s = 2022-09-05 11:52:14 GPS time");
  cloud.gps_time_is_standard = false;
  EXPECT_EQ(colored(cloud, {.by = PointColor::gps_time}).key.scale->origin_text,
            "0 s = 346413934 s in the file");
  cloud.gps_times = {180000.5, 180000.75};  // no whole second between them
  EXPECT_EQ(colored(cloud, {.by = PointColor::gps_time}).key.scale->origin_text,
            "0 s = Tuesday 02:00:00 of the GPS week");
  cloud.files[0].format = "CSV";
  EXPECT_EQ(colored(cloud, {.by = PointColor::gps_time}).key.scale->origin_text,
            "0 s = 180000 s in the file");
  cloud.gps_times = {-1e200, 1e200};
  EXPECT_EQ(colored(cloud, {.by = PointColor::gps_time}).key.scale->origin_text, "");
}

TEST(ColorKeyTest, notes_and_metadata_contain_range_and_map) {
  ColorKey key{.by = PointColor::height, .word = "height", .title = "Height", .unit = "m"};
  EXPECT_EQ(scale_text(key), "");
  EXPECT_EQ(color_metadata(key).size(), 1u);
  key.scale = ColorScale{.map = ColorMap::terrain,
                         .range = {599.13, 611.2},
                         .extent = {598.0, 623.5},
                         .percentiles = ValueRange{1, 99}};
  EXPECT_EQ(scale_text(key),
            "599.13 to 611.2 m (percentiles 1 to 99; all 598 to 623.5 m), colour map terrain");
  const std::vector<std::pair<std::string, std::string>> expected = {
      {"alidade:color_by", "height"},
      {"alidade:color_map", "terrain"},
      {"alidade:color_range", "599.13 611.20000000000005"}};
  EXPECT_EQ(color_metadata(key), expected);
}

TEST(ColorKeyTest, a_note_counts_times_from_the_moment_it_names_and_metadata_from_that_of_the_file) {
  ColorKey key{.by = PointColor::gps_time, .word = "gps_time", .title = "GPS time", .unit = "s"};
  key.scale = ColorScale{.range = {402000025.75, 402002593.5},
                         .extent = {402000000.0, 402002600.0},
                         .origin = 402000026.0,
                         .origin_text = "0 s = 2024-06-09 20:27:06 GPS time"};
  EXPECT_EQ(scale_text(key),
            "-0.25 to 2567.5 s (all -26 to 2574 s); 0 s = 2024-06-09 20:27:06 GPS time, colour map viridis");
  EXPECT_EQ(color_metadata(key).back().second, "402000025.75 402002593.5");
}

/// A cloud whose points have these values of an extra dimension of 16 bits.
PointCloud with_values(const std::vector<std::uint16_t>& values, const std::string& description) {
  PointCloud cloud = test::column(values.size());
  ExtraDimension column = test::extra<std::uint16_t>("Value", ScalarType::uint16, values);
  column.description = description;
  cloud.extra_dimensions.push_back(column);
  return cloud;
}

TEST(ColorPoints, few_whole_numbers_have_a_colour_each) {
  PointColoring coloring{.by = PointColor::attribute, .attribute = "Value"};
  const ColoredPoints lines = colored(with_values({108, 103, 103, 211}, "flight line"), coloring);
  ASSERT_EQ(lines.key.swatches.size(), 3u);
  EXPECT_FALSE(lines.key.scale);
  EXPECT_EQ(lines.key.swatches[0].number, "103");
  EXPECT_EQ(lines.key.swatches[0].count, 2u);
  EXPECT_EQ(lines.colors[0], distinct_color(108));
  EXPECT_EQ(lines.colors[1], distinct_color(103));
  // Numbers that count up are more or less of something.
  const ColoredPoints counts = colored(with_values({0, 2, 1, 2}, "observers"), coloring);
  ASSERT_EQ(counts.key.swatches.size(), 3u);
  EXPECT_EQ(counts.colors[1], shade(ColorMap::viridis, 1.0));
  EXPECT_EQ(counts.colors[2], shade(ColorMap::viridis, 0.5));
  coloring.range = ValueRange{0.0, 4.0};
  EXPECT_EQ(colored(with_values({0, 2, 1, 2}, "observers"), coloring).colors[1],
            shade(ColorMap::viridis, 0.5));
  coloring.range.reset();
  std::vector<std::uint16_t> many(25);
  for (std::size_t i = 0; i < many.size(); ++i) many[i] = static_cast<std::uint16_t>(10 * i);
  EXPECT_TRUE(colored(with_values(many, "height"), coloring).key.scale);
}

TEST(ColorPoints, masks_name_their_bits_and_many_are_counted) {
  const PointColoring coloring{.by = PointColor::attribute, .attribute = "Value"};
  const ColoredPoints masks =
      colored(with_values({0, 5, 5, 0x8000}, "bit i-1: observer i sees it"), coloring);
  ASSERT_EQ(masks.key.swatches.size(), 3u);
  EXPECT_EQ(masks.key.swatches[0].label, "none");
  EXPECT_EQ(masks.key.swatches[1].label, "1, 3");
  EXPECT_EQ(masks.key.swatches[2].label, "16");
  EXPECT_EQ(masks.key.swatches[1].count, 2u);
  std::vector<std::uint16_t> many(32);
  for (std::size_t i = 0; i < many.size(); ++i) many[i] = static_cast<std::uint16_t>(i);
  const ColoredPoints counted = colored(with_values(many, "bit i-1: observer i sees it"), coloring);
  EXPECT_EQ(counted.key.scale->extent, (ValueRange{0.0, 5.0}));
}

TEST(ColorPoints, a_normal_is_a_colour_of_the_surface_towards_the_viewer) {
  LoadedCloud cloud = test::loaded({{0, 0, 0}}, 0.5);
  cloud.colors.clear();
  cloud.color.by = PointColor::normal;
  Scene scene;
  scene.cloud.emplace();
  const World world(scene, &cloud);
  const auto color_along = [&](const glm::dvec3& eye, const glm::dvec3& direction) {
    const Ray ray = make_ray(eye, direction);
    return world.surface_at(ray, world.nearest(ray, {}).value()).color;
  };
  const auto expect_display = [](const Rgb& found, const glm::dvec3& display) {
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(found[axis], std::min(linear_from_srgb(display[axis]), 0.96), 0.02);
  };
  expect_display(color_along({0, 0, 5}, {0, 0, -1}), {0.5, 0.5, 1.0});
  expect_display(color_along({5, 0, 0}, {-1, 0, 0}), {1.0, 0.5, 0.5});
  expect_display(color_along({0, -5, 0}, {0, 1, 0}), {0.5, 0.0, 0.5});
}

TEST(ColorPoints, a_flat_image_shows_the_colours_of_the_legend) {
  for (const std::size_t number : {2u, 5u, 11u, 13u, 21u}) {
    LoadedCloud cloud = test::loaded({{0, 0, 0}}, 5.0);
    cloud.colors = {class_styles()[number].color};
    Scene scene = test::dark_scene(test::camera_at({0, -20, 0}, {0, 0, 0}, 10.0, 4), 4, 0);
    scene.cloud.emplace();
    scene.render.mode = RenderMode::flat;
    for (const Rgb& color : render(scene, &cloud).color) {
      // An albedo ends at 0.95, which is 249.
      for (int channel = 0; channel < 3; ++channel)
        EXPECT_EQ(srgb_code(color[channel]), std::min(cloud.colors[0][channel] / 257, 249)) << number;
    }
  }
}

/// A folder for files, gone with the test.
}  // namespace
}  // namespace alidade
