// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "base/error.h"
#include "cloud/las/write_las.h"
#include "database/sqlite/store_cloud.h"
#include "jobs/field_table.h"
#include "jobs/load_cloud.h"
#include "jobs/sql/load.h"
#include "jobs/sql/rewrite.h"
#include "jobs/sql/row_text.h"
#include "jobs/sql/statement.h"
#include "tests/jobs/heard.h"
#include "tests/support/sql_site.h"

namespace alidade::test {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

/// Statements on a square of 400 points in a database and in a file.
class SqlJobTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = fs::temp_directory_path() / ("alidade_sql_" + std::to_string(::getpid()));
    fs::create_directories(folder);
    database::store_cloud(folder / "site.db", sql_site(), {.chunk_points = 50});
  }
  void TearDown() override { fs::remove_all(folder); }

  /// The request of a statement with texts for --param.
  jobs::SqlRequest request(const std::string& statement, const Words& parameters = {}) const {
    jobs::SqlRequest request;
    const auto table = std::make_shared<jobs::FieldTable>("sql");
    jobs::add_sql_fields(jobs::Fields(table), request);
    table->give("cloud", {(folder / "site.db").string()});
    table->give("statement", {statement});
    for (const std::string& parameter : parameters) table->give("param", {parameter});
    table->read();
    return request;
  }
  std::string text(const jobs::SqlRequest& request, jobs::SqlForm form = jobs::SqlForm::csv) {
    std::string all;
    run(plan(request), jobs::row_text(form, [&](std::string_view more) { all += more; }), heard);
    return all;
  }
  std::string csv(const std::string& statement, const Words& parameters = {}) {
    return text(request(statement, parameters));
  }
  std::string json(const std::string& statement, const Words& parameters = {}) {
    return text(request(statement, parameters), jobs::SqlForm::json);
  }
  /// The message of the error of work(); empty: none.
  template <class Work>
  static std::string error_of(const Work& work) {
    try {
      (void)work();
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }
  CloudInputs clouds(const std::string& name) const {
    const fs::path file = folder / name;
    return resolve_clouds({&file, 1}, jobs::cloud_formats());
  }

  fs::path folder;
  Heard heard;
};

TEST_F(SqlJobTest, rows_have_types_and_statements_reports) {
  const jobs::SqlResult results = run(
      plan(request("SELECT 5 AS a, 0.5 AS b, 'x' AS c, x'00ff' AS d, NULL AS e; SELECT id FROM points WHERE "
                   "dist_ray(100,200,5, 0,0,1, x,y,z) <= 0.1 ORDER BY id")),
      heard);
  ASSERT_EQ(results.size(), 2u);
  using jobs::SqlValue;
  const std::vector<std::pair<std::string, SqlValue>> expected = {
      {"a", std::int64_t{5}},
      {"b", 0.5},
      {"c", std::string("x")},
      {"d", std::vector<std::byte>{std::byte{0}, std::byte{255}}},
      {"e", {}}};
  ASSERT_EQ(results[0].columns.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(results[0].columns[i], expected[i].first);
    EXPECT_TRUE(results[0].values[i] == std::vector{expected[i].second}) << expected[i].first;
  }
  EXPECT_TRUE(results[1].values.at(0) ==
              (std::vector<SqlValue>{std::int64_t{0}, std::int64_t{1}, std::int64_t{20}}));
  EXPECT_EQ(results[0].report.rows, 1u);
  EXPECT_EQ(results[0].report.reads.scans, 0u);
  EXPECT_EQ(results[0].report.rewritten, "");
  EXPECT_EQ(results[1].report.rows, 3u);
  EXPECT_EQ(results[1].report.reads.chunks, 8u);
  EXPECT_EQ(results[1].report.reads.chunks_read, 1u);
  EXPECT_EQ(results[1].report.reads.points_read, 50u);
  EXPECT_TRUE(results[1].report.rewritten.starts_with("SELECT id FROM points WHERE (dist_ray("));
  EXPECT_EQ(heard.text(), "");
  jobs::SqlRequest typed = request("-");
  EXPECT_TRUE(error_of([&] { return run(plan(typed), heard); }).starts_with("missing statement"));
}

