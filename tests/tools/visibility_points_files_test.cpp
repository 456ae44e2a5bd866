// SPDX-License-Identifier: MIT
// What happens to the files that `visibility points` writes.
#include <signal.h>

#include <chrono>
#include <thread>

#include "tests/tools/garden_site.h"

namespace alidade::test {
namespace {

TEST_F(VisibilityPointsTest, existing_output_is_kept_without_overwrite) {
  write_garden();
  for (const char* const name : {"seen.las", "who.csv"}) {
    write(name, "precious");
    const Words words = with(k_points, {"--observer", k_eye, "-o", "seen.las", "--lists", "who.csv"});
    const ProgramResult rejected = run(words);
    EXPECT_EQ(rejected.exit_code, 2);
    EXPECT_TRUE(contains(rejected.err, std::string(name) + ": the file exists")) << rejected.err;
    EXPECT_EQ(read(name), "precious");
    EXPECT_EQ(run(with(words, {"--overwrite", "-q"})).exit_code, 0);
    EXPECT_NE(read(name), "precious");
    std::filesystem::remove(folder / "seen.las");
    std::filesystem::remove(folder / "who.csv");
  }
}

TEST_F(VisibilityPointsTest, what_is_no_regular_file_is_never_replaced) {
  write_garden();
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  const ProgramResult result =
      run(with(k_points, {"--observer", k_eye, "-o", "seen.las", "--lists", "/dev/full", "--overwrite"}));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "/dev/full: cannot replace the file: not a regular file")) << result.err;
  EXPECT_EQ(names(), Words{"garden.las"});
}

TEST_F(VisibilityPointsTest, a_full_disk_is_an_error_that_leaves_nothing) {
  write_garden();
  const Words words = with(k_points, {"-q", "--observer", k_eye});
  for (const std::string output : {"seen.las", "seen.ply", "who.csv"}) {
    const bool is_list = output == "who.csv";
    const Words whole =
        with(words, is_list ? Words{"-o", "seen.las", "--lists", output} : Words{"-o", output});
    ASSERT_EQ(run(whole).exit_code, 0);
    const std::uintmax_t size = std::filesystem::file_size(folder / output);
    std::filesystem::remove(folder / output);
    std::filesystem::remove(folder / "seen.las");
    // The beginning fits; all but the end fits. Of two files, the other one is as large.
    for (const std::uintmax_t bytes : {std::uintmax_t{4096}, size - 1}) {
      const ProgramResult full = run_on_full_disk(whole, bytes);
      EXPECT_EQ(full.exit_code, 2) << output << " " << bytes;
      EXPECT_TRUE(contains(full.err, ": cannot write the file")) << full.err;
      EXPECT_EQ(names(), Words{"garden.las"}) << output << " " << bytes;
    }
  }
}

TEST_F(VisibilityPointsTest, interrupted_it_ends_with_130_and_leaves_nothing) {
  write_garden();
  // So many observers that no machine ends before it is interrupted.
  Program program(with(k_points, {"--observer-grid", "0.05", "-o", "seen.las", "--lists", "who.csv"}),
                  folder);
  const auto limit = std::chrono::steady_clock::now() + std::chrono::minutes(5);
  while (program.running() && !contains(program.errors_so_far(), "placing observers: ") &&
         std::chrono::steady_clock::now() < limit)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  program.send(SIGINT);
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_EQ(names(), Words{"garden.las"});
}

}  // namespace
}  // namespace alidade::test
