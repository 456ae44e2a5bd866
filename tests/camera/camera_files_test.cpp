// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "camera/camera.h"
#include "camera/camera_json.h"
#include "tests/camera/camera_file_text.h"
#include "tests/renderer/describe_scene.h"

namespace alidade::test {

using namespace geo;
using namespace image;
using namespace camera;

namespace {

TEST(CameraFiles, our_own_file_is_a_set_of_one) {
  Camera camera = pinhole_from_fov(60, 40, 50.0, look_at({1, 2, 3}, {4, 5, 6}));
  camera.lens = BrownLens{{.radial = {-0.05}}};
  const CameraSet set = parse(camera_json(camera));
  ASSERT_EQ(set.cameras.size(), 1u);
  EXPECT_EQ(set.cameras[0].name, "cameras.json");
  EXPECT_EQ(describe(set.cameras[0].camera), describe(camera));
}

TEST(CameraFiles, other_json_is_an_error) {
  expect_error("{\"a\": 1}", "cameras.json:1:1: unknown camera file format");
  expect_error("[]", "wrong number of values");
  expect_error("{", "invalid JSON");
  expect_error("{\"frames\": 3}", "wrong type");
}

TEST(CameraFiles, exports_of_other_programs_are_errors_that_name_them_and_what_to_save_instead) {
  const auto problem_of = [](const std::string& text) {
    try {
      parse(text);
    } catch (const Error& error) {
      return error.parts().problem + "; " + error.parts().expected;
    }
    return std::string("no error");
  };
  const auto expect = [&](const std::string& text, const std::string& program, const std::string& remedy) {
    EXPECT_NE(problem_of(text).find(program), std::string::npos) << problem_of(text);
    EXPECT_NE(problem_of(text).find(remedy), std::string::npos) << problem_of(text);
  };
  expect(
      "<?xml version=\"1.0\"?>\n<document "
      "version=\"2.0.0\">\n<chunk><sensors><sensor/></sensors></chunk></document>",
      "Metashape", "COLMAP");
  expect(R"([{"id": 0, "img_name": "a", "position": [1, 2, 3], "rotation": [[1]], "fx": 2}])",
         "3D Gaussian Splatting", "sparse/0");
  expect(R"({"cameras": [{"img_name": "a", "position": [1, 2, 3], "rotation": [[1]]}]})",
         "3D Gaussian Splatting", "sparse/0");
  expect(R"({"class_name": "PinholeCameraParameters", "extrinsic": []})", "Open3D", "transforms.json");
  expect("# Bundle file v0.3\n1 0\n", "Bundler", "COLMAP");
  expect("NVM_V3\n\n1\n", "VisualSFM", "COLMAP");
  expect("imageName X Y Z Omega Phi Kappa\nIMG.jpg 1 2 3 0 90 0\n", "Pix4D", "COLMAP");
  expect("#name,x,y,alt,heading,pitch,roll,f\nIMG.jpg,1,2,3,90,90,0,36\n", "RealityCapture",
         "ns-process-data");
  expect("#name,x,y,alt,yaw,pitch,roll\nIMG,1,2,3,90,0,0\n", "yaw, pitch and roll", "quaternions");
  // What is wrong with formats that are read is said by their readers.
  EXPECT_NE(problem_of("# opencv camera_to_world\ntime,x,y,z,qw,qx,qy,yaw,pitch,roll\n")
                .find("missing column 'qz'"),
            std::string::npos);
}

CameraFileOptions with_lens() {
  return {.lens = pinhole_from_fov(60, 40, 50.0, {}), .original_world = false};
}

CameraSet trajectory(const std::string& text) {
  return parse_cameras(text, "nowhere/flight.csv", with_lens());
}

std::string trajectory_error(const std::string& text, const CameraFileOptions& options = with_lens()) {
  try {
    parse_cameras(text, "flight.csv", options);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

const std::string k_header = "# opencv, camera_to_world\ntime,x,y,z,qw,qx,qy,qz\n";

TEST(Trajectory, rows_are_poses_in_their_order) {
  const CameraSet set = trajectory(k_header + "2.5,7,8,9,1,0,0,0\n\n1.5, 1, 2, 3, 0, 2, 0, 0\r\n");
  ASSERT_EQ(set.cameras.size(), 2u);
  EXPECT_EQ(set.cameras[0].name, "2.5");
  EXPECT_EQ(set.cameras[1].name, "1.5");
  expect_pose(set.cameras[0].camera.pose, {{7, 8, 9}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  expect_pose(set.cameras[1].camera.pose, {{1, 2, 3}, {1, 0, 0}, {0, -1, 0}, {0, 0, -1}});
  EXPECT_EQ(set.cameras[0].camera.width, 60);
  EXPECT_EQ(set.cameras[0].camera.fx, with_lens().lens->fx);
}

TEST(Trajectory, conventions_and_directions_are_as_the_remark_says) {
  // A quarter turn about z.
  const std::string row = "name x y z qx qy qz qw time\nstart 1 2 3 0 0 1 1 0\n";
  expect_pose(trajectory("# opencv camera_to_world\n" + row).cameras[0].camera.pose,
              {{1, 2, 3}, {0, 1, 0}, {-1, 0, 0}, {0, 0, 1}});
  expect_pose(trajectory("# opengl camera_to_world\n" + row).cameras[0].camera.pose,
              {{1, 2, 3}, {0, 1, 0}, {1, 0, 0}, {0, 0, -1}});
  expect_pose(trajectory("# opencv\n#world_to_camera\n" + row).cameras[0].camera.pose,
              {{-2, 1, -3}, {0, -1, 0}, {1, 0, 0}, {0, 0, 1}});
  EXPECT_EQ(trajectory("# opencv camera_to_world\n" + row).cameras[0].name, "start");
}

TEST(Trajectory, nothing_is_guessed) {
  EXPECT_NE(trajectory_error("time,x,y,z,qw,qx,qy,qz\n")
                .find("flight.csv:line 1: missing convention of the quaternions"),
            std::string::npos);
  EXPECT_NE(
      trajectory_error("# opencv\ntime,x,y,z,qw,qx,qy,qz\n").find("missing convention of the quaternions"),
      std::string::npos);
  EXPECT_NE(trajectory_error("# opencv camera_to_world\n1,2,3,4,1,0,0,0\n").find("missing column 'time'"),
            std::string::npos);
  EXPECT_NE(trajectory_error("# opencv camera_to_world\ntime,x,y,z,qw,qx,qy\n").find("missing column 'qz'"),
            std::string::npos);
  EXPECT_NE(trajectory_error(k_header + "1,2,3,4,1,0,0,0\n", {}).find("missing lens for the trajectory"),
            std::string::npos);
}

TEST(Trajectory, damage_is_an_error_at_its_line) {
  EXPECT_NE(trajectory_error(k_header + "1,2,3,4,1,0,0\n").find("flight.csv:line 3: missing value for 'qz'"),
            std::string::npos);
  EXPECT_NE(trajectory_error(k_header + "1,2,3,4,0,0,0,0\n").find("the quaternion is zero"),
            std::string::npos);
  EXPECT_NE(trajectory_error(k_header + "1,2,x,4,1,0,0,0\n").find("invalid y; expected a number, found 'x'"),
            std::string::npos);
  EXPECT_NE(trajectory_error(k_header + "1,2,inf,4,1,0,0,0\n").find("invalid y"), std::string::npos);
  EXPECT_NE(trajectory_error(k_header + "1,2,1e13,4,1,0,0,0\n").find("position out of range"),
            std::string::npos);
  EXPECT_NE(trajectory_error(k_header + "1,2,3,4,1,0,0,0\n1,2,3,4,1,0,0,0\n").find("duplicate camera '1'"),
            std::string::npos);
  EXPECT_NE(trajectory_error(k_header).find("contains no camera with a pose"), std::string::npos);
  EXPECT_NE(trajectory_error("").find("contains no camera with a pose"), std::string::npos);
  EXPECT_NE(trajectory_error("# opencv camera_to_world\ntime,x,x,z\n").find("duplicate column 'x'"),
            std::string::npos);
}

}  // namespace
}  // namespace alidade::test
