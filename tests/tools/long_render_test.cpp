// SPDX-License-Identifier: MIT
// Images that take long: ends by time and noise, previews, checkpoints.
#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>

#include <chrono>
#include <cstdlib>
#include <thread>

#include "tests/support/random.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

class LongRenderTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_square("square.xyz");
  }

  /// Waits until a file is there.
  void wait_for(const Program& program, const std::string& name) const {
    const auto limit = std::chrono::steady_clock::now() + std::chrono::minutes(2);
    while (program.running() && !std::filesystem::exists(folder / name) &&
           std::chrono::steady_clock::now() < limit)
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    ASSERT_TRUE(std::filesystem::exists(folder / name)) << "ended too early, or hangs";
  }

  /// Runs the program in a shell that limits the size of files, in KiB; its messages go to the file "said".
  int run_with_small_files(int limit, const std::string& words) const {
    const std::string command = fmt::format("cd '{}' && ulimit -f {} && '{}' {} 2> said", folder.string(),
                                            limit, program_file().string(), words);
    const int status = std::system(fmt::format("bash -c \"{}\"", command).c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  /// Starts the words and kills the program at a random moment: any, one of the rendering, or one soon after
  /// there is a checkpoint, however fast the machine. False if it had ended before; that must have been well.
  bool killed(const Words& words, Random& random) {
    Program program(words, folder);
    const double moment = random.unit();
    const auto wait_while = [&](const auto& condition) {
      while (program.running() && condition()) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    };
    if (moment < 0.4) wait_while([&] { return !contains(program.errors_so_far(), " of radius "); });
    if (moment >= 0.6) wait_while([&] { return !std::filesystem::exists(folder / "state"); });
    std::this_thread::sleep_for(std::chrono::microseconds(random.below(moment < 0.6 ? 500'000 : 50'000)));
    program.send(SIGKILL);
    const ProgramResult result = program.wait();
    resumed_ += contains(result.err, "% of its samples after") ? 1 : 0;
    if (result.signal == SIGKILL) return true;
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return false;
  }

  /// Starts the program again and again until it has been killed so often, and has resumed at least once;
  /// then lets it end. Whenever it ends before, its image must be the expected one, too.
  void kill_and_resume(const Words& words, const std::string& image, const std::string& expected, int kills) {
    Random random(image);
    resumed_ = 0;
    for (int kill = 0; kill < kills || (resumed_ == 0 && kill < 10 * kills);) {
      if (killed(words, random)) {
        ++kill;
      } else {
        ASSERT_TRUE(!HasFailure() && read(image) == expected);
      }
    }
    EXPECT_GT(resumed_, 0) << "no render lived long enough for a checkpoint";
    ASSERT_EQ(run(words).exit_code, 0);
    EXPECT_TRUE(read(image) == expected) << "another picture after " << kills << " kills";
    EXPECT_FALSE(std::filesystem::exists(folder / "state"));
  }

  int resumed_ = 0;  ///< runs that went on from a checkpoint
};

const Words k_render = {"render", "--cloud", "square.xyz", "--size=80x60"};
const Words k_keep = {"--checkpoint", "state", "--checkpoint-interval", "0.01", "--resume"};

TEST_F(LongRenderTest, killed_at_random_moments_gives_the_bytes_of_an_uninterrupted_run) {
  for (const auto& [surface, kills] : {std::pair{"sphere", 4}, {"disc", 6}, {"blend", 10}}) {
    SCOPED_TRACE(surface);
    const Words words = with(
        k_render, {"--samples=500", "--surface", surface, "--layers",
                   "color,depth,distance,normal,position,albedo,id,variance,depth.sigma,coverage,support"});
    const std::string whole = fmt::format("whole_{}.exr", surface), cut = fmt::format("{}.exr", surface);
    ASSERT_EQ(run(with(words, {"-o", whole})).exit_code, 0);
    kill_and_resume(with(with(words, k_keep), {"-o", cut, "--overwrite"}), cut, read(whole), kills);
  }
}

TEST_F(LongRenderTest, killed_with_a_target_of_noise_it_ends_with_the_same_bytes) {
  const Words words = with(k_render, {"--samples=4000", "--target-noise=0.0005"});
  ASSERT_EQ(run(with(words, {"-o", "whole.png"})).exit_code, 0);
  kill_and_resume(with(with(words, k_keep),
                       {"-o", "out.png", "--overwrite", "--preview", "now.jpg", "--preview-interval=0.1"}),
                  "out.png", read("whole.png"), 8);
}

TEST_F(LongRenderTest, interrupted_it_keeps_a_checkpoint_and_ends_with_130) {
  const Words words = with(k_render, {"--samples=300", "-o", "out.png", "--checkpoint=state"});
  Program program(with(words, {"--preview=now.png", "--samples=100000"}), folder);
  wait_for(program, "now.png");
  program.send(SIGINT);
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_TRUE(contains(result.err, "saved to state; the same command with --resume")) << result.err;
  EXPECT_EQ(names(), (Words{"now.png", "square.xyz", "state"}));
  const ProgramResult other = run(with(words, {"--resume"}));
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_TRUE(contains(other.err,
                       "state: this checkpoint belongs to another picture: it has samples "
                       "100000, this run has 300"))
      << other.err;
  EXPECT_FALSE(contains(other.err, "% of its samples after")) << other.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "out.png"));
}

