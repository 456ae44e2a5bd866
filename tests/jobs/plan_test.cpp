// SPDX-License-Identifier: MIT
#include "jobs/plan.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "base/error.h"
#include "cloud/las/write_las.h"
#include "jobs/load_cloud.h"
#include "jobs/visibility/visibility_cloud.h"
#include "tests/support/garden.h"

namespace alidade::test {
namespace {

class PlanTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / "alidade_plan_test";
    std::filesystem::create_directories(folder_);
    write_las(folder_ / "garden.las", garden(k_metres));
    std::ofstream(folder_ / "garden.xyz") << "1 2 3\n4 5 6\n";
    std::ofstream(folder_ / "masts.csv") << "x,y\n1,2\n";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  jobs::PlannedWork work(const std::string& cloud) const {
    const std::filesystem::path name = folder_ / cloud;
    return {.clouds = resolve_clouds({&name, 1}, jobs::cloud_formats()),
            .reads = {folder_ / "masts.csv", ""},
            .writes = {"", folder_ / "seen.tif"},
            .bytes_per_point = 1000.0};
  }
  std::string name(const char* file) const { return (folder_ / file).string(); }

  std::filesystem::path folder_;
};

TEST_F(PlanTest, tells_files_sizes_and_memory) {
  const std::string text = text_of(work("garden.las"));
  const std::size_t points = garden(k_metres).size();
  EXPECT_TRUE(text.starts_with("reads   " + name("garden.las") + "  " + std::to_string(points) + " points, "))
      << text;
  EXPECT_NE(text.find("\nreads   " + name("masts.csv") + "  8 B\nwrites  " + name("seen.tif") + "\n"),
            std::string::npos)
      << text;
  // 50 MB without points, and 1000 B for each of 7533.
  EXPECT_EQ(points, 7533u);
  EXPECT_NE(text.find("\nneeds   about 57.5 MB of memory"), std::string::npos) << text;
  std::ofstream(folder_ / "seen.tif") << "old";
  EXPECT_NE(text_of(work("garden.las")).find(name("seen.tif") + "  an existing file\n"), std::string::npos);
}

TEST_F(PlanTest, does_not_guess_where_points_are_not_counted) {
  const std::string text = text_of(work("garden.xyz"));
  EXPECT_NE(text.find("garden.xyz  points not counted yet, 12 B\n"), std::string::npos) << text;
  EXPECT_EQ(text.find("needs"), std::string::npos) << text;
}

TEST_F(PlanTest, a_missing_cloud_is_an_error_and_a_damaged_one_unless_read_in_part) {
  EXPECT_THROW(text_of(work("none.las")), Error);
  std::filesystem::resize_file(folder_ / "garden.las", 3000);
  jobs::PlannedWork damaged = work("garden.las");
  EXPECT_THROW(text_of(damaged), Error);
  damaged.partial = true;
  EXPECT_TRUE(text_of(damaged).starts_with("reads   " + name("garden.las")));
}

TEST_F(PlanTest, other_files_that_are_missing_are_errors) {
  jobs::PlannedWork one = work("garden.xyz");
  for (const char* const left_to_others :
       {"-", "tiles/*.las", "postgresql://host/site", "/vsizip/a.zip/b.tif"}) {
    one.reads = {left_to_others};
    EXPECT_NE(text_of(one).find("\nreads   "), std::string::npos) << left_to_others;
  }
  one.reads = {folder_ / "none.csv"};
  try {
    (void)text_of(one);
    FAIL();
  } catch (const Error& error) {
    EXPECT_TRUE(std::string(error.what()).starts_with(name("none.csv") + ": cannot open the file"))
        << error.what();
  }
}

TEST_F(PlanTest, work_without_files_is_stated) {
  EXPECT_EQ(text_of(jobs::PlannedWork{}), "reads and writes no files\n");
  EXPECT_EQ(text_of(jobs::PlannedWork{.reads = {"-"}}), "reads   standard input\n");
}

TEST_F(PlanTest, memory_for_a_raster_alone_is_unknown) {
  jobs::VisibilityRequest request;
  const std::filesystem::path raster = folder_ / "dem.asc";
  std::ofstream(raster) << "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n3 4\n";
  request.files = resolve_clouds({&raster, 1}, jobs::cloud_formats());
  EXPECT_EQ(request.work().bytes_per_point, 0.0);
  EXPECT_EQ(request.work().reads.front(), raster);
  request.files = work("garden.las").clouds;
  EXPECT_GT(request.work().bytes_per_point, 0.0);
}

TEST_F(PlanTest, outputs_are_not_inputs_and_differ) {
  jobs::PlannedWork one = work("garden.las");
  EXPECT_NO_THROW(check_outputs(one, false));
  one.writes.push_back(folder_ / "masts.csv");
  EXPECT_THROW(check_outputs(one, true), Error);
  one.writes.back() = folder_ / "garden.las";
  EXPECT_THROW(check_outputs(one, true), Error);
  one.writes.back() = folder_ / "seen.tif";
  EXPECT_THROW(check_outputs(one, true), Error);
}

}  // namespace
}  // namespace alidade::test
