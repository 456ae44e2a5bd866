// SPDX-License-Identifier: MIT
#include "tests/tools/compare_program.h"

// `alidade compare` on images that the program itself renders.

namespace alidade::test {
namespace {

TEST_F(CompareTest, help_names_units_thresholds_exit_codes_and_examples) {
  const ProgramResult result = compare("--help");
  EXPECT_EQ(result.exit_code, 0);
  for (const char* const part :
       {"metres", "pixels", "STOPS", "flip_median", "depth_5cm", "depth_not_scanned", "--agreement-map",
        "Exit codes:", "Examples:", "--fail-above", "--idiff-codes"})
    EXPECT_TRUE(contains(result.out, part)) << part;
}

TEST_F(CompareTest, equal_images_pass_and_data_alone_goes_to_stdout) {
  render("a.png");
  const ProgramResult result = compare("a.png a.png --json --fail-above flip=0,psnr<inf");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const json found = json::parse(result.out);
  EXPECT_EQ(found["metrics"]["psnr"], "infinity");
  EXPECT_EQ(found["metrics"]["flip"]["mean"], 0.0);
  EXPECT_EQ(found["pass"], true);
}

TEST_F(CompareTest, exit_codes_are_those_of_diff_or_of_idiff) {
  render("a.png");
  render("b.png", "32x24", {"--no-sun"});
  render("small.png", "16x12");
  write("broken.png", "\x89PNG\r\n\x1a\nnothing more");
  EXPECT_EQ(compare("a.png b.png").exit_code, 0) << "without thresholds";
  EXPECT_EQ(compare("a.png b.png --fail-above flip=0").exit_code, 1);
  EXPECT_EQ(compare("a.png small.png").exit_code, 2);
  EXPECT_EQ(compare("a.png broken.png").exit_code, 2);
  EXPECT_EQ(compare("a.png lost.png").exit_code, 2);
  EXPECT_EQ(compare("a.png a.png --idiff-codes").exit_code, 0);
  EXPECT_EQ(compare("a.png b.png --idiff-codes --warn-above flip=0").exit_code, 1);
  EXPECT_EQ(compare("a.png b.png --idiff-codes --warn-above flip=0 --fail-above flip=0").exit_code, 2);
  EXPECT_EQ(compare("a.png small.png --idiff-codes").exit_code, 3);
  EXPECT_EQ(compare("a.png lost.png --idiff-codes").exit_code, 4);
  EXPECT_EQ(compare("a.png a.png --idiff-codes --report-pictures png").exit_code, 4);
}

TEST_F(CompareTest, the_table_has_figures_and_failed_thresholds) {
  render("a.png");
  render("b.png", "32x24", {"--no-sun"});
  const ProgramResult result = compare("a.png b.png --fail-above flip=0,rmse=1");
  for (const char* const part : {"FLIP, mean", "PSNR", "FAILS", "kept", "FAIL\n"})
    EXPECT_TRUE(contains(result.out, part)) << result.out;
}

TEST_F(CompareTest, wrong_thresholds_and_missing_words_are_usage_errors) {
  render("a.png");
  const ProgramResult unknown = compare("a.png a.png --fail-above filp=0.1");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_TRUE(contains(unknown.err, "--fail-above: unknown metric 'filp' in a threshold")) << unknown.err;
  const ProgramResult lacking = compare("a.png a.png --fail-above depth_mean=1");
  EXPECT_EQ(lacking.exit_code, 2);
  EXPECT_TRUE(contains(lacking.err, "the images have no 'depth_mean' for a threshold")) << lacking.err;
  EXPECT_EQ(compare("a.png").exit_code, 2);
  EXPECT_EQ(compare("").exit_code, 2);
  EXPECT_EQ(compare("a.png a.png --crop 0,0,10").exit_code, 2);
  EXPECT_EQ(compare("a.png a.png --crop 5,5,5,10").exit_code, 2);
  EXPECT_EQ(compare("a.png a.png --reference-points p.las").exit_code, 2);
}

TEST_F(CompareTest, repeated_thresholds_hold_together) {
  render("a.png");
  render("b.png", "32x24", {"--no-sun"});
  EXPECT_EQ(compare("a.png b.png --fail-above flip=0 --fail-above flip=1").exit_code, 1);
  const ProgramResult warned = compare("a.png b.png --warn-above flip=0 --warn-above rmse=0");
  EXPECT_TRUE(contains(warned.err, "beyond flip=0") && contains(warned.err, "beyond rmse=0")) << warned.err;
}

TEST_F(CompareTest, options_that_would_do_nothing_are_errors) {
  render("a.png");
  for (const char* const folder_name : {"x", "y"}) {
    std::filesystem::create_directory(folder / folder_name);
    std::filesystem::copy(folder / "a.png", folder / folder_name / "one.png");
  }
  write("pairs.csv", "reference,test\na.png,a.png\n");
  for (const char* const words :
       {"a.png a.png --change-threshold 0.5", "a.png a.png --least-pixels 3", "a.png a.png --largest-shift 3",
        "a.png a.png --report-pictures png", "x y --report s.html --report-pictures png",
        "x y --reference-cloud square.csv", "a.png a.png --test-cloud square.csv",
        "a.png a.png --reports pages", "--pairs pairs.csv a.png"})
    EXPECT_EQ(compare(words).exit_code, 2) << words;
  const ProgramResult result = compare("a.png a.png --exposures 5");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(contains(result.err,
                       "exposures and tone mapper require linear light, but the reference has sRGB values"))
      << result.err;
}

TEST_F(CompareTest, missing_inputs_are_errors_before_anything_is_written) {
  render("a.exr", "32x24", {"--layers", "color"});
  const ProgramResult result =
      compare("a.exr a.exr --report r.html --flip-map flip.png --depth-map depth.png");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "depth.png: this map cannot be computed from these images")) << result.err;
  for (const char* const name : {"r.html", "flip.png", "depth.png"})
    EXPECT_FALSE(std::filesystem::exists(folder / name)) << name;
}

