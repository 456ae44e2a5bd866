// SPDX-License-Identifier: MIT
// Long runs of `alidade visibility` that are killed, interrupted and gone on with.
#include <signal.h>

#include <chrono>
#include <functional>
#include <thread>

#include "tests/support/random.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

using Words = std::vector<std::string>;

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

Words with(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

class VisibilityResumeTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_square("square.xyz");
  }

  void wait_while(const Program& program, const std::function<bool()>& condition) const {
    const auto limit = std::chrono::steady_clock::now() + std::chrono::minutes(2);
    while (program.running() && condition() && std::chrono::steady_clock::now() < limit)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  bool has_checkpoint() const { return std::filesystem::exists(folder / "state"); }
  /// Bytes; 0 if there is none.
  std::uintmax_t checkpoint_size() const {
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(folder / "state", error);
    return error ? 0 : size;
  }

  /// Runs a command whole; then kills it again and again soon after its checkpoint has grown, goes on from
  /// that, and compares all its files.
  void kill_and_resume(const Words& command, const Words& outputs, int kills) {
    Words whole = command, cut = with(command, k_keep);
    for (std::size_t i = 0; i + 1 < outputs.size(); i += 2) {
      whole = with(whole, {outputs[i], "whole_" + outputs[i + 1]});
      cut = with(cut, {outputs[i], outputs[i + 1]});
    }
    const ProgramResult uninterrupted = run(whole);
    ASSERT_EQ(uninterrupted.exit_code, 0) << uninterrupted.err;
    Random random;
    int resumed = 0, killed = 0;
    for (int attempt = 0; attempt < kills; ++attempt) {
      const std::uintmax_t size = checkpoint_size();
      Program program(cut, folder);
      wait_while(program, [&] { return checkpoint_size() == size; });
      std::this_thread::sleep_for(std::chrono::microseconds(random.below(60'000)));
      program.send(SIGKILL);
      const ProgramResult result = program.wait();
      killed += result.signal == SIGKILL ? 1 : 0;
      resumed += contains(result.err, "alidade: going on from state: ") ? 1 : 0;
    }
    EXPECT_GT(killed, 0);
    EXPECT_GT(resumed, 0);
    const ProgramResult last = run(cut);
    ASSERT_EQ(last.exit_code, 0) << last.err;
    for (std::size_t i = 1; i < outputs.size(); i += 2)
      EXPECT_TRUE(read(outputs[i]) == read("whole_" + outputs[i])) << outputs[i];
    EXPECT_FALSE(has_checkpoint());
  }

  const Words k_keep = {"--checkpoint", "state", "--checkpoint-interval", "0.001", "--resume", "--overwrite",
                        "--threads",    "1"};
};

const Words k_points = {"visibility", "points", "square.xyz"};

TEST_F(VisibilityResumeTest, points_killed_at_many_moments_give_the_bytes_of_an_uninterrupted_run) {
  kill_and_resume(with(k_points, {"--observer-grid", "0.3", "--fraction", "99", "--blockers", "all"}),
                  {"-o", "seen.las", "--lists", "who.csv"}, 12);
}

TEST_F(VisibilityResumeTest, places_killed_at_many_moments_give_the_bytes_of_an_uninterrupted_run) {
  kill_and_resume({"visibility", "place", "square.xyz", "--observer-grid", "0.03", "--target-spacing", "0.1",
                   "--count", "3"},
                  {"-o", "places.json"}, 12);
}

TEST_F(VisibilityResumeTest, interrupted_it_keeps_a_checkpoint_and_ends_with_130) {
  const Words words = with(
      k_points, {"--observer-grid", "0.05", "--fraction", "255", "-o", "seen.las", "--checkpoint", "state"});
  Program program(words, folder);
  wait_while(program, [&] { return !has_checkpoint(); });
  program.send(SIGINT);
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_TRUE(contains(result.err, "state keeps what has been computed; the same command with --resume"))
      << result.err;
  EXPECT_EQ(names(), (Words{"square.xyz", "state"}));

  const ProgramResult refused = run(words);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_TRUE(contains(refused.err, "state: exists already; expected --resume")) << refused.err;
  const ProgramResult other = run(with(words, {"--resume", "--transparency", "2"}));
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_TRUE(contains(other.err,
                       "state: is the checkpoint of another run: made with --transparency none, asked for 2"))
      << other.err;
  write("square.xyz", read("square.xyz") + "101 201 5.5\n");
  const ProgramResult cloud = run(with(words, {"--resume"}));
  EXPECT_EQ(cloud.exit_code, 2);
  EXPECT_TRUE(contains(cloud.err, "made with number of points 400, asked for 401")) << cloud.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "seen.las"));
}

TEST_F(VisibilityResumeTest, other_outputs_and_threads_are_the_same_run_another_reference_system_is_not) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "600", "--seed", "1", "-o", "site.las"}).exit_code, 0);
  const Words asked = {"visibility", "points", "site.las", "--observer-grid", "25", "--fraction", "30"};
  const Words whole = {"-o", "whole.las", "--lists", "whole.csv", "--threads", "1"};
  ASSERT_EQ(run(with(asked, whole)).exit_code, 0);
  const Words keep = with(asked, {"--checkpoint", "state", "--checkpoint-interval", "0.001"});
  Program program(with(keep, {"-o", "a.las", "--lists", "a.csv", "--threads", "1"}), folder);
  wait_while(program, [&] { return !has_checkpoint(); });
  const std::uintmax_t head = checkpoint_size();
  wait_while(program, [&] { return checkpoint_size() == head; });
  program.send(SIGKILL);
  ASSERT_EQ(program.wait().signal, SIGKILL);

  const Words others = with(keep, {"--resume", "-o", "b.las", "--lists", "b.csv", "--threads", "2"});
  const std::string site = read("site.las");
  std::string moved = site;
  const std::size_t zone = moved.find("zone 32N");
  ASSERT_NE(zone, std::string::npos);
  moved[zone + 6] = '3';
  write("site.las", moved);
  const ProgramResult refused = run(others);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_TRUE(contains(refused.err, "state: is the checkpoint of another run: made with reference system "))
      << refused.err;

  write("site.las", site);
  const ProgramResult resumed = run(others);
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_TRUE(contains(resumed.err, "alidade: going on from state: ")) << resumed.err;
  EXPECT_TRUE(read("b.las") == read("whole.las"));
  EXPECT_TRUE(read("b.csv") == read("whole.csv"));
}

