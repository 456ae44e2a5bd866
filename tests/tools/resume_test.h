// SPDX-License-Identifier: MIT
#pragma once

#include <signal.h>

#include <chrono>
#include <functional>
#include <thread>

#include "tests/support/random.h"
#include "tests/tools/run_program.h"

namespace alidade::test {

/// Long runs of `alidade visibility` that are killed, interrupted and resumed.
class ResumeTest : public ProgramTest {
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
  /// Bytes; 0 if it is missing.
  std::uintmax_t checkpoint_size() const {
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(folder / "state", error);
    return error ? 0 : size;
  }

  /// Until something is finished; checkpoints are to be written in short intervals.
  void wait_for_a_part(const Program& program) const {
    wait_while(program, [&] { return !has_checkpoint(); });
    const std::uintmax_t head = checkpoint_size();
    wait_while(program, [&] { return checkpoint_size() == head; });
  }

  /// Leaves a checkpoint of a command that was interrupted.
  void interrupt(const Words& command) const {
    Program program(with(command, {"--checkpoint-interval", "0.001"}), folder);
    wait_for_a_part(program);
    program.send(SIGINT);
    const ProgramResult result = program.wait();
    ASSERT_EQ(result.exit_code, 130) << result.err;
    EXPECT_TRUE(contains(result.err, "saved to state; the same command with --resume")) << result.err;
  }

  /// Runs a command without interruption; then kills it again and again soon after its checkpoint has grown,
  /// resumes it, and compares all its files.
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
    for (int attempt = 0; attempt < kills || (!has_checkpoint() && attempt < 10 * kills); ++attempt) {
      const std::uintmax_t size = checkpoint_size();
      Program program(cut, folder);
      wait_while(program, [&] { return checkpoint_size() == size; });
      std::this_thread::sleep_for(std::chrono::microseconds(random.below(60'000)));
      program.send(SIGKILL);
      const ProgramResult result = program.wait();
      killed += result.signal == SIGKILL ? 1 : 0;
      resumed += contains(result.err, "alidade: resuming from state: ") ? 1 : 0;
    }
    EXPECT_GT(killed, 0);
    EXPECT_GT(resumed, 0);
    const ProgramResult last = run(cut);
    ASSERT_EQ(last.exit_code, 0) << last.err;
    EXPECT_TRUE(contains(last.err, "alidade: resuming from state: ")) << last.err;
    for (std::size_t i = 1; i < outputs.size(); i += 2)
      EXPECT_TRUE(read(outputs[i]) == read("whole_" + outputs[i])) << outputs[i];
    EXPECT_FALSE(has_checkpoint());
  }

  const Words k_keep = {"--checkpoint", "state", "--checkpoint-interval", "0.001", "--resume", "--overwrite",
                        "--threads",    "1"};
};

}  // namespace alidade::test
