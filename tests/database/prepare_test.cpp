// SPDX-License-Identifier: MIT
// The paper's SQL as it is typed, and what must happen to input that makes no sense.
#include <algorithm>

#include "database/sqlite/prepare.h"
#include "octree/distance.h"
#include "tests/database/sqlite_fixture.h"

namespace alidade::test {

using namespace database;

namespace {

class PrepareTest : public SqliteTest {
 protected:
  PrepareTest() : cloud_(site(5000)) {
    store_cloud(file_, cloud_, {.chunk_points = 50});
    database_.emplace(file_, Connection::Mode::read);
  }

  /// That of all rows, sorted.
  std::vector<double> first_column(const std::string& sql, bool is_pruned = true) {
    const Prepared prepared = prepare(database_->get(), sql);
    EXPECT_EQ(!prepared.pruned.empty(), is_pruned) << sql << ": " << prepared.reason;
    std::vector<double> found;
    int result = SQLITE_ROW;
    while ((result = sqlite3_step(prepared.statement.get())) == SQLITE_ROW)
      found.push_back(sqlite3_column_double(prepared.statement.get(), 0));
    if (result != SQLITE_DONE) throw Error({.problem = sqlite3_errmsg(database_->get())});
    std::ranges::sort(found);
    return found;
  }

  std::string error_of(const std::string& sql) {
    try {
      first_column(sql);
    } catch (const Error& error) {
      return error.what();
    }
    return "none";
  }

