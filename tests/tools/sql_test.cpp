// SPDX-License-Identifier: MIT
// alidade sql: what it prints, what it rejects, and that only the statement becomes SQL. For rows, parameters
// and errors of statements see tests/jobs/sql_test.cpp.
#include <signal.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "cloud/las/write_las.h"
#include "database/sqlite/connection.h"
#include "database/sqlite/store_cloud.h"
#include "tests/support/sql_site.h"
#include "tests/tools/run_program.h"

namespace alidade::test {

using namespace database;

namespace {

class SqlTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    store_cloud(folder / "site.db", sql_site(), {.chunk_points = 50});
  }

  ProgramResult sql(std::vector<std::string> words) {
    words.insert(words.begin(), {"sql", "site.db"});
    return run(words);
  }
};

TEST_F(SqlTest, the_papers_statement_is_rewritten_and_explained) {
  const ProgramResult result =
      sql({"SELECT id FROM points WHERE dist_ray(100,200,5, 0,0,1, x,y,z) <= 0.1 ORDER BY id", "--csv",
           "--explain"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.out, "id\n0\n1\n20\n");
  EXPECT_TRUE(contains(result.err, "read 1 of 8 chunks (12.5 %), 50 points tested, 3 rows, ")) << result.err;
  EXPECT_TRUE(contains(result.err, "rewritten as: SELECT id FROM points WHERE (dist_ray(")) << result.err;
}

TEST_F(SqlTest, why_a_statement_is_not_rewritten_is_explained) {
  const ProgramResult result =
      sql({"SELECT count(*) FROM points WHERE dist_ray(100,200,5, 0,0,1, x,y,z) <= abs(-1)", "--explain"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(contains(result.err, "read 8 of 8 chunks (100.0 %), 400 points tested, 1 row,")) << result.err;
  EXPECT_TRUE(contains(result.err, "not rewritten: a distance is not compared")) << result.err;
}

TEST_F(SqlTest, parameters_are_options_and_statements_may_come_from_standard_input) {
  const ProgramResult result =
      run_with_input({"sql", "site.db", "-", "--json", "--param", "1.5", "--param", "text='12', \"x\""},
                     "SELECT ? AS a, :text AS b");
  EXPECT_EQ(result.err, "");
  EXPECT_EQ(result.out, "[{\"a\":1.5,\"b\":\"'12', \\\"x\\\"\"}]\n");
  EXPECT_EQ(run_with_input({"sql", "site.db", "--csv"}, "SELECT 7 AS seven").out, "seven\n7\n");
}

TEST_F(SqlTest, an_empty_statement_is_one) {
  const ProgramResult result = run_with_input({"sql", "site.db", "", "--csv"}, "SELECT 7");
  EXPECT_EQ(result.err, "");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.out, "");
}

TEST_F(SqlTest, what_is_stored_cannot_move_the_cursor) {
  const ProgramResult result =
      sql({"SELECT char(0x9b) || '31m' AS a, cast(x'9b' AS text) AS b, char(0x202e, 0x2066) AS c, "
           "cast(x'41e282' AS text) AS "
           "d, 'é€𝄞' AS e"});
  EXPECT_EQ(result.err, "");
  EXPECT_EQ(result.out,
            "a          b     c             d          e\n"
            "---------  ----  ------------  ---------  ---\n"
            "\\u009b31m  \\x9b  \\u202e\\u2066  A\\xe2\\x82  é€𝄞\n");
}

TEST_F(SqlTest, ctrl_c_ends_waiting_for_who_writes) {
  const Connection writer(folder / "site.db", Connection::Mode::write);
  alidade::database::run(writer.get(), "BEGIN EXCLUSIVE");
  Program program({"sql", "site.db", "SELECT 1"}, folder);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  program.send(SIGINT);
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, 130);
  EXPECT_FALSE(contains(result.err, "locked")) << result.err;
}

TEST_F(SqlTest, files_may_begin_with_a_byte_order_mark) {
  write("query.sql", "\ufeffSELECT 7 AS seven;\n\ufeffSELECT 8 AS eight");
  const ProgramResult result = sql({"--file", "query.sql", "--csv"});
  EXPECT_EQ(result.err, "");
  EXPECT_EQ(result.out, "seven\n7\neight\n8\n");
}

TEST_F(SqlTest, names_of_tables_and_files_are_no_sql) {
  const std::string evil = "'; DROP TABLE points; --\"x", file = "a'b\"; --?mode=rwc.db";
  store_cloud(folder / file, sql_site(), {.table = evil});
  store_cloud(folder / file, sql_site());
  const ProgramResult result =
      run({"sql", file,
           "SELECT count(*) AS n FROM \"'; DROP TABLE points; --\"\"x\"; SELECT count(*) AS m FROM points",
           "--csv"});
  EXPECT_EQ(result.err, "");
  EXPECT_EQ(result.out, "n\n400\nm\n400\n");
}

TEST_F(SqlTest, cloud_files_are_the_table_points) {
  const std::string evil = "a'b\"; DROP TABLE points; --.las";
  write_las(folder / evil, sql_site());
  std::filesystem::create_directory(folder / "tiles");
  write_las(folder / "tiles" / "a.laz", sql_site());
  ASSERT_EQ(run({"index", evil, "-o", "site.alidade", "-q"}).exit_code, 0);
  const std::string statement =
      "SELECT id, x, z FROM points WHERE dist_ray(100,200,5, 0,0,1, x,y,z) <= ? ORDER BY id";
  const std::string expected = sql({statement, "--csv", "--param", "0.1"}).out;
  EXPECT_TRUE(contains(expected, "20,100.0,5.0\n")) << expected;
  for (const std::string& cloud :
       {evil, std::string("tiles"), std::string("tiles/*.laz"), std::string("site.alidade")}) {
    const ProgramResult result = run({"sql", cloud, statement, "--csv", "--param", "0.1", "--explain", "-q"});
    EXPECT_EQ(result.exit_code, 0) << cloud << result.err;
    EXPECT_EQ(result.out, expected) << cloud;
    EXPECT_TRUE(contains(result.err, "chunks (")) << result.err;
    EXPECT_TRUE(contains(result.err, "rewritten as: SELECT id, x, z FROM points WHERE (dist_ray("))
        << result.err;
    EXPECT_EQ(run({"sql", cloud, statement, "--csv", "--param", "0.1", "-q"}).err, "");
  }
  const ProgramResult writing = run({"sql", evil, "CREATE VIRTUAL TABLE p USING alidade('site.db')"});
  EXPECT_TRUE(contains(writing.err, "the statement is not read-only")) << writing.err;
  write("garbage.laz", std::string("\x7f\0\x01 garbage", 11));
  EXPECT_TRUE(contains(run({"sql", "garbage.laz", "SELECT 1"}).err, "alidade: error: garbage.laz: "));
  EXPECT_TRUE(contains(run({"sql", "none.laz", "SELECT 1"}).err, "none.laz: cannot open the file: "));
}

TEST_F(SqlTest, what_cannot_be_run_is_an_error_before_anything_is_printed) {
  write("broken.db", "not a database, but long enough that SQLite reads it when it opens such a file......");
  alidade::database::run(Connection(folder / "site.db", Connection::Mode::write).get(),
                         "CREATE TABLE notes(text)");
  const std::string whole = read("site.db");
  write("nul.sql", std::string("SELECT 1 AS a;\0SELECT 2", 23));
  write("short.db", whole.substr(0, whole.size() / 2));
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"site.db", "SELECT count(*) FROM points WHERE \"intensitty\" > 5"},
       "statement:1:35: no such column: intensitty"},
      {{"site.db", "ATTACH 'new.db' AS n"}, "found ATTACH"},
      {{"site.db", "PRAGMA journal_mode = WAL"}, "found PRAGMA"},
      {{"site.db", "SELECT dist_ray(1,2,3, 0,0,0, x,y,z) FROM points"},
       "site.db: dist_ray: the ray direction is zero"},
      {{"site.db", "SELECT 1", "--file", "x.sql"}, "--file"},
      {{"site.db", "--file", "x.sql"}, "x.sql: cannot read the file"},
      {{"site.db", "--file", "nul.sql"}, "nul.sql:1:15: the file contains a NUL byte"},
      {{"none.db", "SELECT 1"}, "none.db: unable to open database file"},
      {{"broken.db", "SELECT 1"}, "broken.db: file is not a database"},
      {{"short.db", "SELECT count(*) FROM points"}, "short.db: "},
      {{"site.db", "SELECT 1", "--partial"}, "site.db: --partial does not apply to databases"}};
  for (const auto& [words, message] : cases) {
    std::vector<std::string> all = {"sql"};
    all.insert(all.end(), words.begin(), words.end());
    const ProgramResult result = run(all);
    EXPECT_EQ(result.exit_code, 2) << message;
    EXPECT_EQ(result.out, "") << message;
    EXPECT_TRUE(contains(result.err, "alidade: error: ")) << result.err;
    EXPECT_TRUE(contains(result.err, message)) << message << "\n" << result.err;
  }
  EXPECT_EQ(names(), (std::vector<std::string>{"broken.db", "nul.sql", "short.db", "site.db"}));
  EXPECT_EQ(read("site.db"), whole);
}

TEST_F(SqlTest, ctrl_c_ends_a_statement) {
  Program program(
      {"sql", "site.db",
       "SELECT 1; WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT count(*) FROM n",
       "--csv"},
      folder);
  const std::filesystem::path out = folder.string() + ".out";
  const auto has_begun = [&] {
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(out, error);
    return !error && size > 0;
  };
  const auto limit = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  // What the first statement gives is there once the second one runs.
  while (program.running() && !has_begun() && std::chrono::steady_clock::now() < limit)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  program.send(SIGINT);
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, 130);
  EXPECT_EQ(result.out, "1\n1\n");
}

}  // namespace
}  // namespace alidade::test
