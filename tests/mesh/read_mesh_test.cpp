// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include "base/error.h"
#include "mesh/triangle_mesh.h"

namespace alidade::test {
namespace {

class ReadMeshTest : public ::testing::Test {
 protected:
  ReadMeshTest() { std::filesystem::create_directories(folder_); }
  ~ReadMeshTest() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }
  TriangleMesh read(const std::string& name, const std::string& content,
                    const MeshPlacement& placement = {}) const {
    return read_mesh(write(name, content), placement);
  }
  std::string error(const std::string& name, const std::string& content) const {
    try {
      read(name, content);
    } catch (const Error& error) {
      std::string text = error.what();
      const std::size_t begin = text.find(name);
      return begin == std::string::npos ? text : text.substr(begin);
    }
    return "no error";
  }

  const std::filesystem::path folder_ = std::filesystem::path(::testing::TempDir()) / "read_mesh_test";
};

const std::string k_head =
    "element vertex 4\nproperty float x\nproperty double y\nproperty short z\n"
    "element edge 1\nproperty list uchar int ends\n"
    "element face 2\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    "property list uchar int vertex_indices\nend_header\n";

template <class T>
void append(std::string& text, T value, bool big) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  if (big) std::reverse(bytes, bytes + sizeof(T));
  text.append(bytes, sizeof(T));
}

std::string ply_text(bool is_binary, bool big) {
  std::string text = "ply\nformat ";
  if (!is_binary) {
    return text + "ascii 1.0\n" + k_head +
           "0 0 1\n2 0 1\n2 2.5 1\n0 2.5 1\n2 0 1\n255 0 0 4 0 1 2 3\n0 255 0 3 0 2 3\n";
  }
  text += std::string("binary_") + (big ? "big" : "little") + "_endian 1.0\n" + k_head;
  for (const auto& [x, y] : {std::pair(0.f, 0.0), {2.f, 0.0}, {2.f, 2.5}, {0.f, 2.5}}) {
    append(text, x, big);
    append(text, y, big);
    append(text, std::int16_t{1}, big);
  }
  text += '\2';
  for (const int end : {0, 1}) append(text, end, big);
  text += std::string("\xff\0\0\4", 4);
  for (const int vertex : {0, 1, 2, 3}) append(text, vertex, big);
  text += std::string("\0\xff\0\3", 4);
  for (const int vertex : {0, 2, 3}) append(text, vertex, big);
  return text;
}

