// SPDX-License-Identifier: MIT
// Databases that contradict themselves: an error that names file, table and chunk.
#include "tests/database/sqlite_fixture.h"

namespace alidade::test {

using namespace database;

namespace {

class SqliteDamageTest : public SqliteTest {
 protected:
  /// What reading everything says after a statement has changed the tables of a whole database.
  std::string error_after(const std::string& change) const {
    std::filesystem::remove(file_);
    store_cloud(file_, site(1000), {.chunk_points = 10});
    {
      const Connection database(file_, Connection::Mode::write);
      run(database.get(), change);
    }
    const Connection database(file_, Connection::Mode::read);
    return error_of(database, "SELECT id, red, x FROM points");
  }
};

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_F(SqliteDamageTest, short_positions_are_reported) {
  const std::string error =
      error_after("UPDATE points_chunk SET positions = substr(positions, 1, 77) WHERE id = 3");
  EXPECT_TRUE(contains(error, "chunk 3") && contains(error, "77 bytes")) << error;
}

TEST_F(SqliteDamageTest, wrong_counts_are_reported) {
  for (const char* const count : {"99", "-1", "9223372036854775807", "1537228672809129302"}) {
    const std::string error =
        error_after(std::string("UPDATE points_chunk SET points = ") + count + " WHERE id = 0");
    EXPECT_TRUE(contains(error, "chunk 0")) << error;
  }
}

TEST_F(SqliteDamageTest, short_and_missing_values_are_reported) {
  const std::string shortened = error_after("UPDATE points_value SET data = x'00' WHERE id = (1 << 32) + 2");
  EXPECT_TRUE(contains(shortened, "chunk 2") && contains(shortened, "red") && contains(shortened, "1 bytes"))
      << shortened;
  const std::string missing = error_after("DELETE FROM points_value WHERE id = 1");
  EXPECT_TRUE(contains(missing, "chunk 1") && contains(missing, "values of id")) << missing;
}

TEST_F(SqliteDamageTest, missing_chunks_are_reported) {
  EXPECT_TRUE(contains(error_after("DELETE FROM points_chunk WHERE id = 5"), "chunk 5"));
}

TEST_F(SqliteDamageTest, impossible_descriptions_are_reported) {
  EXPECT_TRUE(contains(error_after("UPDATE points_column SET place = 5 WHERE name = 'red'"), "red"));
  EXPECT_TRUE(contains(error_after("UPDATE points_column SET type = 77 WHERE name = 'red'"), "red"));
  EXPECT_TRUE(contains(error_after("UPDATE points_column SET size = 4294967296 WHERE name = 'red'"), "red"));
  EXPECT_TRUE(
      contains(error_after("UPDATE points_column SET size = size + (1 << 32) WHERE name = 'id'"), "id"));
  EXPECT_TRUE(contains(error_after("UPDATE points_column SET type = type + 256 WHERE name = 'red'"), "red"));
  EXPECT_TRUE(contains(error_after("UPDATE points_cloud SET scale_x = 0"), "lattice"));
  EXPECT_TRUE(contains(error_after("UPDATE points_cloud SET version = 2"), "unsupported version"));
  EXPECT_TRUE(contains(error_after("DELETE FROM points_column"), "columns"));
  EXPECT_TRUE(contains(error_after("DELETE FROM points_cloud"), "empty table"));
  EXPECT_TRUE(contains(error_after("DROP TABLE points_cloud"), "points_cloud"));
}

TEST_F(SqliteDamageTest, boxes_that_are_missing_or_short_are_reported) {
  EXPECT_TRUE(contains(error_after("DELETE FROM points_bounds WHERE id = 1"), "page 1 of level 0"));
  EXPECT_TRUE(
      contains(error_after("UPDATE points_bounds SET boxes = x'' WHERE id = 1 << 32"), "page 0 of level 1"));
  EXPECT_TRUE(contains(error_after("UPDATE points_cloud SET chunks = 900"), "of its boxes"));
  EXPECT_TRUE(contains(error_after("UPDATE points_cloud SET chunks = 9223372036854775807"), "counts"));
}

TEST_F(SqliteDamageTest, columns_of_one_blob_agree_on_its_size) {
  // The first column that is read decides how long the blob has to be; the next must not read beyond.
  const std::string error =
      error_after("UPDATE points_column SET blob = 1, size = 9000, place = 8998 WHERE name = 'green'");
  EXPECT_TRUE(contains(error, "green") && contains(error, "red")) << error;
  const std::string of_ids =
      error_after("UPDATE points_column SET blob = 0, size = 120000, place = 119998 WHERE name = 'red'");
  EXPECT_TRUE(contains(of_ids, "red") && contains(of_ids, "120000")) << of_ids;
}

TEST_F(SqliteDamageTest, blobs_are_numbered_without_gaps) {
  EXPECT_TRUE(
      contains(error_after("UPDATE points_column SET blob = 1048575 WHERE name = 'gps_time'"), "gps_time"));
}

TEST_F(SqliteDamageTest, tables_that_are_views_over_the_cloud_are_reported) {
  for (const auto& [table, column] :
       {std::pair("chunk", "positions"), {"bounds", "boxes"}, {"value", "data"}}) {
    const std::string name = std::string("points_") + table;
    std::filesystem::remove(file_);
    store_cloud(file_, site(100));
    {
      const Connection database(file_, Connection::Mode::write);
      run(database.get(), "ALTER TABLE " + name + " RENAME TO old");
      run(database.get(),
          "CREATE VIEW " + name + " AS SELECT id, 1 AS points, x AS " + column + " FROM points");
    }
    const Connection database(file_, Connection::Mode::read);
    EXPECT_TRUE(contains(error_of(database, "SELECT red FROM points"), "no such table")) << table;
  }
}

TEST_F(SqliteDamageTest, numbers_of_another_kind_are_reported) {
  EXPECT_TRUE(contains(error_after("UPDATE points_column SET scale = NULL WHERE name = 'red'"), "red"));
  EXPECT_TRUE(contains(error_after("UPDATE points_column SET \"offset\" = 9e999 WHERE name = 'red'"), "red"));
  EXPECT_TRUE(contains(error_after("UPDATE points_column SET name = NULL WHERE name = 'red'"), "name"));
  EXPECT_TRUE(contains(error_after("UPDATE points_column SET name = 'x' WHERE name = 'red'"),
                       "duplicate column name: x"));
  EXPECT_TRUE(contains(error_after("UPDATE points_cloud SET points = 9223372036854775807"), "points"));
  EXPECT_TRUE(contains(error_after("UPDATE points_cloud SET points = 'many'"), "points"));
}

TEST_F(SqliteDamageTest, boxes_that_do_not_hold_their_points_are_reported) {
  const std::string size = "(SELECT length(boxes) FROM points_bounds WHERE id = 0)";
  EXPECT_TRUE(contains(error_after("UPDATE points_bounds SET boxes = zeroblob(" + size + ") WHERE id = 0"),
                       "page 0 of level 0"));
  const std::string no_number = "x'000000000000f87f'";
  EXPECT_TRUE(contains(error_after("UPDATE points_bounds SET boxes = CAST(" + no_number +
                                   " || substr(boxes, 9) AS BLOB) WHERE id = 0"),
                       "page 0 of level 0"));
  // The box of chunk 0 becomes that of chunk 1.
  EXPECT_TRUE(contains(error_after("UPDATE points_bounds SET boxes = CAST(substr(boxes, 49, 48) || "
                                   "substr(boxes, 49) AS BLOB) WHERE id = 0"),
                       "chunk 0"));
}

TEST_F(SqliteDamageTest, errors_name_the_file_and_have_sqlites_code) {
  store_cloud(file_, site(100), {.chunk_points = 10});
  const std::filesystem::path other = folder_ / "other.db";
  store_cloud(other, site(100), {.chunk_points = 10});
  const Connection database(other, Connection::Mode::write);
  run(database.get(), "DELETE FROM points_chunk WHERE id = 5");
  const Connection both(file_, Connection::Mode::write);
  run(both.get(), "ATTACH '" + other.string() + "' AS other");
  const std::string error = error_of(both, "SELECT id FROM other.points");
  EXPECT_TRUE(contains(error, "other.db") && contains(error, "chunk 5")) << error;
  EXPECT_EQ(sqlite3_errcode(both.get()), SQLITE_CORRUPT);
  run(database.get(), "DROP TABLE points_value");
  EXPECT_TRUE(contains(error_of(both, "SELECT id FROM other.points"), "other.db"));
}

TEST_F(SqliteDamageTest, a_cloud_that_cannot_be_read_can_be_replaced) {
  for (const char* const change :
       {"UPDATE points_cloud SET version = 2", "DROP TABLE points_column", "DROP TABLE points_bounds"}) {
    EXPECT_NE(error_after(change), "");
    store_cloud(file_, site(10), {.replace = true});
    const Connection database(file_, Connection::Mode::read);
    EXPECT_EQ(numbers(database, "SELECT count(*) FROM points"), std::vector<double>{10}) << change;
  }
}

TEST_F(SqliteDamageTest, truncated_files_are_reported) {
  store_cloud(file_, site(1000));
  std::filesystem::resize_file(file_, std::filesystem::file_size(file_) / 2);
  try {
    const Connection database(file_, Connection::Mode::read);
    EXPECT_NE(error_of(database, "SELECT sum(x + red) FROM points"), "");
  } catch (const Error& error) {
    EXPECT_TRUE(contains(error.what(), "site.db")) << error.what();
  }
}

}  // namespace
}  // namespace alidade::test
