// SPDX-License-Identifier: MIT
#include <nlohmann/json.hpp>

#include "tests/tools/run_program.h"

// What `alidade compare` prints, and its exit codes; tests/jobs/compare_test.cpp tests its work.

namespace alidade::test {
namespace {

using nlohmann::json;

/// Images that the program itself renders.
class CompareTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_square("square.csv");
  }
  /// An image of the square from above, of so many pixels.
  void render(const std::string& file, const std::string& size = "32x24",
              const std::vector<std::string>& further = {}) {
    std::vector<std::string> words{"render",    "--cloud", "square.csv", "--size", size,
                                   "--samples", "2",       "-q",         "-o",     file};
    words.insert(words.end(), further.begin(), further.end());
    const ProgramResult result = run(words);
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }
  /// Words between single spaces.
  ProgramResult compare(const std::string& words) {
    std::vector<std::string> list{"compare"};
    for (std::size_t begin = 0; begin < words.size();) {
      const std::size_t end = std::min(words.find(' ', begin), words.size());
      list.push_back(words.substr(begin, end - begin));
      begin = end + 1;
    }
    return run(list);
  }
};

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
