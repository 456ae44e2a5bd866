// SPDX-License-Identifier: MIT
#include <bit>
#include <cmath>
#include <limits>

#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/read_alone.h"

namespace alidade::test {
namespace {

PointCloud read_pcd(std::string_view text) {
  return read_alone(open_pcd, text);
}

std::string pcd_error(std::string_view text) {
  return reading_error(open_pcd, text);
}

std::string header(const std::string& fields, const std::string& sizes, const std::string& types,
                   const std::string& counts, const std::string& width, const std::string& data) {
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS " + fields + "\nSIZE " + sizes +
         "\nTYPE " + types + "\nCOUNT " + counts + "\nWIDTH " + width +
         "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + width + "\nDATA " + data + "\n";
}

std::string xyz_header(const std::string& width, const std::string& data) {
  return header("x y z", "4 4 4", "F F F", "1 1 1", width, data);
}

std::string repeated(const std::string& text, int count) {
  std::string result;
  for (int i = 0; i < count; ++i) result += text;
  return result;
}

/// LZF of literals only: valid, if no smaller than its input.
std::string stored_lzf(std::string_view bytes) {
  std::string packed;
  for (; !bytes.empty(); bytes.remove_prefix(std::min<std::size_t>(32, bytes.size()))) {
    const std::string_view run = bytes.substr(0, 32);
    packed += static_cast<char>(run.size() - 1);
    packed += run;
  }
  return packed;
}

std::string compressed(std::string_view packed, std::size_t unpacked_size) {
  std::string bytes;
  append(bytes, static_cast<std::uint32_t>(packed.size()));
  append(bytes, static_cast<std::uint32_t>(unpacked_size));
  return bytes.append(packed);
}

TEST(Pcd, ascii_with_fields_of_any_type) {
  const PointCloud cloud =
      read_pcd(header("normal_x y curvature x normal_y intensity normal_z z label", "4 8 4 4 4 4 4 2 4",
                      "F F F F F F F I U", "1 1 1 1 1 1 1 1 1", "2", "ascii") +
               "0 2.5 0.125 1.5 0.6 100 -0.8 -3 7\n\n1 5325000.25 0 4.5 0 200.5 0 6 4000000000\n");
  ASSERT_EQ(cloud.size(), 2u);
  expect_near(cloud.world(0), {1.5, 2.5, -3}, 1e-9);
  expect_near(cloud.world(1), {4.5, 5325000.25, 6}, 1e-9);
  EXPECT_EQ(cloud.normals[0], glm::vec3(0.0f, 0.6f, -0.8f));
  EXPECT_EQ(cloud.intensities[0], 25700);
  EXPECT_EQ(extra_value<float>(cloud, "curvature", 0), 0.125f);
  EXPECT_EQ(extra_value<std::uint32_t>(cloud, "label", 1), 4000000000u);
  EXPECT_EQ(cloud.files[0].format, "PCD");
  EXPECT_EQ(cloud.files[0].version, "0.7");
}

TEST(Pcd, binary_with_padding_wide_fields_and_64_bit_integers) {
  std::string text =
      header("_ x y z histogram stamp _", "1 4 4 4 4 8 1", "U F F F F U U", "3 1 1 1 2 1 5", "2", "binary");
  for (const float base : {1.0f, 10.0f}) {
    text += "pad";
    append(text, base);
    append(text, base + 1);
    append(text, base + 2);
    append(text, 0.5f);
    append(text, 0.5f);
    append(text, std::uint64_t{1663000000123456789} + static_cast<std::uint64_t>(base));
    text += "56789";
  }
  const PointCloud cloud = read_pcd(text);
  ASSERT_EQ(cloud.size(), 2u);
  expect_near(cloud.world(1), {10, 11, 12}, 1e-6);
  EXPECT_EQ(extra_value<std::uint64_t>(cloud, "stamp", 0), 1663000000123456790u);
  EXPECT_EQ(cloud.extra_dimensions.size(), 1u);
  EXPECT_TRUE(warns(cloud, "histogram"));
}

TEST(Pcd, packed_colours_as_float_bits_or_integers) {
  // Opaque red as a float is a NaN: its bits must come through unharmed.
  const std::uint32_t red = 0xffff8001;
  for (const char* name : {"rgb", "rgba"}) {
    for (const char* type : {"F", "U", "I"}) {
      std::string text = header(std::string("x y z ") + name, "4 4 4 4", std::string("F F F ") + type,
                                "1 1 1 1", "1", "binary");
      for (int i = 0; i < 3; ++i) append(text, 1.0f);
      append(text, red);
      const PointCloud cloud = read_pcd(text);
      EXPECT_EQ(cloud.colors.at(0), Color16(65535, 128 * 257, 257));
      EXPECT_TRUE(cloud.extra_dimensions.empty());
    }
  }
  const auto color_of = [](const char* type, const char* word) {
    return read_pcd(header("x y z rgb", "4 4 4 4", std::string("F F F ") + type, "1 1 1 1", "1", "ascii") +
                    "1 2 3 " + word + "\n")
        .colors.at(0);
  };
  EXPECT_EQ(color_of("U", "4294934529"), Color16(65535, 128 * 257, 257));
  EXPECT_EQ(color_of("I", "-32767"), Color16(65535, 128 * 257, 257));
  EXPECT_EQ(color_of("U", "nan"), Color16(0));
  EXPECT_EQ(color_of("F", "2.3418052e-38"), Color16(65535, 0, 0));  // the float with the bits 0x00ff0000
  EXPECT_EQ(color_of("F", "4210752"), Color16(64 * 257));
  EXPECT_EQ(color_of("F", "nan"), Color16(0));
}

TEST(Pcd, packed_colours_in_text_are_floats_if_any_is_written_as_one) {
  const auto colors_of = [](const std::string& rows) {
    return read_pcd(header("x y z rgb", "4 4 4 4", "F F F F", "1 1 1 1", "2", "ascii") + rows).colors;
  };
  // As PCL's own tutorial: a float of the size of a colour, whose bits are the colour.
  EXPECT_EQ(colors_of("1 2 3 4.2108e+06\n1 2 4 4.808e+06\n"),
            (std::vector<Color16>{Color16(128, 128, 224) * std::uint16_t{257},
                                  Color16(146, 186, 128) * std::uint16_t{257}}));
  // One of few digits is written like a whole number; what the others are decides, before it or behind.
  const auto color = [](float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    return Color16(bits >> 16 & 255, bits >> 8 & 255, bits & 255) * std::uint16_t{257};
  };
  EXPECT_EQ(colors_of("1 2 3 524289\n1 2 4 1.5e-38\n"),
            (std::vector<Color16>{color(524289.0f), color(1.5e-38f)}));
  EXPECT_EQ(colors_of("1 2 3 4210752\n1 2 4 255\n"),
            (std::vector<Color16>{Color16(64 * 257), Color16(0, 0, 65535)}));
}

/// As a program does that copies a file as text from Unix to Windows.
std::string with_carriage_returns(const std::string& bytes) {
  std::string text;
  for (const char byte : bytes) {
    if (byte == '\n') text += '\r';
    text += byte;
  }
  return text;
}

TEST(Pcd, binary_data_that_were_transferred_as_text_are_an_error) {
  std::string text = xyz_header("100", "binary");
  for (int i = 0; i < 300; ++i) append(text, 10.0f + static_cast<float>(i) * 0.37f);
  ASSERT_NE(text.find('\n', xyz_header("100", "binary").size()), std::string::npos)
      << "or the test tests nothing";
  EXPECT_EQ(pcd_error(text), "");
  const std::string message = pcd_error(with_carriage_returns(text));
  EXPECT_NE(message.find("the binary data were changed by a transfer as text"), std::string::npos) << message;
  EXPECT_EQ(message.find("--partial"), std::string::npos) << "which would give wrong points: " << message;
  EXPECT_EQ(error_of([&] {
              const std::string damaged = with_carriage_returns(text);
              read_memory(std::as_bytes(std::span(damaged)), {.partial = true, .region = {}});
            }),
            message);
  // Other bytes behind the points are none of ours, but are not passed over in silence.
  EXPECT_TRUE(warns(read_pcd(text + "\n"), "1 bytes behind the last point were not read"));
  EXPECT_TRUE(warns(read_pcd(text + "\r\n"), "2 bytes behind the last point were not read"));
  EXPECT_FALSE(warns(read_pcd(text), "behind the last point"));
}

TEST(Pcd, points_that_are_not_finite_are_dropped_and_counted) {
  const PointCloud cloud = read_pcd(xyz_header("3", "ascii") + "nan nan nan\n1 2 3\n1 inf 3\n");
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_EQ(cloud.files[0].dropped_count, 2u);
}

TEST(Pcd, compressed_points_are_stored_field_by_field) {
  std::string fields;
  for (const float x : {1.0f, 2.0f}) append(fields, x);
  for (const double y : {3.0, 4.0}) append(fields, y);
  for (const std::int16_t z : {std::int16_t{5}, std::int16_t{-6}}) append(fields, z);
  const std::string text = header("x y z", "4 8 2", "F F I", "1 1 1", "2", "binary_compressed");
  const PointCloud cloud = read_pcd(text + compressed(stored_lzf(fields), fields.size()));
  ASSERT_EQ(cloud.size(), 2u);
  expect_near(cloud.world(0), {1, 3, 5}, 1e-6);
  expect_near(cloud.world(1), {2, 4, -6}, 1e-6);
}

TEST(Pcd, sizes_of_compressed_points_that_lie_are_errors) {
  const std::string start = xyz_header("2", "binary_compressed");
  const std::string packed = stored_lzf(std::string(24, 'a'));
  const auto expect = [&](const std::string& data, const char* message) {
    EXPECT_NE(pcd_error(start + data).find(message), std::string::npos) << pcd_error(start + data);
  };
  EXPECT_EQ(pcd_error(start + compressed(packed, 24)), "");
  expect(compressed(packed, 12),
         "wrong size of the uncompressed points; expected 2 points of 12 bytes, found 12 bytes");
  expect(compressed(packed, 25), "wrong size of the uncompressed points");
  expect(compressed(packed, 24).substr(0, 20), "truncated compressed points");
  expect(compressed(packed.substr(0, 20), 24), "corrupt compressed points");
  expect("1234", "truncated file");
  const std::string many = xyz_header("100000000", "binary_compressed");
  EXPECT_NE(pcd_error(many + compressed(packed, 1200000000)).find("too few compressed bytes for the points"),
            std::string::npos);
}

TEST(Pcd, a_file_without_points_reads) {
  EXPECT_EQ(read_pcd(xyz_header("0", "ascii")).size(), 0u);
  EXPECT_EQ(read_pcd(xyz_header("0", "binary")).size(), 0u);
  EXPECT_EQ(read_pcd(xyz_header("0", "binary_compressed")).size(), 0u);
}

TEST(Pcd, headers_without_count_or_width_read) {
  EXPECT_EQ(read_pcd("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 1\nDATA ascii\n1 2 3\n").size(), 1u);
  EXPECT_EQ(
      read_pcd("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 2\nDATA ascii\n1 2 3\n4 5 6").size(),
      2u);
}

TEST(Pcd, errors_name_file_location_expectation_and_finding) {
  const auto expect = [](const std::string& text, const char* message) {
    EXPECT_NE(pcd_error(text).find(message), std::string::npos) << pcd_error(text) << "\nfor\n"
                                                                << text.substr(0, 300);
  };
  expect("289814.15 4320978.61 170.76\n", "memory:line 1: unknown header line; expected VERSION");
  expect("FIELDS x y z\nSIZE 4 4\n",
         "memory:line 2: wrong number of values; expected 3, one per field, found 2");
  expect("FIELDS x y z\nSIZE 4 4 four\n", "memory:line 2: invalid value; expected an integer");
  expect("FIELDS x y z\nTYPE F F\n",
         "memory:line 2: wrong number of types; expected 3, one per field, found 2");
  expect("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\n", "memory:line 4: truncated header");
  expect("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nDATA ascii\n", "missing number of points");
  expect("SIZE\nTYPE\nWIDTH 1\nDATA ascii\n", "missing FIELDS");
  expect("FIELDS x y z\nTYPE F F F\nWIDTH 1\nDATA ascii\n", "missing SIZE");
  expect("FIELDS x y z\nSIZE 4 4 4\nWIDTH 1\nDATA ascii\n", "missing TYPE");
  expect("FIELDS x y z\nSIZE 4 4 3\nTYPE F F F\nWIDTH 1\nDATA ascii\n",
         "unsupported type of the field \"z\"");
  expect("FIELDS x y z\nSIZE 4 4 4\nTYPE F F Q\nWIDTH 1\nDATA ascii\n",
         "unsupported type of the field \"z\"");
  expect(header("x y z a", "4 4 4 8", "F F F F", "1 1 1 18446744073709551615", "1", "binary"),
         "field too long");
  expect(xyz_header("1", "binary_packed"), "unsupported data type");
  expect(xyz_header("1152921504606846976", "ascii") + "1 2 3\n", "too short for its points");
  expect(xyz_header("1152921504606846976", "binary") + "1 2 3\n", "too short for its points");
  expect("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 4294967296\nHEIGHT 4294967297\nDATA ascii\n",
         "WIDTH times HEIGHT exceeds 64 bits");
  expect("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nHEIGHT 2\nPOINTS 5\nDATA ascii\n",
         "POINTS is not WIDTH times");
  expect("FIELDS x x z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 0\nDATA ascii\n", "duplicate column name");
  expect("FIELDS a y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 0\nDATA ascii\n", "missing x column");
  expect(xyz_header("2", "ascii") + "1 2 3\n4 5 zz\n",
         "memory:line 13: invalid value; expected a number, found \"zz\"");
  expect(xyz_header("2", "ascii") + "1 2 3\n4 5         \n", "memory:line 13: wrong number of values");
  expect(xyz_header("2", "ascii") + "1.25 2.25 3.25\n", "truncated file; expected 2 points, found 1");
  expect("# .PCD\nVIEWPOINT 0 0 zero\n", "memory:line 2: invalid viewpoint; expected numbers");
  expect(std::string(10 << 20, 'x'), "memory:line 1: line too long");
}

TEST(Pcd, more_than_4096_fields_are_an_error_of_their_line) {
  const auto with_fields = [](int count) {
    return header("x y z" + repeated(" _", count - 3), "4 4 4" + repeated(" 1", count - 3),
                  "F F F" + repeated(" U", count - 3), "1 1 1" + repeated(" 1", count - 3), "0", "binary");
  };
  EXPECT_EQ(pcd_error(with_fields(4096)), "");
  const std::string expected = "memory:line 3: too many columns; expected at most 4096, found 4097";
  EXPECT_EQ(pcd_error(with_fields(4097)).substr(0, expected.size()), expected);
}

TEST(Pcd, only_the_first_packed_colour_is_the_colour) {
  const PointCloud cloud = read_pcd(
      header("x y z rgba rgb", "4 4 4 4 4", "F F F U U", "1 1 1 1 1", "1", "ascii") + "1 2 3 255 256\n");
  EXPECT_EQ(cloud.colors[0], Color16(0, 0, 65535));
  EXPECT_EQ(extra_value<std::uint32_t>(cloud, "rgb", 0), 256u);
}

TEST(Pcd, every_truncation_is_an_error_or_a_clean_read) {
  std::string binary = xyz_header("2", "binary");
  for (const float value : {1, 2, 3, 4, 5, 6}) append(binary, value);
  const std::string packed_header = xyz_header("2", "binary_compressed");
  const std::string packed = packed_header + compressed(stored_lzf(std::string(24, 'a')), 24);
  const std::string ascii = xyz_header("2", "ascii") + "1 2 3\n4 5 6\n";
  for (const std::string& sample : {binary, packed, ascii}) EXPECT_EQ(read_pcd(sample).size(), 2u);
  EXPECT_EQ(count_readable_prefixes(open_pcd, binary), 0u);
  EXPECT_EQ(count_readable_prefixes(open_pcd, packed), 0u);
  // Only the line end after the last number can go unnoticed.
  EXPECT_EQ(count_readable_prefixes(open_pcd, ascii), 1u);
}

std::string organised_header(int width, int height, const std::string& viewpoint) {
  return "VERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nWIDTH " + std::to_string(width) + "\nHEIGHT " +
         std::to_string(height) + "\n" + (viewpoint.empty() ? "" : "VIEWPOINT " + viewpoint + "\n") +
         "DATA ascii\n";
}

/// Points on the rays of the pixels of a camera of 8 x 6 pixels, the first two of them unmeasured.
/// `in_axes(right, down, forward)` puts them into the axes of the file.
template <class InAxes>
std::string frame(const std::string& viewpoint, const InAxes& in_axes) {
  std::string text = organised_header(8, 6, viewpoint) + "nan nan nan\n";
  for (int cell = 1; cell < 48; ++cell) {
    const double depth = cell == 1 ? 0.0 : 2.0 + 0.3 * (cell % 5);
    const glm::dvec3 point = in_axes(depth * (cell % 8 - 3.1) / 7.0, depth * (cell / 8 - 2.4) / 7.0, depth);
    text += std::to_string(point.x) + " " + std::to_string(point.y) + " " + std::to_string(point.z) + "\n";
  }
  return text;
}

glm::dvec3 as_seen(double right, double down, double forward) {
  return {right, down, forward};
}

TEST(Pcd, a_grid_on_the_rays_of_pixels_is_the_frame_of_a_depth_camera_at_the_origin) {
  for (const char* const viewpoint : {"", "0 0 0 1 0 0 0", "0 0 0 0 1 0 0", "5 6 7 0.5 0.5 0.5 0.5"}) {
    const PointCloud cloud = read_pcd(frame(viewpoint, as_seen));
    ASSERT_EQ(cloud.scanner_positions.size(), 1u) << viewpoint;
    const ScannerPosition& camera = cloud.scanner_positions[0];
    EXPECT_EQ(camera.position, glm::dvec3(0.0));
    EXPECT_EQ(camera.axes, (DepthCameraAxes{.forward = {0, 0, 1}, .down = {0, 1, 0}}));
  }
}

TEST(Pcd, or_at_the_viewpoint_whose_quaternion_may_have_any_length) {
  // A third of a turn about (1, 1, 1): right is y, down is z, forward is x.
  const auto placed = [](double right, double down, double forward) {
    return glm::dvec3(5, 6, 7) + glm::dvec3(forward, right, down);
  };
  for (const char* const viewpoint :
       {"5 6 7 0.5 0.5 0.5 0.5", "5 6 7 30 30 30 30", "5 6 7 -1e-9 -1e-9 -1e-9 -1e-9"}) {
    const PointCloud cloud = read_pcd(frame(viewpoint, placed));
    ASSERT_EQ(cloud.scanner_positions.size(), 1u) << viewpoint;
    EXPECT_EQ(cloud.scanner_positions[0].position, glm::dvec3(5, 6, 7));
    ASSERT_TRUE(cloud.scanner_positions[0].axes) << viewpoint;
    expect_near(cloud.scanner_positions[0].axes->forward, {1, 0, 0}, 1e-14);
    expect_near(cloud.scanner_positions[0].axes->down, {0, 0, 1}, 1e-14);
  }
}

TEST(Pcd, other_grids_have_no_camera_and_the_position_of_their_viewpoint_unless_it_is_the_origin) {
  // A scanner that turns about z, and a height map.
  const auto ring = [](double right, double down, double depth) {
    return glm::dvec3(depth * std::cos(8.0 * right), depth * std::sin(8.0 * right), -down);
  };
  const auto map = [](double right, double down, double depth) {
    return glm::dvec3(10.0 * right / depth, 10.0 * down / depth, 5.0 + 0.1 * depth);
  };
  for (const std::string& file : {frame("5 6 7 1 0 0 0", ring), frame("5 6 7 1 0 0 0", map)}) {
    const PointCloud cloud = read_pcd(file);
    EXPECT_EQ(cloud.scanner_positions, (std::vector<ScannerPosition>{{"", {5, 6, 7}, {}}}));
  }
  EXPECT_TRUE(read_pcd(frame("0 0 0 0 1 0 0", ring)).scanner_positions.empty());
  EXPECT_TRUE(read_pcd(frame("", ring)).scanner_positions.empty());
  EXPECT_TRUE(read_pcd(xyz_header("1", "ascii") + "1 2 3\n").scanner_positions.empty());
}

TEST(Pcd, an_impossible_viewpoint_is_ignored_with_a_warning) {
  for (const char* const viewpoint :
       {"5 6 nan 1 0 0 0", "5 6 7 1 0 0", "5 6 7 1 0 0 0 0", "5 6 7 0 0 0 0", "5 6 7 nan 0 0 0",
        "5 6 7 inf 0 0 0", "5 6 7 1e-200 0 0 0", "5 6 7 1e300 1e300 0 0", "1e999 6 7 1 0 0 0"}) {
    const PointCloud cloud = read_pcd(organised_header(2, 1, viewpoint) + "1 2 3\n4 5 6\n");
    EXPECT_EQ(cloud.size(), 2u);
    EXPECT_TRUE(cloud.scanner_positions.empty()) << viewpoint;
    EXPECT_TRUE(warns(cloud, "VIEWPOINT")) << viewpoint;
  }
  EXPECT_FALSE(warns(read_pcd(organised_header(1, 1, "5 6 7 1 0 0 0") + "1 2 3\n"), "VIEWPOINT"));
}

TEST(Pcd, reads_files_of_other_programs) {
  const std::filesystem::path organised_path = shared_data("pcd/region_growing_rgb_tutorial.pcd");
  if (organised_path.empty()) GTEST_SKIP() << k_no_shared_data;
  const PointCloud organised = read_alone(open_pcd, InputFile(organised_path));
  ASSERT_EQ(organised.size(), 259847u);
  EXPECT_EQ(organised.files[0].dropped_count, 47353u);
  expect_near(organised.bounds().min, {-1.0720570087432861, -1.5806399583816528, 0.8430001139640808}, 1.2e-7);
  expect_near(organised.bounds().max, {1.8101530075073242, 0.4080914855003357, 3.821000099182129}, 1.2e-7);
  glm::u64vec3 color_sum(0);
  for (const Color16& color : organised.colors) color_sum += glm::u64vec3(color);
  EXPECT_EQ(color_sum, glm::u64vec3(41468041, 36508734, 34265005) * std::uint64_t{257});
  EXPECT_EQ(organised.colors.front(), Color16(147, 128, 96) * std::uint16_t{257});
  EXPECT_EQ(organised.colors.back(), Color16(179, 160, 149) * std::uint16_t{257});
  ASSERT_EQ(organised.scanner_positions.size(), 1u);
  EXPECT_TRUE(organised.scanner_positions[0].axes);

  const PointCloud binary = read_alone(open_pcd, InputFile(shared_data("pcd/Zaghetto.pcd")));
  ASSERT_EQ(binary.size(), 59750u);
  expect_near(binary.bounds().max, {0.7284700274467468, 0.8388699889183044, 0.6972500085830688}, 3e-8);

  const PointCloud ascii = read_alone(open_pcd, InputFile(shared_data("pcd/lamppost.pcd")));
  ASSERT_EQ(ascii.size(), 1771u);
  expect_near(ascii.bounds().min, {-11.171875, -0.375, -5.447998}, 1e-9);

  const PointCloud utm = read_alone(open_pcd, InputFile(shared_data("pcd/FSite8_red2-utm.pcd")));
  ASSERT_EQ(utm.size(), 21714u);
  EXPECT_NEAR(utm.world(0).x, 499471.625, 0.015625);
  EXPECT_NEAR(utm.world(0).y, 5418405.5, 0.25);
  EXPECT_NEAR(utm.world(0).z, 251.1199951171875, 1.6e-5);
  EXPECT_NEAR(utm.bounds().max.x, 500549.40625, 0.015625);
  EXPECT_NEAR(utm.bounds().max.z, 319.5199890136719, 1.6e-5);
}

TEST(Pcd, a_file_without_header_is_not_pcd) {
  const std::filesystem::path path = shared_data("malformed/missingheader.pcd");
  if (path.empty()) GTEST_SKIP() << k_no_shared_data;
  const std::string message = error_of([&] { open_pcd(InputFile(path)); });
  EXPECT_NE(message.find("missingheader.pcd:line 1: unknown header line"), std::string::npos) << message;
  EXPECT_EQ(read_alone(open_text, InputFile(path)).size(), 10u);
}

}  // namespace
}  // namespace alidade::test
