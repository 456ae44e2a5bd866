// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/read_alone.h"

namespace alidade::test {
namespace {

PointCloud read_ply(std::string_view text, AttributeSet wanted = AttributeSet::all()) {
  return read_alone(open_ply, text, wanted);
}

/// Appends a value big endian.
template <class Value>
void append_big(std::string& bytes, Value value) {
  std::string each;
  append(each, value);
  std::reverse(each.begin(), each.end());
  bytes += each;
}

TEST(Ply, ascii_with_any_order_of_properties_and_other_elements_before_and_after) {
  const PointCloud cloud = read_ply(
      "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\nobj_info nothing\r\n"
      "element face 2\r\nproperty list uchar int vertex_indices\r\n"
      "element vertex 2\r\nproperty uchar blue\r\nproperty float z\r\nproperty uchar red\r\nproperty double "
      "y\r\n"
      "property uchar green\r\nproperty short x\r\nelement edge 1\r\nproperty int a\r\nend_header\r\n"
      "3 0 1 0\r\n0\r\n"
      "3 0.5 1 2.25 2 -7\r\n\r\n255 -1 0 100000 128 32767\r\n99\r\n");
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.world(0), glm::dvec3(-7, 2.25, 0.5));
  EXPECT_EQ(cloud.world(1), glm::dvec3(32767, 100000, -1));
  EXPECT_EQ(cloud.colors[0], Color16(257, 514, 771));
  EXPECT_EQ(cloud.colors[1], Color16(0, 128 * 257, 65535));
  EXPECT_EQ(cloud.files[0].format, "PLY");
  EXPECT_EQ(cloud.files[0].version, "ascii 1.0");
}

TEST(Ply, every_scalar_type_under_both_names_in_both_byte_orders) {
  const char* const names[][8] = {
      {"char", "uchar", "short", "ushort", "int", "uint", "float", "double"},
      {"int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"}};
  for (const auto& types : names) {
    for (const bool big : {false, true}) {
      std::string text = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                         "_endian 1.0\nelement vertex 1\nproperty " + types[7] + " x\nproperty " + types[4] +
                         " y\nproperty " + types[6] + " z\n";
      for (const char* type : types) text += std::string("property ") + type + " extra_" + type + "\n";
      text += "end_header\n";
      const auto put = [&](auto value) { big ? append_big(text, value) : append(text, value); };
      put(1234567.125);
      put(std::int32_t{-70000});
      put(0.5f);
      put(std::int8_t{-5});
      put(std::uint8_t{250});
      put(std::int16_t{-30000});
      put(std::uint16_t{60000});
      put(std::int32_t{-2000000000});
      put(std::uint32_t{4000000000});
      put(1.1f);
      put(1.1);
      const PointCloud cloud = read_ply(text);
      ASSERT_EQ(cloud.size(), 1u);
      EXPECT_EQ(cloud.world(0).y, -70000.0);
      expect_near(cloud.world(0), {1234567.125, -70000.0, 0.5}, 1e-9);
      const auto name = [&](int index) { return std::string("extra_") + types[index]; };
      EXPECT_EQ(extra_value<std::int8_t>(cloud, name(0), 0), -5);
      EXPECT_EQ(extra_value<std::uint8_t>(cloud, name(1), 0), 250);
      EXPECT_EQ(extra_value<std::int16_t>(cloud, name(2), 0), -30000);
      EXPECT_EQ(extra_value<std::uint16_t>(cloud, name(3), 0), 60000);
      EXPECT_EQ(extra_value<std::int32_t>(cloud, name(4), 0), -2000000000);
      EXPECT_EQ(extra_value<std::uint32_t>(cloud, name(5), 0), 4000000000u);
      EXPECT_EQ(extra_value<float>(cloud, name(6), 0), 1.1f);
      EXPECT_EQ(extra_value<double>(cloud, name(7), 0), 1.1);
    }
  }
}

TEST(Ply, lists_are_skipped_in_vertices_and_in_elements_before_them) {
  std::string text =
      "ply\nformat binary_little_endian 1.0\nelement strip 2\nproperty list int short indices\nproperty "
      "uchar tag\n"
      "element empty 1000000000000\nelement fixed 3\nproperty double a\n"
      "element vertex 2\nproperty float x\nproperty list uchar float weights\nproperty float y\nproperty "
      "float z\n"
      "element face 5\nproperty list uchar int vertex_indices\nend_header\n";
  append(text, std::int32_t{3});
  text.append(6, 'x');
  text += 'T';
  append(text, std::int32_t{0});
  text += 'T';
  text.append(24, 'y');
  for (const float base : {1.0f, 4.0f}) {
    append(text, base);
    append(text, std::uint8_t{2});
    text.append(8, 'w');
    append(text, base + 1);
    append(text, base + 2);
  }
  const PointCloud cloud = read_ply(text);
  ASSERT_EQ(cloud.size(), 2u);
  expect_near(cloud.world(0), {1, 2, 3}, 1e-7);
  expect_near(cloud.world(1), {4, 5, 6}, 1e-7);
  EXPECT_TRUE(cloud.extra_dimensions.empty());
}

TEST(Ply, attributes_are_known_by_the_names_programs_use) {
  const PointCloud cloud = read_ply(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "property float nx\nproperty float ny\nproperty float nz\n"
      "property uchar diffuse_red\nproperty uchar diffuse_green\nproperty uchar diffuse_blue\n"
      "property ushort scalar_Intensity\nproperty float scalar_Classification\nproperty double GpsTime\n"
      "property uchar return_number\nproperty uchar number_of_returns\nproperty ushort nir\n"
      "property float scan_angle\nproperty uchar user_data\nproperty ushort PointSourceId\n"
      "property uchar scan_direction_flag\nproperty uchar edge_of_flight_line\nproperty uchar class_flags\n"
      "property uchar scan_channel\nproperty float scalar_Amplitude\nend_header\n"
      "1 2 3 0 0.6 -0.8 1 2 3 4000 6 12345.678 2 3 50000 -12.5 9 77 1 1 5 2 0.25\n");
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_EQ(cloud.normals[0], glm::vec3(0.0f, 0.6f, -0.8f));
  EXPECT_EQ(cloud.colors[0], Color16(257, 514, 771));
  EXPECT_EQ(cloud.intensities[0], 4000);
  EXPECT_EQ(cloud.classifications[0], 6);
  EXPECT_EQ(cloud.gps_times[0], 12345.678);
  EXPECT_EQ(cloud.returns[0], (ReturnNumbers{2, 3}));
  EXPECT_EQ(cloud.near_infrared[0], 50000);
  EXPECT_EQ(cloud.scan_angles[0], -12.5f);
  EXPECT_EQ(cloud.user_data[0], 9);
  EXPECT_EQ(cloud.point_source_ids[0], 77);
  EXPECT_EQ(cloud.flags[0], 1 << 7 | 1 << 6 | 2 << 4 | 5);
  EXPECT_EQ(extra_value<float>(cloud, "scalar_Amplitude", 0), 0.25f);
  EXPECT_EQ(cloud.extra_dimensions.size(), 1u);
}

TEST(Ply, attributes_that_are_not_wanted_take_no_memory) {
  const PointCloud cloud = read_ply(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty ushort intensity\n"
      "property int other\nend_header\n1 2 3 4 5 6 7 8\n",
      Attribute::intensity);
  EXPECT_EQ(cloud.attributes(), AttributeSet(Attribute::intensity));
  EXPECT_EQ(cloud.intensities[0], 7);
}

std::string colored(const char* type, const char* values) {
  const std::string property = std::string("property ") + type;
  return "ply\nformat ascii 1.0\nelement vertex 2\nproperty int x\nproperty int y\nproperty int z\n" +
         property + " red\n" + property + " green\n" + property + " blue\nend_header\n" + values;
}

TEST(Ply, colours_fill_16_bits_whatever_their_type) {
  EXPECT_EQ(read_ply(colored("uchar", "0 0 0 255 1 0\n0 0 0 0 0 0\n")).colors[0], Color16(65535, 257, 0));
  EXPECT_EQ(read_ply(colored("float", "0 0 0 1 0.5 0\n0 0 0 0 0 0\n")).colors[0], Color16(65535, 32768, 0));
  EXPECT_EQ(read_ply(colored("float", "0 0 0 255 128 0\n0 0 0 1 0 0\n")).colors[1], Color16(257, 0, 0));
  EXPECT_EQ(read_ply(colored("ushort", "0 0 0 65535 128 0\n0 0 0 256 0 0\n")).colors[1], Color16(256, 0, 0));
  const PointCloud assumed = read_ply(colored("ushort", "0 0 0 255 128 0\n0 0 0 1 0 0\n"));
  EXPECT_EQ(assumed.colors[0], Color16(65535, 128 * 257, 0));
  EXPECT_TRUE(warns(assumed, "8-bit"));
}

TEST(Ply, float_intensities_up_to_1_are_stretched_and_negative_ones_start_at_0) {
  const auto intensities = [](const char* values) {
    return read_ply(
               "ply\nformat ascii 1.0\nelement vertex 3\nproperty int x\nproperty int y\nproperty int z\n"
               "property float intensity\nend_header\n" +
               std::string(values))
        .intensities;
  };
  using Values = std::vector<std::uint16_t>;
  EXPECT_EQ(intensities("0 0 0 0\n0 0 0 0.5\n0 0 0 1\n"), (Values{0, 32768, 65535}));
  EXPECT_EQ(intensities("0 0 0 0\n0 0 0 2\n0 0 0 255\n"), (Values{0, 514, 65535}));
  EXPECT_EQ(intensities("0 0 0 0\n0 0 0 2\n0 0 0 4096\n"), (Values{0, 2, 4096}));
  EXPECT_EQ(intensities("0 0 0 -20\n0 0 0 -10\n0 0 0 0\n"), (Values{0, 32768, 65535}));
  EXPECT_EQ(intensities("0 0 0 nan\n0 0 0 0.5\n0 0 0 1\n"), (Values{0, 32768, 65535}));
  EXPECT_EQ(intensities("0 0 0 -3\n0 0 0 -3\n0 0 0 -3\n"), (Values{0, 0, 0}));
  EXPECT_EQ(intensities("0 0 0 -inf\n0 0 0 5\n0 0 0 inf\n").size(), 3u);
}

TEST(Ply, points_that_are_not_finite_are_dropped_and_counted) {
  std::string text =
      "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty "
      "float z\n"
      "property uchar classification\nend_header\n";
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinity = std::numeric_limits<float>::infinity();
  const float rows[4][3] = {{1, 2, 3}, {nan, 2, 3}, {1, -infinity, 3}, {4, 5, 6}};
  for (int i = 0; i < 4; ++i) {
    for (const float value : rows[i]) append(text, value);
    append(text, static_cast<std::uint8_t>(i));
  }
  const PointCloud cloud = read_ply(text);
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.files[0].dropped_count, 2u);
  EXPECT_EQ(cloud.classifications, (std::vector<std::uint8_t>{0, 3}));
  EXPECT_TRUE(warns(cloud, "2 points"));
}

