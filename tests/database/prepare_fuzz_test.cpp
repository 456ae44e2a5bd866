// SPDX-License-Identifier: MIT
// Statements of all sorts give the same answer whether chunks are left unread or not.
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
    add_statement_tables(made.get());
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
    const StatementAnswer expected = answer_of(plain.get(), made, wanted);
    const StatementAnswer answer = answer_of(pruning.get(), prepared.statement.get(), wanted);
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
