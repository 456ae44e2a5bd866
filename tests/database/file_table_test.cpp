// SPDX-License-Identifier: MIT
// Tables over files in place: what they answer, and what they reject.
#include <fstream>
#include <iterator>

#include "cloud/las/write_las.h"
#include "database/sqlite/prepare.h"
#include "database/sqlite/scan.h"
#include "octree/build.h"
#include "octree/distance.h"
#include "octree/index_file/index_file.h"
#include "octree/index_file/save_index.h"
#include "tests/database/random_statement.h"
#include "tests/database/sqlite_fixture.h"

namespace alidade::test {

using namespace database;

namespace {

using Paths = std::vector<std::filesystem::path>;

class FileTableTest : public SqliteTest {
 protected:
  /// A table over files in a database in memory.
  static Connection over(const Paths& files) { return Connection(files, {}); }

  std::filesystem::path write_site(const std::string& name, std::size_t count) const {
    const std::filesystem::path file = folder_ / name;
    if (file.extension() != ".alidade") {
      write_las(file, site(count), {.overwrite = true});
      return file;
    }
    const std::filesystem::path las = write_site(name + ".las", count);
    PointCloud cloud = read_cloud(las);
    save_index(file, build(cloud), cloud, {.overwrite = true});
    return file;
  }

  static void make(const Connection& connection, const std::string& table, const std::string& argument) {
    run(connection.get(), "CREATE VIRTUAL TABLE " + table + " USING alidade(" + argument + ")");
  }

