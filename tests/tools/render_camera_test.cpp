// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cstdlib>

#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

const std::string k_camera =
    R"({"version": 1, "model": "pinhole", "width": 24, "height": 16, "intrinsics": {"vertical_fov": 50},
  "pose": {"look_at": {"eye": [101, 201, 9], "target": [101, 201.1, 5]}}})";

class RenderCameraTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_square("square.xyz");
    std::filesystem::create_directories(folder / "model");
    write("model/cameras.txt", "1 PINHOLE 24 16 20 20 12 8\n2 SIMPLE_RADIAL 30 20 20 15 10 -0.05\n");
    // From above, looking down: half a turn about x.
    write("model/images.txt",
          "1 0 1 0 0 -101 201 9 1 photos/b.jpg\n\n2 0 1 0 0 -100.5 201 9 2 photos/a.jpg\n\n3 0 1 0 0 -100 "
          "200 9 1 c.jpg\n\n");
  }

  ProgramResult render(std::vector<std::string> words) {
    words.insert(words.begin(), {"render", "--cloud", "square.xyz", "--samples", "2"});
    return run(words);
  }
};

TEST_F(RenderCameraTest, every_camera_of_a_model_is_a_numbered_image_in_the_order_of_names) {
  const ProgramResult result = render({"--camera", "model", "-o", "out_%03d.png"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "rendering 3 images")) << result.err;
  EXPECT_TRUE(contains(result.err, "wrote out_000.png to out_002.png")) << result.err;
  EXPECT_EQ(names(),
            (std::vector<std::string>{"model", "out_000.png", "out_001.png", "out_002.png", "square.xyz"}));
  // c.jpg, photos/a.jpg, photos/b.jpg
  EXPECT_TRUE(contains(read("out_000.png"), "c.jpg"));
  EXPECT_TRUE(contains(read("out_001.png"), "photos/a.jpg"));
  EXPECT_TRUE(contains(read("out_002.png"), "photos/b.jpg"));
}

TEST_F(RenderCameraTest, images_may_have_the_names_of_their_photos) {
  ASSERT_EQ(render({"--camera", "model", "-o", "%s.png"}).exit_code, 0);
  EXPECT_EQ(names(),
            (std::vector<std::string>{"c.png", "model", "photos_a.png", "photos_b.png", "square.xyz"}));
}