TEST_F(SqlJobTest, tables_are_aligned_by_their_first_rows) {
  EXPECT_EQ(text(request("SELECT 5 AS five, 'a\nb' AS text, NULL AS none, x'00ff' AS bytes, 0.1 + 0.2 AS sum;"
                         "\n-- nothing\n;SELECT id, x, 'ä' || id AS \"ä\" FROM points WHERE id IN (0, 399)"),
                 jobs::SqlForm::table),
            "five  text  none  bytes    sum\n"
            "----  ----  ----  -------  ---\n"
            "   5  a\\nb  NULL  x'00ff'  0.3\n"
            " id      x  ä\n"
            "---  -----  ----\n"
            "  0  100.0  ä0\n"
            "399  101.9  ä399\n");
  const std::string many =
      text(request("WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE "
                   "i < 1001) SELECT iif(i = 1001, 'longer', i) AS i FROM n"),
           jobs::SqlForm::table);
  EXPECT_TRUE(many.starts_with("   i\n----\n   1\n")) << many.substr(0, 20);
  EXPECT_TRUE(many.ends_with("1000\nlonger\n")) << "the 1001st row is not measured";
}

TEST_F(SqlJobTest, csv_quotes_what_needs_it) {
  EXPECT_EQ(
      csv("SELECT 'a,b' AS \"x,\"\"y\", '' AS empty, NULL AS none, 'q\"' AS quote, -1e999 AS low, x'0a' "
          "AS bytes"),
      "\"x,\"\"y\",empty,none,quote,low,bytes\n\"a,b\",\"\",,\"q\"\"\",-inf,0a\n");
}

TEST_F(SqlJobTest, parameters_are_values_and_no_sql) {
  std::ofstream(folder / "query.sql") << "SELECT ? AS a, ? AS b, ? AS c;\nSELECT ?2 AS d, typeof(?3) AS g, "
                                         ":text AS e, ?1 AS f";
  const std::string evil = "'); DROP TABLE points; --";
  jobs::SqlRequest from_file = request("", {"1.5", evil, "NULL", "text='12', \"x\""});
  from_file.source = {.file = folder / "query.sql"};
  EXPECT_EQ(text(from_file, jobs::SqlForm::json),
            "[{\"a\":1.5,\"b\":\"" + evil + "\",\"c\":null}]\n[{\"d\":\"" + evil +
                "\",\"g\":\"null\",\"e\":\"'12', \\\"x\\\"\",\"f\":1.5}]\n");
}

TEST_F(SqlJobTest, parameters_that_read_as_numbers_are_numbers) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"0.5", "0.5"},
      {"+0.5", "0.5"},
      {" 0.5 ", "0.5"},
      {"-.5", "-0.5"},
      {"7.", "7.0"},
      {"1e-400", "0.0"},
      {"-1e999", "-inf"},
      {"+12", "12"},
      {"9223372036854775807", "9223372036854775807"},
      {"1e2", "100.0"},
      {"'12'", "12 text"},
      {"9223372036854775808", "9.223372036854776e+18"},
      {"inf", "inf text"},
      {"nan", "nan text"},
      {"infinity", "infinity text"},
      {"nan(1)", "nan(1) text"},
      {"'it''s'", "it's text"},
      {"it's", "it's text"},
      {"", " text"}};
  for (const auto& [value, expected] : cases) {
    if (expected.ends_with(" text")) {
      EXPECT_EQ(json("SELECT a || iif(typeof(a) = 'text', ' text', '') AS a FROM (SELECT ? AS a)", {value}),
                "[{\"a\":\"" + expected + "\"}]\n")
          << value;
    } else {
      EXPECT_EQ(csv("SELECT ? AS a", {value}), "a\n" + expected + "\n") << value;
    }
  }
  for (const std::string value : {"0x1", "0,5", "1 2", "2026-11-23", "1e", "-", ".", "- 1", "+'1'"}) {
    EXPECT_EQ(error_of([&] { return csv("SELECT 1 WHERE 2 <= ?", {value}); }),
              "--param: invalid number; expected a number, or quoted text: \"'TEXT'\", found " + value);
  }
}