TEST_F(LongRenderTest, without_a_checkpoint_yet_resume_starts_with_a_message) {
  const Words words = with(k_render, {"--samples=2"});
  ASSERT_EQ(run(with(words, {"-o", "whole.exr"})).exit_code, 0);
  const ProgramResult result = run(with(with(words, k_keep), {"-o", "out.exr"}));
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(contains(result.err, "no checkpoint state: starting from the beginning")) << result.err;
  EXPECT_TRUE(read("out.exr") == read("whole.exr"));
  EXPECT_EQ(names(), (Words{"out.exr", "square.xyz", "whole.exr"}));
}

TEST_F(LongRenderTest, existing_checkpoint_is_kept_without_resume_or_overwrite) {
  write("state", "precious");
  const Words words = with(k_render, {"--samples=2", "-o", "out.png", "--checkpoint=state"});
  for (const std::string flag : {"-v", "--skip-existing"}) {
    const ProgramResult rejected = run(with(words, {flag}));
    EXPECT_EQ(rejected.exit_code, 2);
    EXPECT_TRUE(contains(rejected.err, "state: the file exists; expected --resume")) << rejected.err;
  }
  const ProgramResult foreign = run(with(words, {"--resume"}));
  EXPECT_EQ(foreign.exit_code, 2);
  EXPECT_TRUE(contains(foreign.err, "state:byte 0: not an Alidade checkpoint")) << foreign.err;
  EXPECT_EQ(read("state"), "precious");
}

TEST_F(LongRenderTest, file_that_is_no_checkpoint_is_never_replaced_by_one) {
  const Words words =
      with(k_render, {"--samples=2", "-o", "out.png", "--checkpoint=notes.txt", "--overwrite"});
  for (const std::string content : {"precious", "", "ALIDPAR"}) {
    write("notes.txt", content);
    const ProgramResult rejected = run(words);
    EXPECT_EQ(rejected.exit_code, 2);
    EXPECT_TRUE(contains(rejected.err, "notes.txt:byte 0: not an Alidade checkpoint")) << rejected.err;
    EXPECT_EQ(read("notes.txt"), content);
  }
  // One of another version may be.
  write("notes.txt", "ALIDPART, but else not as checkpoints are");
  EXPECT_EQ(run(words).exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "notes.txt"));
}