TEST_F(CompareTest, agreement_is_a_map_with_figures_and_requires_depth_sigma) {
  render("plain.exr", "32x24", {"--layers", "color,depth"});
  render("scan.exr", "32x24", {"--layers", "color,depth,depth.sigma"});
  const json metrics = found("plain.exr scan.exr --agreement-map map.png")["metrics"];
  EXPECT_EQ(metrics["depth_differs"], 0.0);
  EXPECT_EQ(metrics["depth_not_scanned"], 0.0);
  EXPECT_GT(metrics["depth_agrees"], 0.0);
  EXPECT_TRUE(read("map.png").starts_with("\x89PNG"));
  EXPECT_EQ(compare("plain.exr scan.exr --agreement-map map.png").exit_code, 2) << "the file exists";
  EXPECT_EQ(compare("plain.exr scan.exr --fail-above depth_differs=0").exit_code, 0);
  EXPECT_EQ(compare("plain.exr scan.exr --fail-above depth_agrees=100.5").exit_code, 1);
  const ProgramResult result = compare("plain.exr plain.exr --agreement-map none.png");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "none.png: this map cannot be computed from these images") &&
              contains(result.err, "render --layers color,depth,depth.sigma"))
      << result.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "none.png"));
  const ProgramResult lacking = compare("plain.exr plain.exr --fail-above depth_agrees=90");
  EXPECT_TRUE(contains(lacking.err, "depth.sigma")) << lacking.err;
}

TEST_F(CompareTest, reports_and_maps_appear_whole_and_replace_nothing_unasked) {
  render("a.png");
  render("b.png", "32x24", {"--no-sun"});
  const std::string words = "a.png b.png -q --report r.html --flip-map flip.png --color-map color.png";
  EXPECT_EQ(compare(words).exit_code, 0);
  EXPECT_TRUE(read("r.html").starts_with("<!doctype html>"));
  EXPECT_TRUE(read("flip.png").starts_with("\x89PNG"));
  const std::string before = read("r.html");
  const ProgramResult again = compare(words);
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_TRUE(contains(again.err, "r.html: the file exists")) << again.err;
  EXPECT_EQ(compare(words + " --overwrite").exit_code, 0);
  EXPECT_EQ(read("r.html"), before) << "the same pictures give the same page";
  EXPECT_EQ(compare("a.png b.png --report a.png --overwrite").exit_code, 2) << "inputs are no outputs";
}

