// SPDX-License-Identifier: MIT
// A cloud in a database is taken wherever cloud files are.
#include <algorithm>

#include "tests/tools/program_words.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

class DatabaseCloudTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    ASSERT_EQ(run({"generate", "courtyard", "--points", "20000", "-o", "yard.las"}).exit_code, 0);
    ASSERT_EQ(run({"sql", "load", "yard.las", "yard.db"}).exit_code, 0);
  }

  std::string done(const Words& words) {
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.out;
  }
};

TEST_F(DatabaseCloudTest, answers_and_pictures_are_those_of_the_file) {
  const auto query = [&](const std::string& cloud) {
    return done({"query", cloud, "--ray", "690000,5325000,650,0.01,0,-1", "--radius", "3", "--class", "2"});
  };
  const std::string answers = query("yard.las");
  EXPECT_GT(std::ranges::count(answers, '\n'), 10);
  EXPECT_EQ(query("yard.db"), answers);
  EXPECT_EQ(query("yard.db?table=points"), answers);

  // Pictures say of which cloud they are, so both get one name.
  for (const char* const kind : {"las", "db"}) {
    std::filesystem::rename(folder / (std::string("yard.") + kind), folder / "cloud");
    done({"render", "--cloud", "cloud", "--size", "60x40", "--samples", "2", "-o",
          std::string(kind) + ".png"});
    std::filesystem::rename(folder / "cloud", folder / (std::string("yard.") + kind));
  }
  EXPECT_TRUE(read("db.png") == read("las.png"));
  EXPECT_TRUE(contains(done({"info", "yard.db"}), "20000"));
}

TEST_F(DatabaseCloudTest, what_is_no_cloud_is_told) {
  for (const char* const name : {"yard.db?table=other", "no.db?table=points", "yard.las?table=points"}) {
    const ProgramResult result = run({"info", name});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(contains(result.err, std::string(name).substr(0, 4))) << result.err;
  }
}

}  // namespace
}  // namespace alidade::test
