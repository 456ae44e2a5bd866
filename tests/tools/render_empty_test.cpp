// SPDX-License-Identifier: MIT
// Images, depth maps and rasters that show nothing: they are written, named, and the exit code is 1.
#include <fmt/format.h>

#include "cloud/las/write_las.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

class RenderEmptyTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_square("square.xyz");
    // From above: down, down, and up into the sky.
    std::filesystem::create_directories(folder / "model");
    write("model/cameras.txt", "1 PINHOLE 24 16 20 20 12 8\n");
    write("model/images.txt",
          "1 0 1 0 0 -101 201 9 1 a.jpg\n\n2 0 1 0 0 -100.5 201 9 1 b.jpg\n\n3 1 0 0 0 -101 -201 -9 1 "
          "c.jpg\n\n");
    std::filesystem::create_directories(folder / "away");
    write("away/cameras.txt", "1 PINHOLE 24 16 20 20 12 8\n");
    write("away/images.txt", "3 1 0 0 0 -101 -201 -9 1 c.jpg\n\n4 1 0 0 0 -100 -201 -9 1 d.jpg\n\n");
  }

  ProgramResult render(const Words& words) {
    return run(with({"render", "--cloud", "square.xyz", "--samples", "2"}, words));
  }
};

TEST_F(RenderEmptyTest, a_camera_that_looks_away_is_named_and_the_exit_code_is_1) {
  const ProgramResult one = render({"--camera", "model", "--camera-name", "c.jpg", "-o", "one.png"});
  EXPECT_EQ(one.exit_code, 1);
  EXPECT_TRUE(
      contains(one.err,
               "warning: camera 'c.jpg' sees nothing; no point of the cloud is in the frame of any photo; "
               "expected cameras that look at the cloud: they look away from it; are their axes those of "
               "OpenGL"))
      << one.err;
  EXPECT_TRUE(contains(one.err, "found cameras at x 101, y 201, z 9; a cloud at x ")) << one.err;
  const ProgramResult set = render({"--camera", "model", "-o", "%s.png"});
  EXPECT_EQ(set.exit_code, 1);
  EXPECT_TRUE(contains(set.err, "warning: camera 'c.jpg' sees nothing")) << set.err;
  EXPECT_FALSE(contains(set.err, "'a.jpg'")) << set.err;
  EXPECT_EQ(names(), (Words{"a.png", "away", "b.png", "c.png", "model", "one.png", "square.xyz"}))
      << "all are written";
  const ProgramResult two = render({"--camera", "away", "-o", "%s.exr", "--layers", "depth,id"});
  EXPECT_EQ(two.exit_code, 1);
  EXPECT_TRUE(contains(two.err, "2 cameras see nothing: 'c.jpg', 'd.jpg'; ")) << two.err;
  EXPECT_EQ(render({"--camera", "model", "--camera-name", "a.jpg", "-o", "a.png", "--overwrite"}).exit_code,
            0);
}

TEST_F(RenderEmptyTest, a_depth_map_without_a_depth_is_named) {
  const ProgramResult set = render({"--camera", "model", "--depth", "%s.npy"});
  EXPECT_EQ(set.exit_code, 1);
  EXPECT_TRUE(contains(set.err, "camera 'c.jpg' sees nothing; no point")) << set.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "c.npy"));
  const ProgramResult both =
      render({"--camera", "model", "--camera-name", "c", "--depth", "d.exr", "-o", "c.png"});
  EXPECT_EQ(both.exit_code, 1);
  EXPECT_EQ(both.err.find("sees nothing"), both.err.rfind("sees nothing")) << "said once: " << both.err;
  EXPECT_EQ(render({"--camera", "model", "--camera-name", "a", "--depth", "a.exr"}).exit_code, 0);
  // All are too deep for 16 bits of micrometres.
  const ProgramResult deep =
      render({"--camera", "model", "--camera-name", "a", "--depth", "deep.png", "--depth-scale", "1e6"});
  EXPECT_EQ(deep.exit_code, 1);
  EXPECT_TRUE(contains(deep.err, "the frame contains points, but no pixel shows one")) << deep.err;
}