TEST_F(SqlJobTest, parameters_without_and_with_names_may_be_in_one_statement) {
  EXPECT_EQ(json("SELECT :a AS a, ? AS b, @c AS c, ? AS d", {"a=1", "2", "c=3", "4"}),
            "[{\"a\":1,\"b\":2,\"c\":3,\"d\":4}]\n");
  EXPECT_EQ(json("SELECT ?2 AS a, :b AS b, ?1 AS c", {"1", "2", "b=3"}), "[{\"a\":2,\"b\":3,\"c\":1}]\n");
}

TEST_F(SqlJobTest, no_bytes_are_not_null) {
  jobs::SqlRequest bytes = request("SELECT hex(?), typeof(?), typeof(?)");
  using Bytes = std::vector<std::byte>;
  for (const Bytes& value : {Bytes{std::byte{0}, std::byte{255}}, Bytes(), Bytes()})
    bytes.parameters.values.push_back({"", value});
  bytes.parameters.values.back().value = {};
  EXPECT_EQ(text(bytes), "hex(?),typeof(?),typeof(?)\n00FF,blob,null\n");
}

TEST_F(SqlJobTest, what_cannot_be_run_is_an_error_before_a_row) {
  const std::vector<std::tuple<std::string, Words, std::string>> cases = {
      {"SELECT 1; SELEC 2", {}, "statement:1:11: the statement is not read-only; expected SELECT"},
      {"SELECT 1;\nSELECT idd FROM points", {}, "statement:2:8: no such column: idd"},
      {"SELECT 1; SELECT 1 FROM nowhere", {}, "statement: no such table: nowhere"},
      {"WITH a AS (SELECT 1) DELETE FROM notes", {}, "a statement that writes"},
      {"VACUUM INTO 'copy.db'", {}, "found VACUUM"},
      {"SELECT ?, ?", {"1"}, "missing value of parameter 2"},
      {"SELECT @a", {"1"}, "missing value of parameter @a; expected --param a=VALUE"},
      {"SELECT 1", {"a=1"}, "--param: unknown parameter :a"},
      {"SELECT 1", {"1"}, "--param: no parameter for value 1"}};
  database::run(database::Connection(folder / "site.db", database::Connection::Mode::write).get(),
                "CREATE TABLE notes(text)");
  for (const auto& [statement, parameters, message] : cases) {
    bool has_begun = false;
    const jobs::RowSink sink{.begin = [&](const Words&) { has_begun = true; }, .row = {}, .end = {}};
    const std::string found = error_of([&] { run(plan(request(statement, parameters)), sink, heard); });
    EXPECT_NE(found.find(message), std::string::npos) << found;
    EXPECT_FALSE(has_begun) << statement;
  }
}

TEST_F(SqlJobTest, plans_reject_what_needs_no_point) {
  const auto planned = [&](const fs::path& cloud, const fs::path& file, bool partial) {
    jobs::SqlRequest made = request("SELECT 1");
    made.cloud = cloud;
    if (!file.empty()) made.source = {.file = file};
    made.partial = partial;
    return error_of([&] { return jobs::plan(made); });
  };
  EXPECT_TRUE(planned("", {}, false).starts_with("missing cloud or database"));
  EXPECT_NE(planned("none.db", {}, true).find("--partial does not apply to databases"), std::string::npos);
  EXPECT_EQ(planned(folder / "site.db", folder / "none.sql", false),
            (folder / "none.sql").string() + ": cannot read the file");
  EXPECT_EQ(planned(folder / "site.db", folder, false),
            folder.string() + ": cannot read the file; found a folder");
}

TEST_F(SqlJobTest, a_statement_stops_with_the_listener) {
  struct Stopped : Heard {
    bool stops() const override { return true; }
  } stopped;
  EXPECT_THROW(run(plan(request("WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT "
                                "count(*) FROM n")),
                   stopped),
               Cancelled);
}

TEST_F(SqlJobTest, cloud_files_are_the_table_points) {
  write_las(folder / "site.las", sql_site());
  jobs::SqlRequest on_file = request(
      "SELECT id, x, z FROM points WHERE dist_ray(100,200,5, 0,0,1, x,y,z) <= ? ORDER BY id", {"0.1"});
  const std::string expected = text(on_file);
  EXPECT_TRUE(heard.stages.empty()) << "a database is read where it is";
  on_file.cloud = folder / "site.las";
  EXPECT_EQ(text(on_file), expected);
  EXPECT_EQ(heard.stages, Words{"reading"});
}

