// SPDX-License-Identifier: MIT
#include "cloud/laz/shared_models.h"

#include <gtest/gtest.h>

namespace alidade {
namespace {

TEST(MedianPredictorTest, new_values_replace_the_largest_or_the_smallest_by_turns) {
  struct Step {
    std::int32_t inserted;
    std::array<std::int32_t, 5> values;
    bool replaces_largest;
  };
  MedianPredictor predictor;
  EXPECT_EQ(predictor.median(), 0);
  EXPECT_TRUE(predictor.replaces_largest());
  for (const Step& step :
       {Step{5, {0, 0, 0, 0, 5}, false}, Step{3, {0, 0, 0, 3, 5}, false}, Step{8, {0, 0, 3, 5, 8}, false},
        Step{-2, {-2, 0, 3, 5, 8}, true}, Step{7, {-2, 0, 3, 5, 7}, false}, Step{7, {0, 3, 5, 7, 7}, false},
        Step{1, {1, 3, 5, 7, 7}, true}}) {
    predictor.insert(step.inserted);
    EXPECT_EQ(predictor.values(), step.values);
    EXPECT_EQ(predictor.replaces_largest(), step.replaces_largest);
    EXPECT_EQ(predictor.median(), step.values[2]);
  }
}

TEST(MedianPredictorTest, values_beyond_all_five_are_inserted_too) {
  MedianPredictor predictor;
  predictor.insert(INT32_MAX);
  predictor.insert(INT32_MIN);
  EXPECT_EQ(predictor.values(), (std::array<std::int32_t, 5>{INT32_MIN, 0, 0, 0, INT32_MAX}));
  EXPECT_TRUE(predictor.replaces_largest());
}

}  // namespace
}  // namespace alidade
