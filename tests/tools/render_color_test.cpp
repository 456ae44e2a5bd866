// SPDX-License-Identifier: MIT
#include <algorithm>

#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

class RenderColorTest : public ProgramTest {
 protected:
  /// A small cloud with every attribute of LAS.
  void SetUp() override {
    ProgramTest::SetUp();
    ASSERT_EQ(run({"generate", "courtyard", "--points", "5000", "-o", "yard.las", "-q"}).exit_code, 0);
  }

  ProgramResult render(Words more) {
    Words words = {"render", "--cloud", "yard.las", "--size=16x12", "--samples=1"};
    if (std::ranges::find(more, "-o") == more.end()) words.insert(words.end(), {"-o", "out.png"});
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  }
  bool is_there(const std::string& name) const { return std::filesystem::exists(folder / name); }
};

TEST_F(RenderColorTest, every_way_to_colour_makes_its_own_image_and_a_legend) {
  Words images;
  for (const std::string by : {"intensity", "height", "classification", "normal", "gps_time", "scan_angle"}) {
    const ProgramResult result =
        render({"--color-by", by, "--legend", by + ".png", "-o", "out_" + by + ".png"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(contains(result.err, "5000 points, coloured by " + by)) << result.err;
    EXPECT_EQ(read(by + ".png").substr(1, 3), "PNG");
    const std::string image = read("out_" + by + ".png");
    EXPECT_TRUE(contains(image, "alidade:color_by")) << by;
    images.push_back(image.substr(image.find("IDAT")));
  }
  std::ranges::sort(images);
  EXPECT_EQ(std::ranges::adjacent_find(images), images.end());
}

TEST_F(RenderColorTest, range_and_map_are_printed_and_stored) {
  const ProgramResult result =
      render({"--color", "height", "--color-map", "turbo", "--color-range", "600,610.5"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "height: 600 to 610.5 m (all 5")) << result.err;
  EXPECT_TRUE(contains(result.err, "colour map turbo")) << result.err;
  const std::string image = read("out.png");
  EXPECT_TRUE(contains(image, "600 610.5"));
  EXPECT_TRUE(contains(image, "turbo"));
}

TEST_F(RenderColorTest, a_legend_changes_nothing_about_the_image) {
  ASSERT_EQ(render({"--color-by", "height", "-o", "plain.png"}).exit_code, 0);
  ASSERT_EQ(
      render({"--color-by", "height", "-o", "with.png", "--legend", "legend.png", "--legend-size", "400x300"})
          .exit_code,
      0);
  EXPECT_EQ(read("plain.png"), read("with.png"));
  ASSERT_EQ(
      render({"--color-by", "height", "-o", "again.png", "--legend=second.png", "--legend-size=400x300"})
          .exit_code,
      0);
  EXPECT_EQ(read("legend.png"), read("second.png"));
}

TEST_F(RenderColorTest, options_override_the_scene) {
  const auto write_scene = [&](const std::string& color) {
    write("scene.json", R"({"version": 1, "cloud": {"file": "yard.las", "color": )" + color + "}}");
  };
  const auto said = [&](Words more) {
    Words words = {"render", "scene.json", "--size=8x6", "--samples=1", "-o", "out.png", "--overwrite"};
    words.insert(words.end(), more.begin(), more.end());
    return run(words).err;
  };
  write_scene(R"({"by": "height", "map": "turbo", "range": [600, 605]})");
  EXPECT_TRUE(contains(said({}), "height: 600 to 605 m"));
  EXPECT_TRUE(contains(said({"--color-range", "599,601"}), "height: 599 to 601 m"));
  EXPECT_TRUE(contains(said({"--color-map", "viridis"}), "colour map viridis"));
  EXPECT_TRUE(contains(said({"--color-percentiles", "5,95"}), "percentiles 5 to 95"));
  // The map and range were meant for heights.
  EXPECT_TRUE(contains(said({"--color-by", "intensity"}), "(percentiles 1 to 99; "));
  EXPECT_TRUE(contains(said({"--color-by", "intensity"}), "colour map grey"));
}

TEST_F(RenderColorTest, single_classes_can_have_other_colours) {
  ASSERT_EQ(render({"--color-by", "classification", "--legend", "usual.png", "-o", "a.png"}).exit_code, 0);
  ASSERT_EQ(render({"--color-by", "classification", "--class-color", "6=#102030,2=#00ff00", "--legend",
                    "changed.png", "-o", "b.png"})
                .exit_code,
            0);
  EXPECT_NE(read("usual.png"), read("changed.png"));
  const ProgramResult rejected =
      render({"--color-by", "height", "--class-color", "6=#102030", "-o", "c.png"});
  EXPECT_EQ(rejected.exit_code, 2);
  EXPECT_TRUE(contains(rejected.err, "class colours require classification")) << rejected.err;
}

TEST_F(RenderColorTest, a_legend_of_the_points_own_colours_is_an_error_with_the_reason) {
  for (const Words& words : {Words{"--color-by", "rgb"}, Words{}}) {
    Words more = words;
    more.insert(more.end(), {"--legend", "legend.png"});
    const ProgramResult result = render(more);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(contains(result.err, "rgb colours have no legend")) << result.err;
    EXPECT_EQ(names(), Words{"yard.las"});
  }
}

TEST_F(RenderColorTest, a_legend_that_cannot_be_written_is_an_error_before_the_work) {
  write("old.png", "precious");
  for (const Words& words : {Words{"--legend", "none/legend.png"},
                             {"--legend", "old.png"},
                             {"--legend", "out.png"},
                             {"--legend", "./sub/../out.png"},
                             {"--legend", "l.png", "--legend-size", "20x20"}}) {
    Words more = words;
    more.insert(more.end(), {"--color-by", "height"});
    const ProgramResult result = render(more);
    EXPECT_EQ(result.exit_code, 2) << words[1];
    EXPECT_TRUE(contains(result.err, "alidade: error: ")) << result.err;
    EXPECT_EQ(names(), (Words{"old.png", "yard.las"})) << words[1];
  }
  EXPECT_EQ(read("old.png"), "precious");
  EXPECT_EQ(render({"--color-by", "height", "--legend", "old.png", "--overwrite"}).exit_code, 0);
  EXPECT_NE(read("old.png"), "precious");
}

TEST_F(RenderColorTest, a_legend_that_is_there_already_may_stay) {
  write("legend.png", "earlier");
  const ProgramResult result = render({"--color-by", "height", "--legend", "legend.png", "--skip-existing"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(read("legend.png"), "earlier");
  EXPECT_TRUE(is_there("out.png"));
}

TEST_F(RenderColorTest, a_legend_of_other_colours_does_not_stay_without_the_checkpoint_it_was_made_with) {
  ASSERT_EQ(render({"--color-by", "height", "--legend", "legend.png"}).exit_code, 0);
  const std::string heights = read("legend.png");
  const Words classes = {"--color-by", "classification", "--legend",
                         "legend.png", "--checkpoint=s", "--resume"};
  Words more = classes;
  more.insert(more.end(), {"-o", "classes.png"});
  const ProgramResult rejected = render(more);
  EXPECT_EQ(rejected.exit_code, 2);
  EXPECT_TRUE(contains(rejected.err, "legend.png: the file exists")) << rejected.err;
  EXPECT_EQ(read("legend.png"), heights);
  more.push_back("--overwrite");
  EXPECT_EQ(render(more).exit_code, 0);
  EXPECT_NE(read("legend.png"), heights);
}

TEST_F(RenderColorTest, a_size_without_a_legend_is_an_error) {
  EXPECT_EQ(render({"--color-by", "height", "--legend-size", "300x300"}).exit_code, 2);
}

TEST_F(RenderColorTest, a_missing_attribute_is_an_error_that_lists_what_the_cloud_has) {
  const ProgramResult result = render({"--color-by", "greenish"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err,
                       "yard.las: the cloud has no attribute \"greenish\"; expected one of height, "
                       "normal, rgb, intensity, classification"))
      << result.err;
  write_square("square.xyz");
  const ProgramResult of_text =
      run({"render", "--cloud", "square.xyz", "--color-by", "classification", "-o", "out.png"});
  EXPECT_EQ(of_text.exit_code, 2);
  EXPECT_TRUE(contains(of_text.err, "expected one of height, normal")) << of_text.err;
}

TEST_F(RenderColorTest, a_scene_without_a_cloud_has_no_legend) {
  write("scene.json", R"({"version": 1, "objects": [{"type": "ground_plane"}]})");
  const ProgramResult result = run({"render", "scene.json", "-o", "out.png", "--legend", "legend.png"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "scene.json: the scene has no cloud for --legend\n")) << result.err;
}

TEST_F(RenderColorTest, a_range_and_percentiles_of_one_image_are_an_error) {
  const ProgramResult result =
      render({"--color-by", "height", "--color-range", "600,610", "--color-percentiles", "5,95"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "--color-range")) << result.err;
  EXPECT_TRUE(contains(result.err, "--color-percentiles")) << result.err;
}

TEST_F(RenderColorTest, a_map_of_the_scene_can_be_put_aside) {
  write("scene.json",
        R"({"version": 1, "cloud": {"file": "yard.las", "color": {"by": "height", "map": "turbo"}}})");
  const ProgramResult result =
      run({"render", "scene.json", "--size=8x6", "--samples=1", "-o", "out.png", "--color-map", "auto"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "colour map terrain")) << result.err;
}

}  // namespace
}  // namespace alidade::test
