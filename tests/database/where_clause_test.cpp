// SPDX-License-Identifier: MIT
#include "database/sqlite/where_clause.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "tests/database/sqlite_fixture.h"

namespace alidade::test {
namespace {

class WhereClauseTest : public SqliteTest {
 protected:
  static std::vector<std::uint8_t> marks(const PointCloud& cloud, const std::string& text) {
    std::vector<std::uint8_t> marks(cloud.size(), 2);
    WhereClause(text).mark(cloud, marks);
    return marks;
  }

  static std::string problem(const std::string& text, std::size_t count = 3) {
    try {
      marks(site(count), text);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(WhereClauseTest, holds_for_the_rows_that_brute_force_finds) {
  // More than one connection evaluates.
  const PointCloud cloud = site(150'000);
  const ExtraDimension& height = cloud.extra_dimensions[0];
  const std::vector<std::pair<std::string, std::function<bool(std::size_t)>>> conditions = {
      {"classification = 2", [&](std::size_t row) { return cloud.classifications[row] == 2; }},
      {"classification IN (2, 5) OR return_number = 3",
       [&](std::size_t row) {
         const int kind = cloud.classifications[row];
         return kind == 2 || kind == 5 || cloud.returns[row].number == 3;
       }},
      {"red BETWEEN 100 AND 30000 AND NOT blue > 7",
       [&](std::size_t row) { return cloud.colors[row].x >= 100 && cloud.colors[row].x <= 30000; }},
      {"x + y > 6015050 -- a comment",
       [&](std::size_t row) { return cloud.world(row).x + cloud.world(row).y > 6015050; }},
      {"gps_time % 2 = 0",
       [&](std::size_t row) { return static_cast<std::int64_t>(cloud.gps_times[row]) % 2 == 0; }},
      {"\"Height\" >= 1", [&](std::size_t row) { return height.values[2 * row] >= 100; }},
      {"height IS NULL", [&](std::size_t row) { return height.values[2 * row] == 0; }},
      {"height = NULL", [](std::size_t) { return false; }},
      {"dist_plane(690000,5325000,400, 0,0,1, x,y,z) <= 0.25",
       [&](std::size_t row) { return cloud.world(row).z - 400 <= 0.25; }},
      {"1", [](std::size_t) { return true; }}};
  for (const auto& [text, holds] : conditions) {
    const std::vector<std::uint8_t> found = marks(cloud, text);
    for (std::size_t row = 0; row < cloud.size(); ++row)
      ASSERT_EQ(found[row], holds(row) ? 1 : 0) << text << " at row " << row;
  }
}

TEST_F(WhereClauseTest, what_is_no_condition_is_an_error) {
  EXPECT_EQ(
      problem("z >"),
      "invalid condition 'z >': incomplete input; expected a condition such as \"classification = 2 AND "
      "intensity > 100\"");
  for (const std::string text :
       {"", "  ", "1) OR (1", "z > 1; DELETE FROM point", "z > 1 ORDER BY z", "z >> ", "'"})
    EXPECT_NE(problem(text), "") << text;
}

TEST_F(WhereClauseTest, a_condition_that_changes_from_one_time_to_the_next_is_an_error) {
  for (const char* const text : {"z > ?", "z > ?1", "z > :low", "z > @low OR 1", "$low < z"}) {
    const std::string said = problem(text);
    EXPECT_NE(said.find("it has the parameter "), std::string::npos) << text << ": " << said;
    EXPECT_NE(said.find("expected a value in its place"), std::string::npos) << said;
  }
  for (const char* const text :
       {"random() % 10 = 0", "RANDOM ( ) > 0", "\"random\"() > 0", "length(randomblob(4)) = 4",
        "changes() = 0", "gps_time < current_timestamp", "z IN (SELECT random())",
        "julianday('now') > gps_time", "date() > '2020'",
        "datetime(gps_time, 'unixepoch', 'localtime') > '2020'", "strftime('%s') > gps_time",
        "time('NOW') > '1'", "unixepoch('subsec') > gps_time"}) {
    const std::string said = problem(text);
    EXPECT_NE(said.find("changes from one time to the next; expected a condition on values of the points"),
              std::string::npos)
        << text << ": " << said;
  }
  // Text and names of that kind are none of these, and dates of the points are their values.
  for (const char* const text :
       {"'?' = '?'", "'random()' <> ''", "z > 0 -- ? random()", "datetime(gps_time, 'unixepoch') < '2100'",
        "strftime('%Y', gps_time, 'unixepoch') >= '1970'"})
    EXPECT_EQ(problem(text), "") << text;
}

TEST_F(WhereClauseTest, rows_have_no_number_in_a_condition_and_attributes_of_such_names_are_values) {
  for (const char* const name : {"rowid", "oid", "_rowid_"})
    EXPECT_NE(problem(std::string(name) + " < 3").find("no such column: " + std::string(name)),
              std::string::npos);
  PointCloud cloud = site(5);
  cloud.extra_dimensions.clear();
  for (const char* const name : {"_row", "_ROW_"}) {
    ExtraDimension one = plain_dimension(name, ScalarType::uint8);
    one.values = {200, 7, 201, 7, 202};
    cloud.extra_dimensions.push_back(one);
    EXPECT_EQ(marks(cloud, std::string(name) + " > 7"), (std::vector<std::uint8_t>{1, 0, 1, 0, 1})) << name;
  }
}

TEST_F(WhereClauseTest, a_column_that_is_missing_is_an_error_that_lists_those_that_are_not) {
  const std::string columns =
      "x, y, z, red, green, blue, classification, return_number, number_of_returns, gps_time, Height";
  EXPECT_EQ(
      problem("intensity > 3"),
      "invalid condition 'intensity > 3': no such column: intensity; expected a condition on " + columns);
  // Not taken for a text, as SQLite does by default.
  EXPECT_NE(problem("\"intensity\" > 3").find("no such column"), std::string::npos);
}

TEST_F(WhereClauseTest, errors_of_an_evaluation_are_errors) {
  EXPECT_NE(problem("abs(-9223372036854775807 - 1) > 0").find("integer overflow"), std::string::npos);
}

TEST_F(WhereClauseTest, one_row_that_takes_for_ever_is_given_up) {
  const PointCloud cloud = site(3);
  std::vector<std::uint8_t> marks(cloud.size());
  const WhereClause clause(
      "(WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT max(i) FROM n) > x");
  std::atomic<int> calls = 0;
  EXPECT_THROW(clause.mark(cloud, marks, [&] { return ++calls > 10; }), Cancelled);
}

TEST_F(WhereClauseTest, a_cloud_without_points_needs_no_columns) {
  EXPECT_EQ(problem("intensity > 3", 0), "");
}

}  // namespace
}  // namespace alidade::test