TEST(Ply, float32_coordinates_are_kept_to_less_than_their_own_rounding) {
  std::string text =
      "ply\nformat binary_little_endian 1.0\nelement vertex 200\nproperty float x\nproperty float "
      "y\nproperty float "
      "z\nend_header\n";
  std::vector<glm::vec3> points;
  for (int i = 0; i < 200; ++i) {
    points.emplace_back(690000.0f + 0.0625f * static_cast<float>(i),
                        5325000.0f + 0.5f * static_cast<float>(i), 1.0f / static_cast<float>(i + 1));
    for (int axis = 0; axis < 3; ++axis) append(text, points.back()[axis]);
  }
  const PointCloud cloud = read_ply(text);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(cloud.world(i).x, points[i].x, 0.03125);
    EXPECT_NEAR(cloud.world(i).y, points[i].y, 0.25);
    EXPECT_NEAR(cloud.world(i).z, points[i].z, 6e-8);
  }
}

TEST(Ply, coarse_float32_coordinates_are_a_warning_with_their_steps) {
  const auto read = [](const char* type, double east, double north) {
    std::string text = std::string("ply\nformat binary_little_endian 1.0\nelement vertex 1000\nproperty ") +
                       type + " x\nproperty " + type + " y\nproperty " + type + " z\nend_header\n";
    for (int i = 0; i < 1000; ++i) {
      for (const double value : {east + 0.1 * i, north + 0.1 * (i * 7 % 1000), 0.01 * i}) {
        if (std::string(type) == "float") append(text, static_cast<float>(value));
        if (std::string(type) == "double") append(text, value);
        if (std::string(type) == "int") append(text, static_cast<std::int32_t>(value));
      }
    }
    return read_ply(text);
  };
  EXPECT_TRUE(warns(read("float", 500000, 5000000), "rounded here: y in steps of 0.5"));
  EXPECT_TRUE(warns(read("float", 1500000, 9000000), "x in steps of 0.125, y in steps of 1"));
  EXPECT_FALSE(warns(read("float", 0, 0), "float32"));
  EXPECT_FALSE(warns(read("float", 500, 5000), "float32"));
  EXPECT_FALSE(warns(read("double", 500000, 5000000), "float32"));
  EXPECT_FALSE(warns(read("int", 690000, 9000000), "float32"));
  // One point has no spacing.
  std::string single =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float "
      "y\nend_header\n";
  append(single, 500000.0f);
  append(single, 5000000.0f);
  EXPECT_FALSE(warns(read_ply(single), "float32"));
}