TEST_F(SqlJobTest, a_cloud_becomes_a_table_that_is_replaced_only_with_overwrite) {
  jobs::LoadRequest load;
  load.files = clouds("site.db");
  load.output = folder / "copy.db";
  load.chunk_points = 7;
  EXPECT_EQ(run(plan(load), heard).point_count, 400u);
  EXPECT_EQ(heard.notes, Words{"stored 400 points as table points of " + (folder / "copy.db").string()});
  EXPECT_EQ(heard.stages, (Words{"reading", "storing"}));
  jobs::SqlRequest counted =
      request("SELECT count(*) AS n FROM points; SELECT max(points) AS m FROM points_chunk");
  counted.cloud = load.output;
  EXPECT_EQ(text(counted), "n\n400\nm\n7\n");
  const auto planned = [&] { return plan(load).request().files.size(); };
  EXPECT_NE(error_of(planned).find("the table points exists"), std::string::npos);
  load.output += "?table=copy";
  EXPECT_NE(error_of(planned).find("the database name has a table; expected --table NAME"),
            std::string::npos);
  load.output = folder / "copy.db";
  counted.cloud += "?table=points";
  EXPECT_NE(
      error_of([&] { return text(counted); }).find("the name of a cloud in a database; expected the name"),
      std::string::npos);
  load.overwrite = true;
  EXPECT_EQ(error_of([&] { return run(plan(load), heard).point_count; }), "");
}

TEST_F(SqlJobTest, databases_with_names_of_clouds_are_rejected) {
  jobs::LoadRequest load;
  load.files = clouds("site.db");
  const auto message = [&](const std::string& database) {
    load.output = database;
    return error_of([&] { return plan(load); });
  };
  for (const char* const name : {"square.las", "a.catalog.json", "x.parquet"})
    EXPECT_EQ(message(name), std::string(name) +
                                 ": the database name is that of a cloud file; expected the "
                                 "database as the last name, such as site.db");
  EXPECT_NE(message((folder / "site.db").string()).find("the output is also an input"), std::string::npos);
}

TEST_F(SqlJobTest, statements_are_rewritten_within_bounds_of_numbers_or_a_cloud) {
  const auto rewritten = [&](const std::string& bounds) {
    jobs::RewriteRequest request;
    const auto table = std::make_shared<jobs::FieldTable>("sql rewrite");
    jobs::add_rewrite_fields(jobs::Fields(table), request);
    table->give("dialect", {"datafusion"});
    table->give("statement", {"SELECT * FROM p WHERE dist_ray(100,200,5, 1,0,0, x,y,z) <= 0.1; SELECT 1"});
    if (!bounds.empty()) table->give("bounds", {bounds});
    table->read();
    return run(plan(request), heard);
  };
  const auto plain = rewritten("");
  ASSERT_EQ(plain.size(), 2u);
  EXPECT_EQ(plain[0].box_count, 0u);
  EXPECT_EQ(plain[0].text.find("dist_ray"), std::string::npos);
  EXPECT_EQ(plain[1].text, "SELECT 1");
  ASSERT_EQ(heard.notes.size(), 2u) << heard.text();
  EXPECT_TRUE(heard.notes[0].starts_with("no conditions on boxes: ")) << heard.notes[0];
  write_las(folder / "site.las", sql_site());
  const auto of_cloud = rewritten((folder / "site.las").string()),
             of_numbers = rewritten("100,200,5,101.9,201.9,5");
  EXPECT_GT(of_cloud[0].box_count, 0u);
  EXPECT_GT(of_numbers[0].box_count, 0u);
  EXPECT_LE(of_numbers[0].share, 1.0);
  const auto message = [&](const std::string& bounds) { return error_of([&] { return rewritten(bounds); }); };
  EXPECT_EQ(message("0,0,0,1,1,x"), "bounds: invalid value; expected a number, found 'x'");
  EXPECT_TRUE(
      message("0,0,0,1,1").starts_with("--bounds: invalid bounds; expected x0,y0,z0,x1,y1,z1 or a cloud"));
  EXPECT_TRUE(message("0,0,1,1,1,0").starts_with("--bounds: limits out of order"));
  EXPECT_TRUE(message((folder / "none").string()).find("none") != std::string::npos);
}

}  // namespace
}  // namespace alidade::test
