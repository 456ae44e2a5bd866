// SPDX-License-Identifier: MIT
// alidade sql at a terminal: lines are edited and called back, and Ctrl-C leaves the prompt alive.
#include <signal.h>

#include <cstdlib>

#include "database/sqlite/store_cloud.h"
#include "tests/support/sql_site.h"
#include "tests/tools/run_program.h"
#include "tests/tools/terminal.h"

namespace alidade::test {

using namespace database;

namespace {

class SqlPromptTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    store_cloud(folder / "site.db", sql_site(), {.chunk_points = 50});
  }
};

TEST_F(SqlPromptTest, statements_are_typed_edited_and_called_back) {
  constexpr const char* k_prompt = "alidade> ";
  const std::string up = "\x1b[A", to_begin = "\x01", to_end = "\x05", backspace = "\x7f";
  {
    Terminal terminal(folder, {"sql", "site.db", "--param", "more=25"});
    ASSERT_TRUE(terminal.shows("", k_prompt));
    EXPECT_TRUE(terminal.edits("SELECT 4000 +\n", "...> "));
    EXPECT_TRUE(terminal.edits("23;\n", "4023"));
    EXPECT_TRUE(terminal.edits("SELECT 4000 + :more;\n", "4025"));
    EXPECT_TRUE(terminal.edits(".mode csv\n", k_prompt));
    EXPECT_TRUE(terminal.edits(".tables\n", "points,cloud"));
    EXPECT_TRUE(terminal.edits(".schema POINTS\n", "points,x,REAL"));
    // Characters that are not UTF-8 are dropped, and no key after them.
    EXPECT_TRUE(terminal.edits("SELECT 4000 + 26, '\xe9';\n", "4026"));
    EXPECT_TRUE(terminal.edits("SELECT '\xa9' || 4027 || '\xff';\n", "\ufffd4027\ufffd\r\n"));
    EXPECT_TRUE(terminal.edits("/* not run\n", "...> "));
    EXPECT_TRUE(terminal.edits("SELECT 70 + 7;\n", "...> "));
    EXPECT_TRUE(terminal.edits("*/ SELECT 4000 + 24;\n", "4024"));
    EXPECT_TRUE(terminal.edits(".frob\n", "unknown command"));
    EXPECT_TRUE(terminal.edits("SELECT idd;\n", "statement:1:8: no such column: idd"));
    EXPECT_TRUE(
        terminal.edits("ELECT 'caf\xc3\xa9' || count(*) AS n FROM points" + to_begin + "S" + to_end + ";\n",
                       "caf\xc3\xa9"
                       "400"));
    EXPECT_TRUE(terminal.edits(up + backspace + " WHERE dist_ray(100,200,5, 0,0,1, x,y,z) <= 0.1;\n",
                               "caf\xc3\xa9"
                               "3\r\n"));
    EXPECT_TRUE(terminal.edits(".explain on\n", k_prompt));
    EXPECT_TRUE(terminal.edits(up + up + "\n", "read 1 of 8 chunks"));
    EXPECT_TRUE(terminal.edits(".quit\n", ""));
    EXPECT_EQ(terminal.exit_code(), 0);
  }
  const std::filesystem::path history = folder / "state" / "alidade" / "sql_history";
  EXPECT_EQ(std::filesystem::status(history).permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  Terminal later(folder, {"sql", "site.db", "--param", "more=25"});
  ASSERT_TRUE(later.shows("", k_prompt));
  EXPECT_TRUE(later.edits(up + up + "\n",
                          "\xc3\xa9"
                          "3"));
  EXPECT_TRUE(later.edits("\x04", ""));
  EXPECT_EQ(later.exit_code(), 0);
}

TEST_F(SqlPromptTest, ctrl_c_drops_what_is_typed_or_runs) {
  const std::string ctrl_c = "\x03";
  Terminal terminal(folder, {"sql", "site.db", "--param", "more=25"});
  ASSERT_TRUE(terminal.shows("", "alidade> "));
  EXPECT_TRUE(terminal.edits("SELECT 1 +\n", "...> "));
  EXPECT_TRUE(terminal.edits("half a st", "half a st"));
  EXPECT_TRUE(terminal.shows(ctrl_c, "\nalidade> "));
  EXPECT_TRUE(terminal.edits("WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i FROM n) SELECT i FROM n;\n",
                             "1\r\n1\r\n"));
  EXPECT_TRUE(terminal.shows(ctrl_c, "\nalidade> "));
  EXPECT_TRUE(terminal.edits("SELECT 4000 + 23;\n", "4023"));
  EXPECT_TRUE(terminal.edits("\x04", ""));
  EXPECT_EQ(terminal.exit_code(), 0);
}

}  // namespace
}  // namespace alidade::test