TEST(Ply, gaussian_splats_have_the_colour_of_their_constant) {
  std::string text = "ply\nformat binary_little_endian 1.0\nelement vertex 3\n";
  for (const char* name :
       {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "f_rest_0", "opacity", "scale_0", "rot_0"})
    text += std::string("property float ") + name + "\n";
  text += "end_header\n";
  constexpr float k_half = 1.7724538509f;  // 0.5 / 0.28209479177387814
  for (int i = 0; i < 3; ++i) {
    for (const float value : {1.0f * static_cast<float>(i), 2.0f, 3.0f, static_cast<float>(i - 1) * k_half,
                              0.0f, 100.0f, 0.5f, 0.5f, 0.5f, 0.5f})
      append(text, value);
  }
  const PointCloud cloud = read_ply(text);
  ASSERT_EQ(cloud.colors.size(), 3u);
  EXPECT_EQ(cloud.colors[0], Color16(0, 32768, 65535));
  EXPECT_EQ(cloud.colors[1], Color16(32768, 32768, 65535));
  EXPECT_EQ(cloud.colors[2], Color16(65535, 32768, 65535));
  EXPECT_TRUE(warns(cloud, "opacity, scales and rotations are not used"));
  EXPECT_FALSE(warns(cloud, "colours range"));
  EXPECT_EQ(cloud.extra_dimensions.size(), 4u);
  // Colours of the file's own come first, and two of three make no colour.
  EXPECT_FALSE(warns(
      read_ply(
          "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
          "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float f_dc_0\n"
          "property float f_dc_1\nproperty float f_dc_2\nend_header\n1 2 3 4 5 6 0 0 0\n"),
      "splats"));
  EXPECT_TRUE(
      read_ply(
          "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
          "property float f_dc_0\nproperty float f_dc_1\nend_header\n1 2 3 0 0\n")
          .colors.empty());
}

