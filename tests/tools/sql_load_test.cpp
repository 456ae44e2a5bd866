// SPDX-License-Identifier: MIT
// Clouds of any format go into a database, whatever the names of cloud, database and table are, completely or
// not at all.
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "cloud/read_cloud.h"
#include "database/sql/sql_tokens.h"
#include "database/sqlite/connection.h"
#include "tests/support/absent_data.h"
#include "tests/tools/run_program.h"

namespace alidade::test {

using namespace database;

namespace {

class SqlLoadTest : public ProgramTest {
 protected:
  ProgramResult load(Words files, const Words& options = {}) {
    Words words = {"sql", "load"};
    words.insert(words.end(), files.begin(), files.end());
    words.insert(words.end(), options.begin(), options.end());
    return run(words);
  }

  double number(const std::string& database, const std::string& sql) const {
    const Connection connection(folder / database, Connection::Mode::read);
    Statement statement(connection.get(), sql);
    EXPECT_TRUE(statement.step()) << sql;
    return statement.number(0);
  }

  /// Points of the square with corner (100, 200, 5).
  double points(const std::string& database, const std::string& table = "points") const {
    return number(database, "SELECT count(*) FROM " + sql_name(table) +
                                " WHERE x BETWEEN 99.9 AND 102 AND y BETWEEN 199.9 AND 202 AND z = 5");
  }

