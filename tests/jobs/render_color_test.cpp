// SPDX-License-Identifier: MIT
#include <algorithm>

#include "tests/jobs/render_job.h"

namespace alidade::test {
namespace {

class RenderColorTest : public RenderJobTest {
 protected:
  /// A small cloud with every attribute of LAS.
  void SetUp() override {
    RenderJobTest::SetUp();
    write_yard("yard.las", 5000);
  }

  RenderOutcome render(Words more) {
    Words words = {"--cloud", "yard.las", "--size=16x12", "--samples=1"};
    if (std::ranges::find(more, "-o") == more.end()) words.insert(words.end(), {"-o", "out.png"});
    words.insert(words.end(), more.begin(), more.end());
    return RenderJobTest::render(words);
  }
  bool is_there(const std::string& name) const { return std::filesystem::exists(folder / name); }
};

TEST_F(RenderColorTest, every_way_to_colour_makes_its_own_image_and_a_legend) {
  Words images;
  for (const std::string by : {"intensity", "height", "classification", "normal", "gps_time", "scan_angle"}) {
    const RenderOutcome result =
        render({"--color-by", by, "--legend", by + ".png", "-o", "out_" + by + ".png"});
    ASSERT_TRUE(result.is_done) << result.said;
    EXPECT_TRUE(contains(result.said, "5000 points, coloured by " + by)) << result.said;
    EXPECT_EQ(read(by + ".png").substr(1, 3), "PNG");
    const std::string image = read("out_" + by + ".png");
    EXPECT_TRUE(contains(image, "alidade:color_by")) << by;
    images.push_back(image.substr(image.find("IDAT")));
  }
  std::ranges::sort(images);
  EXPECT_EQ(std::ranges::adjacent_find(images), images.end());
}

TEST_F(RenderColorTest, range_and_map_are_printed_and_stored) {
  const RenderOutcome result =
      render({"--color", "height", "--color-map", "turbo", "--color-range", "600,610.5"});
  ASSERT_TRUE(result.is_done) << result.said;
  EXPECT_TRUE(contains(result.said, "height: 600 to 610.5 m (all 5")) << result.said;
  EXPECT_TRUE(contains(result.said, "colour map turbo")) << result.said;
  const std::string image = read("out.png");
  EXPECT_TRUE(contains(image, "600 610.5"));
  EXPECT_TRUE(contains(image, "turbo"));
}

TEST_F(RenderColorTest, options_override_the_scene) {
  const auto write_scene = [&](const std::string& color) {
    write("scene.json", R"({"version": 1, "cloud": {"file": "yard.las", "color": )" + color + "}}");
  };
  const auto said = [&](Words more) {
    Words words = {"scene.json", "--size=8x6", "--samples=1", "-o", "out.png", "--overwrite"};
    words.insert(words.end(), more.begin(), more.end());
    return RenderJobTest::render(words).said;
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
  ASSERT_TRUE(render({"--color-by", "classification", "--legend", "usual.png", "-o", "a.png"}).is_done);
  ASSERT_TRUE(render({"--color-by", "classification", "--class-color", "6=#102030,2=#00ff00", "--legend",
                      "changed.png", "-o", "b.png"})
                  .is_done);
  EXPECT_NE(read("usual.png"), read("changed.png"));
  const RenderOutcome rejected =
      render({"--color-by", "height", "--class-color", "6=#102030", "-o", "c.png"});
  EXPECT_FALSE(rejected.is_done);
  EXPECT_TRUE(contains(rejected.said, "class colours require classification")) << rejected.said;
}

TEST_F(RenderColorTest, a_legend_of_the_points_own_colours_is_an_error_with_the_reason) {
  for (const Words& words : {Words{"--color-by", "rgb"}, Words{}}) {
    Words more = words;
    more.insert(more.end(), {"--legend", "legend.png"});
    const RenderOutcome result = render(more);
    EXPECT_FALSE(result.is_done);
    EXPECT_TRUE(contains(result.said, "rgb colours have no legend")) << result.said;
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
    const RenderOutcome result = render(more);
    EXPECT_FALSE(result.is_done) << words[1];
    EXPECT_EQ(names(), (Words{"old.png", "yard.las"})) << words[1];
  }
  EXPECT_EQ(read("old.png"), "precious");
  EXPECT_TRUE(render({"--color-by", "height", "--legend", "old.png", "--overwrite"}).is_done);
  EXPECT_NE(read("old.png"), "precious");
}

TEST_F(RenderColorTest, a_legend_that_is_there_already_may_stay) {
  write("legend.png", "earlier");
  const RenderOutcome result = render({"--color-by", "height", "--legend", "legend.png", "--skip-existing"});
  EXPECT_TRUE(result.is_done) << result.said;
  EXPECT_EQ(read("legend.png"), "earlier");
  EXPECT_TRUE(is_there("out.png"));
}

TEST_F(RenderColorTest, a_legend_of_other_colours_does_not_stay_without_the_checkpoint_it_was_made_with) {
  ASSERT_TRUE(render({"--color-by", "height", "--legend", "legend.png"}).is_done);
  const std::string heights = read("legend.png");
  const Words classes = {"--color-by", "classification", "--legend",
                         "legend.png", "--checkpoint=s", "--resume"};
  Words more = classes;
  more.insert(more.end(), {"-o", "classes.png"});
  const RenderOutcome rejected = render(more);
  EXPECT_FALSE(rejected.is_done);
  EXPECT_TRUE(contains(rejected.said, "legend.png: the file exists")) << rejected.said;
  EXPECT_EQ(read("legend.png"), heights);
  more.push_back("--overwrite");
  EXPECT_TRUE(render(more).is_done);
  EXPECT_NE(read("legend.png"), heights);
}

TEST_F(RenderColorTest, a_size_without_a_legend_is_an_error) {
  EXPECT_FALSE(render({"--color-by", "height", "--legend-size", "300x300"}).is_done);
}

TEST_F(RenderColorTest, a_missing_attribute_is_an_error_that_lists_what_the_cloud_has) {
  const RenderOutcome result = render({"--color-by", "greenish"});
  EXPECT_FALSE(result.is_done);
  EXPECT_TRUE(contains(result.said,
                       "yard.las: the cloud has no attribute \"greenish\"; expected one of height, "
                       "normal, rgb, intensity, classification"))
      << result.said;
  write_square("square.xyz");
  const RenderOutcome of_text =
      RenderJobTest::render({"--cloud", "square.xyz", "--color-by", "classification", "-o", "out.png"});
  EXPECT_FALSE(of_text.is_done);
  EXPECT_TRUE(contains(of_text.said, "expected one of height, normal")) << of_text.said;
}

TEST_F(RenderColorTest, a_scene_without_a_cloud_has_no_legend) {
  write("scene.json", R"({"version": 1, "objects": [{"type": "ground_plane"}]})");
  const RenderOutcome result =
      RenderJobTest::render({"scene.json", "-o", "out.png", "--legend", "legend.png"});
  EXPECT_FALSE(result.is_done);
  EXPECT_TRUE(contains(result.said, "scene.json: the scene has no cloud for --legend\n")) << result.said;
}

TEST_F(RenderColorTest, a_range_and_percentiles_of_one_image_are_an_error) {
  const RenderOutcome result =
      render({"--color-by", "height", "--color-range", "600,610", "--color-percentiles", "5,95"});
  EXPECT_FALSE(result.is_done);
  EXPECT_TRUE(contains(result.said, "color_range")) << result.said;
  EXPECT_TRUE(contains(result.said, "color_percentiles")) << result.said;
}

TEST_F(RenderColorTest, a_map_of_the_scene_can_be_put_aside) {
  write("scene.json",
        R"({"version": 1, "cloud": {"file": "yard.las", "color": {"by": "height", "map": "turbo"}}})");
  const RenderOutcome result = RenderJobTest::render(
      {"scene.json", "--size=8x6", "--samples=1", "-o", "out.png", "--color-map", "auto"});
  EXPECT_TRUE(result.is_done) << result.said;
  EXPECT_TRUE(contains(result.said, "colour map terrain")) << result.said;
}

}  // namespace
}  // namespace alidade::test