TEST_F(RenderEmptyTest, an_extent_beside_the_cloud_is_named) {
  const Words above = {"--orthographic", "top", "--resolution", "0.5"};
  const ProgramResult beside = render(with(above, {"--extent", "0,0,10,10", "-o", "beside.tif"}));
  EXPECT_EQ(beside.exit_code, 1);
  EXPECT_TRUE(contains(beside.err, "warning: --extent contains no points of the cloud")) << beside.err;
  for (const char* const layer : {"elevation", "count", "density"}) {
    const std::string file = fmt::format("{}.tif", layer);
    EXPECT_EQ(render(with(above, {"--extent", "0,0,10,10", "--layers", layer, "-o", file})).exit_code, 1)
        << layer;
    EXPECT_TRUE(std::filesystem::exists(folder / file)) << layer;
    EXPECT_EQ(render(with(above, {"--layers", layer, "-o", file, "--overwrite"})).exit_code, 0) << layer;
  }
  EXPECT_EQ(render(with(above, {"-o", "all.tif"})).exit_code, 0);
}

TEST_F(RenderEmptyTest, an_image_of_the_sky_alone_is_no_mistake) {
  write("sky.json", R"({"version": 1, "sky": {"type": "constant", "radiance": [1, 1, 1]},
    "camera": {"model": "pinhole", "width": 8, "height": 8, "intrinsics": {"vertical_fov": 50},
               "pose": {"look_at": {"eye": [0, 0, 0], "target": [0, 1, 0]}}}, "render": {"samples": 1}})");
  EXPECT_EQ(run({"render", "sky.json", "-o", "sky.png"}).exit_code, 0);
}

TEST_F(RenderEmptyTest, parts_of_an_empty_image_are_named_when_they_are_merged) {
  for (const char* const part : {"1/2", "2/2"})
    ASSERT_EQ(render({"--camera", "model", "--camera-name", "c", "-o", "c.png", "--part", part}).exit_code,
              0);
  const ProgramResult merged = run({"merge", "c.png.part1of2", "c.png.part2of2", "-o", "c.png"});
  EXPECT_EQ(merged.exit_code, 1);
  EXPECT_TRUE(contains(merged.err, "warning: c.png: the camera sees nothing")) << merged.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "c.png"));
}

TEST_F(RenderEmptyTest, colours_and_rasters_of_one_value_are_named) {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(0.01), .offset = {100, 200, 0}};
  for (int i = 0; i < 400; ++i) cloud.positions.push_back({10 * (i % 20), 10 * (i / 20), i % 7});
  cloud.intensities.assign(400, 0);
  cloud.classifications.assign(400, 2);
  write_las(folder / "plain.las", cloud);
  const auto said = [&](const Words& words) {
    const ProgramResult result =
        run(with({"render", "plain.las", "--samples", "1", "--size", "24x16", "--overwrite"}, words));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.err;
  };
  EXPECT_TRUE(contains(said({"--color-by", "intensity", "-o", "a.png"}),
                       "warning: --color-by intensity: all values are 0"));
  EXPECT_TRUE(contains(said({"--color-by", "classification", "-o", "a.png"}),
                       "warning: --color-by classification: all values are 2"));
  EXPECT_FALSE(contains(said({"--color-by", "height", "-o", "a.png"}), "all values"));
  const ProgramResult rasters = run({"render", "plain.las", "--orthographic", "top", "--resolution", "0.2",
                                     "--layers", "intensity,classification", "-o", "plain.tif"});
  EXPECT_EQ(rasters.exit_code, 0);
  EXPECT_TRUE(contains(rasters.err, "plain_intensity.tif: all points have the intensity 0")) << rasters.err;
  EXPECT_TRUE(contains(rasters.err, "plain_classification.tif: all points have the classification 2"))
      << rasters.err;
}

}  // namespace
}  // namespace alidade::test