  PointCloud cloud_;
  std::optional<Connection> database_;
};

TEST_F(PrepareTest, the_papers_statements_equal_brute_force_on_100_rays) {
  Random random;
  std::size_t found = 0;
  for (int i = 0; i < 100; ++i) {
    const glm::dvec3 origin(random.between(690000, 690100), random.between(5325000, 5325100),
                            random.between(395, 430));
    glm::dvec3 direction = random.direction();
    if (i % 10 == 0) direction = {1e-200, 0, i % 20 == 0 ? 1.0 : -1.0};
    const std::string numbers = fmt::format("{:.17g},{:.17g},{:.17g}, {:.17g},{:.17g},{:.17g}", origin.x,
                                            origin.y, origin.z, direction.x, direction.y, direction.z);
    const Ray ray = make_ray(origin, direction);
    const Plane plane = make_plane(origin, direction);
    std::vector<double> near, ahead;
    for (std::size_t id = 0; id < cloud_.size(); ++id) {
      if (project(ray, cloud_.world(id)).distance > 1) continue;
      near.push_back(static_cast<double>(id));
      if (signed_distance(plane, cloud_.world(id)) >= 0) ahead.push_back(static_cast<double>(id));
    }
    const std::string near_sql = "SELECT id FROM points WHERE dist_ray(" + numbers + ", x,y,z) <= 1";
    EXPECT_EQ(first_column(near_sql), near);
    EXPECT_EQ(first_column(near_sql + " AND dist_plane(" + numbers + ", x,y,z) >= 0"), ahead);
    found += near.size();
  }
  EXPECT_GT(found, 100u);
  EXPECT_LT(database_->reads().chunks_read, database_->reads().chunks / 4);
}

TEST_F(PrepareTest, chunks_and_points_are_counted) {
  first_column("SELECT id FROM points WHERE dist_ray(690050,5325050,410, 0,0,1, x,y,z) <= 1");
  const ScanReads reads = database_->reads();
  EXPECT_EQ(reads.scans, 1u);
  EXPECT_EQ(reads.chunks, 100u);
  EXPECT_GT(reads.chunks_read, 0u);
  EXPECT_LT(reads.chunks_read, 10u);
  EXPECT_EQ(reads.points_read, 50 * reads.chunks_read);
  first_column("SELECT id FROM points", false);
  EXPECT_EQ(database_->reads().chunks_read, 100 + reads.chunks_read);
  EXPECT_EQ(database_->reads().rows_given, 5000 + reads.rows_given);
}

TEST_F(PrepareTest, invalid_directions_and_positions_are_errors) {
  const std::vector<std::array<std::string, 2>> cases = {{"1,2,3, 0,0,0", "is zero"},
                                                         {"1,2,3, 1e999,0,0", "is not finite"},
                                                         {"1e999,2,3, 0,0,1", "is not finite"},
                                                         {"1,2,-1e999, 0,0,1", "is not finite"}};
  for (const std::string function : {"dist_ray(", "dist_plane("}) {
    for (const auto& [numbers, problem] : cases) {
      const std::string condition = function + numbers + ", x,y,z) <= 1";
      const std::string error = error_of("SELECT id FROM points WHERE " + condition);
      EXPECT_NE(error.find(problem), std::string::npos) << condition << ": " << error;
      // Met by no row, and so no error, as without limits.
      EXPECT_EQ(error_of("SELECT id FROM points WHERE id < 0 AND " + condition), "none");
    }
  }
}

TEST_F(PrepareTest, null_and_limits_that_no_distance_meets_give_no_rows) {
  const std::string ray = "dist_ray(690050,5325050,410, 0,0,1, x,y,z)";
  for (const std::string& condition :
       {ray + " <= NULL", ray + " <= -1", ray + " BETWEEN 2 AND 1", ray + " <= (1e999 - 1e999)",
        "NOT " + ray + " <= NULL", std::string("dist_ray(NULL,5325050,410, 0,0,1, x,y,z) <= 1"),
        std::string("dist_plane(690050,5325050,410, 0,NULL,1, x,y,z) >= 0"),
        std::string("dist_ray(690050,5325050,410, 0,0,(1e999 - 1e999), x,y,z) <= 1")})
    EXPECT_TRUE(first_column("SELECT id FROM points WHERE " + condition).empty()) << condition;
}

TEST_F(PrepareTest, a_limit_that_is_null_hides_no_error) {
  const std::string wrong = "dist_ray(0,0,0, 0,0,0, x,y,z)", nothing = "dist_ray(0,0,0, NULL,0,1, x,y,z) < 2";
  for (const std::string& condition :
       {wrong + " <= NULL", wrong + " BETWEEN NULL AND 1", wrong + " BETWEEN 0 AND NULL",
        wrong + " <= 1 AND " + nothing, wrong + " <= NULL AND " + nothing})
    EXPECT_NE(error_of("SELECT id FROM points WHERE " + condition).find("the ray direction is zero"),
              std::string::npos)
        << condition;
  EXPECT_NE(error_of("SELECT id FROM points WHERE dist_plane('a',0,0, 1,0,0, x,y,z) >= 4 AND " + nothing)
                .find("invalid argument 1; expected a number"),
            std::string::npos);
}

TEST_F(PrepareTest, what_may_answer_differently_each_time_gets_no_limit) {
  run(Connection(file_, Connection::Mode::write).get(),
      "CREATE VIEW coin AS SELECT abs(random()) % 2 * 5 AS r");
  const std::string near = "dist_ray(690050,5325050,410, 0,0,1, x,y,z) <= ";
  for (const std::string& sql : {"SELECT id, abs(random()) % 2 AS r FROM points WHERE " + near + "r",
                                 "SELECT id, length(randomblob(id % 3)) AS r FROM points WHERE " + near + "r",
                                 "SELECT id FROM points, coin WHERE " + near + "r"}) {
    const Prepared prepared = prepare(database_->get(), sql);
    EXPECT_EQ(prepared.pruned, "") << sql;
    EXPECT_EQ(prepared.reason, "it calls random or randomblob, which are volatile");
  }
}

TEST_F(PrepareTest, operators_that_call_functions_give_errors_only_where_rows_meet_them) {
  EXPECT_TRUE(
      first_column(
          "SELECT id FROM points WHERE id < 0 AND dist_ray(690050,5325050,410, 0,0,1, x,y,z) <= ('{' -> 'a')",
          false)
          .empty());
  EXPECT_TRUE(
      first_column("SELECT id FROM points WHERE id < 0 AND dist_ray(0,0,('{' ->> 'a'), 0,0,1, x,y,z) <= 1",
                   false)
          .empty());
}

TEST_F(PrepareTest, a_byte_order_mark_between_tokens_is_blank) {
  const std::string distance = "dist_ray(690050,5325050,9999, 1,0,0, x,y,z)";
  EXPECT_EQ(first_column("SELECT id FROM points WHERE z \ufeffBETWEEN 0 AND " + distance + " = 1", false),
            first_column("SELECT id FROM points WHERE (z BETWEEN 0 AND " + distance + ") = 1", false));
  EXPECT_EQ(first_column("\ufeffSELECT id AS a\ufeff FROM points WHERE \ufeff" + distance +
                         " <= 1 ORDER BY a\ufeff"),
            std::vector<double>());
}

TEST_F(PrepareTest, a_limit_that_is_text_is_above_every_distance) {
  EXPECT_EQ(first_column("SELECT id FROM points WHERE dist_ray(1,2,3, 0,0,1, x,y,z) <= '1'").size(), 5000u);
}

TEST_F(PrepareTest, errors_name_line_and_column_of_the_statement) {
  EXPECT_EQ(error_of("SELECT id,\n  \u00e4, idd FROM points"),
            "statement:2:3: no such column: \u00e4; expected one of id, x, y, z, red, green, blue, "
            "classification, return_number, number_of_returns, gps_time, Height (points)");
  EXPECT_EQ(error_of("SELECT id FROM nowhere"), "statement: no such table: nowhere");
}

TEST_F(PrepareTest, a_text_is_taken_statement_by_statement) {
  const std::string text = "SELECT 1; -- one\n SELECT id FROM points; \n -- end";
  const Prepared first = prepare(database_->get(), text);
  EXPECT_EQ(first.size, 9u);
  const Prepared second = prepare(database_->get(), text, first.size);
  EXPECT_EQ(first.size + second.size, text.find("\n -- end") - 1);
  EXPECT_EQ(prepare(database_->get(), text, first.size + second.size).statement, nullptr);
}

}  // namespace
}  // namespace alidade::test