TEST_F(RenderCameraTest, one_camera_by_name_gives_the_image_it_has_in_the_set) {
  ASSERT_EQ(render({"--camera", "model", "-o", "%d.png"}).exit_code, 0);
  for (const std::string name : {"photos/b.jpg", "b.jpg", "b"}) {
    const ProgramResult result =
        render({"--camera", "model", "--camera-name", name, "-o", "one.png", "--overwrite"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const std::string set = read("2.png"), one = read("one.png");
    EXPECT_EQ(set.substr(set.find("IDAT")), one.substr(one.find("IDAT"))) << name;
  }
}

TEST_F(RenderCameraTest, several_cameras_by_name_are_rendered_in_their_order) {
  ASSERT_EQ(
      render({"--camera", "model", "--camera-name", "b", "--camera-name", "c", "-o", "%d.png"}).exit_code, 0);
  EXPECT_EQ(names(), (std::vector<std::string>{"0.png", "1.png", "model", "square.xyz"}));
  EXPECT_TRUE(contains(read("0.png"), "photos/b.jpg"));
  EXPECT_TRUE(contains(read("1.png"), "c.jpg"));
}

TEST_F(RenderCameraTest, an_interrupted_set_resumes_where_it_ended) {
  ASSERT_EQ(render({"--camera", "model", "-o", "%d.png"}).exit_code, 0);
  const std::string first = read("0.png");
  std::filesystem::remove(folder / "1.png");
  write("2.png", "another program's");
  EXPECT_EQ(render({"--camera", "model", "-o", "%d.png"}).exit_code, 2);
  const ProgramResult result = render({"--camera", "model", "-o", "%d.png", "--skip-existing"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "wrote 1.png")) << result.err;
  EXPECT_EQ(read("0.png"), first);
  EXPECT_EQ(read("2.png"), "another program's");
  const ProgramResult nothing = render({"--camera", "model", "-o", "%d.png", "--skip-existing"});
  EXPECT_EQ(nothing.exit_code, 0);
  EXPECT_TRUE(contains(nothing.err, "all images exist")) << nothing.err;
}

TEST_F(RenderCameraTest, mistakes_about_cameras_are_errors_before_the_work) {
  const auto expect = [&](const std::vector<std::string>& words, const std::string& part) {
    const ProgramResult result = render(words);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_TRUE(contains(result.err, part)) << result.err;
    EXPECT_FALSE(contains(result.err, "loading cloud")) << result.err;
    EXPECT_EQ(names(), (std::vector<std::string>{"fold.json", "model", "square.xyz"}));
  };
  write("fold.json",
        R"({"version": 1, "model": "brown", "width": 24, "height": 16, "intrinsics": {"vertical_fov": 50},
    "distortion": {"k1": -3}, "pose": {"look_at": {"eye": [101, 201, 9], "target": [101, 201.1, 5]}}})");
  expect({"--camera", "model", "-o", "out.png"}, "out.png: 3 cameras, but one output name");
  expect({"--camera", "model", "-o", "%d_%d.png"}, "several numbers or names");
  expect({"--camera", "model", "-o", "%x.png"}, "invalid percent sign");
  expect({"--camera", "model", "--camera-name", "photos/bb.jpg", "-o", "out.png"},
         "model: no camera named 'photos/bb.jpg'");
  expect({"--camera", "nowhere", "-o", "out.png"}, "nowhere: no such file");
  expect({"--camera", "fold.json", "-o", "out.png"}, "the distortion folds over");
  expect({"--camera", "model", "--panorama", "1,2,3", "-o", "out.png"}, "--panorama");
  expect({"--camera-name", "a", "-o", "out.png"}, "--camera-name requires --camera");
  expect({"--panorama", "1,2", "-o", "out.png"}, "expected 3 numbers separated by commas");
  expect({"--panorama", "1,2,3,4", "-o", "out.png"}, "expected 3 numbers separated by commas");
  expect({"--panorama", "1,2,x", "-o", "out.png"}, "--panorama");
  expect({"--orthographic", "side", "--resolution", "1", "-o", "out.png"}, "expected top, found 'side'");
  expect({"--orthographic", "top", "-o", "out.png"}, "--orthographic requires --resolution");
  expect({"--resolution", "1", "-o", "out.png"}, "--resolution requires --orthographic");
  expect({"--orthographic", "top", "--resolution", "0", "-o", "out.png"}, "--resolution");
  expect({"--panorama", "1,2,3", "-o", "out.tif"}, "a GeoTIFF requires an orthographic camera");
}

TEST_F(RenderCameraTest, lenses_that_fold_over_name_their_camera) {
  write("model/cameras.txt", "1 PINHOLE 24 16 20 20 12 8\n2 SIMPLE_RADIAL 30 20 20 15 10 -5\n");
  const ProgramResult result = render({"--camera", "model", "-o", "%d.png"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "model: camera 'photos/a.jpg': the distortion folds over")) << result.err;
  // The others can be rendered.
  EXPECT_EQ(render({"--camera", "model", "--camera-name", "b", "-o", "b.png"}).exit_code, 0);
}

TEST_F(RenderCameraTest, two_photos_that_would_be_one_image_are_an_error) {
  write("model/images.txt", "1 0 1 0 0 -101 201 9 1 a/b.jpg\n\n2 0 1 0 0 -100.5 201 9 2 a_b.png\n\n");
  const ProgramResult result = render({"--camera", "model", "-o", "%s.png"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "cameras 'a/b.jpg' and 'a_b.png' have the same output a_b.png"))
      << result.err;
}

TEST_F(RenderCameraTest, names_from_a_file_lead_nowhere_else) {
  write("model/images.txt", "1 0 1 0 0 -101 201 9 1 ../../b.jpg\n\n");
  ASSERT_EQ(render({"--camera", "model", "-o", "%s.png"}).exit_code, 0);
  EXPECT_EQ(names(), (std::vector<std::string>{".._.._b.png", "model", "square.xyz"}));
}

TEST_F(RenderCameraTest, a_trajectory_takes_its_lens_from_a_camera_file) {
  write("lens.json", k_camera);
  write("flight.csv",
        "# opencv camera_to_world\ntime,x,y,z,qw,qx,qy,qz\n0,101,201,9,0,1,0,0\n0.5,101.5,201,9,0,1,0,0\n");
  const ProgramResult missing = render({"--camera", "flight.csv", "-o", "%04d.png"});
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_TRUE(contains(missing.err, "flight.csv:line 2: missing lens for the trajectory")) << missing.err;
  const ProgramResult result = render({"--camera", "flight.csv", "--lens", "lens.json", "-o", "%04d.png"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(read("0000.png"), read("0001.png"));
}

TEST_F(RenderCameraTest, a_camera_inside_a_point_is_an_error) {
  const ProgramResult result = render({"--panorama", "100.1,200.1,5.01", "--radius", "0.1", "-o", "out.png"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(
      contains(result.err,
               "the camera is inside the sphere of point 21; expected a distance above 0.1, or --near "
               "0.0101 to look past it, found 0.01"))
      << result.err;
  const auto seen = [&](const std::string& from, const std::string& near) {
    const ProgramResult made = render({"--panorama", from, "--near", near, "--radius", "0.1", "--size",
                                       "16x8", "--overwrite", "-o", "out.png"});
    EXPECT_EQ(made.exit_code, near == "1000" ? 1 : 0) << made.err;
    return read("out.png");
  };
  seen("100.1,200.1,5.2", "0");
  // Past the point, other points are seen; beyond all of them, the sky.
  EXPECT_NE(seen("100.1,200.1,5.01", "0.0101"), seen("100.1,200.1,5.01", "1000"));
}

TEST_F(RenderCameraTest, gdalinfo_prints_the_corners_of_an_orthophoto) {
  if (std::system("command -v gdalinfo > /dev/null") != 0) GTEST_SKIP() << "gdalinfo (gdal-bin) is not there";
  ASSERT_EQ(run({"generate", "courtyard", "--points", "2e4", "-o", "yard.las", "-q"}).exit_code, 0);
  const ProgramResult result =
      run({"render", "--cloud", "yard.las", "--orthographic", "top", "--resolution", "0.5", "--extent",
           "689950,5324960,690050,5325020", "--samples", "1", "-o", "top.tif", "-q"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  ASSERT_EQ(std::system(fmt::format("cd '{}' && gdalinfo top.tif > said", folder.string()).c_str()), 0);
  const std::string said = read("said");
  for (const char* const line :
       {"Size is 200, 120", "Upper Left  (  689950.000, 5325020.000)",
        "Lower Left  (  689950.000, 5324960.000)", "Upper Right (  690050.000, 5325020.000)",
        "Lower Right (  690050.000, 5324960.000)", "WGS 84 / UTM zone 32N", "ColorInterp=Alpha"}) {
    EXPECT_TRUE(contains(said, line)) << line << "\n" << said;
  }
}

TEST_F(RenderCameraTest, an_orthophoto_covers_the_cloud_on_whole_multiples_of_its_resolution) {
  const ProgramResult result =
      render({"--orthographic", "top", "--resolution", "0.5", "--radius", "0.05", "-o", "top.exr"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  // From 99.95 to 101.95 and 199.95 to 201.95: 5 pixels each way from 99.5 and 199.5 on.
  EXPECT_TRUE(contains(read("top.exr"), "orthographic, 5 x 5 pixels")) << result.err;
  EXPECT_TRUE(contains(read("top.exr"), "at 99.500 202.000"));
}

}  // namespace
}  // namespace alidade::test
