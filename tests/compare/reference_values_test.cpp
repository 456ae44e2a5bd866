// SPDX-License-Identifier: MIT
// Nine pairs of images with the values that other programs give for them: the FLIP tool of its authors
// (version 1.6), scikit-image 0.19.3 and NumPy. The file with the values has the settings.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "compare/metrics/errors.h"
#include "compare/metrics/flip.h"
#include "compare/metrics/ssim.h"
#include "compare/read_compared_image.h"
#include "tests/support/absent_data.h"

namespace alidade::test {

using namespace compare;

namespace {

const std::filesystem::path k_folder = std::filesystem::path(ALIDADE_SHARED_DATA) / "compare";

class ReferenceValues : public ::testing::Test {
 protected:
  void SetUp() override {
    std::ifstream stream(k_folder / "reference.json");
    if (!stream) GTEST_SKIP() << absent(k_folder.string(), 9);
    pairs_ = nlohmann::json::parse(stream).at("pairs");
    ASSERT_EQ(pairs_.size(), 9u);
  }

  /// Calls check(values, reference, test) for each pair.
  template <class Check>
  void for_each_pair(const Check& check) {
    for (const nlohmann::json& pair : pairs_) {
      const std::string reference = pair.at("reference"), test = pair.at("test");
      SCOPED_TRACE(test + " against " + reference);
      check(pair, read_compared_image(k_folder / reference), read_compared_image(k_folder / test));
    }
  }

  nlohmann::json pairs_;
};

TEST_F(ReferenceValues, flip_is_that_of_its_authors_tool_within_1e_4) {
  for_each_pair([](const nlohmann::json& pair, const ComparedImage& reference, const ComparedImage& test) {
    const FlipResult result = flip(reference, test);
    const nlohmann::json& expected = pair.at("flip");
    EXPECT_NEAR(result.mean, expected.at("mean").get<double>(), 1e-4);
    EXPECT_NEAR(result.weighted_median, expected.at("weighted_median").get<double>(), 1e-4);
    EXPECT_NEAR(result.weighted_first_quartile, expected.at("weighted_q1").get<double>(), 1e-4);
    EXPECT_NEAR(result.weighted_third_quartile, expected.at("weighted_q3").get<double>(), 1e-4);
    EXPECT_NEAR(result.min, expected.at("min").get<double>(), 1e-4);
    EXPECT_NEAR(result.max, expected.at("max").get<double>(), 1e-4);
    if (!expected.contains("exposures")) {
      EXPECT_EQ(result.exposures, 0);
      return;
    }
    EXPECT_EQ(result.exposures, expected.at("exposures").get<double>());
    EXPECT_NEAR(result.start_exposure, expected.at("start_exposure").get<double>(), 1e-4);
    EXPECT_NEAR(result.stop_exposure, expected.at("stop_exposure").get<double>(), 1e-4);
  });
}

TEST_F(ReferenceValues, ssim_is_that_of_scikit_image_within_1e_6) {
  int compared = 0;
  for_each_pair([&](const nlohmann::json& pair, const ComparedImage& reference, const ComparedImage& test) {
    if (!pair.contains("ssim")) return;
    EXPECT_NEAR(similarity(reference, test).ssim, pair.at("ssim").get<double>(), 1e-6);
    ++compared;
  });
  EXPECT_EQ(compared, 6);
}

TEST_F(ReferenceValues, errors_are_those_of_numpy_within_1e_9) {
  int compared = 0;
  for_each_pair([&](const nlohmann::json& pair, const ComparedImage& reference, const ComparedImage& test) {
    if (!pair.contains("rmse")) return;
    const ErrorMetrics metrics = error_metrics(reference, test, ColorEncoding::display);
    EXPECT_NEAR(metrics.rmse, pair.at("rmse").get<double>(), 1e-9);
    EXPECT_NEAR(metrics.mean_abs, pair.at("mean_abs").get<double>(), 1e-9);
    EXPECT_NEAR(metrics.max_abs, pair.at("max_abs").get<double>(), 1e-9);
    if (pair.at("psnr").is_null())
      EXPECT_EQ(metrics.psnr, std::numeric_limits<double>::infinity());
    else
      EXPECT_NEAR(metrics.psnr, pair.at("psnr").get<double>(), 1e-9);
    ++compared;
  });
  EXPECT_EQ(compared, 6);
}

}  // namespace
}  // namespace alidade::test
