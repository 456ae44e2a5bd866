// SPDX-License-Identifier: MIT
#include "jobs/compare/compare.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "cloud/read_cloud.h"
#include "compare/report/comparison_json.h"
#include "jobs/field_table.h"
#include "tests/compare/drawn_images.h"
#include "tests/compare/image_files.h"
#include "tests/jobs/heard.h"

namespace alidade::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Comparisons of images, requested as on a command line.
class CompareJobTest : public ImageFilesTest {
 protected:
  void SetUp() override {
    ImageFilesTest::SetUp();
    before_ = fs::current_path();
    fs::current_path(folder);
  }
  void TearDown() override {
    fs::current_path(before_);
    ImageFilesTest::TearDown();
  }

  /// The request of words between single spaces: REFERENCE, TEST, then fields.
  static jobs::CompareRequest read(const std::string& text, jobs::CompareRequest& request) {
    const auto table = std::make_shared<jobs::FieldTable>("compare");
    jobs::add_compare_fields(jobs::Fields(table), request);
    std::istringstream stream(text);
    const std::vector<std::string> words{std::istream_iterator<std::string>(stream), {}};
    table->give("reference", {words.at(0)});
    table->give("test", {words.at(1)});
    for (std::size_t i = 2; i < words.size(); ++i) {
      const bool is_flag = i + 1 == words.size() || words[i + 1].starts_with("--");
      table->give(words[i].substr(2), is_flag ? std::vector<std::string>{} : std::vector{words[i + 1]});
      i += is_flag ? 0 : 1;
    }
    table->read();
    return request;
  }
  compare::PairOutcome compared(const std::string& words) {
    jobs::CompareRequest request;
    read(words, request);
    const jobs::ComparePlan checked = plan(request);
    EXPECT_FALSE(checked.request().is_batch);
    return std::move(run(checked, heard).front());
  }
  json found(const std::string& words) {
    const compare::PairOutcome pair = compared(words);
    return json::parse(compare::comparison_json(*pair.comparison, pair.verdict, pair.warnings));
  }
  /// The message of the error; empty: none.
  std::string error(const std::string& words) {
    try {
      (void)compared(words);
    } catch (const std::exception& thrown) {
      return thrown.what();
    }
    return "";
  }

