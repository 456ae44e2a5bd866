// SPDX-License-Identifier: MIT
#include "extensions/scratch/scratch_checkpoint.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <fstream>
#include <iterator>
#include <vector>

#include "base/error.h"
#include "base/fingerprint.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

class ScratchCheckpointTest : public ::testing::Test {
 protected:
  ScratchCheckpointTest() : folder_(fs::path(testing::TempDir()) / "scratch_checkpoint_test") {
    fs::remove_all(folder_);
    fs::create_directory(folder_);
  }
  ~ScratchCheckpointTest() override { fs::remove_all(folder_); }

  ScratchCheckpoint open(const fs::path& state, bool resume = true) const {
    return {{.file = state, .resume = resume}, {{"test", "1"}}};
  }

  /// Leaves a checkpoint of 10 rows of a byte.
  void leave_rows(const fs::path& state) const {
    ScratchCheckpoint checkpoint = open(state);
    KeptFile rows = checkpoint.file("positions");
    rows.append(std::array<std::byte, 10>{std::byte{1}});
    checkpoint.keep(10, std::vector<ScratchCheckpoint::Kept>{{"positions", &rows, 10}});
    ASSERT_EQ(checkpoint.rows(), 10u);
  }

  template <class Work>
  static std::string error_of(const Work& work) {
    try {
      work();
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  }
  static void write(const fs::path& file) { std::ofstream(file) << "precious"; }
  static std::string read(const fs::path& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  fs::path folder_;
};

TEST_F(ScratchCheckpointTest, never_touches_files_of_the_user) {
  const auto expect_kept = [&](const fs::path& state, const std::string& name) {
    write(state / name);
    EXPECT_FALSE(is_scratch_checkpoint(state)) << name;
    for (const bool resume : {false, true})
      EXPECT_NE(error_of([&] { open(state, resume); }).find("not a checkpoint of kept rows"),
                std::string::npos)
          << name;
    EXPECT_EQ(read(state / name), "precious") << name;
    fs::remove(state / name);
  };
  fs::create_directory(folder_ / "empty");
  for (const char* const name :
       {"manifest", "rows-1.laz", "rows-2024.csv", "rows-positions", "rows-attribute-1"})
    expect_kept(folder_ / "empty", name);
  leave_rows(folder_ / "state");
  for (const char* const name : {"rows-2024.csv", "rows-attribute-", "rows-attribute-1a",
                                 ".manifest.part-mine", ".manifest.part-1-", ".alidade-notes"})
    expect_kept(folder_ / "state", name);
  write(folder_ / "precious");
  fs::create_symlink(folder_ / "precious", folder_ / "state" / "rows-attribute-1");
  EXPECT_NE(error_of([&] { open(folder_ / "state"); }), "");
  EXPECT_EQ(read(folder_ / "precious"), "precious");
}

TEST_F(ScratchCheckpointTest, takes_what_a_killed_run_left) {
  leave_rows(folder_ / "state");
  for (const char* const name : {"rows-attribute-3", ".manifest.part-123-0", ".alidade-a1B2c3"})
    write(folder_ / "state" / name);
  EXPECT_EQ(open(folder_ / "state").rows(), 10u);
  EXPECT_FALSE(open(folder_ / "state", false).resumes());
  EXPECT_FALSE(fs::exists(folder_ / "state" / "rows-positions"));
  EXPECT_FALSE(fs::exists(folder_ / "state" / ".alidade-a1B2c3"));
  ScratchCheckpoint none = open(folder_ / "state");
  EXPECT_TRUE(none.resumes());
  EXPECT_EQ(none.rows(), 0u);
  none.remove();
  fs::create_directory(folder_ / "begun");
  write(folder_ / "begun" / ".manifest.part-123-0");
  EXPECT_FALSE(open(folder_ / "begun").resumes());
}

TEST_F(ScratchCheckpointTest, removes_the_folder_only_if_it_made_it) {
  leave_rows(folder_ / "state");
  open(folder_ / "state").remove();
  EXPECT_FALSE(fs::exists(folder_ / "state"));
  leave_rows(folder_ / "state");
  open(folder_ / "state", false).remove();
  EXPECT_FALSE(fs::exists(folder_ / "state"));
  fs::create_directory(folder_ / "own");
  fs::create_directory_symlink("own", folder_ / "link");
  leave_rows(folder_ / "link");
  open(folder_ / "link").remove();
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_TRUE(fs::is_empty(folder_ / "own"));
  // One that it made, and the user moved.
  leave_rows(folder_ / "made");
  fs::rename(folder_ / "made", folder_ / "moved");
  fs::create_directory_symlink("moved", folder_ / "made");
  open(folder_ / "made").remove();
  EXPECT_TRUE(fs::is_symlink(folder_ / "made"));
}

TEST_F(ScratchCheckpointTest, finds_changed_bytes) {
  leave_rows(folder_ / "state");
  {
    std::fstream file(folder_ / "state" / "rows-positions", std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(5).put('x');
  }
  const std::string manifest = read(folder_ / "state" / "manifest");
  ScratchCheckpoint checkpoint = open(folder_ / "state");
  const std::string error = error_of([&] { checkpoint.file("positions"); });
  EXPECT_NE(error.find("corrupt checkpoint: wrong checksum of rows-positions"), std::string::npos) << error;
  EXPECT_NE(error.find("or --overwrite without --resume to start again"), std::string::npos) << error;
  EXPECT_TRUE(checkpoint.is_corrupt());
  checkpoint.keep(20, {});
  EXPECT_EQ(read(folder_ / "state" / "manifest"), manifest);
}

TEST_F(ScratchCheckpointTest, an_interrupted_comparison_ends_at_once_and_keeps_the_rows) {
  constexpr std::uint64_t k_size = 5 * k_checksum_block + 100;
  {
    ScratchCheckpoint checkpoint = open(folder_ / "state");
    KeptFile rows = checkpoint.file("positions");
    rows.append_zeros(k_size);
    checkpoint.keep(7, std::vector<ScratchCheckpoint::Kept>{{"positions", &rows, k_size}});
  }
  int calls = 0;
  {
    ScratchCheckpoint checkpoint({.file = folder_ / "state", .resume = true}, {{"test", "1"}},
                                 [&] { return ++calls == 2; });
    EXPECT_THROW(checkpoint.file("positions"), Cancelled);
    EXPECT_EQ(calls, 2);
    EXPECT_FALSE(checkpoint.is_corrupt());
  }
  ScratchCheckpoint checkpoint = open(folder_ / "state");
  EXPECT_EQ(checkpoint.rows(), 7u);
  EXPECT_EQ(checkpoint.file("positions").size(), k_size);
}

TEST_F(ScratchCheckpointTest, gives_back_what_exceeds_the_rows) {
  ScratchCheckpoint checkpoint = open(folder_ / "state");
  KeptFile rows = checkpoint.file("positions");
  rows.append_zeros(1000);
  checkpoint.keep(10, std::vector<ScratchCheckpoint::Kept>{{"positions", &rows, 10}});
  EXPECT_EQ(fs::file_size(folder_ / "state" / "rows-positions"), 10u);
}

}  // namespace
}  // namespace alidade