TEST_F(LongRenderTest, going_on_replaces_earlier_previews_and_no_other_image) {
  for (const std::string extension : {"png", "jpg"}) {
    const std::string preview = "now." + extension;
    const Words words = with(k_render, {"--samples=2", "--checkpoint=state", "--preview", preview, "-o"});
    ASSERT_EQ(run(with(words, {"1" + extension + ".png"})).exit_code, 0);
    const std::string first = read(preview);
    for (const Words& flags : {Words{"--resume"}, Words{"--skip-existing"}}) {
      const Words again = with(with(words, {"2" + extension + flags[0] + ".png", "--seed=2"}), flags);
      write(preview, "precious");
      const ProgramResult rejected = run(again);
      EXPECT_EQ(rejected.exit_code, 2);
      EXPECT_TRUE(contains(rejected.err, preview + ": the file exists")) << rejected.err;
      EXPECT_EQ(read(preview), "precious");
      write(preview, first);
      const ProgramResult replaced = run(again);
      EXPECT_EQ(replaced.exit_code, 0) << replaced.err;
      EXPECT_FALSE(read(preview) == first);
    }
  }
}

TEST_F(LongRenderTest, prints_what_ended_it_unless_complete) {
  const auto said = [&](const Words& words) {
    const ProgramResult result = run(with(with(k_render, {"-o", "out.png", "--overwrite"}), words));
    EXPECT_EQ(result.exit_code, 0);
    return result.err;
  };
  const std::string not_reached = " of 20 tiles: raise --samples";
  const std::string few = "--target-noise tests tiles from 32 samples on, but they get 4: raise --samples";
  EXPECT_TRUE(contains(said({"--samples=32", "--target-noise=1e-6"}), not_reached));
  EXPECT_FALSE(contains(said({"--samples=32", "--target-noise=1e-6"}), few));
  EXPECT_TRUE(contains(said({"--samples=4", "--target-noise=0.05"}), few));
  EXPECT_FALSE(contains(said({"--samples=4", "--target-noise=0.05", "-q"}), few));
  EXPECT_FALSE(contains(said({"--samples=64", "--target-noise=100"}), "not reached"));
  EXPECT_TRUE(contains(said({"--samples=2", "--time-limit=1e6"}), "stopped by --samples, not by time"));
  EXPECT_TRUE(contains(said({"--samples=64", "--time-limit=1e6", "--target-noise=100"}),
                       "stopped by --target-noise, not by time"));
  const std::string in_time = said({"--samples=64", "--time-limit=0", "--target-noise=0.1"});
  EXPECT_TRUE(contains(in_time, "target not reached in 20 of 20 tiles: raise --time-limit")) << in_time;
  EXPECT_FALSE(contains(in_time, "not by time")) << in_time;
}

TEST_F(LongRenderTest, goes_on_with_the_image_however_its_name_is_typed) {
  const Words words = with(k_render, {"--samples=100000", "--time-limit=0", "--checkpoint=state"});
  {
    Program program(with(words, {"-o", "out.png", "--time-limit=1e6", "--preview=now.png"}), folder);
    wait_for(program, "now.png");
    program.send(SIGINT);
    ASSERT_EQ(program.wait().exit_code, 130);
  }
  const std::string checkpoint = read("state");
  const std::string typed[] = {"out.png", "./out.png", (folder / "sub" / ".." / "out.png").string()};
  for (const std::string& name : typed) {
    std::filesystem::remove(folder / "out.png");
    std::filesystem::create_directory(folder / "sub");
    write("state", checkpoint);
    const ProgramResult result = run(with(words, {"-o", name, "--resume"}));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(contains(result.err, "resuming from state: " + name + " has ")) << result.err;
  }
  std::filesystem::remove(folder / "out.png");
  write("state", checkpoint);
  const ProgramResult other = run(with(words, {"-o", "sub/out.png", "--resume"}));
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_TRUE(contains(other.err, "the checkpoint belongs to another image; expected one of sub/out.png"))
      << other.err;
}

