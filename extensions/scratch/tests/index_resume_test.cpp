// SPDX-License-Identifier: MIT
// Index files of clouds that memory need not hold, made in runs that are killed, interrupted, or fill the
// disk.
#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <thread>

#include "tests/support/random.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

using Clock = std::chrono::steady_clock;

class IndexResumeTest : public ProgramTest {
 protected:
  /// LAZ files side by side: reading resumes behind the last one that was kept, or within one of many chunks.
  void make_tiles(int count, int points) {
    for (int i = 0; i < count; ++i) {
      const std::string name = fmt::format("tile{}.laz", i);
      ASSERT_EQ(run({"generate", "courtyard", "--points", std::to_string(points), "--seed", std::to_string(i),
                     "-o", name, "-q"})
                    .exit_code,
                0);
      index_.insert(index_.begin() + 1, name);
    }
  }

  void make_whole() {
    const auto start = Clock::now();
    const ProgramResult result = run(with(index_, {"-o", "whole.alidade"}));
    ASSERT_EQ(result.exit_code, 0) << result.err;
    duration_ = Clock::now() - start;
  }

  /// Where runs are killed.
  enum class Phase { anywhere, reading, building, writing };

  bool has_reached(Phase phase, const Program& program) const {
    switch (phase) {
      case Phase::anywhere:
        return true;
      case Phase::reading:
        return has_points();
      case Phase::building:
        return contains(program.errors_so_far(), "reading: ");
      case Phase::writing:
        break;
    }
    const Words all = names();
    return std::ranges::any_of(all, [](const std::string& name) { return name.starts_with(".out.part-"); });
  }

  void wait_for(Phase phase, const Program& program) const {
    const auto limit = Clock::now() + std::chrono::minutes(1);
    while (program.running() && !has_reached(phase, program) && Clock::now() < limit)
      std::this_thread::sleep_for(std::chrono::microseconds(200));
  }

  /// Kills a run at some moment of a phase; whether it came in time.
  bool killed(const Words& words, Phase phase, Random& random) {
    Program program(words, folder);
    wait_for(phase, program);
    const auto most = std::chrono::duration_cast<std::chrono::microseconds>(duration_).count();
    const auto share = static_cast<std::uint64_t>(phase == Phase::anywhere ? most : most / 20);
    std::this_thread::sleep_for(std::chrono::microseconds(random.below(share)));
    program.send(SIGKILL);
    const ProgramResult result = program.wait();
    resumed_ += contains(result.err, "alidade: resuming from state: ") ? 1 : 0;
    return result.signal == SIGKILL;
  }

  void kill_and_resume(int kills) {
    ASSERT_NO_FATAL_FAILURE(make_whole());
    Random random;
    const Words keep = with(index_, with(k_keep, {"-o", "out.alidade"}));
    constexpr std::array k_phases = {Phase::reading, Phase::building, Phase::writing, Phase::anywhere};
    int count = 0;
    for (int attempt = 0; count < kills && attempt < 4 * kills; ++attempt)
      count += killed(keep, k_phases[static_cast<std::size_t>(attempt) % k_phases.size()], random) ? 1 : 0;
    EXPECT_GT(count, 0);
    const bool resumes = has_points();
    const ProgramResult last = run(keep);
    ASSERT_EQ(last.exit_code, 0) << last.err;
    EXPECT_EQ(contains(last.err, "alidade: resuming from state: "), resumes) << last.err;
    EXPECT_GT(resumed_ + (resumes ? 1 : 0), 0);
    expect_whole_and_nothing_else();
  }

  /// Whether the checkpoint has points.
  bool has_points() const { return contains(read("state/manifest"), "positions"); }

  void expect_whole_and_nothing_else() {
    EXPECT_TRUE(read("out.alidade") == read("whole.alidade"));
    Words all = names();
    std::erase_if(all, [](const std::string& name) { return name.starts_with("tile"); });
    EXPECT_EQ(all, (Words{"out.alidade", "whole.alidade"}));
  }

