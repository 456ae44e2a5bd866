// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <sys/wait.h>

#include <cstdlib>

#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

class RenderCommandTest : public ProgramTest {
 protected:
  std::vector<std::string> small(std::vector<std::string> words) {
    words.insert(words.begin(), "render");
    words.insert(words.end(), {"--size=24x16", "--samples=4"});
    return words;
  }
};

TEST_F(RenderCommandTest, cloud_without_scene_gives_an_image_and_prints_what_was_assumed) {
  write_square("square.xyz");
  const ProgramResult result = run(small({"--cloud", "square.xyz", "-o", "out.png"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(read("out.png").substr(1, 3), "PNG");
  EXPECT_EQ(result.out, "");
  EXPECT_TRUE(contains(result.err, "400 points, coloured by height, discs of radius")) << result.err;
}

TEST_F(RenderCommandTest, quiet_prints_nothing) {
  write_square("square.xyz");
  const ProgramResult result = run(small({"--cloud", "square.xyz", "-o", "out.png", "-q"}));
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.out + result.err, "");
}

TEST_F(RenderCommandTest, same_bytes_on_any_number_of_threads) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "2e4", "-o", "yard.las", "-q"}).exit_code, 0);
  for (const auto& [surface, extension] :
       {std::pair<std::string, std::string>{"blend", ".png"}, {"blend", ".exr"}, {"disc", ".exr"}}) {
    std::string first;
    for (const std::string threads : {"1", "2", "5"}) {
      const std::string name = surface + threads + extension;
      ASSERT_EQ(
          run(small({"--cloud", "yard.las", "--surface", surface, "-q", "--threads", threads, "-o", name}))
              .exit_code,
          0);
      if (first.empty()) first = read(name);
      EXPECT_TRUE(read(name) == first) << name;
    }
  }
}

TEST_F(RenderCommandTest, another_seed_gives_another_image) {
  write_square("square.xyz");
  ASSERT_EQ(run(small({"--cloud", "square.xyz", "--seed", "1", "-o", "a.png"})).exit_code, 0);
  ASSERT_EQ(run(small({"--cloud", "square.xyz", "--seed", "2", "-o", "b.png"})).exit_code, 0);
  EXPECT_NE(read("a.png"), read("b.png"));
}

TEST_F(RenderCommandTest, cloud_options_for_a_scene_without_a_cloud_are_an_error) {
  write("scene.json", R"({"version": 1, "camera": {"version": 1, "model": "pinhole", "width": 8, "height": 8,
    "intrinsics": {"vertical_fov": 50}, "pose": {"look_at": {"eye": [0, -5, 1], "target": [0, 0, 0], "up": [0, 0, 1]}}},
    "objects": [{"type": "sphere", "center": [0, 0, 0], "radius": 1,
                 "material": {"type": "lambertian", "albedo": [0.5, 0.5, 0.5]}}]})");
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{{"--radius", "0.1"},
                                                                                     {"--radius-max", "0.1"},
                                                                                     {"--hits", "t"},
                                                                                     {"--color-by", "height"},
                                                                                     {"--max-level", "3"}}) {
    const ProgramResult rejected = run({"render", "scene.json", words[0], words[1], "-o", "out.png"});
    EXPECT_EQ(rejected.exit_code, 2);
    EXPECT_TRUE(contains(rejected.err, "scene.json: the scene has no cloud for " + words[0] + "\n"))
        << rejected.err;
  }
  const ProgramResult result = run(small({"scene.json", "-o", "out.png"}));
  EXPECT_EQ(result.exit_code, 0) << result.err;
}

TEST_F(RenderCommandTest, clouds_and_scenes_are_told_apart_by_their_content) {
  write_square("square.xyz");
  write_square("other.xyz");
  EXPECT_EQ(run(small({"square.xyz", "-o", "one.png"})).exit_code, 0);
  EXPECT_EQ(run(small({"square.xyz", "other.xyz", "-o", "two.png"})).exit_code, 0);
  write("scene",
        R"({"version": 1, "cloud": {"file": "square.xyz"}, "camera": {"version": 1, "model": "pinhole",
    "width": 8, "height": 8, "intrinsics": {"vertical_fov": 50},
    "pose": {"look_at": {"eye": [101, 198, 7], "target": [101, 201, 5], "up": [0, 0, 1]}}}})");
  const ProgramResult scene = run(small({"scene", "-o", "scene.png"}));
  EXPECT_EQ(scene.exit_code, 0) << scene.err;
  write("bad.json", "square.xyz");
  EXPECT_TRUE(contains(run(small({"bad.json", "-o", "no.png"})).err, "bad.json:1:1: invalid JSON"));
  const ProgramResult both = run(small({"square.xyz", "scene", "-o", "no.png"}));
  EXPECT_EQ(both.exit_code, 2);
  EXPECT_TRUE(contains(both.err, "expected one scene file, or clouds, found the scene 'scene' and 1 more"))
      << both.err;
  const ProgramResult site = run(small({"square.xyz", "--site", "courtyard", "-o", "no.png"}));
  EXPECT_EQ(site.exit_code, 2);
  EXPECT_TRUE(contains(site.err, "--site does not apply to a cloud")) << site.err;
}

