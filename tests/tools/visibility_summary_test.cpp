// SPDX-License-Identifier: MIT
#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/tools/wall_site.h"

namespace alidade::test {
namespace {

using Json = nlohmann::json;

class VisibilitySummaryTest : public WallSiteTest {
 protected:
  ProgramResult summary(const Words& more) {
    Words words = {"visibility", "summary", "site.csv", "-q", "--directions", "500", "--step", "5"};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  }
  Json rows(const Words& more) {
    Words words = more;
    words.insert(words.end(), {"-o", "s.json", "--overwrite"});
    const ProgramResult result = summary(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return Json::parse(read("s.json"))["observers"];
  }
};

TEST_F(VisibilitySummaryTest, each_observer_has_a_row) {
  write("eyes.csv", "name,x,y,z,max_distance\nlow,-3,0,1,\nhigh,-3,0,9,\nblind,-3,0,1,0.1\n");
  const Json all = rows({"--observers", "eyes.csv", "--bands", "2,4"});
  ASSERT_EQ(all.size(), 3u);
  const Json &low = all[0], &high = all[1], &blind = all[2];
  EXPECT_EQ(low["name"], "low");
  EXPECT_LT(low["points"], high["points"]);
  EXPECT_LT(low["area"], high["area"]);
  EXPECT_LT(low["share"], 0.9) << "the wall hides floor";
  EXPECT_EQ(low["share_0_2"], 1.0);
  EXPECT_LT(low["share_4_inf"], low["share_2_4"]);
  EXPECT_NEAR(low["area_0_2"].get<double>() + low["area_2_4"].get<double>() + low["area_4_inf"].get<double>(),
              low["area"].get<double>(), 1e-9);
  EXPECT_NEAR(low["distance_min"].get<double>(), 1.0, 0.05);
  EXPECT_NEAR(low["horizon_max"].get<double>(), 18.4, 3.0) << "1 over the eye, 3 away";
  EXPECT_LT(low["sky_view"], 1.0);
  EXPECT_GT(high["sky_view"], 0.99);
  EXPECT_EQ(high["isovist_open"], 1.0);
  EXPECT_LT(low["isovist_open"], 1.0);
  EXPECT_LT(low["isovist_area"], high["isovist_area"]);
  EXPECT_NEAR(low["class_2"].get<double>() + low["class_6"].get<double>(), 1.0, 1e-12);
  EXPECT_NEAR(low["ground_area"].get<double>(), low["class_2"].get<double>() * low["area"].get<double>(),
              1e-9);
  EXPECT_EQ(blind["points"], 0);
  EXPECT_TRUE(blind["distance_mean"].is_null());
  EXPECT_TRUE(blind["share_0_2"].is_null());
}

TEST_F(VisibilitySummaryTest, the_extension_selects_the_format) {
  const Words eye = {"--observer", "-3,0", "-o"};
  for (const char* const output : {"s.csv", "s.geojson"}) {
    Words words = eye;
    words.emplace_back(output);
    ASSERT_EQ(summary(words).exit_code, 0);
  }
  const std::string csv = read("s.csv");
  EXPECT_EQ(csv.rfind("name,x,y,z,points,area,share,area_0_10,share_0_10,area_10_100,", 0), 0u) << csv;
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 2);
  const Json feature = Json::parse(read("s.geojson"))["features"][0];
  EXPECT_EQ(feature["geometry"]["coordinates"], (Json::array({-3.0, 0.0, 2.0})));
  EXPECT_EQ(feature["properties"]["name"], "observer 1");
}

TEST_F(VisibilitySummaryTest, bytes_do_not_depend_on_the_number_of_threads) {
  for (const char* const threads : {"1", "2"}) {
    ASSERT_EQ(
        summary({"--observer-grid", "5", "--threads", threads, "-o", std::string("s") + threads + ".csv"})
            .exit_code,
        0);
  }
  EXPECT_TRUE(read("s1.csv") == read("s2.csv"));
}

TEST_F(VisibilitySummaryTest, what_cannot_be_done_is_an_error) {
  const auto fails_with = [&](const Words& words, const std::string& part) {
    const ProgramResult result = summary(words);
    EXPECT_EQ(result.exit_code, 2) << part;
    EXPECT_NE(result.err.find(part), std::string::npos) << result.err;
    EXPECT_EQ(names(), Words{"site.csv"});
  };
  fails_with({"-o", "s.csv"}, "missing observers");
  fails_with({"--observer", "-3,0", "-o", "s.gpkg"}, "s.gpkg: unknown output format");
  fails_with({"--observer", "-3,0", "-o", "s.csv", "--bands", "5,5"}, "expected ascending distances");
  fails_with({"--observer", "-3,0", "-o", "s.csv", "--bands", "x"}, "--bands");
  fails_with({"--observer", "-3,0", "-o", "s.csv", "--step", "7"}, "360");
  fails_with({"--observer", "-3,0", "-o", "site.csv", "--overwrite"}, "site.csv");
  fails_with({"--observer", "90,0", "-o", "s.csv"}, "no ground below the observer");
}

TEST_F(VisibilitySummaryTest, help_gives_units_and_examples) {
  const ProgramResult result = run({"visibility", "summary", "--help"});
  EXPECT_EQ(result.exit_code, 0);
  for (const char* const part : {"metres", "isovist", "diversity", "Examples:"})
    EXPECT_NE(result.out.find(part), std::string::npos) << part;
}

}  // namespace
}  // namespace alidade::test
