// SPDX-License-Identifier: MIT
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

class OutputTest : public ProgramTest {
 protected:
  /// Waits until the running program has come so far.
  template <class Condition>
  void wait_until(const Program& program, const Condition& is_so_far) const {
    const auto limit = std::chrono::steady_clock::now() + std::chrono::minutes(5);
    bool is_reached = false;
    while (program.running() && !is_reached && std::chrono::steady_clock::now() < limit) {
      is_reached = is_so_far();
      if (!is_reached) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ASSERT_TRUE(is_reached) << "ended before it could be interrupted, or hangs";
  }

  /// Waits until the program has begun an output beside the files that were there.
  void wait_for_work(const Program& program, std::size_t names_before) const {
    wait_until(program, [&] { return names().size() > names_before; });
  }
};

// So long that no machine ends it before the test does.
const Words k_long_generate = {"generate", "courtyard", "--points", "1e9", "-o", "large.las"};

TEST_F(OutputTest, existing_output_is_kept_without_overwrite_and_replaced_with_it) {
  write_square("square.xyz");
  for (Words words :
       {Words{"generate", "courtyard", "--points", "1000", "-o", "out.las"},
        Words{"render", "--cloud", "square.xyz", "--size=8x8", "--samples=1", "-o", "out.png"}}) {
    const std::string& output = words.back();
    write(output, "precious");
    const ProgramResult rejected = run(words);
    EXPECT_EQ(rejected.exit_code, 2);
    EXPECT_TRUE(contains(rejected.err, "alidade: error: " + output + ": the file exists")) << rejected.err;
    EXPECT_TRUE(contains(rejected.err, "--overwrite")) << rejected.err;
    EXPECT_EQ(read(output), "precious");
    const std::string name = output;
    words.push_back("--overwrite");
    EXPECT_EQ(run(words).exit_code, 0);
    EXPECT_NE(read(name), "precious");
  }
}

TEST_F(OutputTest, file_that_is_read_is_never_replaced_whatever_it_is_called) {
  write_square("cloud.png");
  ASSERT_EQ(run({"index", "cloud.png", "-o", "square.alidade", "-q"}).exit_code, 0);
  write("positions.csv", "x,y,z\n100,200,5\n");
  write("scene.json", R"({"version": 1, "cloud": {"files": ["cloud.png"]}})");
  std::filesystem::create_directory(folder / "sub");
  std::filesystem::create_symlink("positions.csv", folder / "link.csv");
  std::filesystem::create_hard_link(folder / "positions.csv", folder / "twin.csv");
  const Words query = {"query", "cloud.png", "--points", "positions.csv", "--overwrite", "-o"};
  for (const Words& words :
       {with(query, {"positions.csv"}), with(query, {"./positions.csv"}),
        with(query, {"sub/../positions.csv"}), with(query, {(folder / "positions.csv").string()}),
        with(query, {"link.csv"}), with(query, {"twin.csv"}), with(query, {"cloud.png", "--format", "csv"}),
        Words{"query", "square.alidade", "--point", "1,2,3", "--overwrite", "--format", "csv", "-o",
              "square.alidade"},
        Words{"index", "square.alidade", "--overwrite", "-o", "square.alidade"},
        Words{"render", "--cloud", "cloud.png", "--size=8x8", "--samples=1", "--overwrite", "-o",
              "cloud.png"},
        Words{"render", "scene.json", "--size=8x8", "--samples=1", "--overwrite", "-o", "cloud.png"}}) {
    SCOPED_TRACE(::testing::PrintToString(words));
    const std::string cloud = read("cloud.png"), positions = read("positions.csv"),
                      index = read("square.alidade");
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(contains(result.err, "the output is also an input")) << result.err;
    EXPECT_EQ(read("cloud.png"), cloud);
    EXPECT_EQ(read("positions.csv"), positions);
    EXPECT_TRUE(read("square.alidade") == index);
  }
}

TEST_F(OutputTest, standard_input_is_never_replaced_either) {
  if (!std::filesystem::exists("/dev/stdin")) GTEST_SKIP() << "this system has no /dev/stdin";
  write_square("square.xyz");
  write("positions.csv", "x,y,z\n100,200,5\n");
  Program program({"query", "square.xyz", "--points", "-", "--overwrite", "-o", "positions.csv"}, folder, {},
                  folder / "positions.csv");
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "positions.csv: the output is also an input")) << result.err;
  EXPECT_EQ(read("positions.csv"), "x,y,z\n100,200,5\n");
}

