// SPDX-License-Identifier: MIT
// What the program says about servers, without one.
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

using ServerProgramTest = ProgramTest;

TEST_F(ServerProgramTest, names_of_servers_are_checked_before_anything_is_read) {
  write_square("square.xyz");
  const std::vector<std::pair<Words, std::string>> cases = {
      {{"sql", "postgresql://me@host/base", "SELECT 1"},
       "postgresql://host/base: not an SQLite file but a server"},
      {{"sql", "postgresql://me:secret@host/base", "SELECT 1"},
       "the server name contains a password, which other users can see in command lines"},
      {{"sql", "load", "square.xyz", "postgresql://host/base?table=x", "--table", "y"},
       "duplicate table name"},
      {{"sql", "load", "square.xyz", "postgresql://host/base?table=x", "--chunk-points", "7"},
       "--chunk-points does not apply to servers"}};
  for (const auto& [words, message] : cases) {
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 2) << message;
    EXPECT_EQ(result.out, "");
    EXPECT_TRUE(contains(result.err, message)) << message << "\n" << result.err;
    EXPECT_FALSE(contains(result.err, "secret")) << result.err;
  }
}

TEST_F(ServerProgramTest, shards_have_equal_parts_of_the_points) {
  write_square("square.xyz");
  const Words words = {"sql", "shard-plan", "square.xyz", "-o", "plan", "--shard", "a/base", "b:5433/base"};
  const ProgramResult result = run(words);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "planned 400 points for 2 shards in plan; plan/README.txt lists"))
      << result.err;
  EXPECT_EQ(read("plan/shard_1.copy").size(), read("plan/shard_2.copy").size());
  EXPECT_TRUE(contains(run(words).err, "the folder exists"));
  const ProgramResult unnamed =
      run({"sql", "shard-plan", "square.xyz", "-o", "more", "--shard", "a/base", "--table", ""});
  EXPECT_EQ(unnamed.exit_code, 2);
  EXPECT_TRUE(contains(unnamed.err, "invalid table name")) << unnamed.err;
}

}  // namespace
}  // namespace alidade::test
