// SPDX-License-Identifier: MIT
#include "compare/comparison.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "compare/report/comparison_json.h"
#include "tests/compare/image_files.h"

namespace alidade::test {

using namespace image;
using namespace compare;

namespace {

using nlohmann::json;

constexpr float k_nan = std::numeric_limits<float>::quiet_NaN();
constexpr int k_width = 64, k_height = 48;

class ComparisonTest : public ImageFilesTest {
 protected:
  static std::vector<float> wave(float brightness = 1.0f) {
    std::vector<float> values(k_width * k_height * 3);
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = brightness * (0.4f + 0.2f * std::sin(0.3f * static_cast<float>(i / 3 % k_width)));
    return values;
  }
  void write(const std::string& name, const std::vector<float>& values) const {
    write_image(name, k_width, k_height, values);
  }
  Comparison compare(const std::string& reference, const std::string& test,
                     const ComparisonOptions& options = {}) const {
    return compare_files(folder / reference, folder / test, options);
  }
  static json as_json(const Comparison& comparison, const std::string& thresholds = "") {
    return json::parse(comparison_json(
        comparison,
        judge(comparison, thresholds.empty() ? std::vector<Threshold>{} : parse_thresholds(thresholds))));
  }
  std::string problem_of(const std::string& reference, const std::string& test,
                         const ComparisonOptions& options = {}) const {
    try {
      compare(reference, test, options);
    } catch (const Error& error) {
      return error.parts().problem;
    }
    return "none";
  }
};

TEST_F(ComparisonTest, equal_images_differ_by_nothing_in_json_without_infinity) {
  write("a.png", wave());
  const json found = as_json(compare("a.png", "a.png"), "flip=0,psnr<inf");
  EXPECT_EQ(found["metrics"]["rmse"], 0.0);
  EXPECT_EQ(found["metrics"]["psnr"], "infinity");
  EXPECT_EQ(found["metrics"]["ssim"], 1.0);
  EXPECT_EQ(found["metrics"]["ms_ssim"], "nan") << "the pictures are too small for five scales";
  EXPECT_EQ(found["metrics"]["flip"]["mean"], 0.0);
  EXPECT_EQ(found["pass"], true);
}

// 51 of 255 everywhere: RMSE 0.2, PSNR 20 log10(1 / 0.2) = 13.9794 dB.
TEST_F(ComparisonTest, figures_of_an_even_difference_are_those_known_on_paper) {
  write("a.png", std::vector<float>(k_width * k_height * 3, 102.0f / 255.0f));
  write("b.png", std::vector<float>(k_width * k_height * 3, 153.0f / 255.0f));
  const json found = as_json(compare("a.png", "b.png"), "rmse=0.1");
  EXPECT_NEAR(found["metrics"]["rmse"].get<double>(), 0.2, 1e-12);
  EXPECT_NEAR(found["metrics"]["psnr"].get<double>(), 13.979400086720377, 1e-9);
  EXPECT_NEAR(found["metrics"]["max_abs"].get<double>(), 0.2, 1e-12);
  // Linear light of the codes 153 and 102 (IEC 61966-2-1): 0.31854678 - 0.13286832.
  EXPECT_NEAR(found["metrics"]["linear"]["rmse"].get<double>(), 0.18567846, 1e-6);
  EXPECT_EQ(found["pass"], false);
  EXPECT_EQ(found["thresholds"][0]["threshold"], "rmse=0.1");
}

TEST_F(ComparisonTest, another_size_is_an_error_of_its_own_unless_the_test_is_resized) {
  write("a.png", wave());
  write_image("small.png", 32, 24, std::vector<float>(32 * 24 * 3, 0.4f));
  EXPECT_THROW(compare("a.png", "small.png"), SizeMismatch);
  ComparisonOptions options;
  options.resize_to_reference = true;
  const Comparison comparison = compare("a.png", "small.png", options);
  EXPECT_EQ(comparison.test.width, k_width);
  ASSERT_EQ(comparison.remarks.size(), 1u);
  EXPECT_NE(comparison.remarks[0].find("resized from 32 x 24"), std::string::npos) << comparison.remarks[0];
}

// EXR files may hold a part of a larger image: their data window.
TEST_F(ComparisonTest, a_resized_test_and_a_mask_do_not_need_the_data_window_of_the_reference) {
  OIIO::ImageSpec spec(k_width, k_height, 3, OIIO::TypeFloat);
  spec.x = 100;
  spec.y = 50;
  spec.full_width = 400;
  spec.full_height = 300;
  const auto output = OIIO::ImageOutput::create("a.exr");
  ASSERT_TRUE(output->open((folder / "a.exr").string(), spec));
  output->write_image(OIIO::TypeFloat, wave().data());
  output->close();
  write_image("small.exr", k_width / 2, k_height / 2, std::vector<float>(k_width * k_height * 3 / 4, 0.4f));
  write("mask.png", std::vector<float>(k_width * k_height * 3, 1.0f));
  EXPECT_THROW(compare("a.exr", "small.exr"), SizeMismatch);
  ComparisonOptions options;
  options.resize_to_reference = true;
  options.mask = folder / "mask.png";
  EXPECT_EQ(compare("a.exr", "small.exr", options).counted, static_cast<std::uint64_t>(k_width * k_height));
}

TEST_F(ComparisonTest, crops_rectangles_and_mask_files_leave_out_what_differs) {
  std::vector<float> other = wave();
  for (int y = 0; y < 10; ++y)
    for (int i = 0; i < 3 * 20; ++i) other[static_cast<std::size_t>(y * k_width * 3 + i)] = 1.0f;
  std::vector<float> mask(k_width * k_height * 3, 0.0f);
  for (std::size_t i = 10 * k_width * 3; i < mask.size(); ++i) mask[i] = 1.0f;
  write("a.png", wave());
  write("b.png", other);
  write("mask.png", mask);
  EXPECT_GT(compare("a.png", "b.png").color->stored.rmse, 0.05);
  ComparisonOptions cropped, ignored, kept, masked;
  cropped.crop = image::PixelBox{20, 0, k_width, k_height};
  ignored.ignore = {{0, 0, 20, 10}};
  kept.keep = {{0, 10, k_width, k_height}};
  masked.mask = folder / "mask.png";
  for (const ComparisonOptions& options : {cropped, ignored, kept, masked}) {
    const Comparison comparison = compare("a.png", "b.png", options);
    EXPECT_EQ(comparison.color->stored.rmse, 0.0);
    EXPECT_TRUE(std::isinf(comparison.color->stored.psnr));
  }
  EXPECT_EQ(compare("a.png", "b.png", cropped).pixels, 44u * k_height);
  EXPECT_EQ(compare("a.png", "b.png", ignored).counted, k_width * k_height - 200u);
  ComparisonOptions both = cropped;
  both.mask = folder / "mask.png";
  EXPECT_EQ(compare("a.png", "b.png", both).counted, 44u * (k_height - 10u)) << "masks are cropped too";
}

TEST_F(ComparisonTest, the_result_contains_the_request) {
  write("a.exr", wave());
  write("b.exr", wave(0.5f));
  ComparisonOptions options;
  options.crop = image::PixelBox{4, 2, 60, 44};
  options.ignore = {{0, 0, 8, 8}, {9, 9, 10, 10}};
  options.match = ColorModel::affine;
  options.align = true;
  options.flip.pixels_per_degree = 40.0;
  options.flip.tone_mapper = ToneMapper::hable;
  options.find_changes = ChangeMap::color;
  options.changes.threshold = 0.125;
  const Comparison comparison = compare("a.exr", "b.exr", options);
  const json how = as_json(comparison)["how"];
  EXPECT_EQ(how, json::parse(R"({"crop": [4, 2, 60, 44], "ignore": [[0, 0, 8, 8], [9, 9, 10, 10]],
    "pixels_per_degree": 40.0, "tone_mapper": "hable", "match": "affine", "largest_shift": 64,
    "changes": "color", "change_threshold": 0.125, "least_pixels": 16})"));
  std::string text;
  for (const HowLine& line : how_lines(comparison)) text += line.name + ": " + line.text + "\n";
  for (const char* const part : {"Part: 4,2,60,44", "Ignored: 0,0,8,8 9,9,10,10", "40.00 pixels per degree",
                                 "tone mapper hable", "offsets", "Alignment: ", "color above 0.125"})
    EXPECT_NE(text.find(part), std::string::npos) << part << " in\n" << text;
}

TEST_F(ComparisonTest, warnings_are_apart_from_thresholds_and_fail_nothing) {
  write("a.png", wave());
  write("b.png", wave(0.5f));
  const Comparison comparison = compare("a.png", "b.png");
  const json found = json::parse(comparison_json(comparison, judge(comparison, parse_thresholds("rmse=1")),
                                                 judge(comparison, parse_thresholds("rmse=0.01"))));
  EXPECT_EQ(found["pass"], true);
  ASSERT_EQ(found["warnings"].size(), 1u);
  EXPECT_EQ(found["warnings"][0]["threshold"], "rmse=0.01");
  EXPECT_EQ(found["warnings"][0]["fails"], true);
}

TEST_F(ComparisonTest, nothing_that_counts_is_an_error_and_no_pass) {
  write("a.png", wave());
  ComparisonOptions options;
  options.ignore = {{0, 0, k_width, k_height}};
  EXPECT_EQ(problem_of("a.png", "a.png", options), "no pixels to compare");
  write("nan.exr", std::vector<float>(k_width * k_height * 3, k_nan));
  EXPECT_EQ(problem_of("nan.exr", "nan.exr"), "no pixel has finite colours in both images");
}

TEST_F(ComparisonTest, pixels_with_nan_are_counted_reported_and_left_out) {
  std::vector<float> broken = wave();
  broken[0] = k_nan;
  broken[7] = std::numeric_limits<float>::infinity();
  write("a.exr", wave());
  write("b.exr", broken);
  const Comparison comparison = compare("a.exr", "b.exr");
  EXPECT_EQ(comparison.excluded, 2u);
  EXPECT_EQ(comparison.color->stored.rmse, 0.0);
  ASSERT_EQ(comparison.remarks.size(), 1u);
  EXPECT_EQ(comparison.remarks[0], "ignoring 2 pixels with NaN or infinite colours");
}

TEST_F(ComparisonTest, layers_are_compared_and_one_sided_ones_reported) {
  const std::vector<std::string> both{"R", "G", "B", "Z", "id"};
  std::vector<float> reference, test, without;
  for (int i = 0; i < k_width * k_height; ++i) {
    reference.insert(reference.end(), {0.5f, 0.5f, 0.5f, 10.0f, static_cast<float>(i + 1)});
    test.insert(test.end(), {0.5f, 0.5f, 0.5f, 10.25f, static_cast<float>(i % 2 == 0 ? i + 1 : 5000)});
    without.insert(without.end(), {0.5f, 0.5f, 0.5f, 10.0f});
  }
  write_layers("a.exr", k_width, k_height, both, reference);
  write_layers("b.exr", k_width, k_height, both, test);
  write_layers("c.exr", k_width, k_height, {"R", "G", "B", "Z"}, without);
  const json found = as_json(compare("a.exr", "b.exr"))["metrics"];
  EXPECT_NEAR(found["depth_mean"].get<double>(), 0.25, 1e-6);
  EXPECT_EQ(found["depth_5cm"], 0.0);
  EXPECT_EQ(found["ids"], 50.0);
  const Comparison half = compare("a.exr", "c.exr");
  EXPECT_FALSE(half.layers.ids);
  ASSERT_EQ(half.remarks.size(), 1u);
  EXPECT_EQ(half.remarks[0], "ignoring the id layer: only the reference has it");
  EXPECT_THROW(judge(half, parse_thresholds("ids=99")), Error);
}

TEST_F(ComparisonTest, alpha_of_one_image_and_other_sizes_name_their_options) {
  const std::vector<float> plain(3 * k_width * k_height, 0.5f), transparent(4 * k_width * k_height, 0.5f);
  write_layers("a.exr", k_width, k_height, {"R", "G", "B"}, plain);
  write_layers("b.exr", k_width, k_height, {"R", "G", "B", "A"}, transparent);
  const Comparison comparison = compare("a.exr", "b.exr");
  ASSERT_EQ(comparison.remarks.size(), 1u);
  EXPECT_EQ(comparison.remarks[0],
            "ignoring alpha: only the test has it; --opaque leaves out the pixels without a surface");
  write_layers("small.exr", k_width, 1, {"R", "G", "B"}, std::vector<float>(3 * k_width, 0.5f));
  try {
    compare("a.exr", "small.exr");
    ADD_FAILURE();
  } catch (const SizeMismatch& error) {
    EXPECT_NE(std::string(error.what()).find(", or --resize reference, found "), std::string::npos)
        << error.what();
  }
}

TEST_F(ComparisonTest, files_with_nothing_in_common_cannot_be_compared) {
  write("a.png", wave());
  write_layers("z.exr", k_width, k_height, {"Z"}, std::vector<float>(k_width * k_height, 1.0f));
  EXPECT_EQ(problem_of("a.png", "z.exr"), "nothing to compare with the reference");
}

TEST_F(ComparisonTest, matched_colours_are_reported_beside_the_raw_ones) {
  write("a.exr", wave());
  write("b.exr", wave(0.5f));
  ComparisonOptions options;
  options.match = ColorModel::exposure;
  const Comparison comparison = compare("a.exr", "b.exr", options);
  ASSERT_TRUE(comparison.match);
  EXPECT_NEAR(comparison.match->scale.x, 2.0, 1e-3);
  EXPECT_GT(comparison.color->stored.rmse, 0.1);
  EXPECT_LT(comparison.matched->stored.rmse, 1e-3);
  const json found = as_json(comparison, "rmse_matched=0.01");
  EXPECT_EQ(found["pass"], true);
  EXPECT_TRUE(found["match"]["metrics"].contains("flip"));
}

TEST_F(ComparisonTest, changes_are_found_by_depth_with_ids_kept_for_their_points) {
  std::vector<float> reference, test;
  for (int i = 0; i < k_width * k_height; ++i) {
    const int x = i % k_width, y = i / k_width;
    const bool is_gone = x >= 20 && x < 30 && y >= 5 && y < 15;
    reference.insert(reference.end(), {is_gone ? 7.0f : 10.0f, static_cast<float>(i + 1)});
    test.insert(test.end(), {10.0f, static_cast<float>(i + 1)});
  }
  write_layers("a.exr", k_width, k_height, {"Z", "id"}, reference);
  write_layers("b.exr", k_width, k_height, {"Z", "id"}, test);
  ComparisonOptions options;
  options.find_changes = ChangeMap::depth;
  const Comparison comparison = compare("a.exr", "b.exr", options);
  ASSERT_EQ(comparison.changes->regions.size(), 1u);
  EXPECT_EQ(comparison.changes->regions[0].left, 20);
  EXPECT_EQ(comparison.changes->regions[0].bottom, 15);
  EXPECT_EQ(comparison.reference.ids.size(), static_cast<std::size_t>(k_width * k_height));
  options.find_changes = ChangeMap::flip;
  EXPECT_EQ(problem_of("a.exr", "b.exr", options), "colour changes require colours in both images");
}

TEST_F(ComparisonTest, results_do_not_depend_on_the_number_of_threads) {
  // Large enough for more than one piece of work in every step.
  constexpr int k_wide = 700, k_high = 600;
  std::vector<float> one(k_wide * k_high * 3), other = one;
  for (std::size_t i = 0; i < one.size(); ++i) {
    const auto x = static_cast<float>(i / 3 % k_wide), y = static_cast<float>(i / 3 / k_wide);
    one[i] = 0.4f + 0.2f * std::sin(0.3f * x) * std::cos(0.07f * y);
    other[i] =
        0.4f + 0.2f * std::sin(0.3f * x + 0.1f) * std::cos(0.07f * y) + 0.1f * std::sin(0.001f * x * y);
  }
  write_image("a.exr", k_wide, k_high, one);
  write_image("b.exr", k_wide, k_high, other);
  ComparisonOptions options;
  options.match = ColorModel::affine;
  options.align = true;
  options.find_changes = ChangeMap::color;
  const auto text = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const Comparison comparison = compare("a.exr", "b.exr", options);
    return comparison_json(comparison, {});
  };
  EXPECT_EQ(text(1), text(4));
}

TEST_F(ComparisonTest, progress_ends_at_its_total_and_can_stop_the_run) {
  write("a.png", wave());
  std::uint64_t last = 0, whole = 1;
  compare_files(folder / "a.png", folder / "a.png", {}, [&](std::uint64_t done, std::uint64_t total) {
    EXPECT_GT(done, last);
    last = done;
    whole = total;
    return true;
  });
  EXPECT_EQ(last, whole);
  EXPECT_THROW(compare_files(folder / "a.png", folder / "a.png", {},
                             [](std::uint64_t, std::uint64_t) { return false; }),
               Cancelled);
}

TEST_F(ComparisonTest, a_batch_reports_errors_first_and_then_the_worst) {
  write("a.png", wave());
  write("b.png", wave(0.8f));
  write("c.png", wave(0.5f));
  const auto pair = [&](const char* name, const char* test) {
    return ImagePair{name, folder / "a.png", folder / test};
  };
  BatchOptions options;
  options.fail_above = parse_thresholds("rmse=0.1");
  options.warn_above = parse_thresholds("rmse=0.01");
  std::vector<ImagePair> pairs{pair("same", "a.png"), pair("near", "b.png"), pair("missing", "lost.png"),
                               pair("far", "c.png")};
  pairs.push_back({"alone", folder / "a.png", {}});
  const std::vector<PairOutcome> outcomes = compare_pairs(pairs, options);
  std::vector<std::string> names;
  for (const PairOutcome& outcome : outcomes) names.push_back(outcome.pair.name);
  EXPECT_EQ(names, (std::vector<std::string>{"alone", "missing", "far", "near", "same"}));
  EXPECT_FALSE(outcomes[2].pass());
  EXPECT_TRUE(outcomes[3].pass());
  EXPECT_FALSE(outcomes[3].warnings.pass());
  const json found = json::parse(batch_json(outcomes));
  EXPECT_EQ(found["failed"], 3);
  EXPECT_EQ(found["pass"], false);
  EXPECT_EQ(found["pairs"][0]["error"], "the test folder has no image with this name");
  EXPECT_EQ(found["pairs"][4]["metrics"]["psnr"], "infinity");
}

/// Pairs whose reports take a while.
class BatchTest : public ComparisonTest {
 protected:
  void SetUp() override {
    ComparisonTest::SetUp();
    write("a.png", wave());
    write("b.png", wave(0.8f));
    for (int i = 0; i < 6; ++i)
      pairs.push_back({"pair" + std::to_string(i), folder / "a.png", folder / "b.png"});
  }
  BatchOptions options(const char* reports) const {
    BatchOptions wishes;
    wishes.fail_above = parse_thresholds("flip=0.5");
    wishes.reports = folder / reports;
    return wishes;
  }
  std::string page(const char* reports, int pair) const {
    std::ifstream stream(folder / reports / ("pair" + std::to_string(pair) + ".html"), std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  std::vector<ImagePair> pairs;
};

TEST_F(BatchTest, an_error_ends_it_and_spoils_no_page_that_is_written) {
  compare_pairs(pairs, options("whole"));
  // The first call of the progress function creates a folder with the name of the last report.
  bool is_first = true;
  EXPECT_THROW(compare_pairs(pairs, options("ended"),
                             [&](std::uint64_t, std::uint64_t) {
                               if (is_first) std::filesystem::create_directory(folder / "ended/pair5.html");
                               is_first = false;
                               return true;
                             }),
               Error);
  for (int pair = 0; pair < 5; ++pair) {
    const std::string ended = page("ended", pair);
    EXPECT_TRUE(ended.empty() || ended == page("whole", pair)) << pair;
  }
}

TEST_F(BatchTest, can_be_stopped_in_the_midst_of_a_pair) {
  EXPECT_THROW(compare_pairs(pairs, options("none"),
                             [](std::uint64_t done, std::uint64_t total) {
                               EXPECT_EQ(done, 0u);
                               EXPECT_EQ(total, 6u);
                               return false;
                             }),
               Cancelled);
  EXPECT_TRUE(std::filesystem::is_empty(folder / "none"));
}

TEST_F(BatchTest, no_report_replaces_an_image_or_a_kept_file) {
  BatchOptions wishes = options(".");
  wishes.overwrite = true;
  wishes.kept = {folder / "whole/../pair3.html"};
  EXPECT_THROW(compare_pairs(pairs, wishes), Error);
  wishes.kept.clear();
  pairs[2].test = folder / "pair1.html";
  EXPECT_THROW(compare_pairs(pairs, wishes), Error);
}

}  // namespace
}  // namespace alidade::test