TEST_F(CompareTest, points_behind_changes_of_depth_are_written) {
  std::string with_block = "x y z\n", without_block = "x y z\n";
  for (int i = 0; i < 1600; ++i) {
    const int x = i % 40, y = i / 40;
    const bool is_block = x >= 15 && x < 25 && y >= 15 && y < 25;
    const std::string xy = std::to_string(x) + " " + std::to_string(y) + " ";
    with_block += xy + (is_block ? "3\n" : "0\n");
    without_block += xy + "0\n";
  }
  write("before.xyz", with_block);
  write("after.xyz", without_block);
  write(
      "camera.json",
      R"({"version": 1, "model": "orthographic", "width": 80, "height": 80, "intrinsics": {"resolution": 0.5},
            "pose": {"look_at": {"eye": [19.5, 19.5, 50], "target": [19.5, 19.5, 0], "up": [0, 1, 0]}}})");
  for (const char* const name : {"before", "after"}) {
    write(std::string(name) + ".json",
          R"({"version": 1, "cloud": {"files": [")" + std::string(name) +
              R"(.xyz"], "radius": 0.8}, "camera": "camera.json", "render": {"samples": 1},
              "output": {"file": ")" +
              name + R"(.exr", "layers": ["color", "depth", "id"]}})");
    const ProgramResult rendered = run({"render", std::string(name) + ".json", "-q"});
    ASSERT_EQ(rendered.exit_code, 0) << rendered.err;
  }
  const ProgramResult result = compare(
      "before.exr after.exr --json --changes depth --reference-cloud before.xyz --reference-points gone.las "
      "--test-cloud after.xyz --test-points came.las --depth-map depth.png");
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(json::parse(result.out)["changes"]["regions"].size(), 1u);
  const ProgramResult info = run({"info", "--json", "gone.las"});
  ASSERT_EQ(info.exit_code, 0) << info.err;
  const json gone = json::parse(info.out);
  EXPECT_EQ(gone["bounds"]["max"][2], 3.0);
  EXPECT_GE(gone["points"].get<int>(), 100) << "the block";
  EXPECT_LE(gone["points"].get<int>(), 144) << "the block and the points beside it";
  const json came = json::parse(run({"info", "--json", "came.las"}).out);
  EXPECT_EQ(came["bounds"]["max"][2], 0.0) << "the ground below it";
  EXPECT_TRUE(read("depth.png").starts_with("\x89PNG"));

  // The cloud is another one: nothing is written, though all the rest could be.
  write("other.xyz", "x y z\n0 0 0\n");
  const ProgramResult other = compare(
      "before.exr after.exr --changes depth --reference-cloud other.xyz --reference-points new.las "
      "--report new.html --depth-map new.png");
  EXPECT_EQ(other.exit_code, 2);
  for (const std::string& name : names()) EXPECT_FALSE(name.starts_with("new.")) << name;
}

TEST_F(CompareTest, folders_and_tables_are_batches) {
  render("a.png");
  render("b.png", "32x24", {"--no-sun"});
  for (const char* const name : {"x", "y"}) std::filesystem::create_directory(folder / name);
  for (const char* const name : {"one.png", "two.png"})
    std::filesystem::copy(folder / "a.png", folder / "x" / name);
  std::filesystem::copy(folder / "a.png", folder / "y/one.png");
  std::filesystem::copy(folder / "b.png", folder / "y/two.png");
  const ProgramResult result = compare("x y --fail-above flip=0.001 --report summary.html --reports pages");
  EXPECT_EQ(result.exit_code, 1) << result.err;
  EXPECT_LT(result.out.find("two.png"), result.out.find("one.png")) << result.out;
  EXPECT_TRUE(contains(result.out, "1 of 2 pairs fail")) << result.out;
  EXPECT_TRUE(read("summary.html").starts_with("<!doctype html>"));
  EXPECT_TRUE(std::filesystem::exists(folder / "pages/two.png.html"));

  write("pairs.csv", "reference,test,name\nx/one.png,y/one.png,first\nx/one.png,y/lost.png,second\n");
  const ProgramResult table = compare("--pairs pairs.csv --json");
  EXPECT_EQ(table.exit_code, 2) << "a pair that cannot be compared is an error";
  const json found = json::parse(table.out);
  EXPECT_EQ(found["pairs"][0]["name"], "second");
  EXPECT_EQ(found["failed"], 1);
  EXPECT_EQ(compare("--pairs pairs.csv --idiff-codes").exit_code, 4);
  EXPECT_EQ(compare("x y --flip-map f.png").exit_code, 2);

  const std::string before = read("y/one.png");
  for (const char* const output : {"y/one.png", "pairs.csv", "pages/first.html"}) {
    const ProgramResult taken =
        compare("--pairs pairs.csv --reports pages --overwrite --report " + std::string(output));
    EXPECT_TRUE(contains(taken.err, "the output is also an input") ||
                contains(taken.err, "is not the report of a pair"))
        << output << ": " << taken.err;
  }
  EXPECT_EQ(read("y/one.png"), before);
}

}  // namespace
}  // namespace alidade::test