TEST_F(LongRenderTest, error_of_one_sample_is_unknown) {
  const ProgramResult result =
      run(with(k_render, {"--time-limit=0", "--target-noise=0.05", "-o", "out.exr"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "estimated error of a tile: median unknown, worst unknown")) << result.err;
  EXPECT_TRUE(contains(read("out.exr"), "unknown unknown"));
}

TEST_F(LongRenderTest, set_of_images_goes_on_with_the_one_under_way) {
  write("lens.json", R"({"version": 1, "model": "pinhole", "width": 60, "height": 40,
    "intrinsics": {"vertical_fov": 50}, "pose": {"look_at": {"eye": [0, 0, 0], "target": [0, 1, 0]}}})");
  write("way.csv",
        "# opencv "
        "camera_to_world\ntime,x,y,z,qx,qy,qz,qw\n0,101,201,9,1,0,0,0\n1,100.5,201,9,1,0,0,0\n2,100,200,9,1,"
        "0,0,0\n");
  const Words words = {"render",  "--cloud", "square.xyz", "--camera",
                       "way.csv", "--lens",  "lens.json",  "--samples=400"};
  ASSERT_EQ(run(with(words, {"-o", "whole%d.exr"})).exit_code, 0) << run(with(words, {"-o", "w%d.exr"})).err;
  const Words keep = with(with(words, k_keep), {"-o", "out%d.exr", "--skip-existing"});
  Random random;
  for (int kill = 0; kill < 12;) {
    if (killed(keep, random)) {
      ++kill;
    } else {
      ASSERT_FALSE(HasFailure());
      // Done before the last kill: once more from the second image on.
      std::filesystem::remove(folder / "out1.exr");
      std::filesystem::remove(folder / "out2.exr");
    }
  }
  EXPECT_GT(resumed_, 0);
  ASSERT_EQ(run(keep).exit_code, 0);
  for (const std::string number : {"0", "1", "2"})
    EXPECT_TRUE(read("out" + number + ".exr") == read("whole" + number + ".exr")) << number;
  EXPECT_FALSE(std::filesystem::exists(folder / "state"));
}

TEST_F(LongRenderTest, full_disk_loses_neither_the_old_image_nor_the_old_checkpoint) {
  const Words words = with(k_render, {"--samples=200", "-o", "out.exr", "--checkpoint", "state"});
  Program program(with(words, {"--checkpoint-interval=0.01"}), folder);
  wait_for(program, "state");
  program.send(SIGKILL);
  if (program.wait().signal != SIGKILL) GTEST_SKIP() << "this machine was too fast to kill the render";
  const std::string checkpoint = read("state");
  write("out.exr", "precious");
  const int code = run_with_small_files(
      4,
      "render --cloud square.xyz --size=80x60 --samples=200 -o out.exr --checkpoint state "
      "--checkpoint-interval=0.01 --resume --overwrite");
  EXPECT_EQ(code, 2);
  EXPECT_TRUE(contains(read("said"), "alidade: warning: no checkpoint: state: cannot write the file"))
      << read("said");
  EXPECT_TRUE(contains(read("said"), "alidade: error: out.exr: cannot write the file")) << read("said");
  EXPECT_EQ(read("out.exr"), "precious");
  EXPECT_TRUE(read("state") == checkpoint);
  ASSERT_EQ(run(with(words, {"--resume", "--overwrite"})).exit_code, 0);
  const std::string resumed = read("out.exr");
  ASSERT_EQ(run(with(k_render, {"--samples=200", "-o", "whole.exr"})).exit_code, 0);
  EXPECT_TRUE(resumed == read("whole.exr"));
}

TEST_F(LongRenderTest, damaged_checkpoint_is_an_error_and_no_image) {
  Program program(with(k_render, {"--samples=100000", "-o", "out.png", "--checkpoint=state",
                                  "--checkpoint-interval=0.01"}),
                  folder);
  wait_for(program, "state");
  program.send(SIGKILL);
  program.wait();
  std::string content = read("state");
  content[content.size() / 2] = static_cast<char>(content[content.size() / 2] ^ 4);
  write("state", content);
  const ProgramResult result =
      run(with(k_render, {"--samples=100000", "-o", "out.png", "--checkpoint=state", "--resume"}));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "state: corrupt checkpoint: wrong checksum of the samples")) << result.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "out.png"));
  EXPECT_TRUE(read("state") == content);
}