  /// Leaves a checkpoint with points in it, of a run whose index the disk does not hold.
  void leave_checkpoint(const Words& more = {}) {
    const ProgramResult result =
        run_on_full_disk(with(index_, with({"-o", "out.alidade", "--checkpoint", "state"}, more)), 1'500'000);
    ASSERT_EQ(result.exit_code, 2) << result.err;
    EXPECT_TRUE(contains(result.err, "saved to state; the same command with --resume continues"))
        << result.err;
    ASSERT_TRUE(has_points());
  }

  Words index_ = {"index", "--memory", "1M"};
  const Words k_keep = {"--checkpoint", "state", "--checkpoint-interval", "0.001", "--resume", "--overwrite"};
  Clock::duration duration_{};
  int resumed_ = 0;  ///< killed runs that had points of those before
};

TEST_F(IndexResumeTest, killed_runs_end_with_the_same_bytes) {
  make_tiles(4, 40'000);
  kill_and_resume(3);
}

/// On the list of slow tests.
TEST_F(IndexResumeTest, many_killed_runs_of_a_large_file_end_with_the_same_bytes) {
  make_tiles(2, 1'500'000);
  kill_and_resume(10);
}

TEST_F(IndexResumeTest, resumes_behind_every_tile) {
  make_tiles(3, 40'000);
  write("tile.csv",
        "x,y,z,red,green,blue,height\n690000,5325000,600,1,2,3,0.5\n690001,5325000,600,7,8,9,1.5\n");
  index_.insert(index_.begin() + 1, "tile.csv");
  make_whole();
  // The disk holds one column of doubles more each time.
  int resumed = 0;
  for (const std::uint64_t size : {200'000u, 700'000u, 1'300'000u, 2'500'000u}) {
    const ProgramResult result = run_on_full_disk(with(index_, with(k_keep, {"-o", "out.alidade"})), size);
    ASSERT_EQ(result.exit_code, 2) << result.err;
    resumed += contains(result.err, "alidade: resuming from state: ") ? 1 : 0;
    EXPECT_FALSE(std::filesystem::exists(folder / "out.alidade"));
  }
  EXPECT_GT(resumed, 1);
  const ProgramResult last = run(with(index_, with(k_keep, {"-o", "out.alidade"})));
  ASSERT_EQ(last.exit_code, 0) << last.err;
  EXPECT_TRUE(contains(last.err, "120002 points are read")) << last.err;
  expect_whole_and_nothing_else();
}

TEST_F(IndexResumeTest, rejects_other_inputs_options_and_folders) {
  make_tiles(1, 60'000);
  ASSERT_NO_FATAL_FAILURE(leave_checkpoint());
  const Words words = with(index_, {"-o", "out.alidade", "--checkpoint", "state"});
  const auto expect_error = [&](const Words& all, const std::string& part) {
    const ProgramResult result = run(all);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(contains(result.err, part)) << result.err;
    EXPECT_TRUE(has_points());
  };
  expect_error(words, "state: the folder exists; expected --resume to continue from it, or --overwrite");
  expect_error(
      with(words, {"--resume", "--color-depth", "16"}),
      "state: this checkpoint belongs to another run: it has --color-depth none, this run has 16; expected "
      "the same cloud and options, or no --resume");
  const std::filesystem::path tile = folder / "tile0.laz";
  const auto changed = std::filesystem::last_write_time(tile);
  std::filesystem::last_write_time(tile, changed + std::chrono::seconds(1));
  expect_error(with(words, {"--resume"}), "tile0.laz ");
  expect_error(with(words, {"--resume"}), " bytes, changed 20");
  std::filesystem::last_write_time(tile, changed);
  std::filesystem::resize_file(folder / "state" / "rows-positions", 1000);
  expect_error(with(words, {"--resume"}),
               "state: corrupt checkpoint: truncated file rows-positions; expected at least");
  std::string manifest = read("state/manifest");
  manifest.back() = static_cast<char>(manifest.back() ^ 1);
  write("state/manifest", manifest);
  expect_error(with(words, {"--resume"}), "manifest:byte 24: corrupt checkpoint: wrong header checksum");
  expect_error(with(words, {"--resume"}), "or --overwrite without --resume to start again");
  manifest.back() = static_cast<char>(manifest.back() ^ 1);
  write("state/manifest", manifest);
  write("state/letter", "dear");
  expect_error(with(words, {"--overwrite"}), "state: not an index checkpoint");
  std::filesystem::remove(folder / "state" / "letter");
  EXPECT_EQ(run(with(words, {"--overwrite"})).exit_code, 0);
  EXPECT_EQ(names(), (Words{"out.alidade", "tile0.laz"}));
}

TEST_F(IndexResumeTest, a_checkpoint_holds_no_absolute_path_and_knows_its_files) {
  make_tiles(1, 60'000);
  const std::filesystem::path tile = folder / index_[1];
  index_[1] = tile;
  ASSERT_NO_FATAL_FAILURE(leave_checkpoint());
  EXPECT_FALSE(contains(read("state/manifest"), folder.string()));
  EXPECT_TRUE(contains(read("state/manifest"), "tile0.laz in folder "));
  // A file of the same name, size and time in another folder is another one.
  std::filesystem::create_directory(folder / "other");
  std::filesystem::rename(tile, folder / "other" / "tile0.laz");
  index_[1] = folder / "other" / "tile0.laz";
  const Words words = with(index_, {"-o", "out.alidade", "--checkpoint", "state"});
  const ProgramResult other = run(with(words, {"--resume"}));
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_TRUE(contains(other.err, "this checkpoint belongs to another run: it has tile0.laz in folder "))
      << other.err;
  EXPECT_FALSE(contains(other.err, folder.string() + "/tile0")) << other.err;
  std::filesystem::rename(folder / "other" / "tile0.laz", tile);
  index_[1] = "tile0.laz";
  const ProgramResult same = run(with(index_, {"-o", "out.alidade", "--checkpoint", "state", "--resume"}));
  EXPECT_TRUE(contains(same.err, "resuming from state: ")) << same.err;
}

TEST_F(IndexResumeTest, changed_rows_are_an_error) {
  make_tiles(1, 60'000);
  ASSERT_NO_FATAL_FAILURE(leave_checkpoint());
  std::string rows = read("state/rows-positions");
  rows[rows.size() / 2] = static_cast<char>(rows[rows.size() / 2] ^ 1);
  write("state/rows-positions", rows);
  const Words words = with(index_, {"-o", "out.alidade", "--checkpoint", "state"});
  const ProgramResult result = run(with(words, {"--resume"}));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "state: corrupt checkpoint: wrong checksum of rows-positions"))
      << result.err;
  EXPECT_FALSE(contains(result.err, "saved to state")) << result.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "out.alidade"));
  EXPECT_EQ(run(with(words, {"--overwrite"})).exit_code, 0);
}

TEST_F(IndexResumeTest, files_of_the_user_stay) {
  make_tiles(1, 2'000);
  const auto expect_rejected = [&](const std::string& kept, const Words& words, const std::string& part) {
    const std::string before = read(kept);
    const ProgramResult result = run(with(words, {"--resume", "--overwrite"}));
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(contains(result.err, part)) << result.err;
    EXPECT_EQ(read(kept), before);
    EXPECT_FALSE(std::filesystem::exists(folder / "out.alidade"));
  };
  std::filesystem::create_directory(folder / "survey");
  std::filesystem::copy_file(folder / "tile0.laz", folder / "survey" / "rows-1.laz");
  const auto index = [](const std::string& input, const std::string& checkpoint) {
    return Words{"index", input, "--memory", "1M", "-o", "out.alidade", "--checkpoint", checkpoint};
  };
  expect_rejected("survey/rows-1.laz", index("survey/rows-1.laz", "survey"),
                  "survey: the checkpoint holds the input survey/rows-1.laz; expected another folder");
  std::filesystem::create_symlink("survey/rows-1.laz", folder / "link.laz");
  expect_rejected("survey/rows-1.laz", index("link.laz", "survey"), "survey: the checkpoint holds the input");
  expect_rejected("survey/rows-1.laz", index("tile0.laz", "survey"), "survey: not an index checkpoint");
  for (const std::string name : {"rows-2024.csv", "manifest"}) {
    std::filesystem::create_directory(folder / "notes");
    write("notes/" + name, "precious");
    expect_rejected("notes/" + name, index("tile0.laz", "notes"), "notes: not an index checkpoint");
    std::filesystem::remove_all(folder / "notes");
  }
  ASSERT_EQ(run({"sql", "load", "tile0.laz", "site.db"}).exit_code, 0);
  expect_rejected("site.db", index("site.db", "state"),
                  "site.db: --checkpoint does not find changes of tables");
}

TEST_F(IndexResumeTest, folder_or_link_of_the_user_stays) {
  make_tiles(1, 2'000);
  std::filesystem::create_directory(folder / "disk");
  std::filesystem::create_directory_symlink("disk", folder / "link");
  for (const char* const name : {"disk", "link"}) {
    const ProgramResult result =
        run(with(index_, {"-o", "out.alidade", "--checkpoint", name, "--overwrite"}));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(names(), (Words{"disk", "link", "out.alidade", "tile0.laz"}));
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
    EXPECT_TRUE(std::filesystem::is_empty(folder / "disk"));
  }
}

TEST_F(IndexResumeTest, organisation_memory_and_output_belong_to_the_run_or_not) {
  make_tiles(1, 60'000);
  ASSERT_NO_FATAL_FAILURE(leave_checkpoint({"--organisation", "layered"}));
  ASSERT_EQ(run({"index", "tile0.laz", "--organisation", "layered", "-o", "whole.alidade"}).exit_code, 0);
  const ProgramResult result =
      run({"index", "tile0.laz", "--memory", "2M", "--organisation", "layered", "--threads", "1",
           "--checkpoint", "state", "--resume", "-o", "out.alidade"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "alidade: resuming from state: 60000 points are read")) << result.err;
  expect_whole_and_nothing_else();
}

TEST_F(IndexResumeTest, interrupted_run_says_how_to_resume) {
  make_tiles(3, 200'000);
  ASSERT_NO_FATAL_FAILURE(make_whole());
  const Words keep = with(index_, with(k_keep, {"-o", "out.alidade"}));
  {
    Program program(keep, folder);
    const auto limit = Clock::now() + std::chrono::minutes(1);
    while (program.running() && !has_points() && Clock::now() < limit)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    program.send(SIGINT);
    const ProgramResult result = program.wait();
    ASSERT_EQ(result.exit_code, 130) << result.err;
    EXPECT_TRUE(contains(result.err, "saved to state; the same command with --resume")) << result.err;
    EXPECT_TRUE(has_points());
  }
  ASSERT_EQ(run(keep).exit_code, 0);
  expect_whole_and_nothing_else();
}

TEST_F(IndexResumeTest, full_disk_leaves_nothing_or_what_can_be_resumed) {
  make_tiles(1, 60'000);
  ASSERT_NO_FATAL_FAILURE(make_whole());
  // Sizes at which positions, doubles, sorted points, and the index come to their end.
  for (const std::uint64_t size : {100'000u, 500'000u, 1'100'000u, 2'000'000u}) {
    const ProgramResult result = run_on_full_disk(with(index_, {"-o", "out.alidade"}), size);
    EXPECT_EQ(result.exit_code, 2) << size;
    EXPECT_TRUE(contains(result.err, "File too large")) << result.err;
    EXPECT_EQ(names(), (Words{"tile0.laz", "whole.alidade"})) << size;
    const ProgramResult kept = run_on_full_disk(with(index_, with(k_keep, {"-o", "out.alidade"})), size);
    EXPECT_EQ(kept.exit_code, 2) << size;
    EXPECT_TRUE(contains(kept.err, "File too large")) << kept.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "out.alidade"));
    EXPECT_EQ(run(with(index_, with(k_keep, {"-o", "out.alidade"}))).exit_code, 0);
    expect_whole_and_nothing_else();
    std::filesystem::remove(folder / "out.alidade");
  }
}

}  // namespace
}  // namespace alidade::test
