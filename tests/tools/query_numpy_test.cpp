// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/support/absent_data.h"
#include "tests/support/random.h"
#include "tests/tools/run_program.h"

// Answers of the program beside those of a short script in another language that looks at every point.

namespace alidade::test {
namespace {

class QueryNumpyTest : public ProgramTest {
 protected:
  /// A Python that has NumPy; empty if missing.
  static std::string python() {
    for (const char* const name : {"python3", "/usr/bin/python3"}) {
      if (std::system(fmt::format("{} -c 'import numpy' 2>/dev/null", name).c_str()) == 0) return name;
    }
    return {};
  }
};

TEST_F(QueryNumpyTest, answers_of_1000_rays_on_a_real_scan_are_those_of_a_short_script_to_the_last_digit) {
  const std::optional<std::filesystem::path> cloud = shared_data("lidar_rgb/autzen_stadium_crop.las");
  if (!cloud) GTEST_SKIP() << absent("../shared/data/lidar_rgb/autzen_stadium_crop.las");
  const std::string interpreter = python();
  if (interpreter.empty()) GTEST_SKIP() << "there is no python3 with NumPy";

  const auto bounds = nlohmann::json::parse(run({"info", "--json", cloud->string()}).out).at("bounds");
  const auto low = bounds.at("min").get<std::array<double, 3>>(),
             high = bounds.at("max").get<std::array<double, 3>>();
  Random random;
  std::string rays = "ox,oy,oz,dx,dy,dz,t_min,t_max\n";
  for (int i = 0; i < 1000; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      rays += fmt::format("{},", random.between(low[axis], high[axis]));
    const glm::dvec3 direction = random.direction();
    rays += fmt::format("{},{},{},-5,120\n", direction.x, direction.y, direction.z - 0.3);
  }
  write("rays.csv", rays);
  for (const char* const measure : {"distance", "t", "entry"}) {
    const ProgramResult result =
        run({"query", cloud->string(), "-q", "--rays", "rays.csv", "--radius", "2", "--k", "8", "--measure",
             measure, "--precision", "17", "-o", "answers.csv", "--overwrite"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    ASSERT_EQ(std::system(
                  fmt::format(
                      "cd '{}' && {} '{}/tests/tools/query_numpy_test.py' '{}' rays.csv 2 8 {} > script.csv",
                      folder.string(), interpreter, ALIDADE_SOURCE_FOLDER, cloud->string(), measure)
                      .c_str()),
              0);
    const std::string answers = read("answers.csv");
    EXPECT_GT(std::count(answers.begin(), answers.end(), '\n'), 1000);
    EXPECT_TRUE(answers == read("script.csv")) << measure;
  }
}

}  // namespace
}  // namespace alidade::test
