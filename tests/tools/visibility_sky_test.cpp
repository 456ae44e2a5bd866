// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>

#include "cloud/read_cloud.h"
#include "tests/support/absent_data.h"
#include "tests/tools/wall_site.h"

namespace alidade::test {
namespace {

class SkyTest : public WallSiteTest {
 protected:
  /// `alidade visibility COMMAND site.csv WORDS...`, quietly.
  ProgramResult visibility(const std::string& command, const Words& words) {
    Words all{"visibility", command, "site.csv", "-q"};
    all.insert(all.end(), words.begin(), words.end());
    return run(all);
  }

  /// The float values of an extra dimension of a cloud.
  std::vector<float> column(const std::string& file, const std::string& name) {
    const std::filesystem::path path = folder / file;
    const PointCloud cloud = read_cloud(std::span(&path, 1));
    std::vector<float> numbers(cloud.size());
    for (const ExtraDimension& dimension : cloud.extra_dimensions) {
      if (dimension.name != name) continue;
      EXPECT_EQ(dimension.type, ScalarType::float32);
      std::memcpy(numbers.data(), dimension.values.data(), dimension.values.size());
      return numbers;
    }
    ADD_FAILURE() << "no " << name;
    return numbers;
  }

  /// Row of the floor's point (0.2 i, 0.2 j).
  static std::size_t floor(int i, int j) { return static_cast<std::size_t>((i + 25) * 51 + (j + 25)); }
};

TEST_F(SkyTest, horizon_is_csv_on_stdout_with_a_row_per_azimuth) {
  const ProgramResult result = visibility("horizon", {"--observer", "-3,0.03,1", "--step", "10"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::istringstream lines(result.out);
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "azimuth,elevation,distance,point_id,x,y,z,unscanned");
  int rows = 0;
  double east = -90.0;
  for (; std::getline(lines, line); ++rows)
    if (line.starts_with("90,")) east = std::stod(line.substr(3));
  EXPECT_EQ(rows, 36);
  // The wall's top edge, 1 m above the eye, and 3 m away; discs at the edge stand over it a little.
  EXPECT_GT(east, 18.4);
  EXPECT_LT(east, 24.0);
}

TEST_F(SkyTest, horizon_writes_geojson_skyline_and_panorama) {
  const ProgramResult result = run({"visibility", "horizon", "site.csv", "--observer", "-3,0.03,1", "--step",
                                    "2", "--resolution", "0.1", "-o", "line.geojson", "--skyline", "line.png",
                                    "--depth", "around.exr", "--depth-size", "128x64"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(names(), (Words{"around.exr", "line.geojson", "line.png", "site.csv"}));
  EXPECT_TRUE(contains(result.err, "sky-view factor")) << result.err;
  const auto line = nlohmann::json::parse(read("line.geojson"));
  ASSERT_EQ(line["features"].size(), 181u);
  EXPECT_EQ(line["features"][0]["geometry"]["coordinates"][0], -3.0);
  EXPECT_TRUE(line.contains("coordinate_system")) << "the cloud has no reference system";
  const double factor = line["features"][0]["properties"]["sky_view_factor"];
  EXPECT_GT(factor, 0.9);
  EXPECT_LT(factor, 1.0);
  EXPECT_TRUE(read("line.png").starts_with("\x89PNG"));
  EXPECT_TRUE(read("around.exr").starts_with("\x76\x2f\x31\x01"));
}

TEST_F(SkyTest, horizon_is_that_of_one_position_with_files_that_name_their_kind) {
  const Words observer{"--observer", "-3,0.03,1"};
  const auto with = [&](Words words) {
    words.insert(words.end(), observer.begin(), observer.end());
    return visibility("horizon", words);
  };
  EXPECT_TRUE(contains(with({"--observer", "1,1,1"}).err, "expected one observer, found 2"));
  EXPECT_TRUE(contains(with({"-o", "line.txt"}).err, "the extension .csv or .geojson"));
  EXPECT_TRUE(contains(with({"--skyline", "line.jpg"}).err, ".png"));
  EXPECT_TRUE(contains(with({"--depth", "line.png"}).err, ".exr"));
  EXPECT_TRUE(contains(with({"--step", "0.7"}).err, "azimuth step"));
  EXPECT_TRUE(contains(with({"--resolution", "0.017"}).err, "resolution"));
  EXPECT_EQ(visibility("horizon", {}).exit_code, 2);
  EXPECT_EQ(names(), (Words{"site.csv"}));
  write("line.csv", "mine");
  EXPECT_EQ(with({"-o", "line.csv"}).exit_code, 2);
  EXPECT_EQ(read("line.csv"), "mine");
  EXPECT_EQ(with({"-o", "line.csv", "--overwrite", "--step", "90"}).exit_code, 0);
}

TEST_F(SkyTest, sky_gives_every_point_its_factor) {
  const ProgramResult result = visibility("sky", {"-o", "sky.las"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::vector<float> views = column("sky.las", "SkyView");
  ASSERT_EQ(views.size(), 51u * 51u + 61u * 20u);
  EXPECT_GT(views[floor(-25, 0)], 0.9f);
  EXPECT_LT(views[floor(-1, 0)], 0.65f) << "beside the wall";
  const std::vector<std::string> before = names();
  EXPECT_EQ(visibility("sky", {"-o", "sky.las"}).exit_code, 2) << "it exists";
  EXPECT_EQ(names(), before);
}

TEST_F(SkyTest, sky_and_sun_write_maps_of_the_ground) {
  ASSERT_EQ(visibility("sky", {"-o", "sky.tif", "--resolution", "0.5", "--directions", "32"}).exit_code, 0);
  ASSERT_EQ(visibility("sun", {"-o", "sun.tif", "--from", "2026-06-21", "--place", "48,11", "--step", "60",
                               "--resolution", "0.5", "--target-height", "0.1", "--preview", "sun.png"})
                .exit_code,
            0);
  for (const char* const file : {"sky.tif", "sun.tif"}) EXPECT_TRUE(read(file).starts_with("II*")) << file;
  EXPECT_TRUE(read("sun.png").starts_with("\x89PNG"));
}

TEST_F(SkyTest, sun_counts_hours_of_every_point) {
  // In the morning the wall's shadow lies west of it.
  const Words day{"--place", "48,11", "--step", "30", "--receiver", "horizontal"};
  Words morning = day, whole = day;
  for (const char* const word :
       {"-o", "morning.las", "--from", "2026-06-21T04:00Z", "--to", "2026-06-21T10:00Z"})
    morning.emplace_back(word);
  for (const char* const word : {"-o", "day.las", "--from", "2026-06-21"}) whole.emplace_back(word);
  ProgramResult result = visibility("sun", morning);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  result = visibility("sun", whole);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::vector<float> hours = column("morning.las", "SunHours"), of_day = column("day.las", "SunHours");
  EXPECT_NEAR(hours[floor(20, 0)], 6.0, 0.01) << "east of the wall";
  EXPECT_LT(hours[floor(-2, 0)], 3.0) << "west of the wall";
  // Of 16 hours; the sun rises behind the wall's end.
  EXPECT_GT(of_day[floor(-25, -25)], 14.0);
  EXPECT_LT(of_day[floor(-25, -25)], 16.1);
}

TEST_F(SkyTest, sun_of_observers_is_a_row_for_each_and_period_with_a_diagram) {
  const Words words{"--place",    "48,11", "--step",     "60",    "--from",
                    "2026-06-21", "--to",  "2026-06-22", "--per", "day"};
  const auto sun = [&](Words more) {
    more.insert(more.begin(), words.begin(), words.end());
    return visibility("sun", more);
  };
  ProgramResult result = sun({"--observer", "-3,0.03,1", "--observer", "-0.3,0,0.1", "-o", "sun.csv"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::istringstream lines(read("sun.csv"));
  std::string line;
  std::getline(lines, line);
  EXPECT_TRUE(line.starts_with("observer,x,y,z,period,SunHours")) << line;
  std::vector<double> hours;
  while (std::getline(lines, line)) {
    EXPECT_TRUE(contains(line, hours.size() % 2 == 0 ? "2026-06-21" : "2026-06-22")) << line;
    const std::size_t at = line.find("2026-06-2") + 11;
    hours.push_back(std::stod(line.substr(at)));
  }
  ASSERT_EQ(hours.size(), 4u);
  EXPECT_GT(hours[0], 1.2 * hours[2]) << "the second one is beside the wall";
  EXPECT_EQ(
      sun({"--observer", "-3,0.03,1", "-o", "sun.json", "--diagram", "sun.png", "--tilt", "40"}).exit_code,
      0);
  EXPECT_TRUE(read("sun.png").starts_with("\x89PNG"));
  const auto object = nlohmann::json::parse(read("sun.json"));
  EXPECT_EQ(object["alidade_sun_receiver"], "tilt 40, aspect 180");
  EXPECT_EQ(sun({"--observer", "-3,0.03,1", "-o", "sun.geojson"}).exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(read("sun.geojson"))["features"].size(), 2u);

  const auto err = [&](const Words& more) {
    Words all{"--observer", "-3,0.03,1", "-o", "b.csv"};
    all.insert(all.end(), more.begin(), more.end());
    const ProgramResult wrong = sun(all);
    EXPECT_EQ(wrong.exit_code, 2) << more.front();
    return wrong.err;
  };
  EXPECT_TRUE(contains(err({"--observer", "1,1,1", "--diagram", "b.png"}), "expected one observer, found 2"));
  EXPECT_TRUE(contains(err({"--diagram", "b.jpg"}), "the extension .png"));
  EXPECT_TRUE(contains(err({"--resolution", "1"}), "--resolution does not apply to --observer"));
  EXPECT_TRUE(contains(err({"--receiver", "surface"}), "--tilt and --aspect"));
  EXPECT_EQ(sun({"--diagram", "b.png", "-o", "b.las"}).exit_code, 2) << "without observers";
  EXPECT_FALSE(std::filesystem::exists(folder / "b.csv"));
}

TEST_F(SkyTest, sun_needs_a_position_and_a_time) {
  const Words from{"--from", "2026-06-21", "-o", "sun.las"};
  EXPECT_TRUE(contains(visibility("sun", from).err, "--place LAT,LON"));
  const auto err = [&](const std::string& option, const std::string& value) {
    Words words{"--place", "48,11", "-o", "sun.las", option, value};
    if (option != "--from") words.insert(words.end(), {"--from", "2026-06-21"});
    const ProgramResult result = visibility("sun", words);
    EXPECT_EQ(result.exit_code, 2) << option << " " << value;
    return result.err;
  };
  EXPECT_TRUE(contains(err("--from", "midsummer"), "invalid date and time"));
  EXPECT_TRUE(contains(err("--from", "2026-06-21T10:00"), "time zone"));
  EXPECT_TRUE(contains(err("--from", "2026-02-30"), "expected a date such as"));
  EXPECT_TRUE(contains(err("--to", "2026-06-20"), "empty time range"));
  EXPECT_TRUE(contains(err("--step", "0"), "--step"));
  EXPECT_TRUE(contains(err("--bin", "40"), "--bin"));
  EXPECT_EQ(visibility("sun", {"--place", "48", "--from", "2026-06-21", "-o", "sun.las"}).exit_code, 2);
  EXPECT_EQ(names(), (Words{"site.csv"}));
}

TEST_F(SkyTest, options_of_maps_mean_nothing_for_points_nor_the_other_way) {
  EXPECT_TRUE(contains(visibility("sky", {"-o", "a.las", "--resolution", "1"}).err, "--resolution"));
  EXPECT_TRUE(contains(visibility("sky", {"-o", "a.ply", "--target-height", "1"}).err, "--target-height"));
  EXPECT_TRUE(contains(visibility("sky", {"-o", "a.las", "--preview", "a.png"}).err, "--preview"));
  EXPECT_TRUE(contains(visibility("sky", {"-o", "a.tif", "--preview", "a.jpg"}).err, ".png"));
  EXPECT_TRUE(contains(visibility("sky", {"-o", "a.txt"}).err, "the extension .las, .laz, .ply or .tif"));
  EXPECT_EQ(visibility("sky", {"-o", "a.las", "--directions", "0"}).exit_code, 2);
}

TEST_F(SkyTest, clouds_in_degrees_have_no_elevations) {
  const auto file = shared_data("lidar/epsg_4326.las");
  if (!file) GTEST_SKIP() << absent("../shared/data/lidar/epsg_4326.las", 3);
  for (const Words& words :
       {Words{"visibility", "sky", file->string(), "-o", "a.las"},
        Words{"visibility", "sun", file->string(), "-o", "a.las", "--from", "2026-06-21"},
        Words{"visibility", "horizon", file->string(), "--observer", "-94.6,39.1,300"}}) {
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 2) << words[1];
    EXPECT_TRUE(contains(result.err, "a projected reference system: --reproject auto")) << result.err;
  }
}

TEST_F(SkyTest, answers_do_not_depend_on_threads) {
  for (const char* const threads : {"1", "3"}) {
    ASSERT_EQ(
        visibility("sky", {"-o", std::string("sky") + threads + ".las", "--threads", threads}).exit_code, 0);
    ASSERT_EQ(visibility("horizon", {"--observer", "-3,0.03,1", "--step", "5", "-o",
                                     std::string("line") + threads + ".csv", "--threads", threads})
                  .exit_code,
              0);
  }
  EXPECT_EQ(read("sky1.las"), read("sky3.las"));
  EXPECT_EQ(read("line1.csv"), read("line3.csv"));
}

}  // namespace
}  // namespace alidade::test
