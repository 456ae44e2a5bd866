// SPDX-License-Identifier: MIT
// Statements of all sorts give the same answer whether chunks are left unread or not.
#include <algorithm>

#include "database/sqlite/prepare.h"
#include "tests/database/random_statement.h"
#include "tests/database/sqlite_fixture.h"

namespace alidade::test {

using namespace database;

namespace {

class PrepareFuzzTest : public SqliteTest {
 protected:
  void SetUp() override {
    store_cloud(file_, site(300), {.chunk_points = 6});
    store_cloud(file_, site(60), {.table = "odd \"cloud", .chunk_points = 7});
    const Connection made(file_, Connection::Mode::write);
    for (const char* const sql :
         {"CREATE TABLE rays(id INTEGER, ox REAL, oy REAL, oz REAL, dx, dy, dz, radius, note TEXT)",
          "INSERT INTO rays VALUES(1, 690050, 5325050, 410, 0, 0, 1, 6, '1'), "
          "(2, 690010, 5325020, 405, 1, 0.5, 0, 9.5, 'far'), (3, 690000, 5325000, 400, 1, 1, 1e-200, 3, "
          "NULL), "
          "(4, 690080, 5325050, 400, NULL, 0, 1, 6, ''), (5, 690020, 5325080, 401, -1, 0, 0.1, '4', '1'), "
          "(6, 690090, 5325010, 400, 0, -1, 0, -1, 'a'), (7, 690090, 5325010, 400, 0, -1, 0, NULL, 'a')",
          "CREATE TABLE marks(id INTEGER, x, y, z)",
          "INSERT INTO marks VALUES(1, 690050, 5325050, 401), (2, NULL, 1, 1), (3, 690010, 5325010, 400.5), "
          "(590, 690060, 5325060, 402)",
          "CREATE VIEW moved AS SELECT id, x, y + 5 AS y, z FROM points",
          "CREATE VIEW showing AS SELECT id, x, y + 5 AS y, z, _chunk FROM points",
          "CREATE VIEW plain_view AS SELECT * FROM points"})
      run(made.get(), sql);
  }

  struct Answer {
    std::vector<std::string> rows;
    std::string error;
  };

  static Answer run_all(sqlite3* database, sqlite3_stmt* statement, const RandomStatement& wanted) {
    for (int i = 1; i <= sqlite3_bind_parameter_count(statement); ++i)
      sqlite3_bind_double(statement, i, 410.0 - 50.0 * i);
    Answer answer;
    int result = SQLITE_ROW;
    while ((result = sqlite3_step(statement)) == SQLITE_ROW) {
      std::string row;
      for (int i = 0; i < sqlite3_column_count(statement); ++i) {
        const auto* const text = reinterpret_cast<const char*>(sqlite3_column_text(statement, i));
        row += fmt::format("{}:{} ", sqlite3_column_type(statement, i), text == nullptr ? "" : text);
      }
      answer.rows.push_back(row);
    }
    if (result != SQLITE_DONE) answer = {.rows = {}, .error = sqlite3_errmsg(database)};
    if (!wanted.is_ordered) std::ranges::sort(answer.rows);
    return answer;
  }
};

TEST_F(PrepareFuzzTest, rewritten_statements_give_what_plain_ones_give) {
  const Connection plain(file_, Connection::Mode::read), pruning(file_, Connection::Mode::read);
  Random random;
  int understood = 0, pruned = 0, helped = 0, with_rows = 0, with_errors = 0;
  for (int i = 0; i < 2500; ++i) {
    const RandomStatement wanted = random_statement(random);
    SCOPED_TRACE(wanted.text);
    sqlite3_stmt* made = nullptr;
    const int result = sqlite3_prepare_v2(plain.get(), wanted.text.c_str(), -1, &made, nullptr);
    const StatementHandle statement(made);
    if (result != SQLITE_OK) {
      EXPECT_THROW(prepare(pruning.get(), wanted.text), Error);
      continue;
    }
    ++understood;
    const ScanReads before = pruning.reads();
    Prepared prepared = prepare(pruning.get(), wanted.text);
    ASSERT_NE(prepared.statement, nullptr);
    EXPECT_EQ(sqlite3_bind_parameter_count(prepared.statement.get()), sqlite3_bind_parameter_count(made));
    const Answer expected = run_all(plain.get(), made, wanted);
    const Answer answer = run_all(pruning.get(), prepared.statement.get(), wanted);
    // Pruning evaluates a condition without a limit for fewer points, or in another order.
    const bool may_differ = !prepared.pruned.empty() && !prepared.reason.empty();
    if (!may_differ || (answer.error.empty() && expected.error.empty())) {
      ASSERT_EQ(answer.rows, expected.rows) << prepared.pruned;
      ASSERT_EQ(answer.error, expected.error) << prepared.pruned;
    }
    if (prepared.pruned.empty()) {
      EXPECT_NE(prepared.reason, "");
      continue;
    }
    ++pruned;
    prepared.statement.reset();
    const ScanReads& after = pruning.reads();
    if (after.chunks_read - before.chunks_read < after.chunks - before.chunks) ++helped;
    if (!expected.rows.empty()) ++with_rows;
    if (!expected.error.empty()) ++with_errors;
  }
  // The test would be worth little if few statements were what it is about.
  EXPECT_GT(understood, 1600);
  EXPECT_GT(pruned, 600);
  EXPECT_GT(helped, 300);
  EXPECT_GT(with_rows, 300);
  EXPECT_GT(with_errors, 15);
}

}  // namespace
}  // namespace alidade::test
