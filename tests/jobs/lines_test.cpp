// SPDX-License-Identifier: MIT
#include "jobs/visibility/lines.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "cloud/las/write_las.h"
#include "jobs/load_cloud.h"
#include "tests/jobs/heard.h"
#include "tests/support/garden.h"

namespace alidade::test {
namespace {

TEST(LinesJobTest, a_job_without_an_output_returns_its_table_and_writes_nothing) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("alidade_lines_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const std::filesystem::path cloud = folder / "garden.las", ends = folder / "ends.csv";
  write_las(cloud, garden(k_metres));
  std::ofstream(ends) << "x,y,z,name\n690005,5325010,601,west\n690015,5325010,601,east\n"
                         "690015,5325012,601,beside\n";
  jobs::LinesRequest request;
  request.files = resolve_clouds({&cloud, 1}, jobs::cloud_formats());
  request.pairs.places = ends;
  Heard heard;
  const jobs::LinesResult result = run(jobs::plan(request), heard);
  ASSERT_EQ(result.table.reports.size(), 3u);
  ASSERT_TRUE(result.table.reports[0].blocker) << "the wall is between west and east";
  EXPECT_EQ(result.table.classifications[result.table.reports[0].blocker->point_id], 6);
  EXPECT_FALSE(result.table.reports[2].blocker) << "east and beside are on one side";
  EXPECT_EQ(result.table.unscanned.size(), 3u);
  EXPECT_EQ(std::ranges::count(heard.notes, "1 of 3 lines are free"), 1) << heard.text();
  // The ground below the lines is no stage of its own.
  EXPECT_EQ(std::ranges::count(heard.stages, "computing the ground"), 0);
  EXPECT_EQ(std::ranges::count(heard.stages, "testing lines of sight"), 1);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 2);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace alidade::test
