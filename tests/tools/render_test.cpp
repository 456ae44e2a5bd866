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

TEST_F(RenderCommandTest, a_legend_changes_nothing_about_the_image) {
  write_square("square.xyz");
  const auto render = [&](const Words& words) {
    ASSERT_EQ(run(with(small({"square.xyz", "--color-by", "height"}), words)).exit_code, 0);
  };
  render({"-o", "plain.png"});
  render({"-o", "with.png", "--legend", "legend.png", "--legend-size", "400x300"});
  EXPECT_EQ(read("plain.png"), read("with.png"));
  render({"-o", "again.png", "--legend=second.png", "--legend-size=400x300"});
  EXPECT_EQ(read("plain.png"), read("again.png"));
  EXPECT_EQ(read("legend.png"), read("second.png"));
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

TEST_F(RenderCommandTest, max_level_of_points_without_levels_is_an_error) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "2000", "-o", "site.las", "-q"}).exit_code, 0);
  const ProgramResult result =
      run({"render", "--cloud", "site.las", "-o", "out.png", "--max-level", "2", "--dry-run"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("max_level requires a layered index; expected an index file"), std::string::npos)
      << result.err;
}

}  // namespace
}  // namespace alidade::test
