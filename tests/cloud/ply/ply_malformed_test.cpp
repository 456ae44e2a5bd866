// SPDX-License-Identifier: MIT
#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/read_alone.h"

namespace alidade::test {
namespace {

PointCloud read_ply(std::string_view text) {
  return read_alone(open_ply, text);
}

std::string ply_error(std::string_view text) {
  return reading_error(open_ply, text);
}

TEST(PlyMalformed, errors_name_file_location_expectation_and_finding) {
  const std::string start = "ply\nformat ascii 1.0\n";
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const auto expect = [](const std::string& text, const char* message) {
    EXPECT_NE(ply_error(text).find(message), std::string::npos) << ply_error(text) << "\nfor\n"
                                                                << text.substr(0, 300);
  };
  expect("plx\n", "memory:byte 0: not a PLY file; expected \"ply\" as the first line, found \"plx\"");
  expect("ply\nformat ascii 2.0\n", "memory:line 2: unsupported PLY format");
  expect("ply\nelement vertex 1\n" + xyz + "end_header\n1 2 3\n", "missing format line");
  expect(start + "element vertex 1\n" + xyz, "memory:line 6: truncated header; expected end_header");
  expect(start + "property float x\n", "memory:line 3: property before the first element");
  expect(start + "element vertex -1\n", "memory:line 3: invalid element line");
  expect(start + "element vertex 99999999999999999999\n", "memory:line 3: invalid element line");
  expect(start + "element vertex 1\nproperty half x\n", "memory:line 4: unsupported property type");
  expect(start + "element vertex 1\nproperty list float int a\n", "memory:line 4: invalid list count type");
  expect(start + "element vertex 1\nproperty x\n", "memory:line 4: invalid property line");
  expect(start + "elephant 1\n", "memory:line 3: unknown header line");
  expect(start + "element face 1\nproperty int a\nend_header\n1\n", "missing points; expected an element");
  expect(start + "element vertex 1\nproperty int x\nelement vertex 1\nend_header\n1\n",
         "duplicate element vertex");
  expect(start + "element vertex 1\nproperty float y\nproperty float z\nend_header\n1 2\n",
         "missing x column");
  expect(start + "element vertex 1\n" + xyz + "property float x\nend_header\n1 2 3 4\n",
         "duplicate column name");
  expect(start + "element vertex 2\n" + xyz + "end_header\n1 2 3\n4 5 six\n",
         "memory:line 9: invalid value; expected a number, found \"six\"");
  expect(start + "element vertex 1\n" + xyz + "end_header\n1 2        \n", "memory:line 8: too few values");
  expect(start + "element vertex 1\n" + xyz + "end_header\n1 2 3 4\n", "memory:line 8: too many values");
  expect(start + "element vertex 3\n" + xyz + "end_header\n1.25 2.25 3.25\n4.25 5.25 6.25\n",
         "truncated file");
  expect(start + "element vertex 1152921504606846976\n" + xyz + "end_header\n1 2 3\n",
         "too short for its vertices; expected 1152921504606846976 vertices, found 1");
  expect(
      "ply\nformat binary_little_endian 1.0\nelement vertex 1152921504606846976\n" + xyz + "end_header\n1234",
      "memory:byte 133: truncated file: too short for its vertices");
  expect(
      "ply\nformat binary_little_endian 1.0\nelement other 1152921504606846976\nproperty double a\n"
      "element vertex 0\n" +
          xyz + "end_header\n1234",
      "too short for its element \"other\"");
  expect(start + "comment " + std::string(10 << 20, 'x') + "\n", "memory:line 3: line too long");
}

TEST(PlyMalformed, more_than_4096_properties_are_an_error_of_their_line) {
  const auto with_properties = [](int count) {
    std::string text = "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\n";
    for (int i = 2; i < count; ++i) text += "property float p" + std::to_string(i) + "\n";
    return text + "end_header\n";
  };
  EXPECT_EQ(ply_error(with_properties(4096)), "");
  const std::string expected = "memory:line 4100: too many columns; expected at most 4096, found 4097";
  EXPECT_EQ(ply_error(with_properties(4097)).substr(0, expected.size()), expected);
}

TEST(PlyMalformed, a_list_with_a_negative_or_impossible_length_is_an_error) {
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement face 1\nproperty list int int a\n"
      "element vertex 1\nproperty char x\nproperty char y\nproperty char z\nend_header\n";
  for (const std::int32_t count : {-1, 1, 0x7fffffff}) {
    std::string text = header;
    append(text, count);
    text += "xyz";
    EXPECT_NE(
        ply_error(text).find("invalid list length of \"a\"; expected 0 to 0, found " + std::to_string(count)),
        std::string::npos)
        << ply_error(text);
  }
  EXPECT_NE(
      ply_error("ply\nformat ascii 1.0\nelement vertex 1\nproperty list int int a\nproperty char x\nproperty "
                "char y\nproperty char z\nend_header\n-1 1 2 3\n")
          .find("line 9: invalid list length"),
      std::string::npos);
}

TEST(PlyMalformed, every_truncation_is_an_error_or_a_clean_read) {
  const std::string ascii =
      "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int i\nelement vertex 2\nproperty float x\n"
      "property list uchar int skipped\nproperty float y\nproperty float z\nproperty int extra\nend_header\n"
      "3 0 1 1\n1.5 2 7 8 2.5 3.5 4\n5.5 0 6.5 7.5 8\n";
  std::string binary =
      "ply\nformat binary_big_endian 1.0\nelement face 1\nproperty list uchar ushort i\nelement vertex 2\n"
      "property char x\nproperty list uchar uchar skipped\nproperty char y\nproperty char z\nend_header\n";
  binary += {1, 0, 9, 1, 2, 7, 7, 2, 3, 4, 0, 5, 6};
  EXPECT_EQ(read_ply(ascii).size(), 2u);
  EXPECT_EQ(read_ply(binary).size(), 2u);
  // Text may lose the end of its last line and, unnoticed, nothing more than the last digit.
  EXPECT_EQ(count_readable_prefixes(open_ply, ascii), 1u);
  EXPECT_EQ(count_readable_prefixes(open_ply, binary), 0u);
}

TEST(PlyMalformed, malformed_files_of_other_projects) {
  const std::filesystem::path no_vertex = shared_data("malformed/no_vertex.ply");
  if (no_vertex.empty()) GTEST_SKIP() << k_no_shared_data;
  const std::string message = error_of([&] { open_ply(InputFile(no_vertex)); });
  EXPECT_NE(message.find("no_vertex.ply:line 3: missing points"), std::string::npos) << message;
  const PointCloud odd = read_alone(open_ply, InputFile(shared_data("malformed/unsized_dims.ply")));
  ASSERT_EQ(odd.size(), 1u);
  EXPECT_EQ(odd.world(0), glm::dvec3(1, 12346, 0));
  EXPECT_EQ(extra_value<double>(odd, "i", 0), 1234567890.0);
  EXPECT_EQ(extra_value<std::int32_t>(odd, "j", 0), 12345);
}

}  // namespace
}  // namespace alidade::test
