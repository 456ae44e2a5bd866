// SPDX-License-Identifier: MIT
#include "cloud/rows.h"

#include <gtest/gtest.h>

#include "tests/cloud/chosen_points.h"

namespace alidade {
namespace {

using test::expect_same_columns;
using test::full_cloud;
using test::rows_of;

TEST(KeepRowsTest, points_with_a_mark_close_up_in_their_order_with_all_attributes) {
  std::mt19937_64 engine(1);
  for (const int share : {1, 2, 10, 400}) {
    const PointCloud cloud = full_cloud(1000, 500, 3);
    std::vector<std::uint8_t> marks(cloud.size());
    std::vector<std::size_t> rows;
    for (std::size_t row = 0; row < marks.size(); ++row) {
      if (engine() % static_cast<std::uint64_t>(share) != 0) continue;
      marks[row] = static_cast<std::uint8_t>(1 + engine() % 255);
      rows.push_back(row);
    }
    PointCloud kept = cloud;
    keep_rows(kept, marks);
    expect_same_columns(kept, rows_of(cloud, rows));
  }
}

TEST(KeepRowsTest, columns_that_are_absent_stay_absent) {
  PointCloud cloud;
  cloud.positions = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  cloud.intensities = {1, 2, 3};
  keep_rows(cloud, std::vector<std::uint8_t>{0, 1, 1});
  EXPECT_EQ(cloud.positions, (std::vector<LatticePosition>{{4, 5, 6}, {7, 8, 9}}));
  EXPECT_EQ(cloud.attributes(), AttributeSet(Attribute::intensity));
}

TEST(KeepRowsTest, none_or_all_can_stay) {
  const PointCloud cloud = full_cloud(50, 20, 4);
  PointCloud all = cloud, none = cloud, empty;
  keep_rows(all, std::vector<std::uint8_t>(50, 1));
  keep_rows(none, std::vector<std::uint8_t>(50, 0));
  keep_rows(empty, {});
  expect_same_columns(all, cloud);
  EXPECT_EQ(none.size(), 0u);
  EXPECT_TRUE(none.colors.empty());
  EXPECT_EQ(none.extra_dimensions.size(), 2u) << "what dimensions there are is still known";
  EXPECT_TRUE(none.extra_dimensions[0].values.empty());
  EXPECT_EQ(empty.size(), 0u);
}

TEST(KeepRowsTest, the_files_counts_follow_if_they_account_for_all_points) {
  PointCloud cloud = full_cloud(10, 20, 4);
  for (const std::uint64_t count : {3u, 0u, 2u, 5u}) cloud.files.emplace_back().point_count = count;
  PointCloud unknown = cloud;
  unknown.files.pop_back();
  const std::vector<std::uint8_t> marks = {0, 1, 1, 0, 0, 1, 0, 0, 0, 1};
  keep_rows(cloud, marks);
  keep_rows(unknown, marks);
  const auto counts = [](const PointCloud& of) {
    std::vector<std::uint64_t> result;
    for (const CloudFile& file : of.files) result.push_back(file.point_count);
    return result;
  };
  EXPECT_EQ(counts(cloud), (std::vector<std::uint64_t>{2, 0, 0, 2}));
  EXPECT_EQ(counts(unknown), (std::vector<std::uint64_t>{3, 0, 2}));
  keep_every(cloud, 3);
  EXPECT_EQ(counts(cloud), (std::vector<std::uint64_t>{1, 0, 0, 1}));
}

TEST(KeepEveryTest, the_first_point_and_every_nth_from_there_on_stay) {
  const PointCloud cloud = full_cloud(100, 20, 5);
  for (const std::uint64_t step : {1u, 2u, 3u, 7u, 99u, 100u, 101u}) {
    std::vector<std::size_t> rows;
    for (std::size_t row = 0; row < cloud.size(); row += step) rows.push_back(row);
    PointCloud kept = cloud;
    keep_every(kept, step);
    expect_same_columns(kept, rows_of(cloud, rows));
  }
}

TEST(KeepEveryTest, a_step_beyond_the_end_leaves_the_first_point) {
  PointCloud cloud = full_cloud(10, 20, 6);
  keep_every(cloud, UINT64_MAX);
  EXPECT_EQ(cloud.size(), 1u);
  PointCloud empty;
  keep_every(empty, 3);
  EXPECT_EQ(empty.size(), 0u);
}

}  // namespace
}  // namespace alidade