TEST_F(OutputTest, output_is_checked_before_the_input_is_read) {
  write("out.png", "precious");
  const ProgramResult result = run({"render", "--cloud", "absent.las", "-o", "out.png"});
  EXPECT_TRUE(contains(result.err, "out.png: the file exists")) << result.err;
}

TEST_F(OutputTest, bad_input_leaves_no_output) {
  write("broken.las", "LASF and nothing more");
  EXPECT_EQ(run({"render", "--cloud", "broken.las", "-o", "out.png"}).exit_code, 2);
  EXPECT_EQ(names(), Words{"broken.las"});
}

TEST_F(OutputTest, unknown_kind_of_image_is_rejected_before_the_work) {
  write_square("square.xyz");
  const ProgramResult result = run({"render", "--cloud", "square.xyz", "-o", "out.bmpx"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "out.bmpx")) << result.err;
  EXPECT_FALSE(contains(result.err, "rendering")) << result.err;
  EXPECT_EQ(names(), Words{"square.xyz"});
}

TEST_F(OutputTest, output_into_a_missing_folder_is_an_error) {
  const ProgramResult result = run({"generate", "courtyard", "-o", "absent/out.las"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "absent/out.las")) << result.err;
}

TEST_F(OutputTest, output_into_a_folder_that_takes_no_files_is_an_error) {
  // Not even the superuser may make files here.
  if (!std::filesystem::exists("/proc/self")) GTEST_SKIP() << "this system has no /proc";
  const ProgramResult result = run({"generate", "courtyard", "--points", "1000", "-o", "/proc/out.las"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "/proc/out.las")) << result.err;
}

TEST_F(OutputTest, read_only_folder_is_an_error) {
  if (::geteuid() == 0) GTEST_SKIP() << "the superuser may write into read-only folders";
  std::filesystem::permissions(folder,
                               std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  const ProgramResult result = run({"generate", "courtyard", "--points", "1000", "-o", "out.las"});
  std::filesystem::permissions(folder, std::filesystem::perms::owner_all);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(names(), Words{});
}

TEST_F(OutputTest, devices_are_never_replaced) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  for (const char* const overwrite : {"--quiet", "--overwrite"}) {
    const ProgramResult result =
        run({"generate", "courtyard", "--points", "1000", overwrite, "-o", "/dev/full"});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(contains(result.err, "/dev/full")) << result.err;
    EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
  }
}

TEST_F(OutputTest, interrupted_program_ends_with_130_and_leaves_nothing) {
  for (const int signal : {SIGINT, SIGTERM}) {
    Program program(k_long_generate, folder);
    wait_for_work(program, 0);
    program.send(signal);
    const ProgramResult result = program.wait();
    EXPECT_EQ(result.exit_code, 130) << result.err;
    EXPECT_EQ(names(), Words{});
  }
}

TEST_F(OutputTest, interrupted_render_ends_with_130_and_leaves_nothing) {
  write_square("square.xyz");
  Program program({"render", "--cloud", "square.xyz", "--samples", "20000", "-o", "out.png"}, folder);
  // Beyond loading, so that the interrupt meets the tracer.
  wait_until(program, [&] { return contains(program.errors_so_far(), "loading cloud: "); });
  program.send(SIGINT);
  EXPECT_EQ(program.wait().exit_code, 130);
  EXPECT_EQ(names(), Words{"square.xyz"});
}

TEST_F(OutputTest, interrupted_convert_ends_with_130_and_keeps_what_was_there) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "20000", "-o", "site.las", "-q"}).exit_code, 0);
  write("out.laz", "precious");
  Words words(200, "site.las");
  words.insert(words.begin(), "convert");
  words.insert(words.end(), {"-o", "out.laz", "--overwrite", "--spacing", "0.001"});
  Program program(words, folder);
  // Beyond reading, so that the interrupt meets what thins and writes.
  wait_until(program, [&] { return contains(program.errors_so_far(), "reading: "); });
  program.send(SIGINT);
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_EQ(names(), (Words{"out.laz", "site.las"}));
  EXPECT_EQ(read("out.laz"), "precious");
}

TEST_F(OutputTest, killed_program_leaves_no_output_under_its_name) {
  Program program(k_long_generate, folder);
  wait_for_work(program, 0);
  program.send(SIGKILL);
  EXPECT_EQ(program.wait().signal, SIGKILL);
  EXPECT_FALSE(std::filesystem::exists(folder / "large.las"));
}

}  // namespace
}  // namespace alidade::test