  static void overwrite(const std::filesystem::path& file, const std::string& text) {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << text;
  }
};

std::vector<std::string> columns_of_table(const Connection& connection, const std::string& table) {
  Statement statement(connection.get(),
                      "SELECT name || ' ' || type || ' ' || hidden FROM pragma_table_xinfo(?)");
  statement.bind(1, table);
  std::vector<std::string> columns;
  while (statement.step()) columns.push_back(statement.text(0));
  return columns;
}

/// All rows of a table by id, every column with its type.
std::vector<std::string> all_rows(const Connection& connection, const std::string& table) {
  Statement statement(connection.get(), "SELECT * FROM " + table + " ORDER BY id");
  const std::size_t all = columns_of_table(connection, table).size();
  const int count = static_cast<int>(all) - TableColumns::k_hidden;
  std::vector<std::string> rows;
  while (statement.step()) {
    std::string& row = rows.emplace_back();
    for (int i = 0; i < count; ++i) row += fmt::format("{}:{} ", statement.type(i), statement.text(i));
  }
  return rows;
}

TEST_F(FileTableTest, columns_and_rows_are_those_of_the_loaded_table) {
  // 100 points have colours of 8 bits.
  for (const auto& [name, count] : std::vector<std::pair<std::string, std::size_t>>{{"a.las", 1500},
                                                                                    {"a.laz", 1500},
                                                                                    {"a.copc.laz", 1500},
                                                                                    {"b.copc.laz", 100},
                                                                                    {"a.alidade", 1500},
                                                                                    {"b.alidade", 100}}) {
    SCOPED_TRACE(name);
    const Paths file = {write_site(name, count)};
    store_files(file_, resolve_clouds(file, index_and_file_formats()), {}, {.replace = true});
    const Connection loaded(file_, Connection::Mode::read);
    const Connection in_place = over(file);
    const std::vector<std::string> rows = all_rows(loaded, "points");
    ASSERT_EQ(rows.size(), count);
    EXPECT_EQ(all_rows(in_place, "points"), rows);
    EXPECT_EQ(columns_of_table(in_place, "points"), columns_of_table(loaded, "points"));
    EXPECT_GT(columns_of_table(loaded, "points").size(), 20u);
  }
}

/// For files of the format that the parameter names.
class RandomStatementTest : public FileTableTest, public ::testing::WithParamInterface<const char*> {};

TEST_P(RandomStatementTest, the_answer_is_that_of_the_loaded_table) {
  const std::string name = GetParam();
  const Paths file = {write_site(name, 300)}, small = {write_site("small_" + name, 60)};
  const auto inputs = [](const Paths& files) { return resolve_clouds(files, index_and_file_formats()); };
  store_files(file_, inputs(file), {}, {.chunk_points = 6, .replace = true});
  store_files(file_, inputs(small), {}, {.table = "odd \"cloud", .chunk_points = 7, .replace = true});
  const Connection loaded(file_, Connection::Mode::write), in_place = over(file);
  make(in_place, "\"odd \"\"cloud\"", sql_text(small.front().string()));
  for (const Connection* const connection : {&loaded, &in_place}) add_statement_tables(connection->get());
  Random random;
  int compared = 0, pruned = 0, with_rows = 0;
  while (compared < 200) {
    const RandomStatement wanted = random_statement(random);
    SCOPED_TRACE(wanted.text);
    // Views do not reach files, chunks have other numbers, and which row represents a group is undefined.
    const bool is_open = wanted.text.find("GROUP BY") != std::string::npos ||
                         wanted.text.find("moved") != std::string::npos ||
                         wanted.text.find("showing") != std::string::npos ||
                         wanted.text.find("plain_view") != std::string::npos ||
                         wanted.text.find(", _chunk FROM") != std::string::npos;
    if (is_open) continue;
    std::optional<Prepared> here;
    try {
      here = prepare(in_place.get(), wanted.text);
    } catch (const Error&) {
      EXPECT_THROW(prepare(loaded.get(), wanted.text), Error);
      continue;
    }
    const Prepared there = prepare(loaded.get(), wanted.text);
    EXPECT_EQ(here->pruned, there.pruned);
    const StatementAnswer expected = answer_of(loaded.get(), there.statement.get(), wanted);
    const StatementAnswer answer = answer_of(in_place.get(), here->statement.get(), wanted);
    // Whether a row with an error is met depends on the chunks.
    if (expected.error.empty() || there.reason.empty()) {
      ASSERT_EQ(answer.rows, expected.rows);
      ASSERT_EQ(answer.error, expected.error);
    }
    ++compared;
    if (!there.pruned.empty()) ++pruned;
    if (!expected.rows.empty()) ++with_rows;
  }
  EXPECT_GT(pruned, 60);
  EXPECT_GT(with_rows, 40);
}

INSTANTIATE_TEST_SUITE_P(Formats, RandomStatementTest, ::testing::Values("a.las", "a.copc.laz", "a.alidade"));

TEST_F(FileTableTest, the_form_with_a_ray_and_rowids_work_and_leave_chunks_unread) {
  const Connection in_place = over({write_site("a.las", 20000)});
  const std::string ray = "points(690050,5325050,500, 0,0,-1)";
  const std::vector<double> inside =
      numbers(in_place, "SELECT id FROM points WHERE dist_ray(690050,5325050,500, 0,0,-1, x,y,z) <= 9");
  EXPECT_GT(inside.size(), 100u);
  const ScanReads before = in_place.reads();
  EXPECT_EQ(numbers(in_place, "SELECT count(*) FROM " + ray + " WHERE dist <= 9").at(0),
            static_cast<double>(inside.size()));
  const ScanReads after = in_place.reads();
  EXPECT_LT(after.chunks_read - before.chunks_read, (after.chunks - before.chunks) / 4);
  std::vector<double> sorted =
      numbers(in_place, "SELECT t FROM " + ray + " WHERE dist <= 9 ORDER BY t LIMIT 20");
  EXPECT_TRUE(std::ranges::is_sorted(sorted));
  EXPECT_EQ(sorted, numbers(in_place, "SELECT t FROM " + ray + " WHERE dist <= 9 ORDER BY t + 0 LIMIT 20"));
  EXPECT_EQ(numbers(in_place,
                    "SELECT count(*) FROM points a, points b WHERE a.rowid = b.rowid AND a.id = b.id "
                    "AND a.id < 50"),
            (std::vector<double>{50}));
  EXPECT_EQ(numbers(in_place,
                    "SELECT count(*) FROM points WHERE rowid = -1 OR rowid = 1 << 62 OR _chunk = 1 << 30"),
            (std::vector<double>{0}));
}

TEST_F(FileTableTest, of_a_copc_file_only_nodes_are_read_that_may_have_points) {
  const std::filesystem::path file = write_site("a.copc.laz", 150'000);
  PointCloud cloud = read_cloud(file);
  const Connection in_place = over({file});
  const std::string condition = "dist_ray(690050,5325050,500, 0,0,-1, x,y,z) <= 5";
  const Prepared prepared =
      prepare(in_place.get(), "SELECT id, red, \"Height\" FROM points WHERE " + condition + " ORDER BY id");
  const Ray ray = make_ray({690050, 5325050, 500}, {0, 0, -1});
  std::size_t found = 0;
  for (std::size_t id = 0; id < cloud.size(); ++id) {
    if (project(ray, cloud.world(id)).distance > 5) continue;
    ASSERT_EQ(sqlite3_step(prepared.statement.get()), SQLITE_ROW);
    EXPECT_EQ(sqlite3_column_int64(prepared.statement.get(), 0), static_cast<sqlite3_int64>(id));
    EXPECT_EQ(sqlite3_column_int64(prepared.statement.get(), 1), cloud.colors[id].x);
    ++found;
  }
  EXPECT_EQ(sqlite3_step(prepared.statement.get()), SQLITE_DONE);
  sqlite3_reset(prepared.statement.get());
  EXPECT_GT(found, 500u);
  EXPECT_LT(in_place.reads().points_read, 15'000u);
  EXPECT_GT(in_place.reads().chunks,
            150'000u / 128);  // more than one node, each with a chunk that is not full
}

TEST_F(FileTableTest, an_index_file_that_is_cut_below_a_statement_ends_the_process_with_an_error) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  for (const char* const columns : {"x", "red", "gps_time"}) {
    const std::filesystem::path file = write_site("a.alidade", 50'000);
    const Connection in_place = over({file});
    Statement statement(in_place.get(), std::string("SELECT ") + columns + " FROM points");
    ASSERT_TRUE(statement.step());
    const auto cut_and_read = [&] {
      std::filesystem::resize_file(file, 4096);
      while (statement.step()) {
      }
    };
    EXPECT_EXIT(cut_and_read(), ::testing::ExitedWithCode(2), "a.alidade: the file became shorter")
        << columns;
  }
}

TEST_F(FileTableTest, damage_in_a_copc_file_is_an_error) {
  const std::filesystem::path file = write_site("a.copc.laz", 5000);
  std::string bytes;
  {
    std::ifstream stream(file, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(stream), {});
  }
  int errors = 0;
  for (std::size_t at = 1000; at < bytes.size(); at += bytes.size() / 40) {
    std::string damaged = bytes;
    damaged[at] ^= 0x5a;
    overwrite(file, damaged);
    try {
      const Connection in_place = over({file});
      errors += !error_of(in_place, "SELECT max(z), max(red), max(gps_time) FROM points").empty();
    } catch (const Error&) {
      ++errors;
    }
  }
  EXPECT_GT(errors, 0);
}

TEST_F(FileTableTest, a_file_that_has_changed_or_gone_is_an_error) {
  for (const char* const name : {"a.las", "a.copc.laz", "a.alidade"}) {
    const std::filesystem::path file = write_site(name, 100);
    const Connection in_place = over({file});
    EXPECT_EQ(error_of(in_place, "SELECT count(*) FROM points"), "");
    write_site(name, 100);
    EXPECT_EQ(error_of(in_place, "SELECT count(*) FROM points"),
              file.string() +
                  ": the file has changed since it was opened; expected the file as it was when it "
                  "was opened; make the table or statement again");
    std::filesystem::remove(file);
    EXPECT_TRUE(error_of(in_place, "SELECT 1 FROM points")
                    .starts_with(file.string() + ": the file was removed since it was opened"));
    write_site(name, 70);
    run(in_place.get(), "DROP TABLE points");
    make(in_place, "points", sql_text(file.string()));
    EXPECT_EQ(numbers(in_place, "SELECT count(*) FROM points"), (std::vector<double>{70}));
  }
}

TEST_F(FileTableTest, names_are_texts_of_sql_and_stay_names) {
  const Connection connection = over({write_site("a.las", 10)});
  for (const std::string& name :
       {std::string("it's.las"), std::string("a'); DROP TABLE points; --.las"), std::string("a, b.las"),
        std::string("\"quoted\" %s \\.las"), std::string("ä [1] (2).las"), std::string("''.las")}) {
    const std::string file = write_site(name, 20).string();
    make(connection, "temp.odd", "  " + sql_text(file) + " ");
    EXPECT_EQ(numbers(connection, "SELECT count(*) FROM odd"), (std::vector<double>{20})) << name;
    run(connection.get(), "ALTER TABLE odd RENAME TO \"o'd;d\"");
    EXPECT_EQ(numbers(connection, "SELECT count(*) FROM \"o'd;d\""), (std::vector<double>{20})) << name;
    run(connection.get(), "DROP TABLE \"o'd;d\"");
  }
  const std::string two = sql_text((folder_ / "a.las").string());
  make(connection, "temp.two", two + ", " + two);
  EXPECT_EQ(numbers(connection, "SELECT max(id) FROM two"), (std::vector<double>{19}));
  make(connection, "temp.pattern", sql_text((folder_ / "it*.las").string()));
  EXPECT_EQ(numbers(connection, "SELECT count(*) FROM pattern"), (std::vector<double>{20}));
}

TEST_F(FileTableTest, bad_arguments_are_errors) {
  const Connection connection = over({write_site("a.las", 10)});
  overwrite(folder_ / "empty.las", "");
  overwrite(folder_ / "garbage.laz", std::string("\x7f\0\x01garbage", 10));
  const std::string whole = [&] {
    std::ifstream stream(write_site("b.alidade", 1000), std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(stream), {});
  }();
  overwrite(folder_ / "short.alidade", whole.substr(0, whole.size() / 2));
  std::string damaged = whole;
  damaged[4096 + 96] ^= 0x55;  // a kind in the root node
  overwrite(folder_ / "damaged.alidade", damaged);
  const auto in_folder = [&](const char* name) { return sql_text((folder_ / name).string()); };
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "missing argument of alidade"},
      {"''", "invalid argument of alidade; expected a quoted file name: USING alidade('site.laz'), found ''"},
      {"a.las", "invalid argument of alidade"},
      {"\"a.las\"", "invalid argument of alidade"},
      {"'a' 'b'", "found 'a' 'b'"},
      {"'a.las', 5", "found 5"},
      {"file='a.las'", "invalid argument"},
      {in_folder("none.las"), "none.las: cannot open the file"},
      {in_folder("none*.las"), "none*.las: "},
      {in_folder("empty.las"), "empty.las: "},
      {in_folder("garbage.laz"), "garbage.laz: "},
      {in_folder("short.alidade"), "short.alidade:byte 24: truncated file"},
      {in_folder("damaged.alidade"), "damaged.alidade:byte 4096: corrupt section nodes"},
      {sql_text("/dev/zero"), "/dev/zero: "},
      {sql_text("https://127.0.0.1:1/a.las"), "https://127.0.0.1:1/a.las: "}};
  for (const auto& [argument, message] : cases) {
    const std::string error =
        error_of(connection, "CREATE VIRTUAL TABLE temp.bad USING alidade(" + argument + ")");
    EXPECT_NE(error.find(message), std::string::npos) << argument << "\n" << error;
  }
}

TEST_F(FileTableTest, a_database_file_cannot_open_files) {
  const std::string las = sql_text(write_site("a.las", 10).string());
  store_cloud(file_, site(10));
  {
    const Connection writing(file_, Connection::Mode::write);
    const std::string message = error_of(writing, "CREATE VIRTUAL TABLE p USING alidade(" + las + ")");
    EXPECT_NE(
        message.find(
            "site.db: the table p would let a database open files; expected CREATE VIRTUAL TABLE temp.\"p\""),
        std::string::npos)
        << message;
    make(writing, "temp.p", las);
    EXPECT_EQ(numbers(writing, "SELECT count(*) FROM p"), (std::vector<double>{10}));
    run(writing.get(), "CREATE TEMP VIEW v AS SELECT * FROM p");
    EXPECT_EQ(numbers(writing, "SELECT count(*) FROM v"), (std::vector<double>{10}));
    // What an author of hostile files can do.
    run(writing.get(), "PRAGMA writable_schema = ON");
    Statement(writing.get(), "INSERT INTO main.sqlite_schema VALUES('table', 'p', 'p', 0, ?)")
        .bind(1, "CREATE VIRTUAL TABLE p USING alidade(" + las + ")")
        .run();
  }
  for (const int trusted : {0, 1}) {
    const Connection reading(file_, Connection::Mode::read);
    sqlite3_db_config(reading.get(), SQLITE_DBCONFIG_TRUSTED_SCHEMA, trusted, nullptr);
    EXPECT_NE(error_of(reading, "SELECT * FROM p").find("the table p would let a database open files"),
              std::string::npos);
    EXPECT_EQ(numbers(reading, "SELECT count(*) FROM points"), (std::vector<double>{10}));
  }
}

TEST_F(FileTableTest, a_database_in_memory_that_came_from_elsewhere_cannot_open_files) {
  const Connection source = over({write_site("a.las", 10)}), target = over({write_site("b.las", 10)});
  sqlite3_int64 size = 0;
  unsigned char* const bytes = sqlite3_serialize(source.get(), "main", &size, 0);
  ASSERT_EQ(sqlite3_deserialize(target.get(), "main", bytes, size, size, SQLITE_DESERIALIZE_FREEONCLOSE),
            SQLITE_OK);
  EXPECT_NE(error_of(target, "SELECT * FROM points").find("the table points would let a database open files"),
            std::string::npos);
}

TEST_F(FileTableTest, a_table_in_memory_survives_a_rollback_if_the_schema_is_trusted_or_temporary) {
  const std::string las = sql_text(write_site("a.las", 10).string());
  const Connection connection = over({folder_ / "a.las"});
  make(connection, "temp.t", las);
  for (const int trusted : {1, 0}) {
    sqlite3_db_config(connection.get(), SQLITE_DBCONFIG_TRUSTED_SCHEMA, trusted, nullptr);
    for (const char* const sql : {"BEGIN", "CREATE TABLE a(b)", "ROLLBACK"}) run(connection.get(), sql);
    EXPECT_EQ(error_of(connection, "SELECT * FROM points").empty(), trusted == 1);
    EXPECT_EQ(numbers(connection, "SELECT count(*) FROM t"), (std::vector<double>{10}));
  }
}

TEST_F(FileTableTest, a_view_cannot_open_files_unless_it_is_temporary) {
  const Connection in_place = over({write_site("a.las", 10)});
  run(in_place.get(), "CREATE VIEW v AS SELECT * FROM points");
  EXPECT_NE(error_of(in_place, "SELECT * FROM v").find("unsafe use of virtual table"), std::string::npos);
  run(in_place.get(), "CREATE TEMP VIEW w AS SELECT * FROM points");
  EXPECT_EQ(numbers(in_place, "SELECT count(*) FROM w"), (std::vector<double>{10}));
}

TEST_F(FileTableTest, empty_clouds_values_that_are_not_numbers_and_very_many_attributes) {
  PointCloud cloud;
  write_las(folder_ / "empty.las", cloud);
  const Connection empty = over({folder_ / "empty.las"});
  EXPECT_EQ(numbers(empty, "SELECT count(*) FROM points"), (std::vector<double>{0}));
  EXPECT_EQ(rows(empty, "SELECT t FROM points(0,0,0, 0,0,1) WHERE dist < 1 ORDER BY t LIMIT 1").size(), 0u);

  std::string text = "x,y,z,value\n1,2,3,nan\n4,5,6,inf\n7,8,9,0.5\n";
  overwrite(folder_ / "values.csv", text);
  const Connection values = over({folder_ / "values.csv"});
  EXPECT_EQ(rows(values, "SELECT value IS NULL FROM points ORDER BY id"),
            (std::vector<std::string>{"1", "0", "0"}));
  EXPECT_EQ(numbers(values, "SELECT id FROM points WHERE value < 1"), (std::vector<double>{2}));

  text = "x,y,z";
  for (int i = 0; i < 2500; ++i) text += fmt::format(",a{}", i);
  text += "\n1,2,3";
  for (int i = 0; i < 2500; ++i) text += ",4";
  overwrite(folder_ / "wide.csv", text + "\n");
  try {
    over({folder_ / "wide.csv"});
    FAIL() << "too many columns were accepted";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what())
                  .find("wide.csv: too many columns for a table of SQLite; expected at most 2000"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace alidade::test
