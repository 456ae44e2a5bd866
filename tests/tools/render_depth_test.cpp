// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>

#include "compare/read_compared_image.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

class RenderDepthTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_square("square.xyz");
    std::filesystem::create_directories(folder / "model");
    write("model/cameras.txt", "1 PINHOLE 24 16 20 20 12 8\n");
    // From above, looking down: half a turn about x.
    write("model/images.txt", "1 0 1 0 0 -101 201 9 1 photos/a.jpg\n\n2 0 1 0 0 -100.5 201 9 1 b.jpg\n\n");
    nlohmann::ordered_json frames;
    for (const std::string name : {"./images/b.jpg", "images/a.jpg"}) {
      frames.push_back({{"file_path", name},
                        {"depth_file_path", "earlier.png"},
                        {"sharpness", 12.25},
                        {"transform_matrix",
                         {{1, 0, 0, name == "images/a.jpg" ? 101.0 : 100.5},
                          {0, 1, 0, 201},
                          {0, 0, 1, 9},
                          {0, 0, 0, 1}}}});
    }
    transforms_ = {
        {"w", 24},          {"h", 16},   {"fl_x", 20.0},     {"fl_y", 20},           {"cx", 12},   {"cy", 8},
        {"aabb_scale", 16}, {"k1", 0.0}, {"frames", frames}, {"mine", {{"b", 0.1}}}, {"a", "text"}};
    write("transforms.json", transforms_.dump());
  }

  ProgramResult render(std::vector<std::string> words) {
    words.insert(words.begin(), {"render", "--cloud", "square.xyz"});
    return run(words);
  }

  /// Values of a map of 24 x 16 in COLMAP's format.
  std::vector<float> map(const std::string& name) const {
    const std::string bytes = read(name), head = "24&16&1&";
    EXPECT_EQ(bytes.substr(0, head.size()), head);
    EXPECT_EQ(bytes.size(), head.size() + 24 * 16 * sizeof(float));
    std::vector<float> values(24 * 16);
    if (bytes.size() >= head.size() + values.size() * sizeof(float))
      std::memcpy(values.data(), bytes.data() + head.size(), values.size() * sizeof(float));
    return values;
  }

  /// A Python that has a module; empty if missing.
  static std::string python_with(const std::string& module) {
    for (const char* const name : {"python3", "/usr/bin/python3"}) {
      if (std::system(fmt::format("{} -c 'import {}' > /dev/null 2>&1", name, module).c_str()) == 0)
        return name;
    }
    return {};
  }

  /// Maps of one camera in every format, and the values themselves.
  void expect_read_by(const std::string& module) {
    const std::string interpreter = python_with(module);
    if (interpreter.empty()) GTEST_SKIP() << "there is no python3 with " << module;
    for (const char* const name : {"0.npy", "0.png", "0.exr", "0.tif", "0.bin"}) {
      const ProgramResult result = render({"--camera", "model", "--camera-name", "a", "--depth", name,
                                           "--depth-mask", "mask.png", "--overwrite", "-q"});
      ASSERT_EQ(result.exit_code, 0) << result.err;
    }
    write("raw", read("0.bin").substr(std::string("24&16&1&").size()));
    EXPECT_EQ(std::system(fmt::format("cd '{}' && {} '{}/tests/tools/render_depth_test.py' {}",
                                      folder.string(), interpreter, ALIDADE_SOURCE_FOLDER, module)
                              .c_str()),
              0);
  }

  nlohmann::ordered_json transforms_;
};

TEST_F(RenderDepthTest, numpy_reads_the_values_of_npy_and_of_colmaps_format) {
  expect_read_by("numpy");
}

TEST_F(RenderDepthTest, opencv_reads_png_tiff_exr_and_mask) {
  expect_read_by("cv2");
}

TEST_F(RenderDepthTest, open3d_puts_the_points_where_they_were) {
  expect_read_by("open3d");
}

TEST_F(RenderDepthTest, depth_without_an_image_is_the_plane_of_the_points_and_0_beside_it) {
  const ProgramResult result = render({"--camera", "model", "--camera-name", "a", "--depth", "a.bin"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "tracing depth")) << result.err;
  EXPECT_TRUE(contains(result.err, "wrote a.bin")) << result.err;
  EXPECT_TRUE(contains(result.err, "discs of radius")) << result.err;
  EXPECT_FALSE(contains(result.err, "rendering")) << result.err;
  std::size_t seen = 0;
  for (const float depth : map("a.bin")) {
    EXPECT_TRUE(depth == 0.0f || std::fabs(depth - 4.0f) < 1e-4f) << depth;
    seen += depth > 0.0f;
  }
  EXPECT_GT(seen, 80u);
  EXPECT_LT(seen, 200u);
}