TEST_F(RenderCommandTest, an_exact_site_takes_the_place_of_the_cloud) {
  ASSERT_EQ(run(small({"--site", "courtyard", "-o", "site.png"})).exit_code, 0);
  write("scene.json", R"({"version": 1, "cloud": {"file": "none.las"}})");
  ASSERT_EQ(run(small({"scene.json", "--site", "courtyard", "-o", "scene.png"})).exit_code, 0);
  EXPECT_NE(read("site.png"), read("scene.png"));  // whose light is another
  const ProgramResult radius = run(small({"--site", "courtyard", "--radius", "0.1", "-o", "no.png"}));
  EXPECT_EQ(radius.exit_code, 2);
  EXPECT_TRUE(contains(radius.err, "--radius has no effect with --site")) << radius.err;
  write("glass.json", R"({"version": 1, "cloud": {"file": "none.las", "material": {"type": "dielectric"}}})");
  const ProgramResult glass = run(small({"glass.json", "--site", "courtyard", "-o", "no.png"}));
  EXPECT_EQ(glass.exit_code, 2);
  EXPECT_TRUE(contains(glass.err, "--site does not support glass")) << glass.err;
  EXPECT_EQ(run(small({"--site", "moon", "-o", "no.png"})).exit_code, 2);
}

TEST_F(RenderCommandTest, clouds_are_discs_unless_options_are_of_spheres) {
  write_square("square.xyz");
  int number = 0;
  const auto expect_surface = [&](std::vector<std::string> options, const std::string& surface) {
    options.insert(options.begin(), {"--cloud", "square.xyz", "-o", std::to_string(number++) + ".png"});
    const ProgramResult result = run(small(options));
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(contains(result.err, surface)) << result.err;
  };
  expect_surface({}, "discs of radius 0.92 times the distance to neighbour 8");
  expect_surface({"--surface", "disc", "--radius-factor", "0.5"}, "discs of radius 0.5 times");
  expect_surface({"--surface", "sphere"}, "spheres of radius");
  expect_surface({"--radius", "0.5"}, "spheres of radius 0.5");
  expect_surface({"--normals", "sphere"}, "spheres of radius");
  expect_surface({"--radius", "adapted", "--radius-neighbours", "2"}, "spheres of radius 0.75 times");
  for (const std::vector<std::string>& option :
       {std::vector<std::string>{"--radius", "0.5"}, {"--hits", "t"}, {"--normals", "smooth"}}) {
    const ProgramResult result =
        run(small({"--cloud", "square.xyz", "--surface", "disc", option[0], option[1], "-o", "no.png"}));
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(contains(result.err, option[0])) << result.err;
    EXPECT_TRUE(contains(result.err, "has no effect on discs")) << result.err;
  }
}

TEST_F(RenderCommandTest, misspelt_key_in_a_scene_gives_file_line_and_suggestion) {
  write("scene.json", "{\n  \"version\": 1,\n  \"camrea\": \"a.json\"\n}\n");
  const ProgramResult result = run({"render", "scene.json", "-o", "out.png"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "alidade: error: scene.json:3:")) << result.err;
  EXPECT_TRUE(contains(result.err, "camera")) << result.err;
}

TEST_F(RenderCommandTest, cloud_without_points_has_no_view) {
  write("empty.ply",
        "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float "
        "z\nend_header\n");
  const ProgramResult result = run(small({"--cloud", "empty.ply", "-o", "out.png"}));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "empty.ply: the cloud has no points")) << result.err;
  ASSERT_EQ(run({"index", "empty.ply", "-o", "empty.alidade", "-q"}).exit_code, 0);
  const ProgramResult of_index = run(small({"--cloud", "empty.alidade", "-o", "out.png"}));
  EXPECT_EQ(of_index.exit_code, 2);
  EXPECT_TRUE(contains(of_index.err, "empty.alidade: the cloud has no points")) << of_index.err;
}

TEST_F(RenderCommandTest, missing_part_that_writes_images_is_an_error_before_the_work) {
  write_square("square.xyz");
  std::filesystem::copy(program_file(), folder / "alone");
  const std::string command =
      fmt::format("cd '{}' && ./alone render --cloud square.xyz -o out.png 2> said", folder.string());
  const int status = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 2);
  EXPECT_TRUE(contains(read("said"), "alidade_openimageio")) << read("said");
  EXPECT_FALSE(contains(read("said"), "loading cloud")) << read("said");
  EXPECT_EQ(names(), (std::vector<std::string>{"alone", "said", "square.xyz"}));
}

TEST_F(RenderCommandTest, one_point_is_an_image) {
  write("one.xyz", "690000 5325000 500\n");
  EXPECT_EQ(run(small({"--cloud", "one.xyz", "-o", "out.png"})).exit_code, 0);
}

