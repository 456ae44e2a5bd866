// SPDX-License-Identifier: MIT
// The module in programs of others: sqlite3's shell and Python.
#include <array>
#include <cstdio>

#include "cloud/las/write_las.h"
#include "tests/database/sqlite_fixture.h"

namespace alidade::test {

using namespace database;

namespace {

class SqliteModuleTest : public SqliteTest {
 protected:
  void SetUp() override { store_cloud(file_, site(3000), {.chunk_points = 50}); }

  /// What a command of the shell prints, errors too.
  static std::string output_of(const std::string& command) {
    std::string text;
    FILE* const pipe = ::popen((command + " 2>&1").c_str(), "r");
    if (pipe == nullptr) return text;
    std::array<char, 4096> part;
    while (const std::size_t count = std::fread(part.data(), 1, part.size(), pipe))
      text.append(part.data(), count);
    ::pclose(pipe);
    return text;
  }

  static constexpr const char* k_counts =
      "SELECT count(*) FROM points WHERE dist_ray(690050,5325050,500, 0,0,-1, x,y,z) <= 9 UNION ALL "
      "SELECT count(*) FROM points(690050,5325050,500, 0,0,-1) WHERE dist <= 9";

  std::string expected() const {
    const Connection database(file_, Connection::Mode::read);
    const std::vector<double> counts = numbers(database, k_counts);
    EXPECT_GT(counts.at(0), 10.0);
    EXPECT_EQ(counts.at(0), counts.at(1));
    return fmt::format("{}\n{}\n", counts[0], counts[1]);
  }
};

TEST_F(SqliteModuleTest, works_in_the_stock_shell) {
  if (output_of("command -v sqlite3").empty()) GTEST_SKIP() << "no sqlite3 shell here";
  EXPECT_EQ(output_of(fmt::format("sqlite3 '{}' \".load {}\" \"{}\"", file_.string(), ALIDADE_SQLITE_FILE,
                                  k_counts)),
            expected());
}

TEST_F(SqliteModuleTest, makes_tables_over_files_in_the_stock_shell) {
  if (output_of("command -v sqlite3").empty()) GTEST_SKIP() << "no sqlite3 shell here";
  write_las(folder_ / "site.copc.laz", site(3000));
  const std::string table = fmt::format("CREATE VIRTUAL TABLE temp.points USING alidade('{}')",
                                        (folder_ / "site.copc.laz").string());
  EXPECT_EQ(output_of(fmt::format("sqlite3 :memory: \".load {}\" \"{}\" \"{}\"", ALIDADE_SQLITE_FILE, table,
                                  k_counts)),
            expected());
}

TEST_F(SqliteModuleTest, works_in_python) {
  const std::string script = fmt::format(
      "import sqlite3\nc = sqlite3.connect('{}')\nc.enable_load_extension(True)\nc.load_extension('{}')\n"
      "for row in c.execute('''{}'''): print(row[0])\n",
      file_.string(), ALIDADE_SQLITE_FILE, k_counts);
  if (output_of("/usr/bin/python3 -c 'import sqlite3; sqlite3.Connection.enable_load_extension; print(1)'") !=
      "1\n")
    GTEST_SKIP() << "no Python whose SQLite loads modules";
  EXPECT_EQ(output_of(fmt::format("/usr/bin/python3 -c \"{}\"", script)), expected());
}

}  // namespace
}  // namespace alidade::test