TEST(Ply, names_of_cloudcompare_are_those_of_attributes) {
  const PointCloud cloud = read_ply(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float "
      "z\nproperty float "
      "scalar_intensity\nproperty float scalar_Classification\nproperty float scalar_Return_Number\nproperty "
      "float "
      "scalar_Number_Of_Returns\nproperty float scalar_Gps_Time\nproperty float "
      "scalar_Scan_Angle_Rank\nproperty float "
      "scalar_Point_Source_ID\nproperty float scalar_C2C_absolute_distances\nend_header\n1 2 3 1000 6 1 2 "
      "500.5 -10 7 0.25\n");
  EXPECT_EQ(cloud.intensities, std::vector<std::uint16_t>{1000});
  EXPECT_EQ(cloud.classifications, std::vector<std::uint8_t>{6});
  EXPECT_EQ(cloud.returns.at(0), (ReturnNumbers{1, 2}));
  EXPECT_EQ(cloud.gps_times, std::vector<double>{500.5});
  EXPECT_EQ(cloud.scan_angles, std::vector<float>{-10});
  EXPECT_EQ(cloud.point_source_ids, std::vector<std::uint16_t>{7});
  EXPECT_EQ(cloud.extra_dimensions.size(), 1u);
}

TEST(Ply, binary_data_that_were_transferred_as_text_are_an_error) {
  const auto as_text = [](const std::string& bytes) {
    std::string text;
    for (const char byte : bytes) text += byte == '\n' ? std::string("\r\n") : std::string(1, byte);
    return text;
  };
  for (const bool has_faces : {false, true}) {
    std::string text =
        "ply\nformat binary_little_endian 1.0\nelement vertex 1000\nproperty float x\nproperty float "
        "y\nproperty float z\n";
    if (has_faces) text += "element face 1\nproperty list uchar int vertex_indices\n";
    text += "end_header\n";
    for (int i = 0; i < 3000; ++i) append(text, 10.0f + static_cast<float>(i) * 0.37f);
    if (has_faces) text += std::string("\1\0\0\0\0", 5);
    EXPECT_EQ(read_ply(text).size(), 1000u);
    const std::string message = reading_error(open_ply, as_text(text));
    EXPECT_NE(message.find("the binary data were changed by a transfer as text"), std::string::npos)
        << message;
  }
}