TEST_F(ReadMeshTest, ply_of_every_encoding_gives_the_same_triangles) {
  for (const auto& [is_binary, big] : {std::pair(false, false), {true, false}, {true, true}}) {
    const TriangleMesh mesh = read("a.ply", ply_text(is_binary, big));
    const std::vector<glm::dvec3> vertices{{0, 0, 1}, {2, 0, 1}, {2, 2.5, 1}, {0, 2.5, 1}};
    EXPECT_EQ(mesh.vertices, vertices);
    const std::vector<TriangleMesh::Triangle> triangles{{0, 1, 2}, {0, 2, 3}, {0, 2, 3}};
    EXPECT_EQ(mesh.triangles, triangles);
    const std::vector<Rgb> colors{{1, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    EXPECT_EQ(mesh.triangle_colors, colors);
    EXPECT_TRUE(mesh.vertex_colors.empty());
    EXPECT_TRUE(mesh.warnings.empty());
  }
}

TEST_F(ReadMeshTest, every_shortened_ply_is_an_error) {
  for (const bool is_binary : {false, true}) {
    const std::string whole = ply_text(is_binary, false);
    // A text without its last line's end is whole.
    const std::size_t end = is_binary ? whole.size() : whole.size() - 2;
    for (std::size_t size = 0; size < end; ++size)
      EXPECT_THROW(read("a.ply", whole.substr(0, size)), Error) << size;
  }
}

TEST_F(ReadMeshTest, obj_has_negative_numbers_texture_numbers_and_colours) {
  write("a b.mtl", "newmtl red wall\nKd 0.5 0.25 0\nnewmtl roof\nKd spectral x\n");
  const TriangleMesh mesh =
      read("a.obj",
           "# house\nmtllib a b.mtl\nv 0 0 0\nv 2 0 0 1.0\nv 2 2 0\nv 0 2 0\nvt 0 0\nvn 0 0 1\n"
           "o part\nf 1 2 3\nusemtl red wall\nf -4/1 -2/1/1 -1//1\ns off\nf 1/1 2/1 3/1 4/1\n");
  EXPECT_EQ(mesh.vertices[2], glm::dvec3(2, 2, 0));
  const std::vector<TriangleMesh::Triangle> triangles{{0, 1, 2}, {0, 2, 3}, {0, 1, 2}, {0, 2, 3}};
  EXPECT_EQ(mesh.triangles, triangles);
  const Rgb red{0.5f, 0.25f, 0.0f};
  EXPECT_EQ(mesh.triangle_colors, (std::vector<Rgb>{Rgb(0.5f), red, red, red}));

  const TriangleMesh colored = read("b.obj", "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n");
  EXPECT_EQ(colored.vertex_colors, (std::vector<Rgb>{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}));
}

TEST_F(ReadMeshTest, a_material_without_colour_leaves_the_colours_of_vertices) {
  write("a.mtl", "newmtl red\nKd 1 0 0\n");
  const TriangleMesh mesh = read("a.obj",
                                 "mtllib a.mtl\nv 0 0 0 0 1 0\nv 1 0 0 0 1 0\nv 0 1 0 0 1 0\n"
                                 "usemtl red\nusemtl unknown\nf 1 2 3\n");
  EXPECT_TRUE(mesh.triangle_colors.empty());
  EXPECT_EQ(mesh.vertex_colors, std::vector<Rgb>(3, {0, 1, 0}));
}

TEST_F(ReadMeshTest, a_missing_mtl_file_is_a_warning) {
  const TriangleMesh mesh = read("a.obj", "mtllib gone.mtl\nusemtl x\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  ASSERT_EQ(mesh.warnings.size(), 1u);
  EXPECT_NE(mesh.warnings[0].find("gone.mtl"), std::string::npos);
  EXPECT_TRUE(mesh.triangle_colors.empty());
}

TEST_F(ReadMeshTest, a_mesh_is_scaled_then_turned_then_moved) {
  const TriangleMesh mesh = read("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 3\nf 1 2 3\n",
                                 {.scale = 2.0, .rotate_z = 90.0, .translate = {690000, 5325000, 500}});
  const std::vector<glm::dvec3> expected{
      {690000, 5325000, 500}, {690000, 5325002, 500}, {689998, 5325000, 506}};
  for (std::size_t i = 0; i < 3; ++i)
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(mesh.vertices[i][axis], expected[i][axis], 1e-8);
}

TEST_F(ReadMeshTest, triangles_without_area_are_left_out_with_a_warning) {
  const TriangleMesh mesh =
      read("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 1 2\nf 1 2 4\nf 1 2\nf 1 2 3\n");
  EXPECT_EQ(mesh.triangles, (std::vector<TriangleMesh::Triangle>{{0, 1, 2}}));
  ASSERT_EQ(mesh.warnings.size(), 1u);
  EXPECT_NE(mesh.warnings[0].find("left out 3 triangles without area"), std::string::npos);
  EXPECT_EQ(error("b.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"),
            "b.obj: no triangles; expected faces with an area, found 1 without area");
}

TEST_F(ReadMeshTest, malformed_obj_files_are_errors_that_name_the_line) {
  EXPECT_EQ(error("a.obj", "v 0 0 0\nv 0 nan 1\n"), "a.obj:line 2: vertex 2 is not finite");
  EXPECT_EQ(error("a.obj", "v 0 0 x\n"), "a.obj:line 1: invalid value; expected a number, found 'x'");
  EXPECT_EQ(error("a.obj", "v 0 0\n"), "a.obj:line 1: too few values");
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (const char* number : {"0", "4", "-4", "x", "", "99999999999999999999", "1.5"}) {
    EXPECT_EQ(
        error("a.obj", vertices + "f 1 2 " + number + "/1\n"),
        std::string("a.obj:line 4: a face names a vertex that does not exist; expected numbers from 1 to "
                    "3, or from -3 to -1, found '") +
            number + "/1'");
  }
  EXPECT_EQ(error("a.obj", ""), "a.obj: no triangles; expected faces with an area, found none");
  EXPECT_EQ(error("a.obj", vertices), "a.obj: no triangles; expected faces with an area, found none");
  EXPECT_EQ(error("a.obj", "v 0 0 0\nv 1e13 0 0\nv 0 1 0\nf 1 2 3\n"),
            "a.obj: vertex 1 is too far away; expected coordinates up to 1e12, found 1e+13");
  EXPECT_EQ(error("a.stl", "solid"), "a.stl: unknown mesh format; expected the extension .ply or .obj");
}

TEST_F(ReadMeshTest, a_small_file_that_claims_many_triangles_is_rejected) {
  const auto claimed = [](const std::string& format, const std::string& vertices, const std::string& faces) {
    return "ply\nformat " + format + " 1.0\nelement vertex " + vertices +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
           "\nproperty list uchar int vertex_index\nend_header\n";
  };
  const std::string many = "100000000";
  for (const std::string format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    const std::string data = format == "ascii" ? "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n" : std::string(49, '\0');
    EXPECT_NE(error("a.ply", claimed(format, "3", many) + data)
                  .find("a.ply: truncated file: too short for its element 'face'"),
              std::string::npos);
    EXPECT_NE(error("a.ply", claimed(format, many, "1") + data)
                  .find("a.ply: truncated file: too short for its element 'vertex'"),
              std::string::npos);
  }
}

TEST_F(ReadMeshTest, malformed_ply_files_are_errors) {
  const auto ply = [](const std::string& vertices, const std::string& faces, const std::string& data) {
    return "ply\nformat ascii 1.0\nelement vertex " + vertices +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
           "\nproperty list uchar int vertex_index\nend_header\n" + data;
  };
  const std::string corners = "0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_EQ(error("a.ply", ply("3", "1", corners + "3 0 1 2\n")), "no error");
  EXPECT_EQ(error("a.ply", ply("3", "1", corners + "3 0 1 3\n")),
            "a.ply:line 13: a face names a vertex that does not exist; expected numbers from 0 to below 3, "
            "found 3");
  EXPECT_EQ(error("a.ply", ply("3", "1", corners + "3 0 1 -1\n")),
            "a.ply:line 13: a face names a vertex that does not exist; expected numbers from 0 to below 3, "
            "found -1");
  EXPECT_EQ(error("a.ply", ply("3", "1", corners + "9 0 1 2\n")),
            "a.ply:line 13: invalid list length of 'vertex_index'; expected 0 to 3, found 9");
  EXPECT_EQ(error("a.ply", ply("3", "1", "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n")),
            "a.ply: vertex 1 is not finite");
  // Counts are compared with the file before memory is taken.
  EXPECT_NE(error("a.ply", ply("4000000000", "1", corners)).find("truncated file"), std::string::npos);
  EXPECT_NE(error("a.ply", ply("3", "100000000", corners)).find("truncated file"), std::string::npos);
  EXPECT_NE(error("a.ply", ply("18446744073709551615", "1", corners)).find("truncated file"),
            std::string::npos);
  EXPECT_EQ(error("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n"),
            "a.ply: vertices without coordinates; expected the properties x, y and z");
  // A count without bytes after it costs no time.
  EXPECT_EQ(
      error("a.ply",
            "ply\nformat ascii 1.0\nelement other 18446744073709551615\nelement vertex 1\nproperty float x\n"
            "property float y\nproperty float z\nend_header\n0 0 0\n"),
      "a.ply: no triangles; expected faces with an area, found none");
}

}  // namespace
}  // namespace alidade::test
