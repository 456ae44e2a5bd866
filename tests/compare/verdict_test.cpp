// SPDX-License-Identifier: MIT
#include "compare/verdict.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "base/error.h"

namespace alidade::test {

using namespace image;
using namespace compare;

namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();

Comparison with_colors(double flip, double psnr) {
  Comparison comparison;
  comparison.color.emplace();
  comparison.color->flip.mean = flip;
  comparison.color->stored.psnr = psnr;
  comparison.color->ssim = 0.9;
  return comparison;
}

bool passes(const Comparison& comparison, const std::string& thresholds) {
  return judge(comparison, parse_thresholds(thresholds)).pass();
}

std::string problem_of(const std::string& thresholds) {
  try {
    parse_thresholds(thresholds);
  } catch (const Error& error) {
    return error.what();
  }
  return "none";
}

TEST(VerdictTest, a_list_is_read_as_it_is_written) {
  const std::vector<Threshold> thresholds = parse_thresholds("flip=0.05, psnr < 30,rmse>1e-3");
  ASSERT_EQ(thresholds.size(), 3u);
  EXPECT_EQ(to_text(thresholds[0]), "flip=0.05");
  EXPECT_EQ(to_text(thresholds[1]), "psnr<30");
  EXPECT_EQ(to_text(thresholds[2]), "rmse>0.001");
}

TEST(VerdictTest, every_figure_has_a_name_of_its_own_and_says_what_it_is) {
  std::vector<std::string_view> names;
  for (const MetricKind& kind : metric_kinds()) {
    EXPECT_EQ(find_metric(kind.name), &kind) << kind.name;
    EXPECT_FALSE(kind.note.empty()) << kind.name;
    names.push_back(kind.name);
  }
  std::ranges::sort(names);
  EXPECT_EQ(std::ranges::adjacent_find(names), names.end());
  EXPECT_EQ(find_metric("flop"), nullptr);
}

TEST(VerdictTest, without_thresholds_a_comparison_passes) {
  EXPECT_TRUE(judge(with_colors(1.0, 0.0), {}).pass());
}

TEST(VerdictTest, equals_fails_what_is_worse_and_the_limit_itself_never_fails) {
  const Comparison comparison = with_colors(0.05, 30.0);
  EXPECT_TRUE(passes(comparison, "flip=0.05"));
  EXPECT_FALSE(passes(comparison, "flip=0.0499"));
  EXPECT_TRUE(passes(comparison, "psnr=30"));
  EXPECT_FALSE(passes(comparison, "psnr=30.01"));
}

TEST(VerdictTest, below_and_above_mean_what_they_say) {
  const Comparison comparison = with_colors(0.05, 30.0);
  EXPECT_TRUE(passes(comparison, "psnr<30"));
  EXPECT_FALSE(passes(comparison, "psnr<31"));
  EXPECT_FALSE(passes(comparison, "psnr>29"));
  EXPECT_FALSE(passes(comparison, "flip<0.06"));
}

TEST(VerdictTest, one_that_fails_is_enough) {
  EXPECT_FALSE(passes(with_colors(0.05, 30.0), "flip=0.1,psnr<40"));
}

TEST(VerdictTest, infinite_psnr_of_equal_images_passes_every_limit) {
  EXPECT_TRUE(passes(with_colors(0.0, k_infinity), "psnr<1000,psnr<inf"));
  EXPECT_FALSE(passes(with_colors(0.0, 90.0), "psnr<inf"));
}

TEST(VerdictTest, nan_fails_every_limit) {
  const Comparison comparison = with_colors(std::numeric_limits<double>::quiet_NaN(), 30.0);
  for (const char* const threshold : {"flip=1", "flip<0", "flip>1"})
    EXPECT_FALSE(passes(comparison, threshold)) << threshold;
}

TEST(VerdictTest, unknown_names_are_reported_with_the_nearest_known_one) {
  EXPECT_NE(problem_of("filp=0.05").find("unknown metric 'filp'"), std::string::npos)
      << problem_of("filp=0.05");
  EXPECT_NE(problem_of("filp=0.05").find("'flip'"), std::string::npos) << problem_of("filp=0.05");
}

TEST(VerdictTest, what_is_no_threshold_is_rejected) {
  for (const char* const text :
       {"", "flip", "flip=", "=0.1", "flip=0.05,", "flip=nan", "flip=0.05x", "flip==1", "flip<=1"})
    EXPECT_NE(problem_of(text), "none") << text;
}

TEST(VerdictTest, a_threshold_on_what_is_not_there_is_an_error) {
  EXPECT_THROW(judge(with_colors(0.0, 30.0), parse_thresholds("depth_mean=0.1")), Error);
}

}  // namespace
}  // namespace alidade::test