TEST_F(RenderDepthTest, distance_along_the_ray_is_larger_beside_the_axis) {
  const std::vector<std::string> words{"--camera", "model", "--camera-name", "a", "-q", "--depth"};
  auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = words;
    all.insert(all.end(), more.begin(), more.end());
    return render(all);
  };
  ASSERT_EQ(with({"axis.bin"}).exit_code, 0);
  ASSERT_EQ(with({"ray.bin", "--depth-along", "ray", "--depth-scale", "2"}).exit_code, 0);
  const std::vector<float> axis = map("axis.bin"), ray = map("ray.bin");
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 24; ++x) {
      const double u = (x + 0.5 - 12) / 20, v = (y + 0.5 - 8) / 20;
      const std::size_t pixel = static_cast<std::size_t>(y * 24 + x);
      EXPECT_NEAR(ray[pixel], 2 * axis[pixel] * std::sqrt(1 + u * u + v * v), 1e-5);
    }
  }
}

TEST_F(RenderDepthTest, spheres_are_used_where_the_options_say_so_and_are_warned_of) {
  const std::vector<std::string> words{"--camera", "model", "--camera-name", "a",
                                       "--depth",  "a.bin", "--overwrite"};
  for (const auto& [option, value, warned] :
       {std::tuple{"--radius", "0.05", true}, {"--hits", "t", true}, {"--surface", "sphere", false}}) {
    std::vector<std::string> all = words;
    all.insert(all.end(), {option, value});
    const ProgramResult result = render(all);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(contains(result.err, "make depths too small, at grazing angles by several radii"), warned)
        << result.err;
  }
}

TEST_F(RenderDepthTest, an_image_is_the_same_with_and_without_depth_beside_it) {
  const std::vector<std::string> words{
      "--camera", "model", "--camera-name", "a",        "--surface",   "blend", "--samples",
      "2",        "-q",    "--overwrite",   "--layers", "color,depth", "-o",    "a.exr"};
  ASSERT_EQ(render(words).exit_code, 0);
  const std::string alone = read("a.exr");
  std::vector<std::string> both = words;
  both.insert(both.end(), {"--depth", "a.bin", "--depth-mask=m.png"});
  ASSERT_EQ(render(both).exit_code, 0);
  EXPECT_TRUE(read("a.exr") == alone);
  EXPECT_EQ(names(),
            (std::vector<std::string>{"a.bin", "a.exr", "m.png", "model", "square.xyz", "transforms.json"}));
}

