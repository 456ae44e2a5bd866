// SPDX-License-Identifier: MIT
#include "jobs/visibility/sky.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <string>
#include <variant>
#include <vector>

#include "cloud/las/write_las.h"
#include "jobs/load_cloud.h"
#include "jobs/visibility/sun.h"
#include "tests/jobs/heard.h"
#include "tests/support/garden.h"

namespace alidade::test {
namespace {

namespace fs = std::filesystem;

class SkyJobTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("alidade_sky_" + std::to_string(::getpid()));
    fs::create_directories(folder);
    write_las(folder / "garden.las", garden(k_metres));
  }
  void TearDown() override { fs::remove_all(folder); }

  /// A request on the garden.
  template <class Request>
  Request request(const std::string& output) {
    Request made;
    const fs::path cloud = folder / "garden.las";
    made.files = resolve_clouds({&cloud, 1}, jobs::cloud_formats());
    made.output = folder / output;
    return made;
  }

  jobs::SunRequest noon(const std::string& output) {
    auto made = request<jobs::SunRequest>(output);
    made.from = {parse_date_time("2026-06-21T10:00Z")};
    made.to = {parse_date_time("2026-06-21T12:00Z")};
    made.step_minutes = 60.0;
    made.location = {48.0, 11.0};
    return made;
  }

  Heard heard;
  fs::path folder;
};

const geo::Raster<float>& map_of(const jobs::SkyResult& result) {
  return std::get<geo::Raster<float>>(result.views);
}

TEST_F(SkyJobTest, sky_of_points_is_by_point_id) {
  auto sky = request<jobs::SkyRequest>("sky.las");
  sky.directions = 8;
  const jobs::SkyResult result = run(jobs::plan(sky), heard);
  EXPECT_EQ(std::get<std::vector<float>>(result.views).size(), garden(k_metres).size());
  EXPECT_EQ(result.crs.wkt, k_metres);
  EXPECT_TRUE(fs::exists(sky.output));
}

TEST_F(SkyJobTest, sky_of_the_ground_is_a_map_with_the_metadata_of_its_file) {
  auto sky = request<jobs::SkyRequest>("sky.tif");
  sky.directions = 8;
  sky.map.resolution = 2.0;
  const jobs::SkyResult result = run(jobs::plan(sky), heard);
  EXPECT_EQ(map_of(result).values.size(), map_of(result).grid.size());
  EXPECT_EQ(map_of(result).grid.cell_size, 2.0);
  const jobs::MapMetadata::value_type text{"alidade_sky", "sky-view factor on the horizontal, 8 directions"};
  EXPECT_EQ(std::ranges::count(result.metadata, text), 1);
}

TEST_F(SkyJobTest, without_an_output_nothing_is_written) {
  auto sky = request<jobs::SkyRequest>("sky.las");
  jobs::SunRequest sun = noon("sun.las");
  sky.output.clear();
  sun.output.clear();
  sky.directions = 8;
  EXPECT_EQ(std::get<std::vector<float>>(run(jobs::plan(sky), heard).views).size(), garden(k_metres).size());
  EXPECT_EQ(run(jobs::plan(sun), heard).numbers.size(), garden(k_metres).size());
  sky.map.resolution = 4.0;
  sun.map.resolution = 4.0;
  EXPECT_GT(map_of(run(jobs::plan(sky), heard)).values.size(), 0u);
  EXPECT_TRUE(run(jobs::plan(sun), heard).grid);
  sun.map.resolution.reset();
  sun.observers.positions = {visibility::parse_observer("690005,5325010,601")};
  EXPECT_EQ(run(jobs::plan(sun), heard).numbers.size(), 1u);
  EXPECT_EQ(heard.text().find("wrote"), std::string::npos) << heard.text();
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1);
}

TEST_F(SkyJobTest, sun_of_observers_is_for_each_and_period) {
  jobs::SunRequest sun = noon("sun.csv");
  sun.observers.positions = {visibility::parse_observer("690005,5325010,601"),
                             visibility::parse_observer("690015,5325010,601")};
  const jobs::SunResult result = run(jobs::plan(sun), heard);
  ASSERT_EQ(result.observers.size(), 2u);
  ASSERT_EQ(result.receivers(), 2u);
  for (const float hours : result.numbers) EXPECT_FLOAT_EQ(hours, 2.0f);
  EXPECT_FALSE(result.grid);
}

TEST_F(SkyJobTest, sun_of_the_ground_is_a_map_for_each_period) {
  jobs::SunRequest sun = noon("sun.tif");
  sun.map.resolution = 4.0;
  const jobs::SunResult result = run(jobs::plan(sun), heard);
  ASSERT_TRUE(result.grid);
  EXPECT_EQ(result.receivers(), result.grid->size());
  EXPECT_EQ(bands_of(sun, result).size(), result.periods.size());
}

TEST_F(SkyJobTest, plans_reject_what_needs_no_cloud) {
  const auto message = [](const auto& request) -> std::string {
    try {
      (void)jobs::plan(request);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  };
  auto sky = request<jobs::SkyRequest>("sky.las");
  sky.map.resolution = 1.0;
  EXPECT_NE(message(sky).find("--resolution does not apply"), std::string::npos) << message(sky);
  jobs::SunRequest sun = noon("sun.las");
  sun.diagram = folder / "sun.png";
  EXPECT_NE(message(sun).find("--diagram requires an observer"), std::string::npos) << message(sun);
}

}  // namespace
}  // namespace alidade::test