TEST_F(VisibilityResumeTest, without_a_checkpoint_yet_resume_starts_and_says_so) {
  const Words words = with(k_points, {"--observer", "101,201,7"});
  ASSERT_EQ(run(with(words, {"-o", "whole.las"})).exit_code, 0);
  const ProgramResult result = run(with(with(words, k_keep), {"-o", "out.las"}));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "there is no checkpoint state yet: starting afresh")) << result.err;
  EXPECT_TRUE(read("out.las") == read("whole.las"));
  EXPECT_EQ(names(), (Words{"out.las", "square.xyz", "whole.las"}));
}

TEST_F(VisibilityResumeTest, file_that_is_no_checkpoint_is_never_replaced_by_one) {
  write("notes.txt", "precious");
  for (const std::string flag : {"--overwrite", "--resume"}) {
    const ProgramResult refused =
        run(with(k_points, {"--observer", "101,201,7", "-o", "out.las", "--checkpoint", "notes.txt", flag}));
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_TRUE(contains(refused.err, "notes.txt:byte 0: is not a checkpoint of such a run")) << refused.err;
    EXPECT_EQ(read("notes.txt"), "precious");
  }
  const ProgramResult same =
      run(with(k_points, {"--observer", "101,201,7", "-o", "out.las", "--checkpoint", "./out.las"}));
  EXPECT_EQ(same.exit_code, 2);
  EXPECT_TRUE(contains(same.err, "./out.las: is an output to write")) << same.err;
}

TEST_F(VisibilityResumeTest, lines_killed_at_many_moments_give_the_bytes_of_an_uninterrupted_run) {
  std::string places = "x,y,z\n";
  for (int i = 0; i < 12; ++i)
    places += std::to_string(100.0 + 0.1 * i) + "," + std::to_string(200.0 + 0.07 * i) + ",5.3\n";
  write("places.csv", places);
  kill_and_resume({"visibility", "lines", "square.xyz", "--places", "places.csv", "--frequency", "60GHz"},
                  {"-o", "lines.json"}, 12);
}

}  // namespace
}  // namespace alidade::test