/// Of tests/tools/render_depth_test.py, which compares the other formats with this one.
TEST_F(RenderDepthTest, a_map_has_the_values_of_the_layer_of_an_image) {
  for (const std::string surface : {"disc", "blend", "sphere"}) {
    const ProgramResult result =
        render({"--camera", "model", "--camera-name", "a", "--surface", surface, "--samples", "2", "-q",
                "--overwrite", "--layers", "color,depth", "-o", "a.exr", "--depth", "a.bin"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const std::vector<float> depths = map("a.bin");
    const compare::ComparedImage image = compare::read_compared_image(folder / "a.exr");
    ASSERT_EQ(image.depth.size(), depths.size());
    std::size_t seen = 0;
    for (std::size_t pixel = 0; pixel < depths.size(); ++pixel) {
      const bool sees = compare::is_depth(image.depth[pixel]);
      ASSERT_EQ(depths[pixel], sees ? image.depth[pixel] : 0.0f) << surface;
      seen += sees ? 1 : 0;
    }
    EXPECT_GT(seen, 80u);
  }
}

TEST_F(RenderDepthTest, maps_of_a_set_have_the_names_that_colmap_looks_for) {
  std::filesystem::create_directories(folder / "depth_maps" / "photos");
  const ProgramResult result =
      render({"--camera", "model", "--depth", "depth_maps/%f.geometric.bin", "--depth-format", "colmap"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "depth_maps/b.jpg.geometric.bin"));
  EXPECT_TRUE(std::filesystem::exists(folder / "depth_maps/photos/a.jpg.geometric.bin"));
  write("model/images.txt", "1 0 1 0 0 -101 201 9 1 ../b.jpg\n\n");
  const ProgramResult outside = render({"--camera", "model", "--depth", "depth_maps/%f.bin"});
  EXPECT_EQ(outside.exit_code, 2);
  EXPECT_TRUE(contains(outside.err, "camera '../b.jpg' leads out of the folder")) << outside.err;
}

TEST_F(RenderDepthTest, transforms_get_the_depth_of_each_frame_and_keep_all_else) {
  std::filesystem::create_directories(folder / "depth");
  const ProgramResult result = render({"--camera", "transforms.json", "--depth", "depth/%s.png",
                                       "--depth-scale", "500", "--transforms-out", "transforms_depth.json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "wrote transforms_depth.json: depths are in units of 0.002 m"))
      << result.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "depth/images_a.png"));
  EXPECT_TRUE(std::filesystem::exists(folder / "depth/images_b.png"));
  transforms_["frames"][0]["depth_file_path"] = "depth/images_b.png";
  transforms_["frames"][1]["depth_file_path"] = "depth/images_a.png";
  EXPECT_EQ(read("transforms_depth.json"), transforms_.dump(2) + "\n");
  // The result is itself a file of cameras, and an interrupted set can be resumed.
  std::filesystem::remove(folder / "depth/images_b.png");
  std::filesystem::remove(folder / "transforms_depth.json");
  write("depth/images_a.png", "there already");
  const ProgramResult again =
      render({"--camera", "transforms.json", "--depth", "depth/%s.png", "--depth-scale", "500",
              "--transforms-out", "transforms_depth.json", "--skip-existing"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_TRUE(contains(again.err, "wrote depth/images_b.png\n")) << again.err;
  EXPECT_EQ(read("depth/images_a.png"), "there already");
  EXPECT_EQ(read("transforms_depth.json"), transforms_.dump(2) + "\n");
  const ProgramResult nothing =
      render({"--camera", "transforms_depth.json", "--depth", "depth/%s.png", "--skip-existing"});
  EXPECT_EQ(nothing.exit_code, 0);
  EXPECT_TRUE(contains(nothing.err, "all images exist")) << nothing.err;
}

TEST_F(RenderDepthTest, what_16_bits_cannot_hold_is_0_and_is_reported) {
  const ProgramResult result = render({"--camera", "model", "--camera-name", "a", "--depth", "a.png",
                                       "--depth-mask", "m.png", "--depth-scale", "20000"});
  EXPECT_EQ(result.exit_code, 1) << "nothing is left in the map: " << result.err;
  EXPECT_TRUE(contains(result.err,
                       "deeper than the 3.27675 m that 16 bits hold with --depth-scale 20000, and are 0; the "
                       "deepest, 4 m, requires --depth-scale 1.63e+04 or another format"))
      << result.err;
}

TEST_F(RenderDepthTest, what_lies_beside_or_behind_a_fisheye_has_no_depth_along_the_axis) {
  write("fish.json", R"({"version": 1, "model": "fisheye", "width": 64, "height": 64,
    "intrinsics": {"fx": 15, "fy": 15, "cx": 32, "cy": 32}, "distortion": {},
    "pose": {"look_at": {"eye": [101, 201, 5.5], "target": [102, 201, 5.5]}}})");
  const ProgramResult axis = render({"--camera", "fish.json", "--depth", "0.npy", "--depth-mask", "0.png"});
  ASSERT_EQ(axis.exit_code, 0) << axis.err;
  EXPECT_TRUE(contains(axis.err,
                       "pixels are 90 degrees or more off the optical axis, and are 0; they require "
                       "--depth-along ray"))
      << axis.err;
  const ProgramResult ray =
      render({"--camera", "fish.json", "--depth", "1.npy", "--depth-mask", "1.png", "--depth-along", "ray"});
  ASSERT_EQ(ray.exit_code, 0) << ray.err;
  EXPECT_FALSE(contains(ray.err, "90 degrees")) << ray.err;
  EXPECT_EQ(read("0.png"), read("1.png"));
}

TEST_F(RenderDepthTest, a_view_of_the_whole_cloud_and_an_exact_site_have_depth_too) {
  EXPECT_EQ(render({"--size", "30x20", "--depth", "a.npy"}).exit_code, 0);
  EXPECT_EQ(read("a.npy").size(), 128 + 30u * 20u * 4u);
  EXPECT_EQ(run({"render", "--site", "courtyard", "--size", "30x20", "--depth", "site.npy"}).exit_code, 0);
  EXPECT_EQ(read("site.npy").size(), 128 + 30u * 20u * 4u);
}

TEST_F(RenderDepthTest, mistakes_are_errors_before_the_work) {
  std::filesystem::create_directories(folder / "other");
  write("there.npy", "");
  const std::vector<std::string> before = names();
  const auto expect = [&](const std::vector<std::string>& words, const std::string& part) {
    const ProgramResult result = render(words);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_TRUE(contains(result.err, part)) << result.err;
    EXPECT_FALSE(contains(result.err, "loading cloud")) << result.err;
    EXPECT_EQ(names(), before);
  };
  expect({"--depth", "a.png", "--depth-format", "npy"},
         "a.png: --depth-format npy and the extension disagree; expected the extension .npy, found .png");
  expect({"--depth", "a.jpg"}, "a.jpg: unknown format of depth maps");
  expect({"--depth", "a"}, "found no extension");
  expect({"--depth", "a.png", "--depth-format", "jpg"}, "expected exr|png16|npy|tiff|colmap, found 'jpg'");
  for (const char* const scale : {"0", "-1", "nan", "inf", "1e10", "x"})
    expect({"--depth", "a.png", "--depth-scale", scale}, "--depth-scale: invalid value; expected a number");
  expect({"--depth-scale", "5", "-o", "a.png"}, "--depth-scale requires --depth");
  expect({"--depth-mask", "m.png", "-o", "a.png"}, "--depth-mask requires --depth");
  expect({"--depth", "there.npy"}, "there.npy: the file exists");
  expect({"--depth", "a.npy", "--depth-mask", "m.exr"}, "m.exr: unknown format of masks");
  expect({"--depth", "nowhere/a.npy"}, "nowhere/a.npy: cannot write the file: no such folder");
  expect({"--depth", "a.png", "-o", "other/../a.png"}, "a.png: two outputs have this name");
  expect({"--depth", "a.png", "--depth-mask", "a.png"}, "a.png: two outputs have this name");
  expect({"--depth", "a.npy", "--layers", "depth"}, "--layers requires an image; expected -o FILE");
  expect({"--depth", "a.npy", "--time-limit", "1"}, "--time-limit requires an image");
  expect({"--depth", "a.npy", "--part", "1/2"}, "--part requires an image");
  expect({"--depth", "a.npy", "--preview", "p.png"}, "--preview requires an image");
  expect({"--depth", "a.npy", "--camera", "model"}, "a.npy: 2 cameras, but one output name");
  expect({"--depth", "%s.npy", "--depth-mask", "m.png", "--camera", "model"}, "m.png: 2 cameras");
  expect({"--depth", "a.npy", "--transforms-out", "t.json"},
         "t.json: --transforms-out requires all cameras of a transforms.json");
  expect({"--depth", "%s.npy", "--camera", "model", "--transforms-out", "t.json"},
         "model: --transforms-out requires the cameras of a transforms.json");
  expect(
      {"--depth", "a.npy", "--camera", "transforms.json", "--camera-name", "a", "--transforms-out", "t.json"},
      "t.json: --transforms-out requires all cameras");
  expect({"--depth", "%s.npy", "--camera", "transforms.json", "--transforms-out", "other/t.json"},
         "other/t.json: photographs have names relative to the folder of transforms.json");
  expect({"--depth", "%s.npy", "--camera", "transforms.json", "--transforms-out", "transforms.json",
          "--overwrite"},
         "transforms.json: the output is also an input");
}

TEST_F(RenderDepthTest, maps_come_with_the_first_part_of_an_image_and_stay_when_it_resumes) {
  const std::vector<std::string> words{"--camera", "model",   "--camera-name", "a",         "-q", "-o",
                                       "a.png",    "--depth", "depth.npy",     "--samples", "2"};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = words;
    all.insert(all.end(), more.begin(), more.end());
    return render(all);
  };
  ASSERT_EQ(with({"--part", "2/2"}).exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "depth.npy"));
  ASSERT_EQ(with({"--part", "1/2"}).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(folder / "depth.npy"));
  const ProgramResult again = with({});
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_TRUE(contains(again.err, "depth.npy: the file exists")) << again.err;
  // Without a checkpoint, a resumption starts from the beginning; with one, the map may stay.
  EXPECT_EQ(with({"--checkpoint", "state", "--resume"}).exit_code, 2);
  write("state", "not a checkpoint");
  const ProgramResult resumed = with({"--checkpoint", "state", "--resume"});
  EXPECT_FALSE(contains(resumed.err, "depth.npy")) << resumed.err;
}

TEST_F(RenderDepthTest, a_full_disk_leaves_no_map) {
  const ProgramResult result = run_on_full_disk(
      {"render", "--cloud", "square.xyz", "--size", "200x200", "--depth", "a.npy", "-q"}, 8192);
  EXPECT_EQ(result.exit_code, 2) << result.err;
  EXPECT_TRUE(contains(result.err, "a.npy: cannot write")) << result.err;
  EXPECT_EQ(names(), (std::vector<std::string>{"model", "square.xyz", "transforms.json"}));
}

}  // namespace
}  // namespace alidade::test
