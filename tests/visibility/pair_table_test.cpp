// SPDX-License-Identifier: MIT
#include "visibility/lines/line_files.h"

#include <gtest/gtest.h>
#include <filesystem>

#include <fstream>

#include "base/error.h"

namespace alidade::test {

using namespace visibility;

namespace {

std::filesystem::path written(const std::string& text) {
  const std::filesystem::path path = std::filesystem::temp_directory_path() / "pair_table_test.csv";
  std::ofstream(path) << text;
  return path;
}

std::string problem_of(const std::string& text) {
  const std::filesystem::path path = written(text);
  try {
    read_pair_table(path);
  } catch (const Error& error) {
    return std::string(error.what()).substr(path.string().size());
  }
  return "";
}

TEST(PairTable, names_alone_are_pairs_of_positions_known_elsewhere) {
  const std::vector<GivenPair> pairs = read_pair_table(written("to,from\nmast,roof\n\n\"a, b\",c\n"));
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_FALSE(pairs[0].has_positions);
  EXPECT_EQ(pairs[0].from.name, "roof");
  EXPECT_EQ(pairs[0].to.name, "mast");
  EXPECT_EQ(pairs[1].to.name, "a, b");
  EXPECT_TRUE(pairs[1].from.source.ends_with("pair_table_test.csv:line 4"));
}

TEST(PairTable, positions_may_lack_z_height_and_name) {
  const std::vector<GivenPair> pairs = read_pair_table(
      written("from_x,from_y,from_z,from_height,to_x,to_y,to_z,to\n1,2,3,10,4,5,,mast\n-1e2,0.5,,,0,0,7,\n"));
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_TRUE(pairs[0].has_positions);
  EXPECT_EQ(pairs[0].from.position, glm::dvec2(1, 2));
  EXPECT_EQ(pairs[0].from.z, 3.0);
  EXPECT_EQ(pairs[0].from.height, 10.0);
  EXPECT_EQ(pairs[0].to.position, glm::dvec2(4, 5));
  EXPECT_FALSE(pairs[0].to.z);
  EXPECT_EQ(pairs[0].to.name, "mast");
  EXPECT_EQ(pairs[1].from.position, glm::dvec2(-100, 0.5));
  EXPECT_FALSE(pairs[1].from.height);
  EXPECT_EQ(pairs[1].to.z, 7.0);
}

TEST(PairTable, errors_name_the_line) {
  EXPECT_TRUE(problem_of("").starts_with(": contains no pairs"));
  EXPECT_TRUE(problem_of("from,to\n").starts_with(": contains no pairs"));
  EXPECT_TRUE(problem_of("from,until\na,b\n").starts_with(":line 1: unknown column"));
  EXPECT_TRUE(problem_of("from,from\na,b\n").starts_with(":line 1: duplicate column from"));
  EXPECT_TRUE(problem_of("from\na\n").starts_with(":line 1: missing columns"));
  EXPECT_TRUE(problem_of("from,to,from_x,from_y\na,b,1,2\n").starts_with(":line 1: missing columns"));
  EXPECT_TRUE(problem_of("from,to,from_z\na,b,1\n").starts_with(":line 1: missing columns"));
  const std::string header = "from_x,from_y,to_x,to_y\n";
  EXPECT_EQ(problem_of(header + "1,2,3,4\n"), "");
  EXPECT_TRUE(problem_of(header + "1,2,3\n").starts_with(":line 2: too few columns"));
  EXPECT_TRUE(problem_of(header + "1,2,3,4,5\n").starts_with(":line 2: too many columns"));
  EXPECT_TRUE(
      problem_of(header + "\n1,2,x,4\n").starts_with(":line 3: invalid to_x; expected a finite number"));
  EXPECT_TRUE(problem_of(header + "1,2,,4\n").starts_with(":line 2: invalid to_x; expected a finite number"));
  EXPECT_TRUE(
      problem_of(header + "1,nan,3,4\n").starts_with(":line 2: invalid from_y; expected a finite number"));
  EXPECT_TRUE(
      problem_of(header + "1,inf,3,4\n").starts_with(":line 2: invalid from_y; expected a finite number"));
  EXPECT_TRUE(problem_of("from,to\na,\n").starts_with(":line 2: missing endpoint name"));
}

}  // namespace
}  // namespace alidade::test
