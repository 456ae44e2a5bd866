// SPDX-License-Identifier: MIT
// alidade sql at a terminal: lines are edited and called back, and Ctrl-C leaves the prompt alive.
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <cstdlib>
#include <utility>

#include "database/sqlite/store_cloud.h"
#include "tests/support/sql_site.h"
#include "tests/tools/run_program.h"

namespace alidade::test {

using namespace database;

namespace {

/// A person at a terminal who has started the program.
class Terminal {
 public:
  Terminal(const std::filesystem::path& folder, const std::string& database) {
    const std::string program = program_file(), state = folder / "state";
    process_ = ::forkpty(&terminal_, nullptr, nullptr, nullptr);
    if (process_ != 0) return;
    ::setenv("XDG_STATE_HOME", state.c_str(), 1);
    ::setenv("TERM", "xterm", 1);
    if (::chdir(folder.c_str()) != 0) ::_exit(125);
    ::execl(program.c_str(), program.c_str(), "sql", database.c_str(), "--param", "more=25", nullptr);
    ::_exit(126);
  }
  ~Terminal() {
    if (terminal_ >= 0) ::close(terminal_);
    if (process_ <= 0) return;
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  /// Types keys and waits until `expected` is shown after them; all that was shown, of the failure too.
  ::testing::AssertionResult shows(const std::string& keys, const std::string& expected) {
    shown_.clear();
    if (::write(terminal_, keys.data(), keys.size()) < 0)
      return ::testing::AssertionFailure() << "cannot type";
    while (shown_.find(expected) == std::string::npos) {
      if (!read_more()) return ::testing::AssertionFailure() << "shown: " << shown_;
    }
    return ::testing::AssertionSuccess();
  }

  /// The same, once the program edits lines: until then the terminal's own rules for keys hold.
  ::testing::AssertionResult edits(const std::string& keys, const std::string& expected) {
    termios rules = {};
    for (int i = 0;
         i < k_longest_wait && ::tcgetattr(terminal_, &rules) == 0 && (rules.c_lflag & ICANON) != 0; ++i)
      ::poll(nullptr, 0, 1);
    return shows(keys, expected);
  }

  /// The program's exit code, once it has ended.
  int exit_code() {
    while (read_more()) {
    }
    // Ends it if it has not ended, with another code.
    ::close(std::exchange(terminal_, -1));
    int status = 0;
    ::waitpid(std::exchange(process_, -1), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  static constexpr int k_longest_wait = 30'000;  ///< milliseconds

  bool read_more() {
    pollfd waiting{.fd = terminal_, .events = POLLIN, .revents = 0};
    char part[4096];
    if (::poll(&waiting, 1, k_longest_wait) != 1) return false;
    const ::ssize_t count = ::read(terminal_, part, sizeof part);
    if (count > 0) shown_.append(part, static_cast<std::size_t>(count));
    return count > 0;
  }

  int terminal_ = -1;
  pid_t process_ = -1;
  std::string shown_;
};

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
    Terminal terminal(folder, "site.db");
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
  Terminal later(folder, "site.db");
  ASSERT_TRUE(later.shows("", k_prompt));
  EXPECT_TRUE(later.edits(up + up + "\n",
                          "\xc3\xa9"
                          "3"));
  EXPECT_TRUE(later.edits("\x04", ""));
  EXPECT_EQ(later.exit_code(), 0);
}

TEST_F(SqlPromptTest, ctrl_c_drops_what_is_typed_or_runs) {
  const std::string ctrl_c = "\x03";
  Terminal terminal(folder, "site.db");
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
