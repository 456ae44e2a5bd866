// SPDX-License-Identifier: MIT
#include "jobs/visibility/points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "base/error.h"
#include "cloud/read_cloud.h"
#include "jobs/visibility/summary.h"
#include "tests/jobs/garden_job.h"

namespace alidade::test {
namespace {

using PointsJobTest = GardenJobTest;

TEST_F(PointsJobTest, points_are_seen_or_have_a_blocker) {
  auto points = request<jobs::PointsRequest>();
  points.observers.positions = {k_before};
  const jobs::PointsResult result = run(plan(points), heard);
  ASSERT_EQ(result.observers.size(), 1u);
  EXPECT_EQ(result.observers[0].position, glm::dvec3(690005, 5325010, 601.7));
  EXPECT_FALSE(result.crs.empty());
  const PointCloud cloud = read_cloud(folder / "garden.las");
  ASSERT_EQ(result.seen.counts.size(), cloud.size());
  ASSERT_EQ(result.seen.blockers.size(), 1u);
  for (std::size_t id = 0; id < cloud.size(); ++id) {
    ASSERT_EQ(result.seen.counts[id] == 0, result.seen.blockers[0][id] != visibility::k_no_blocker) << id;
    if (cloud.positions[id].x < 9500) {
      ASSERT_EQ(result.seen.counts[id], 1u) << id;
    }
  }
  EXPECT_EQ(heard.text().find("wrote"), std::string::npos) << heard.text();
  EXPECT_NE(heard.text().find("points are visible ("), std::string::npos) << heard.text();
  EXPECT_EQ(file_count(), 1u);
}

TEST_F(PointsJobTest, lists_can_be_the_only_output) {
  auto points = request<jobs::PointsRequest>();
  points.observers.positions = {k_before, k_behind};
  points.lists = folder / "lists.csv";
  const jobs::PointsResult result = run(plan(points), heard);
  std::ifstream file(points.lists);
  std::size_t lines = 0;
  for (std::string line; std::getline(file, line);) ++lines;
  std::size_t pairs = 0;
  for (const std::uint32_t count : result.seen.counts) pairs += count;
  EXPECT_EQ(lines, pairs + 1);
  EXPECT_EQ(file_count(), 2u);
}

TEST_F(PointsJobTest, plans_need_no_points) {
  auto points = request<jobs::PointsRequest>();
  EXPECT_THROW(plan(points), Error) << "no observers";
  points.observers.positions = {k_before};
  points.output = folder / "seen.txt";
  EXPECT_THROW(plan(points), Error);
  points.output = folder / "garden.las";
  EXPECT_THROW(plan(points), Error);
  auto summary = request<jobs::SummaryRequest>();
  summary.observers.positions = {k_before};
  summary.summary.step = 7.0;
  EXPECT_THROW(plan(summary), Error);
  EXPECT_TRUE(heard.text().empty());
  EXPECT_EQ(file_count(), 1u);
}

TEST_F(PointsJobTest, each_observer_has_a_summary) {
  auto summary = request<jobs::SummaryRequest>();
  summary.observers.positions = {k_before, k_behind};
  summary.summary.directions = 64;
  const jobs::SummaryResult result = run(plan(summary), heard);
  ASSERT_EQ(result.summaries.size(), 2u);
  ASSERT_EQ(result.observers.size(), 2u);
  EXPECT_FALSE(result.crs.empty());
  // The garden is symmetric.
  EXPECT_GT(result.summaries[0].visible_points, 3000u);
  EXPECT_NEAR(result.summaries[0].area.visible, result.summaries[1].area.visible,
              0.05 * result.summaries[0].area.visible);
  EXPECT_EQ(heard.notes.back(), "2 observers");
  EXPECT_EQ(file_count(), 1u);
}

}  // namespace
}  // namespace alidade::test
