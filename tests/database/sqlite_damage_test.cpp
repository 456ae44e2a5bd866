// SPDX-License-Identifier: MIT
// Databases that are not what they say: an error that names table and chunk, never a wrong row.
#include "tests/database/sqlite_fixture.h"

namespace alidade::test {
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

TEST_F(SqliteDamageTest, short_positions_are_told) {
  const std::string error =
      error_after("UPDATE points_chunk SET positions = substr(positions, 1, 77) WHERE id = 3");
  EXPECT_TRUE(contains(error, "chunk 3") && contains(error, "77 bytes")) << error;
}

TEST_F(SqliteDamageTest, counts_that_lie_are_told) {
  for (const char* const count : {"99", "-1", "9223372036854775807", "1537228672809129302"}) {
    const std::string error =
        error_after(std::string("UPDATE points_chunk SET points = ") + count + " WHERE id = 0");
    EXPECT_TRUE(contains(error, "chunk 0")) << error;
  }
}

TEST_F(SqliteDamageTest, short_and_missing_values_are_told) {
  const std::string shortened = error_after("UPDATE points_value SET data = x'00' WHERE id = (1 << 32) + 2");
  EXPECT_TRUE(contains(shortened, "chunk 2") && contains(shortened, "red") && contains(shortened, "1 bytes"))
      << shortened;
  const std::string missing = error_after("DELETE FROM points_value WHERE id = 1");
  EXPECT_TRUE(contains(missing, "chunk 1") && contains(missing, "values of id")) << missing;
}

TEST_F(SqliteDamageTest, columns_that_disagree_about_their_blob_are_told) {
  const std::string error =
      error_after("UPDATE points_column SET blob = 0, size = 120000, place = 119998 WHERE name = 'red'");
  EXPECT_TRUE(contains(error, "values of red") && contains(error, "120000 bytes")) << error;
}

TEST_F(SqliteDamageTest, missing_chunks_are_told) {
  EXPECT_TRUE(contains(error_after("DELETE FROM points_chunk WHERE id = 5"), "chunk 5"));
}

TEST_F(SqliteDamageTest, descriptions_that_cannot_be_are_told) {
  EXPECT_TRUE(contains(error_after("UPDATE points_column SET place = 5 WHERE name = 'red'"), "red"));
  EXPECT_TRUE(contains(error_after("UPDATE points_column SET type = 77 WHERE name = 'red'"), "red"));
  EXPECT_TRUE(contains(error_after("UPDATE points_column SET size = 4294967296 WHERE name = 'red'"), "red"));
  EXPECT_TRUE(contains(error_after("UPDATE points_cloud SET scale_x = 0"), "lattice"));
  EXPECT_TRUE(contains(error_after("UPDATE points_cloud SET version = 2"), "another version"));
  EXPECT_TRUE(contains(error_after("DELETE FROM points_column"), "columns"));
  EXPECT_TRUE(contains(error_after("DELETE FROM points_cloud"), "is empty"));
  EXPECT_TRUE(contains(error_after("DROP TABLE points_cloud"), "points_cloud"));
}

TEST_F(SqliteDamageTest, boxes_that_are_missing_or_short_are_told) {
  EXPECT_TRUE(contains(error_after("DELETE FROM points_bounds WHERE id = 1"), "page 1 of level 0"));
  EXPECT_TRUE(
      contains(error_after("UPDATE points_bounds SET boxes = x'' WHERE id = 1 << 32"), "page 0 of level 1"));
  EXPECT_TRUE(contains(error_after("UPDATE points_cloud SET chunks = 9223372036854775807"), "of its boxes"));
}

TEST_F(SqliteDamageTest, truncated_files_are_told) {
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