  /// A grey image as text, of numbers 0 .. 255.
  template <typename Value>
  void draw(const std::string& name, int width, int height, const Value& value) const {
    std::ofstream file(folder / name);
    file << "P2\n" << width << " " << height << "\n255\n";
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) file << static_cast<int>(value(x, y)) << "\n";
  }
  std::string text_of(const std::string& name) const {
    std::ifstream file(folder / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  Heard heard;

 private:
  fs::path before_;
};

TEST_F(CompareJobTest, masks_crop_and_size_choose_what_counts) {
  const auto ramp = [](int x, int y) { return 5 * x + y; };
  draw("a.pgm", 40, 30, ramp);
  draw("small.pgm", 20, 15, ramp);
  draw("mask.pgm", 40, 30, [](int x, int) { return x < 8 ? 255 : 0; });
  EXPECT_EQ(found("a.pgm a.pgm")["counted"], 1200);
  EXPECT_EQ(found("a.pgm a.pgm --mask mask.pgm")["counted"], 240);
  EXPECT_EQ(found("a.pgm a.pgm --only 0,0,10,30 --only 10,0,12,5")["counted"], 310);
  EXPECT_EQ(found("a.pgm a.pgm --ignore 0,0,10,30 --ignore 5,0,12,30")["counted"], 840);
  EXPECT_EQ(found("a.pgm a.pgm --only 0,0,10,30 --ignore 0,0,40,29")["counted"], 10);
  EXPECT_EQ(found("a.pgm a.pgm --crop 4,5,20,25")["pixels"], 320);
  EXPECT_NE(error("a.pgm small.pgm --resize none").find("--resize reference"), std::string::npos);
  EXPECT_EQ(found("a.pgm small.pgm --resize reference")["test"]["width"], 40);
}

TEST_F(CompareJobTest, alpha_depth_and_sky_choose_what_counts) {
  // A third of the pixels is transparent, a quarter has no depth, and no id.
  std::vector<float> values;
  for (int i = 0; i < 120; ++i) {
    const bool is_sky = i % 4 == 0;
    values.insert(values.end(), {0.5f, 0.5f, 0.5f, i % 3 == 0 ? 0.0f : 1.0f,
                                 is_sky ? std::numeric_limits<float>::infinity() : 7.0f,
                                 is_sky ? 0.0f : static_cast<float>(i + 1)});
  }
  write_layers("a.exr", 12, 10, {"R", "G", "B", "A", "Z", "id"}, values);
  EXPECT_EQ(found("a.exr a.exr")["counted"], 120);
  EXPECT_EQ(found("a.exr a.exr --opaque")["counted"], 80);
  EXPECT_EQ(found("a.exr a.exr --valid-depth")["counted"], 90);
  EXPECT_EQ(found("a.exr a.exr --ignore-sky")["counted"], 90);
}

TEST_F(CompareJobTest, colours_are_matched_and_edges_aligned) {
  const auto blot = [](double x, double y) { return 40 + 200 * blots(x, y); };
  draw("a.pgm", 96, 80, blot);
  draw("darker.pgm", 96, 80, [&](int x, int y) { return std::lround(0.8 * blot(x, y)); });
  draw("moved.pgm", 96, 80, [&](int x, int y) { return blot(x - 5, y); });
  const json matched = found("a.pgm darker.pgm --match exposure");
  EXPECT_GT(matched["match"]["scale"][0], 1.3) << "0.8 of the codes is 0.62 of the light";
  EXPECT_LT(matched["match"]["metrics"]["rmse"], 0.1 * matched["metrics"]["rmse"].get<double>());
  EXPECT_NE(found("a.pgm darker.pgm --match affine")["match"]["offset"][0], 0.0);
  const json aligned = found("a.pgm moved.pgm --align")["alignment"];
  EXPECT_TRUE(aligned["certain"]);
  EXPECT_NEAR(aligned["shift"][0], 5.0, 0.2);
  EXPECT_FALSE(found("a.pgm moved.pgm --align --largest-shift 2")["alignment"]["certain"]);
}

TEST_F(CompareJobTest, flip_is_seen_from_another_distance_and_in_other_exposures) {
  std::vector<float> sunny, cloudy;
  for (int i = 0; i < 3 * 32 * 24; ++i) {
    const auto light = static_cast<float>(blots(i / 3 % 32, i / 3 / 32.0));
    sunny.push_back(2.0f * light);
    cloudy.push_back(0.5f * light * light);
  }
  write_image("a.exr", 32, 24, sunny);
  write_image("b.exr", 32, 24, cloudy);
  const auto flip = [&](const std::string& words) {
    return json(
        found("a.exr b.exr --start-exposure -2 --stop-exposure 1 --exposures 3" + words)["metrics"]["flip"]);
  };
  const json plain = flip("");
  EXPECT_EQ(plain["start_exposure"], -2.0);
  EXPECT_EQ(plain["stop_exposure"], 1.0);
  EXPECT_EQ(plain["exposures"], 3);
  for (const char* const words :
       {" --pixels-per-degree 20", " --tone-mapper hable", " --tone-mapper reinhard"})
    EXPECT_NE(flip(words)["mean"], plain["mean"]) << words;
}

TEST_F(CompareJobTest, thresholds_and_sizes_choose_regions_of_change) {
  draw("a.pgm", 60, 40, [](int, int) { return 0; });
  draw("b.pgm", 60, 40, [](int x, int y) {
    const bool is_small = x < 8 && y < 8, is_large = x >= 30 && x < 50 && y >= 10 && y < 30;
    return is_large ? 100 : is_small ? 250 : 0;
  });
  const auto regions = [&](const std::string& words) {
    return compared("a.pgm b.pgm --changes color" + words).comparison->changes->regions.size();
  };
  EXPECT_EQ(regions(""), 2u);
  EXPECT_EQ(regions(" --change-threshold 0.5"), 1u) << "the small one";
  EXPECT_EQ(regions(" --least-pixels 100"), 1u) << "the large one";
  EXPECT_EQ(regions(" --change-threshold 0.5 --least-pixels 100"), 0u);
  EXPECT_FALSE(found("a.pgm b.pgm --changes flip")["changes"]["regions"].empty());
}

TEST_F(CompareJobTest, pages_hold_images_as_requested) {
  draw("a.pgm", 40, 30, [](int x, int y) { return 5 * x + y; });
  for (const std::string packing : {"png", "jpeg"}) {
    EXPECT_EQ(error("a.pgm a.pgm --report " + packing + ".html --report-pictures " + packing), "");
    EXPECT_NE(text_of(packing + ".html").find("data:image/" + packing), std::string::npos) << packing;
  }
  EXPECT_EQ(text_of("png.html").find("data:image/jpeg"), std::string::npos);
}

TEST_F(CompareJobTest, repeated_thresholds_hold_together) {
  draw("a.pgm", 20, 10, [](int x, int) { return 5 * x; });
  draw("b.pgm", 20, 10, [](int x, int y) { return 5 * x + 3 * y; });
  EXPECT_TRUE(compared("a.pgm b.pgm --fail-above flip=1").pass());
  EXPECT_FALSE(compared("a.pgm b.pgm --fail-above flip=0 --fail-above flip=1").pass());
  EXPECT_TRUE(compared("a.pgm b.pgm --warn-above flip=0 --warn-above rmse=0").pass());
  ASSERT_EQ(heard.warnings.size(), 2u) << heard.text();
  EXPECT_TRUE(heard.warnings[0].starts_with("beyond flip=0")) << heard.text();
  EXPECT_TRUE(heard.warnings[1].starts_with("beyond rmse=0")) << heard.text();
}

TEST_F(CompareJobTest, missing_maps_are_errors_before_anything_is_written) {
  write_image("a.exr", 4, 3, std::vector<float>(36, 0.5f));
  const std::string message = error("a.exr a.exr --report r.html --flip-map flip.png --depth-map depth.png");
  EXPECT_TRUE(message.starts_with("depth.png: this map cannot be computed from these images")) << message;
  for (const char* const name : {"r.html", "flip.png", "depth.png"})
    EXPECT_FALSE(fs::exists(folder / name)) << name;
}

TEST_F(CompareJobTest, agreement_is_a_map_with_figures_and_requires_depth_sigma) {
  std::vector<float> plain, scan;
  for (int i = 0; i < 80; ++i) {
    plain.insert(plain.end(), {0.5f, 0.5f, 0.5f, 10.0f});
    scan.insert(scan.end(), {0.5f, 0.5f, 0.5f, 10.02f, 0.01f});
  }
  write_layers("plain.exr", 10, 8, {"R", "G", "B", "Z"}, plain);
  write_layers("scan.exr", 10, 8, {"R", "G", "B", "Z", "depth.sigma"}, scan);
  const json metrics = found("plain.exr scan.exr --agreement-map map.png")["metrics"];
  EXPECT_EQ(metrics["depth_differs"], 0.0);
  EXPECT_EQ(metrics["depth_not_scanned"], 0.0);
  EXPECT_GT(metrics["depth_agrees"], 0.0);
  EXPECT_TRUE(text_of("map.png").starts_with("\x89PNG"));
  EXPECT_NE(error("plain.exr scan.exr --agreement-map map.png").find("the file exists"), std::string::npos);
  EXPECT_TRUE(compared("plain.exr scan.exr --fail-above depth_differs=0").pass());
  EXPECT_FALSE(compared("plain.exr scan.exr --fail-above depth_agrees=100.5").pass());
  const std::string message = error("plain.exr plain.exr --agreement-map none.png");
  EXPECT_TRUE(message.starts_with("none.png: this map cannot be computed from these images")) << message;
  EXPECT_NE(message.find("render --layers color,depth,depth.sigma"), std::string::npos) << message;
  EXPECT_FALSE(fs::exists(folder / "none.png"));
  EXPECT_NE(error("plain.exr plain.exr --fail-above depth_agrees=90").find("depth.sigma"), std::string::npos);
}

TEST_F(CompareJobTest, points_behind_changes_of_depth_are_written) {
  // Points 1 apart, seen from above by a pixel each; a block of 10 by 10 has gone.
  std::vector<float> before, after;
  std::ofstream old_cloud(folder / "before.xyz"), new_cloud(folder / "after.xyz");
  for (int i = 0; i < 1600; ++i) {
    const int x = i % 40, y = i / 40;
    const bool is_block = x >= 15 && x < 25 && y >= 15 && y < 25;
    old_cloud << x << " " << y << (is_block ? " 3\n" : " 0\n");
    new_cloud << x << " " << y << " 0\n";
    before.insert(before.end(), {is_block ? 47.0f : 50.0f, static_cast<float>(i + 1)});
    after.insert(after.end(), {50.0f, static_cast<float>(i + 1)});
  }
  old_cloud.close();
  new_cloud.close();
  write_layers("before.exr", 40, 40, {"Z", "id"}, before);
  write_layers("after.exr", 40, 40, {"Z", "id"}, after);
  const json changes = found(
      "before.exr after.exr --changes depth --reference-cloud before.xyz --reference-points gone.las "
      "--test-cloud after.xyz --test-points came.las --depth-map depth.png")["changes"];
  EXPECT_EQ(changes["regions"].size(), 1u);
  const PointCloud gone = read_cloud(folder / "gone.las"), came = read_cloud(folder / "came.las");
  ASSERT_GE(gone.size(), 90u) << "the block, perhaps without its corners";
  ASSERT_LE(gone.size(), 100u);
  for (std::size_t row = 0; row < gone.size(); ++row) EXPECT_EQ(gone.world(row).z, 3.0);
  EXPECT_EQ(came.size(), gone.size());
  EXPECT_EQ(came.world(0).z, 0.0) << "the ground below it";
  EXPECT_TRUE(text_of("depth.png").starts_with("\x89PNG"));

  // The cloud is another one: nothing is written, though all the rest could be.
  std::ofstream(folder / "other.xyz") << "0 0 0\n";
  EXPECT_NE(error("before.exr after.exr --changes depth --reference-cloud other.xyz --reference-points "
                  "new.las --report new.html --depth-map new.png"),
            "");
  for (const char* const name : {"new.las", "new.html", "new.png"})
    EXPECT_FALSE(fs::exists(folder / name)) << name;
}

TEST_F(CompareJobTest, fields_that_would_do_nothing_are_errors) {
  draw("a.pgm", 20, 10, [](int x, int) { return 5 * x; });
  for (const char* const name : {"x", "y"}) {
    fs::create_directory(folder / name);
    fs::copy(folder / "a.pgm", folder / name / "one.pgm");
  }
  for (const char* const words :
       {"a.pgm a.pgm --change-threshold 0.5", "a.pgm a.pgm --least-pixels 3", "a.pgm a.pgm --largest-shift 3",
        "a.pgm a.pgm --report-pictures png", "x y --report s.html --report-pictures png",
        "x y --reference-cloud a.xyz", "a.pgm a.pgm --test-cloud a.xyz", "a.pgm a.pgm --reports pages",
        "a.pgm a.pgm --reference-points p.las", "a.pgm a.pgm --pairs pairs.csv", "x y --flip-map f.png"})
    EXPECT_NE(error(words), "") << words;
  EXPECT_EQ(error("a.pgm a.pgm --exposures 5"), "");
  EXPECT_NE(heard.text().find("exposures and tone mapper require linear light"), std::string::npos);
}

TEST_F(CompareJobTest, folders_are_pairs_by_name) {
  draw("a.pgm", 20, 10, [](int x, int) { return 5 * x; });
  draw("b.pgm", 20, 10, [](int x, int) { return 10 * x; });
  for (const char* const name : {"x", "y"}) fs::create_directory(folder / name);
  for (const char* const name : {"x/one.pgm", "x/two.pgm", "y/one.pgm"})
    fs::copy(folder / "a.pgm", folder / name);
  fs::copy(folder / "b.pgm", folder / "y/two.pgm");
  jobs::CompareRequest request;
  const jobs::ComparePlan checked = plan(read("x y --fail-above flip=0.001", request));
  EXPECT_TRUE(checked.request().is_batch);
  request.comparison.mask = "mask.pgm";
  request.reports = "pages";
  const jobs::PlannedWork work = plan(request).work();
  EXPECT_EQ(std::ranges::count(work.reads, fs::path("mask.pgm")), 1);
  EXPECT_EQ(std::ranges::count(work.writes, fs::path("pages")), 1);
  const jobs::CompareResult pairs = run(checked, heard);
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].pair.name, "two.pgm") << "the worst first";
  EXPECT_FALSE(pairs[0].pass());
  EXPECT_TRUE(pairs[1].pass());
}

}  // namespace
}  // namespace alidade::test
