// SPDX-License-Identifier: MIT
// alidade convert to Parquet. For what is in the files see parquet_test.cpp.
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

class ConvertToParquetTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    ASSERT_EQ(run({"generate", "courtyard", "--points", "60000", "-o", "site.las", "-q"}).exit_code, 0);
    write("plain.xyz", "690002 5325000.25 601\n690003 5325000.5 602\n");
  }
};

TEST_F(ConvertToParquetTest, bytes_do_not_depend_on_memory) {
  const std::vector<Words> cases = {{"site.las", "plain.xyz"}, {"site.las", "--spacing", "0.5"}};
  for (const Words& words : cases) {
    for (const char* const memory : {"1G", "1M"}) {
      Words all = {"convert", "-o", std::string(memory) + ".parquet", "--memory", memory, "--overwrite"};
      all.insert(all.end(), words.begin(), words.end());
      const ProgramResult result = run(all);
      ASSERT_EQ(result.exit_code, 0) << result.err;
      // Points that are all written are sorted in any case.
      EXPECT_EQ(contains(result.err, "the points exceed --memory"),
                words.size() > 2 && std::string(memory) == "1M")
          << result.err;
    }
    EXPECT_TRUE(read("1G.parquet") == read("1M.parquet")) << words.back();
  }
}

TEST_F(ConvertToParquetTest, its_options_are_for_no_other_format) {
  for (const Words& option : {Words{"--geometry"}, Words{"--group-points", "2048"}}) {
    Words words = {"convert", "site.las", "-o", "out.las"};
    words.insert(words.end(), option.begin(), option.end());
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(contains(result.err,
                         "out.las: " + option.front() + " requires Parquet; expected the extension .parquet"))
        << result.err;
  }
}

TEST_F(ConvertToParquetTest, on_a_full_disk_nothing_is_left) {
  const ProgramResult result = run_on_full_disk({"convert", "site.las", "-o", "out.parquet", "-q"}, 100000);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "out.parquet")) << result.err;
  EXPECT_EQ(names(), (Words{"plain.xyz", "site.las"}));
}

}  // namespace
}  // namespace alidade::test