TEST_F(LongRenderTest, preview_changes_nothing_and_ends_as_the_image) {
  const Words words = with(k_render, {"--samples=20"});
  ASSERT_EQ(run(with(words, {"-o", "whole.png"})).exit_code, 0);
  ASSERT_EQ(run(with(words, {"-o", "out.png", "--preview", "now.png"})).exit_code, 0);
  EXPECT_TRUE(read("out.png") == read("whole.png"));
  const std::string image = read("out.png"), preview = read("now.png");
  EXPECT_EQ(image.substr(image.find("IDAT")), preview.substr(preview.find("IDAT")));
  const ProgramResult rejected = run(with(words, {"-o", "other.png", "--preview", "now.png"}));
  EXPECT_EQ(rejected.exit_code, 2);
  EXPECT_TRUE(contains(rejected.err, "now.png: the file exists")) << rejected.err;
}

TEST_F(LongRenderTest, preview_that_cannot_be_written_is_a_warning) {
  std::filesystem::create_directory(folder / "previews");
  Program program(with(k_render, {"--samples=400", "-o", "out.png", "--preview", "previews/now.png",
                                  "--preview-interval=0.001"}),
                  folder);
  wait_for(program, "previews/now.png");
  std::filesystem::rename(folder / "previews", folder / "elsewhere");
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "alidade: warning: no preview: previews/now.png")) << result.err;
  EXPECT_EQ(result.err.find("warning: no preview"), result.err.rfind("warning: no preview"));
  EXPECT_EQ(read("out.png").substr(1, 3), "PNG");
}

TEST_F(LongRenderTest, time_limit_prints_how_many_samples_were_taken) {
  const ProgramResult result =
      run(with(k_render, {"--samples=1000000", "--time-limit", "0", "-o", "out.exr"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "out.exr: samples per pixel: 1 to 1, mean 1.0")) << result.err;
  EXPECT_TRUE(contains(read("out.exr"), "alidade:samples_reached"));
  EXPECT_TRUE(contains(read("out.exr"), "--time-limit 0"));
}

TEST_F(LongRenderTest,
       target_noise_prints_what_was_reached_and_gives_the_same_bytes_on_any_number_of_threads) {
  const Words words = with(k_render, {"--samples=1000", "--target-noise", "0.05"});
  const ProgramResult result = run(with(words, {"--threads=1", "-o", "1.exr"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "estimated error of a tile: median ")) << result.err;
  EXPECT_TRUE(contains(read("1.exr"), "alidade:noise_reached"));
  ASSERT_EQ(run(with(words, {"--threads=3", "-o", "3.exr"})).exit_code, 0);
  EXPECT_TRUE(read("1.exr") == read("3.exr"));
}

TEST_F(LongRenderTest, mistakes_are_errors_before_the_work) {
  const auto expect = [&](const Words& words, const std::string& part) {
    const ProgramResult result = run(with(k_render, words));
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_TRUE(contains(result.err, part)) << result.err;
    EXPECT_FALSE(contains(result.err, "loading cloud")) << result.err;
    EXPECT_EQ(names(), Words{"square.xyz"});
  };
  expect({"-o", "out.png", "--resume"}, "--resume requires --checkpoint");
  expect({"-o", "out.png", "--checkpoint-interval", "3"}, "--checkpoint-interval requires --checkpoint");
  expect({"-o", "out.png", "--checkpoint", "s", "--checkpoint-interval", "0"}, "--checkpoint-interval");
  expect({"-o", "out.png", "--preview-interval", "3"}, "--preview-interval requires --preview");
  expect({"-o", "out.png", "--preview", "now.exr"}, "now.exr: unknown output format");
  expect({"-o", "out.png", "--preview", "./out.png"}, "./out.png: two outputs have this name");
  expect({"-o", "out.png", "--checkpoint", "out.png"}, "out.png: two outputs have this name");
  expect({"-o", "out.png", "--checkpoint", "a.png", "--preview", "a.png"},
         "a.png: preview and checkpoint have the same name");
  expect({"-o", "out.png", "--checkpoint", "square.xyz", "--overwrite"},
         "square.xyz: the output is also an input");
  expect({"-o", "out.png", "--checkpoint", "absent/state"}, "absent/state");
  expect({"-o", "out.png", "--time-limit", "-1"}, "--time-limit");
  expect({"-o", "out.png", "--target-noise", "0"}, "--target-noise");
}

}  // namespace
}  // namespace alidade::test
