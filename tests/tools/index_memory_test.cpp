// SPDX-License-Identifier: MIT
// Index files of clouds that memory need not hold.
#include "tests/tools/run_program.h"
#include "tools/command.h"

namespace alidade::test {
namespace {

class IndexMemoryTest : public ProgramTest {
 protected:
  void make_site() {
    ASSERT_EQ(run({"generate", "courtyard", "--points", "200000", "-o", "site.las", "-q"}).exit_code, 0);
  }
};

TEST_F(IndexMemoryTest, is_asked_by_more_threads_than_cores_if_memory_does_not_hold_it) {
  write("big.alidade", std::string(1000, ' '));
  const std::string file = (folder / "big.alidade").string();
  const Words render = {"alidade", "render", file, "-o", "picture.png"};
  EXPECT_GE(tools::enough_threads(render, 999), 8);
  EXPECT_FALSE(tools::enough_threads(render, 1000));
  EXPECT_FALSE(tools::enough_threads(Words{"alidade", "convert", file}, 999));
  EXPECT_FALSE(tools::enough_threads(Words{"alidade", "render", file + ".las"}, 999));
}

TEST_F(IndexMemoryTest, states_what_the_disk_has_to_hold) {
  make_site();
  const ProgramResult result = run({"index", "site.las", "-o", "site.alidade", "--memory", "1M"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.err.find("up to 13.4 MB of temporary files in ., where"), std::string::npos) << result.err;
  EXPECT_EQ(names(), (Words{"site.alidade", "site.las"}));
}

TEST_F(IndexMemoryTest, leaves_nothing_on_a_full_disk) {
  make_site();
  // The first cannot hold the points in Morton order, the second the index.
  for (const std::uint64_t size : {std::uint64_t{1} << 20, std::uint64_t{5} << 20}) {
    const ProgramResult result =
        run_on_full_disk({"index", "site.las", "-o", "site.alidade", "--memory", "1M", "-q"}, size);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.err.find("alidade: error: "), 0u) << result.err;
    EXPECT_EQ(names(), (Words{"site.las"}));
  }
}

TEST_F(IndexMemoryTest, rejects_what_needs_memory) {
  make_site();
  const ProgramResult result =
      run({"index", "site.las", "-o", "site.alidade", "--memory", "1M", "--stored-order"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("--memory excludes"), std::string::npos) << result.err;
  EXPECT_EQ(run({"index", "site.las", "-o", "site.alidade", "--memory", "1k"}).exit_code, 2);
}

}  // namespace
}  // namespace alidade::test
