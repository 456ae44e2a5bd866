// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "cloud/las/write_las.h"
#include "tests/tools/run_program.h"

// One site as files whose heights are in feet and in metres.

namespace alidade::test {

using Json = nlohmann::json;

inline constexpr double k_foot_of_surveys = 1200.0 / 3937.0;

inline const std::string k_oregon =
    R"~(PROJCS["NAD83 / Oregon LCC (m)",GEOGCS["NAD83",DATUM["North_American_Datum_1983",SPHEROID["GRS 1980",6378137,)~"
    R"(298.257222101],AUTHORITY["EPSG","6269"]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433],)"
    R"(AUTHORITY["EPSG","4269"]],PROJECTION["Lambert_Conformal_Conic_2SP"],PARAMETER["latitude_of_origin",41.75],)"
    R"(PARAMETER["central_meridian",-120.5],PARAMETER["standard_parallel_1",43],PARAMETER["standard_parallel_2",45.5],)"
    R"(PARAMETER["false_easting",400000],PARAMETER["false_northing",0],UNIT["metre",1],AXIS["Easting",EAST],)"
    R"(AXIS["Northing",NORTH],AUTHORITY["EPSG","2991"]])";

inline std::string with_heights(const std::string& name, const std::string& unit, const std::string& code) {
  return "COMPD_CS[\"NAD83 / Oregon LCC (m) + " + name + "\"," + k_oregon + ",VERT_CS[\"" + name +
         R"(",VERT_DATUM["North American Vertical Datum 1988",2005,AUTHORITY["EPSG","5103"]],)" + unit +
         R"(,AXIS["Gravity-related height",UP],AUTHORITY["EPSG",")" + code + "\"]]]";
}

inline const std::string k_feet =
    with_heights("NAVD88 height (ftUS)", R"(UNIT["US survey foot",0.304800609601219])", "6360");
inline const std::string k_metres = with_heights("NAVD88 height", R"(UNIT["metre",1])", "5703");

inline std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

class UnitsTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_site("feet.las", k_feet, 0.01);
    write_site("metres.las", k_metres, 0.01 * k_foot_of_surveys);
  }

  /// Ground of 40 x 40 m with a wall of 6 m across it, in steps of this height.
  void write_site(const std::string& name, const std::string& wkt, double step, int shift = 0) {
    PointCloud cloud;
    cloud.lattice = {.scale = {0.01, 0.01, step}, .offset = {194500, 259240, 0}};
    cloud.crs = crs_of_wkt(wkt);
    const auto add = [&](int x, int y, double feet) {
      cloud.positions.emplace_back(x, y, static_cast<int>(std::lround(feet * 100)) + shift);
    };
    for (int i = 0; i < 80; ++i)
      for (int j = 0; j < 80; ++j) add(50 * i, 50 * j, 430 + 0.02 * i + 0.4 * std::sin(0.3 * j));
    for (int j = 20; j < 60; ++j)
      for (int k = 1; k < 40; ++k) add(2010, 50 * j, 431 + 0.5 * k);
    write_las(folder / name, cloud, {.overwrite = true});
  }

  /// Runs `words` on both files and expects the same output, byte for byte, and one sentence on heights.
  /// OUT.csv is where they write, if not to the terminal.
  void expect_as_in_metres(Words words) {
    ProgramResult results[2];
    for (int i = 0; i < 2; ++i) {
      Words all = words;
      for (std::string& word : all)
        if (word == "CLOUD") word = i == 0 ? "feet.las" : "metres.las";
      results[i] = run(all);
      EXPECT_EQ(results[i].exit_code, 0) << results[i].err;
      if (std::ranges::find(all, "OUT.csv") == all.end()) continue;
      results[i].out = read("OUT.csv");
      std::filesystem::remove(folder / "OUT.csv");
    }
    EXPECT_FALSE(results[0].out.empty());
    EXPECT_EQ(results[0].out, results[1].out) << words[0] << " " << words[1];
    const std::string said = "heights are converted from US survey foot to metre";
    EXPECT_EQ(count_of(results[0].err, said), 1u) << results[0].err;
    EXPECT_EQ(count_of(results[1].err, said), 0u) << results[1].err;
  }

  Json info(const std::string& file) { return Json::parse(run({"info", "--json", file}).out); }

  std::string error(const Words& words) {
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 2) << result.out;
    return result.err;
  }
};

}  // namespace alidade::test
