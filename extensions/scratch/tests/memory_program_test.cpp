// SPDX-License-Identifier: MIT
// Commands on clouds that memory need not hold.
#include <cstdlib>
#include <utility>

#include "tests/tools/resume_test.h"

namespace alidade::test {
namespace {

class MemoryProgramTest : public ProgramTest {
 protected:
  void make_site() {
    ASSERT_EQ(run({"generate", "courtyard", "--points", "200000", "-o", "site.las", "-q"}).exit_code, 0);
  }
};

TEST_F(MemoryProgramTest, states_what_the_disk_has_to_hold) {
  make_site();
  const ProgramResult result = run({"index", "site.las", "-o", "site.alidade", "--memory", "1M"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.err.find("up to 13.4 MB of temporary files in ., where"), std::string::npos) << result.err;
  EXPECT_EQ(names(), (Words{"site.alidade", "site.las"}));
}

TEST_F(MemoryProgramTest, leaves_nothing_on_a_full_disk) {
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

TEST_F(MemoryProgramTest, rejects_what_needs_memory) {
  make_site();
  const ProgramResult result =
      run({"index", "site.las", "-o", "site.alidade", "--memory", "1M", "--stored-order"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("--memory excludes"), std::string::npos) << result.err;
  EXPECT_EQ(run({"index", "site.las", "-o", "site.alidade", "--memory", "1k"}).exit_code, 2);
}

TEST_F(MemoryProgramTest, information_needs_a_folder_for_temporary_files) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "60000", "-o", "site.laz", "-q"}).exit_code, 0);
  const char* const given = std::getenv("TMPDIR");
  const std::string before = given ? given : "";
  ::setenv("TMPDIR", "/nonexistent", 1);
  const ProgramResult nowhere = run({"info", "site.laz", "--memory", "1M"});
  given ? ::setenv("TMPDIR", before.c_str(), 1) : ::unsetenv("TMPDIR");
  EXPECT_EQ(nowhere.exit_code, 2);
  EXPECT_TRUE(contains(nowhere.err,
                       "/nonexistent: no folder for temporary files; expected the environment variable "
                       "TMPDIR to name a folder"))
      << nowhere.err;
}

TEST_F(MemoryProgramTest, details_of_information_are_for_those_who_request_them) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "60000", "-o", "site.laz", "-q"}).exit_code, 0);
  const Words words = {"info", "site.laz", "--memory", "1M", "--stats"};
  EXPECT_EQ(run(words).err, "");
  const std::string details = run(with(words, {"-v"})).err;
  for (const char* const part : {"of temporary files in ", "reading: ", "counting: "})
    EXPECT_TRUE(contains(details, part)) << details;
}

TEST_F(MemoryProgramTest, visibility_has_the_same_bytes) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "8000", "-o", "site.las", "-q"}).exit_code, 0);
  const Words eye = {"--observer", "689995,5324988,601.7"};
  // Samples of a ground of many cells and their sums lie in files.
  const std::pair<Words, std::string> cases[] = {
      {with({"visibility", "raster", "site.las", "--resolution", "1"}, eye), ".tif"},
      {with({"visibility", "raster", "site.las", "--ground-cell", "0.1", "--mode", "height"}, eye), ".tif"},
      {with({"visibility", "points", "site.las"}, eye), ".las"}};
  for (const auto& [words, extension] : cases) {
    ASSERT_EQ(run(with(words, {"-q", "--overwrite", "-o", "whole" + extension})).exit_code, 0);
    const ProgramResult parts =
        run(with(words, {"-q", "--overwrite", "-o", "parts" + extension, "--memory", "1M"}));
    ASSERT_EQ(parts.exit_code, 0) << parts.err;
    EXPECT_TRUE(read("parts" + extension) == read("whole" + extension)) << extension;
  }
}

TEST_F(ResumeTest, other_memory_is_the_same_run) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "600", "--seed", "1", "-o", "site.las"}).exit_code, 0);
  const Words asked = {"visibility", "points", "site.las", "--observer-grid", "25", "--fraction", "30"};
  ASSERT_EQ(run(with(asked, {"-o", "whole.las"})).exit_code, 0);
  const Words keep = with(asked, {"--checkpoint", "state", "--checkpoint-interval", "0.001"});
  Program program(with(keep, {"-o", "a.las", "--threads", "1"}), folder);
  wait_for_a_part(program);
  program.send(SIGKILL);
  ASSERT_EQ(program.wait().signal, SIGKILL);
  const ProgramResult resumed = run(with(keep, {"--resume", "-o", "b.las", "--memory", "2M"}));
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_TRUE(contains(resumed.err, "resuming from state: ")) << resumed.err;
  EXPECT_TRUE(read("b.las") == read("whole.las"));
}

}  // namespace
}  // namespace alidade::test