  /// Waits until the running program has made a file whose name begins so.
  void wait_for(const Program& program, const std::string& begin) const {
    const auto is_there = [&] {
      return std::ranges::any_of(names(), [&](const std::string& name) { return name.starts_with(begin); });
    };
    const auto limit = std::chrono::steady_clock::now() + std::chrono::minutes(5);
    while (program.running() && !is_there() && std::chrono::steady_clock::now() < limit)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ASSERT_TRUE(program.running()) << "ended before it could be interrupted";
  }
};

TEST_F(SqlLoadTest, a_file_becomes_a_table) {
  write_square("square.xyz");
  const ProgramResult result = load({"square.xyz", "square.db"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_TRUE(contains(result.err, "storing: 400 points")) << result.err;
  EXPECT_TRUE(contains(result.err, "stored 400 points as table points of square.db")) << result.err;
  EXPECT_EQ(points("square.db"), 400);
  EXPECT_EQ(names(), (Words{"square.db", "square.xyz"}));
  EXPECT_EQ(load({"square.xyz", "quiet.db"}, {"-q"}).err, "");
}

TEST_F(SqlLoadTest, files_of_every_format_become_tables) {
  constexpr const char* k_names[] = {"lidar/extrabytes.las",
                                     "laz_vectors/micro1.laz",
                                     "lidar_rgb/lion_takanawa.copc.laz",
                                     "ply/platonic_shelf_big_endian.ply",
                                     "pcd/lamppost.pcd",
                                     "e57/ColouredCubeFloat.e57",
                                     "text/1.2-with-color.ptx",
                                     "text/ripple.pts"};
  for (const char* const name : k_names) {
    SCOPED_TRACE(name);
    const std::optional<std::filesystem::path> file = shared_data(name);
    if (!file) GTEST_SKIP() << absent(std::string("../shared/data/") + name, std::size(k_names));
    ASSERT_EQ(load({file->string(), "site.db"}, {"-q", "--overwrite", "--memory=1M"}).exit_code, 0);
    const PointCloud cloud = read_cloud(*file);
    double sum = 0;
    for (std::size_t row = 0; row < cloud.size(); ++row) sum += std::abs(cloud.world(row).x);
    EXPECT_EQ(number("site.db", "SELECT count(*) FROM points"), static_cast<double>(cloud.size()));
    EXPECT_NEAR(number("site.db", "SELECT sum(abs(x)) FROM points"), sum, 1e-9 * sum);
  }
}

TEST_F(SqlLoadTest, tiles_with_an_index_among_them_are_one_table) {
  write_square("1.xyz");
  write_square("2.xyz");
  ASSERT_EQ(run({"index", "1.xyz", "-o", "1.alidade", "-q"}).exit_code, 0);
  EXPECT_EQ(load({".", "1.alidade", "all.db"}, {"--threads=1", "--chunk-points=7"}).exit_code, 0);
  EXPECT_EQ(points("all.db"), 1200);
  EXPECT_EQ(number("all.db", "SELECT max(points) FROM points_chunk"), 7);
  EXPECT_EQ(number("all.db", "SELECT max(id) FROM points"), 1199);
}

TEST_F(SqlLoadTest, names_are_names_whatever_is_in_them) {
  const std::string table = "we\"ird'; DROP TABLE points; --", database = "a'; DROP TABLE.db";
  write_square("'; ATTACH.xyz");
  EXPECT_EQ(load({"'; ATTACH.xyz", database}).exit_code, 0);
  const ProgramResult result = load({"'; ATTACH.xyz", database}, {"--table", table});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(points(database), 400);
  EXPECT_EQ(points(database, table), 400);
  EXPECT_EQ(load({"'; ATTACH.xyz", ":memory:"}).exit_code, 0);
  EXPECT_EQ(load({"'; ATTACH.xyz", "file:x.db?mode=memory"}).exit_code, 0);
  EXPECT_EQ(names(), (Words{"'; ATTACH.xyz", ":memory:", database, "file:x.db?mode=memory"}));
  EXPECT_EQ(points("file:x.db?mode=memory"), 400);
}

TEST_F(SqlLoadTest, a_table_is_replaced_only_with_overwrite_and_only_if_it_is_a_cloud) {
  write_square("square.xyz");
  write("one.xyz", "100 200 5\n");
  ASSERT_EQ(load({"square.xyz", "site.db"}).exit_code, 0);
  const ProgramResult rejected = load({"one.xyz", "site.db"});
  EXPECT_EQ(rejected.exit_code, 2);
  EXPECT_TRUE(contains(rejected.err,
                       "site.db: the table points exists; expected another name, or "
                       "--overwrite"))
      << rejected.err;
  EXPECT_EQ(points("site.db"), 400);
  EXPECT_EQ(load({"one.xyz", "site.db"}, {"--overwrite"}).exit_code, 0);
  EXPECT_EQ(points("site.db"), 1);
  {
    const Connection connection(folder / "site.db", Connection::Mode::write);
    alidade::database::run(connection.get(), "CREATE TABLE mine(x)");
  }
  const ProgramResult mine = load({"one.xyz", "site.db"}, {"--table=mine", "--overwrite"});
  EXPECT_EQ(mine.exit_code, 2);
  EXPECT_TRUE(contains(mine.err, "expected a cloud")) << mine.err;
}

TEST_F(SqlLoadTest, other_and_damaged_files_are_no_databases_and_stay_as_they_are) {
  write_square("square.xyz");
  ASSERT_EQ(load({"square.xyz", "whole.db"}).exit_code, 0);
  const std::string whole = read("whole.db");
  for (const auto& [content, problem] :
       {std::pair<std::string, std::string>("text that is too long to be taken for an empty file, and is not "
                                            "a database, whatever the name of the file is......",
                                            "file is not a database"),
        {whole.substr(0, whole.size() / 2), "malformed"},
        {whole.substr(0, 100), "malformed"}}) {
    write("site.db", content);
    const ProgramResult result = load({"square.xyz", "site.db"});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(contains(result.err, "alidade: error: ")) << result.err;
    EXPECT_TRUE(contains(result.err, "site.db: ") && contains(result.err, problem)) << result.err;
    EXPECT_TRUE(read("site.db") == content);
  }
}

TEST_F(SqlLoadTest, usage_is_explained) {
  write_square("square.xyz");
  EXPECT_TRUE(contains(load({"square.xyz"}).err, "see 'alidade sql load --help'"));
  const auto says = [&](const Words& files, const Words& options, const std::string& text) {
    const ProgramResult result = load(files, options);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(contains(result.err, text)) << result.err;
  };
  says({"square.xyz", "square.las"}, {}, "square.las: the database name is that of a cloud file");
  says({"square.xyz", "a.catalog.json"}, {}, "a.catalog.json: the database name is that of a cloud file");
  says({"square.xyz", "absent/site.db"}, {}, "absent/site.db: cannot write the file");
  says({"absent.las", "site.db"}, {}, "absent.las");
  says({"square.xyz", "square.db"}, {"--chunk-points=0"}, "--chunk-points");
  says({"square.xyz", "square.db"}, {"--memory=1k"}, "expected at least 1M");
  says({"square.xyz", "square.db"}, {"--table="}, "--table");
  says({"square.xyz", "."}, {}, "cannot replace the file: not a regular file");
  std::filesystem::copy(folder / "square.xyz", folder / "square.db");
  says({"square.db", "square.db"}, {}, "the output is also an input");
  EXPECT_EQ(names(), (Words{"square.db", "square.xyz"}));
}

TEST_F(SqlLoadTest, a_full_disk_leaves_nothing_behind) {
  ASSERT_EQ(run({"generate", "courtyard", "--points=1e5", "-o", "site.las", "-q"}).exit_code, 0);
  const ProgramResult store = run_on_full_disk({"sql", "load", "site.las", "site.db"}, 2'000'000);
  EXPECT_EQ(store.exit_code, 2);
  EXPECT_TRUE(contains(store.err, "alidade: error: ")) << store.err;
  const ProgramResult sort =
      run_on_full_disk({"sql", "load", "site.las", "site.db", "--memory=1M"}, 1'000'000);
  EXPECT_EQ(sort.exit_code, 2);
  EXPECT_TRUE(contains(sort.err, "cannot write a temporary file in this folder")) << sort.err;
  EXPECT_EQ(names(), Words{"site.las"});
}

TEST_F(SqlLoadTest, interrupted_or_killed_it_leaves_no_half_table) {
  ASSERT_EQ(run({"generate", "courtyard", "--points=2e6", "-o", "site.las", "-q"}).exit_code, 0);
  Program interrupted({"sql", "load", "site.las", "site.db"}, folder);
  wait_for(interrupted, ".site.part-");
  interrupted.send(SIGINT);
  EXPECT_EQ(interrupted.wait().exit_code, 130);
  EXPECT_EQ(names(), Words{"site.las"});

  write_square("square.xyz");
  ASSERT_EQ(load({"square.xyz", "site.db"}).exit_code, 0);
  Program killed({"sql", "load", "site.las", "site.db", "--table=more"}, folder);
  wait_for(killed, "site.db-journal");
  killed.send(SIGKILL);
  EXPECT_EQ(killed.wait().exit_code, -1);
  {
    const Connection connection(folder / "site.db", Connection::Mode::write);
    EXPECT_FALSE(Statement(connection.get(), "SELECT 1 FROM sqlite_schema WHERE name LIKE 'more%'").step());
  }
  EXPECT_EQ(points("site.db"), 400);
}

TEST_F(SqlLoadTest, what_a_killed_run_left_of_a_new_file_is_removed_by_the_next) {
  ASSERT_EQ(run({"generate", "courtyard", "--points=2e6", "-o", "site.las", "-q"}).exit_code, 0);
  write_square("square.xyz");
  const auto leavings = [&] {
    return std::ranges::count_if(names(),
                                 [](const std::string& name) { return name.starts_with(".new.part-"); });
  };
  Program killed({"sql", "load", "site.las", "new.db"}, folder);
  wait_for(killed, ".new.part-");
  killed.send(SIGKILL);
  EXPECT_EQ(killed.wait().exit_code, -1);
  EXPECT_EQ(leavings(), 1);
  ASSERT_EQ(load({"square.xyz", "new.db"}).exit_code, 0);
  EXPECT_EQ(leavings(), 0);
  EXPECT_EQ(points("new.db"), 400);
}

}  // namespace
}  // namespace alidade::test
