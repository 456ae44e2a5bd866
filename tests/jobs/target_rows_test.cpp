// SPDX-License-Identifier: MIT
#include "jobs/query/targets.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>

#include "base/error.h"
#include "tests/support/random.h"

namespace alidade::test {

namespace {

class TargetRowsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    file_ = std::filesystem::temp_directory_path() / ("alidade_target_rows_" + std::to_string(::getpid()));
  }
  void TearDown() override { std::filesystem::remove(file_); }

  /// All targets of a text.
  template <class Target>
  std::vector<Target> read(const std::string& text, jobs::TargetFamily family) {
    std::ofstream(file_, std::ios::binary) << text;
    jobs::CheckedQuery query;
    query.family = family;
    query.given(family).text = file_.string();
    jobs::TargetReader<Target> reader(query);
    std::vector<Target> targets;
    for (jobs::TargetBatch<Target> batch; reader.next(100, batch);)
      targets.insert(targets.end(), batch.targets.begin(), batch.targets.end());
    return targets;
  }

  std::filesystem::path file_;
};

/// A text with some bytes changed, left out, doubled or swapped.
std::string damaged(std::string text, Random& random) {
  const std::string characters = "0123456789.,-+eE\"[]{}:\n\r\t naif\\xyzod_\xC3\xBC";
  for (std::uint64_t changes = 1 + random.below(2); changes > 0 && !text.empty(); --changes) {
    const std::size_t at = random.below(text.size()), length = 1 + random.below(6);
    switch (random.below(5)) {
      case 0:
        text[at] = characters[random.below(characters.size())];
        break;
      case 1:
        text.erase(at, length);
        break;
      case 2:
        text.insert(at, text.substr(random.below(text.size()), length));
        break;
      case 3:
        text[at] = static_cast<char>(random.below(256));
        break;
      default:
        text.resize(at);
    }
  }
  return text;
}

// Whatever a text holds, it is either rows whose values keep the rules, or an Error that names line and
// column.
TEST_F(TargetRowsTest, damaged_text_gives_good_rows_or_an_error_with_a_position) {
  const std::string csv =
      "ox,oy,oz,dx,dy,dz,half_angle,t_max\n1,2,3,4,5,6,7.5,inf\n-1e3,2.5e-2,3,0,0,1,0,\n\n0,0,0,\"1\",2,3,89,"
      "5\n";
  const std::string json =
      "{\"origin\": [1, 2, 3], \"direction\": [0, 0, 1], \"half_angle\": 5}\n[1, 2, 3, 4, 5, 6, 7, 0.5, "
      "null, \"inf\"]\n"
      "{\"ox\": 1, \"oy\": 2, \"oz\": 3, \"direction\": [1, 0, 0], \"half_angle\": 5, \"t_min\": -2}\n";
  const auto read_cones = [&](const std::string& text) {
    return read<Cone>(text, jobs::TargetFamily::cones);
  };
  EXPECT_EQ(read_cones(csv).size(), 3u);
  EXPECT_EQ(read_cones(json).size(), 3u);
  Random random;
  int read_count = 0, rejected_count = 0;
  for (int i = 0; i < 3000; ++i) {
    const std::string text = damaged(i % 2 == 0 ? csv : json, random);
    try {
      for (const Cone& cone : read_cones(text)) {
        for (int axis = 0; axis < 3; ++axis) ASSERT_TRUE(std::isfinite(cone.axis.origin[axis])) << text;
        ASSERT_NEAR(glm::length(cone.axis.direction), 1.0, 1e-9) << text;
        ASSERT_TRUE(cone.slope >= 0.0 && std::isfinite(cone.slope) && cone.radius >= 0.0) << text;
      }
      ++read_count;
    } catch (const Error& error) {
      ASSERT_EQ(error.parts().file, file_.string());
      std::size_t line = 0, column = 0;
      ASSERT_EQ(std::sscanf(error.parts().location.c_str(), "%zu:%zu", &line, &column), 2) << error.what();
      ASSERT_TRUE(line >= 1 && line <= 6 + text.size() && column >= 1 && column <= text.size() + 1)
          << error.what();
      ++rejected_count;
    }
  }
  EXPECT_GT(read_count, 50);
  EXPECT_GT(rejected_count, 500);
}

TEST_F(TargetRowsTest, numbers_are_read_to_the_last_bit_in_csv_and_json) {
  Random random;
  std::string csv = "x,y,z\n", json;
  std::vector<glm::dvec3> expected;
  for (int i = 0; i < 3000; ++i) {
    std::string numbers[3];
    glm::dvec3& position = expected.emplace_back();
    for (int axis = 0; axis < 3; ++axis) {
      const double value = std::ldexp(random.between(-1, 1), static_cast<int>(random.below(2000)) - 1000);
      char digits[40];
      std::snprintf(digits, sizeof digits, "%.17g", value);
      numbers[axis] = digits;
      position[axis] = value;
    }
    csv += numbers[0] + "," + numbers[1] + "," + numbers[2] + "\n";
    json += "[" + numbers[0] + "," + numbers[1] + "," + numbers[2] + "]\n";
  }
  EXPECT_TRUE(read<glm::dvec3>(csv, jobs::TargetFamily::points) == expected);
  EXPECT_TRUE(read<glm::dvec3>(json, jobs::TargetFamily::points) == expected);
}

}  // namespace
}  // namespace alidade::test
