// SPDX-License-Identifier: MIT
#include "extensions/placement/job.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "tests/jobs/garden_job.h"

namespace alidade::test {
namespace {

using PlaceJobTest = GardenJobTest;

TEST_F(PlaceJobTest, places_are_chosen_or_there_are_none) {
  auto place = request<jobs::PlaceRequest>();
  place.candidates.positions = {k_before, k_behind};
  place.count = 2;
  const jobs::PlaceResult result = run(plan(place), heard);
  ASSERT_EQ(result.placement.positions.size(), 2u);
  EXPECT_EQ(result.candidates.size(), 2u);
  EXPECT_EQ(result.placement.total, static_cast<double>(result.targets.size()));
  place.curve = folder / "curve.jpg";
  EXPECT_THROW(plan(place), Error);
  place.curve.clear();
  place.class_weights = {{2, 0.0}, {6, 0.0}};
  const jobs::PlaceResult none = run(plan(place), heard);
  EXPECT_TRUE(none.placement.positions.empty());
  EXPECT_EQ(heard.warnings.back(), "no candidate sees any target with a positive weight; writing nothing");
  EXPECT_EQ(file_count(), 1u);
}

}  // namespace
}  // namespace alidade::test