TEST(Ply, a_column_of_carriage_returns_and_line_feeds_is_a_column) {
  for (const bool has_faces : {false, true}) {
    std::string text =
        "ply\nformat binary_little_endian 1.0\nelement vertex 6\nproperty float x\nproperty float "
        "y\nproperty float z\nproperty ushort intensity\n";
    if (has_faces) text += "element face 1\nproperty list uchar int vertex_indices\n";
    text += "end_header\n";
    for (int i = 0; i < 6; ++i) {
      for (int axis = 0; axis < 3; ++axis) append(text, static_cast<float>(i));
      text += "\r\n";
    }
    text += has_faces ? std::string("\1\0\0\0\0", 5) : std::string(3, '\0');
    EXPECT_EQ(read_ply(text).intensities, std::vector<std::uint16_t>(6, 0x0a0d));
  }
}

TEST(Ply, a_file_without_points_or_without_z_reads) {
  const PointCloud empty = read_ply(
      "ply\nformat binary_little_endian 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty "
      "float z\n"
      "end_header\n");
  EXPECT_EQ(empty.size(), 0u);
  const PointCloud flat = read_ply(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float y\nproperty float x\nend_header\n1 2\n");
  EXPECT_EQ(flat.world(0), glm::dvec3(2, 1, 0));
  EXPECT_TRUE(warns(flat, "no z"));
}

TEST(Ply, reads_files_of_other_programs) {
  const std::filesystem::path ascii_path = shared_data("ply/platonic_shelf_ascii.ply");
  if (ascii_path.empty()) GTEST_SKIP() << k_no_shared_data;
  const PointCloud ascii = read_alone(open_ply, InputFile(ascii_path));
  const PointCloud big = read_alone(open_ply, InputFile(shared_data("ply/platonic_shelf_big_endian.ply")));
  ASSERT_EQ(ascii.size(), 50u);
  ASSERT_EQ(big.size(), 50u);
  for (std::size_t i = 0; i < 50; ++i) expect_near(ascii.world(i), big.world(i), 1e-5);
  expect_near(ascii.bounds().min, {-6.524307, -1.158087, -1.158087}, 1e-12);
  expect_near(ascii.bounds().max, {6.963232, 1.158087, 1.158086}, 1e-12);

  const PointCloud scan = read_alone(open_ply, InputFile(shared_data("ply/small_gicp_source.ply")));
  ASSERT_EQ(scan.size(), 69792u);
  expect_near(scan.bounds().min, {-23.75901985168457, -52.00114059448242, -3.021289825439453}, 2e-6);
  expect_near(scan.bounds().max, {18.47993278503418, 6.507869243621826, 9.172804832458496}, 2e-6);
  std::uint64_t sum = 0;
  for (const std::uint16_t intensity : scan.intensities) sum += intensity;
  EXPECT_EQ(sum, 2134792u * 257u);

  const PointCloud colored_cloud = read_alone(open_ply, InputFile(shared_data("scene_sceaux/Sparse.ply")));
  ASSERT_EQ(colored_cloud.size(), 12683u);
  glm::u64vec3 color_sum(0);
  for (const Color16& color : colored_cloud.colors) color_sum += glm::u64vec3(color);
  EXPECT_EQ(color_sum, glm::u64vec3(1271762, 1284867, 1311483) * std::uint64_t{257});
}

}  // namespace
}  // namespace alidade::test