TEST_F(RenderCommandTest, names_that_are_not_ascii_and_hold_spaces_work) {
  write_square("Würfel und Plätze.xyz");
  EXPECT_EQ(run(small({"--cloud", "Würfel und Plätze.xyz", "-o", "Bild 1.png"})).exit_code, 0);
  EXPECT_EQ(run({"info", "--json", "Würfel und Plätze.xyz"}).exit_code, 0);
}

TEST_F(RenderCommandTest, max_level_shows_a_thinned_cloud_of_a_layered_index) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "20000", "-o", "site.las", "-q"}).exit_code, 0);
  ASSERT_EQ(run({"index", "site.las", "--organisation", "layered", "-o", "site.alidade", "-q"}).exit_code, 0);
  const auto render = [&](const std::string& image, const std::vector<std::string>& options) {
    std::vector<std::string> words = {"render", "--cloud", "site.alidade", "-o", image,
                                      "--size", "32x24",   "--samples",    "2"};
    words.insert(words.end(), options.begin(), options.end());
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const std::string content = read(image);
    return content.substr(content.find("IDAT"));  // before that stands the command
  };
  const std::string whole = render("whole.png", {"--surface", "sphere"}),
                    coarse = render("coarse.png", {"--max-level", "1"});
  EXPECT_NE(whole, coarse);
  // All levels there are make the whole cloud, with the same radius.
  EXPECT_EQ(whole, render("all.png", {"--max-level", "255"}));
}

TEST_F(RenderCommandTest, adapted_radii_are_measured_once_and_kept_in_an_index_file) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "20000", "-o", "site.las", "-q"}).exit_code, 0);
  ASSERT_EQ(run({"index", "site.las", "--spacings", "8", "-o", "site.alidade", "-q"}).exit_code, 0);
  const auto render = [&](const std::string& cloud, const std::string& image) {
    const ProgramResult result =
        run({"render", "--cloud", cloud, "-o", image, "--surface", "sphere", "--radius", "adapted",
             "--radius-max", "2", "--size", "32x24", "--samples", "2"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(contains(result.err, "spheres of radius 0.75 times the distance to neighbour 8, at most 2"))
        << result.err;
    const std::string content = read(image);
    return std::pair(content.substr(content.find("IDAT")), contains(result.err, "measuring spacings"));
  };
  const auto [measured, did_measure] = render("site.las", "measured.png");
  const auto [kept, did_measure_again] = render("site.alidade", "kept.png");
  EXPECT_TRUE(did_measure);
  EXPECT_FALSE(did_measure_again);
  EXPECT_EQ(measured, kept);
}

TEST_F(RenderCommandTest, options_of_adapted_radii_beside_one_radius_are_an_error) {
  write_square("square.xyz");
  for (const std::string radius : {"0.1", "auto"}) {
    for (const std::string option : {"--radius-factor", "--radius-neighbours", "--radius-max"}) {
      const ProgramResult result =
          run({"render", "--cloud", "square.xyz", "-o", "out.png", option, "2", "--radius", radius});
      EXPECT_EQ(result.exit_code, 2);
      EXPECT_TRUE(contains(result.err, "error: " + option + ": requires --radius adapted")) << result.err;
    }
  }
}

TEST_F(RenderCommandTest, options_of_adapted_radii_leave_the_others_as_the_scene_has_them) {
  write_square("square.xyz");
  const auto said = [&](const std::string& radius, const std::vector<std::string>& more) {
    write("scene.json", R"({"version": 1, "cloud": {"file": "square.xyz", "radius": )" + radius + "}}");
    std::vector<std::string> words = small({"scene.json", "-o", "out.png", "--overwrite"});
    words.insert(words.end(), more.begin(), more.end());
    return run(words).err;
  };
  const std::string own = R"({"neighbours": 3, "factor": 1.5, "max": 0.5})";
  EXPECT_TRUE(contains(said(own, {"--radius-factor", "2"}),
                       "radius 2 times the distance to neighbour 3, at most 0.5"));
  EXPECT_TRUE(contains(said(own, {"--radius-neighbours", "5", "--radius-max", "0.25"}),
                       "radius 1.5 times the distance to neighbour 5, at most 0.25"));
  EXPECT_TRUE(contains(said(own, {"--radius", "adapted"}),
                       "radius 1.5 times the distance to neighbour 3, at most 0.5"));
  EXPECT_FALSE(contains(said(own, {"--radius-max", "auto"}), "at most 0.5"));
  EXPECT_TRUE(contains(said(own, {"--radius", "0.125"}), "spheres of radius 0.125\n"));
  EXPECT_TRUE(contains(said(own, {"--radius", "auto"}), "(from the spacing of the points)"));
  EXPECT_TRUE(contains(said("0.125", {"--radius-max", "0.25"}),
                       "radius 0.75 times the distance to neighbour 8, at most 0.25"));
}

TEST_F(RenderCommandTest, max_level_of_points_without_levels_is_an_error) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "2000", "-o", "site.las", "-q"}).exit_code, 0);
  const ProgramResult result = run({"render", "--cloud", "site.las", "-o", "out.png", "--max-level", "2"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("max_level requires a layered index; expected an index file"), std::string::npos)
      << result.err;
}

}  // namespace
}  // namespace alidade::test
