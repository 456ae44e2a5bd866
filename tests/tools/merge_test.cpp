// SPDX-License-Identifier: MIT
// Parts of images that are rendered apart, and merged.
#include <fmt/format.h>
#include <signal.h>

#include <chrono>
#include <thread>

#include "tests/support/seal_checkpoint.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

const Words k_render = {"render", "--cloud", "square.xyz", "--size=80x60", "--samples=4"};
const std::string k_layers =
    "--layers=variance,color,depth,distance,normal,position,albedo,id,depth.sigma,coverage,support";

class MergeTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_square("square.xyz");
  }

  void ok(const Words& words) {
    const ProgramResult result = run(words);
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }

  /// Renders all parts of an image.
  void render_parts(const Words& words, const std::string& image, int count) {
    for (int number = 1; number <= count; ++number)
      ok(with(words, {"-o", image, fmt::format("--part={}/{}", number, count)}));
  }

  static Words parts_of(const std::string& image, int count) {
    Words names;
    for (int number = count; number >= 1; --number)  // in any order
      names.push_back(fmt::format("{}.part{}of{}", image, number, count));
    return names;
  }

  void expect_rejection(const Words& parts, const std::string& output, const std::string& message) {
    const ProgramResult result = run(with(with({"merge"}, parts), {"-o", output}));
    EXPECT_EQ(result.exit_code, 2) << message;
    EXPECT_TRUE(contains(result.err, message)) << message << ": " << result.err;
    EXPECT_FALSE(std::filesystem::exists(folder / output)) << message;
  }

  /// Renders in one run and in parts, and compares bytes.
  void expect_same(const Words& words, const std::string& extension, int count) {
    const std::string whole = "whole" + extension, merged = "merged" + extension;
    ok(with(words, {"-o", whole}));
    render_parts(words, "apart" + extension, count);
    ok(with(with({"merge", "-q", "--overwrite"}, parts_of("apart" + extension, count)), {"-o", merged}));
    EXPECT_TRUE(read(whole) == read(merged)) << extension << " of " << count << " parts";
  }
};

TEST_F(MergeTest, parts_give_the_bytes_of_one_run) {
  expect_same(k_render, ".png", 3);
  expect_same(k_render, ".jpg", 2);
  expect_same(with(k_render, {k_layers}), ".exr", 7);
}

TEST_F(MergeTest, parts_hold_no_absolute_paths_and_those_of_other_folders_give_the_bytes_of_one_run) {
  Words parts;
  for (const char* const machine : {"here", "there"}) {
    std::filesystem::create_directory(folder / machine);
    std::filesystem::copy_file(folder / "square.xyz", folder / machine / "square.xyz");
    const std::string number = fmt::format("{}", parts.size() + 1), image = folder / machine / "a.exr";
    ok({"render", "--cloud", folder / machine / "square.xyz", "--size=80x60", "--samples=4", "-o", image,
        "--part=" + number + "/2"});
    parts.push_back(std::string(machine) + "/a.exr.part" + number + "of2");
    EXPECT_FALSE(contains(read(parts.back()), folder.string()));
  }
  ok(with(with({"merge"}, parts), {"-o", "merged.exr"}));
  ok(with(k_render, {"-o", "whole.exr"}));
  EXPECT_TRUE(read("merged.exr") == read("whole.exr"));
  // Another cloud of the same name is another image.
  write("there/square.xyz", read("square.xyz") + "101 201 6\n");
  ok({"render", "--cloud", folder / "there" / "square.xyz", "--size=80x60", "--samples=4", "-o",
      folder / "there" / "a.exr", "--part=2/2", "--overwrite"});
  expect_rejection(parts, "other.exr", "this part belongs to another picture: it has number of points");
}

TEST_F(MergeTest, parts_of_every_surface_give_the_bytes_of_one_run) {
  for (const std::string surface : {"disc", "blend", "sphere"})
    expect_same(with(k_render, {k_layers, "--surface", surface, "--overwrite"}), ".exr", 3);
}

TEST_F(MergeTest, orthophoto_of_parts_gives_the_bytes_of_one_run) {
  ok({"generate", "courtyard", "--points", "2e4", "-o", "yard.las", "-q"});
  expect_same({"render", "--cloud", "yard.las", "--orthographic", "top", "--resolution", "0.5", "--samples",
               "2", "--extent", "689950,5324960,690050,5325020"},
              ".tif", 5);
  EXPECT_TRUE(contains(read("merged.tif"), "WGS 84 / UTM zone 32N"));
}

TEST_F(MergeTest, more_parts_than_tiles_and_a_single_part_give_the_bytes_of_one_run) {
  const Words small = {"render", "--cloud", "square.xyz", "--size=20x30", "--samples=2"};
  expect_same(small, ".png", 4);
  expect_same(with(small, {k_layers, "--overwrite"}), ".exr", 1);
}

TEST_F(MergeTest, parts_of_a_set_of_cameras_are_merged_image_by_image) {
  write("lens.json", R"({"version": 1, "model": "pinhole", "width": 60, "height": 40,
    "intrinsics": {"vertical_fov": 50}, "pose": {"look_at": {"eye": [0, 0, 0], "target": [0, 1, 0]}}})");
  write("way.csv",
        "# opencv camera_to_world\ntime,x,y,z,qx,qy,qz,qw\n0,101,201,9,1,0,0,0\n1,100.5,201,9,1,0,0,0\n");
  const Words words = {"render",  "--cloud", "square.xyz", "--camera",
                       "way.csv", "--lens",  "lens.json",  "--samples=4"};
  ok(with(words, {"-o", "whole%d.exr"}));
  render_parts(words, "out%d.exr", 2);
  for (const std::string number : {"0", "1"}) {
    ok(with(with({"merge"}, parts_of("out" + number + ".exr", 2)), {"-o", "out" + number + ".exr"}));
    EXPECT_TRUE(read("out" + number + ".exr") == read("whole" + number + ".exr")) << number;
  }
  expect_rejection({"out0.exr.part1of2", "out1.exr.part2of2"}, "mixed.exr",
                   "out1.exr.part2of2: this part belongs to another picture: it has camera");
  const ProgramResult again = run(with(words, {"-o", "out%d.exr", "--part=2/2", "--skip-existing"}));
  EXPECT_TRUE(contains(again.err, "all images exist")) << again.err;
}

TEST_F(MergeTest, killed_and_resumed_part_has_the_bytes_of_an_uninterrupted_one) {
  const Words words = {"render",         "--cloud", "square.xyz", "--size=80x60",
                       "--samples=3000", k_layers,  "--part=2/3"};
  ok(with(words, {"-o", "whole.exr"}));
  const std::string whole = read("whole.exr.part2of3");
  std::filesystem::remove(folder / "whole.exr.part2of3");
  const Words keep =
      with(words, {"-o", "whole.exr", "--checkpoint=state", "--checkpoint-interval=0.01", "--resume"});
  int killed = 0;
  for (int attempt = 0; attempt < 4; ++attempt) {
    Program program(keep, folder);
    const auto limit = std::chrono::steady_clock::now() + std::chrono::minutes(2);
    while (program.running() && !std::filesystem::exists(folder / "state") &&
           std::chrono::steady_clock::now() < limit)
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    std::this_thread::sleep_for(std::chrono::milliseconds(20 * attempt));
    program.send(SIGKILL);
    if (program.wait().signal != SIGKILL) break;
    ++killed;
  }
  if (!std::filesystem::exists(folder / "state"))
    GTEST_SKIP() << "this machine was too fast to kill the render";
  EXPECT_GT(killed, 0);
  EXPECT_FALSE(contains(read("state"), folder.string())) << "checkpoints hold no absolute paths";
  // What is there is neither a part nor the checkpoint of another part.
  expect_rejection({"state"}, "out.exr",
                   "state: a checkpoint of an unfinished render; expected a finished part");
  Words other = keep;
  other[6] = "--part=1/3";
  const ProgramResult rejected = run(other);
  EXPECT_TRUE(contains(rejected.err, "it has part 2/3, this run has 1/3")) << rejected.err;
  ok(keep);
  EXPECT_TRUE(read("whole.exr.part2of3") == whole);
  EXPECT_FALSE(std::filesystem::exists(folder / "state"));
}

TEST_F(MergeTest, missing_and_foreign_parts_are_errors_that_name_them) {
  render_parts(k_render, "a.png", 5);
  const Words all = parts_of("a.png", 5);
  expect_rejection({"a.png.part2of5"}, "out.png", "missing parts 1, 3 to 5 of 5");
  expect_rejection(Words(all.begin(), all.end() - 1), "out.png", "missing part 1 of 5");
  const auto rejects = [&](const Words& words, const std::string& number, const std::string& message) {
    ok(with(words, {"-o", "b.png", "--part=" + number, "--overwrite", "-q"}));
    std::string file = "b.png.part" + number;
    file.replace(file.find('/'), 1, "of");
    Words parts(all.begin(), all.end() - 1);
    parts.push_back(file);
    expect_rejection(parts, "out.png", file + ": " + message);
  };
  const std::string another = "this part belongs to another picture: it has ";
  rejects(with(k_render, {"--seed=2"}), "1/5", another + "seed 2, a.png.part5of5 has 1");
  rejects(with(k_render, {"--samples=5"}), "1/5", another + "samples 5, a.png.part5of5 has 4");
  rejects(with(k_render, {"--size=81x60"}), "1/5", another + "camera");
  rejects(with(k_render, {"--exposure=1"}), "1/5", another + "exposure 1, a.png.part5of5 has ");
  rejects(with(k_render, {"--sun=135,20"}), "1/5", another);
  rejects(k_render, "1/4", "this part belongs to another division of the image; expected one of 5 parts");
  write("square.xyz", read("square.xyz") + "101 201 6\n");
  rejects(k_render, "1/5", another + "number of points");
  // The name of the image may be another one.
  write_square("square.xyz");
  ok(with(k_render, {"-o", "b.png", "--part=1/5", "--overwrite"}));
  Words parts(all.begin(), all.end() - 1);
  ok(with(with({"merge"}, parts), {"b.png.part1of5", "-o", "out.png"}));
  // The same part again is no harm, with other samples it is.
  ok(with(with({"merge"}, all), {"b.png.part1of5", "-o", "again.png"}));
  std::string content = read("b.png.part1of5");
  content.back() = static_cast<char>(content.back() ^ 1);
  std::vector<std::byte> bytes(content.size());
  std::memcpy(bytes.data(), content.data(), content.size());
  seal_checkpoint(bytes);
  std::memcpy(content.data(), bytes.data(), content.size());
  write("b.png.part1of5", content);
  expect_rejection(with(all, {"b.png.part1of5"}), "twice.png",
                   "b.png.part1of5: part 1/5 is also a.png.part1of5, with other samples");
}

TEST_F(MergeTest, damaged_parts_and_other_files_are_errors) {
  render_parts(k_render, "a.png", 2);
  const Words all = parts_of("a.png", 2);
  const std::string whole = read("a.png.part2of2");
  const auto rejects = [&](const std::string& content, const std::string& message) {
    write("a.png.part2of2", content);
    expect_rejection(all, "out.png", message);
  };
  for (const std::size_t size : {std::size_t{0}, std::size_t{50}, std::size_t{300}, whole.size() - 1})
    rejects(whole.substr(0, size), "a.png.part2of2");
  rejects(whole + " ", "a.png.part2of2:byte 16: corrupt checkpoint: wrong file size");
  std::string flipped = whole;
  flipped[whole.size() - 40] = static_cast<char>(flipped[whole.size() - 40] ^ 1);
  rejects(flipped, "a.png.part2of2: corrupt checkpoint: wrong checksum of the samples");
  flipped = whole;
  flipped[90] = static_cast<char>(flipped[90] ^ 1);
  rejects(flipped, "corrupt checkpoint: wrong header checksum");
  rejects("PNG, or so", "a.png.part2of2:byte 0: not a part of an image");
  const auto forged = [&](std::size_t position, std::uint32_t value) {
    std::vector<std::byte> bytes(whole.size());
    std::memcpy(bytes.data(), whole.data(), whole.size());
    put(bytes, position, value);
    seal_checkpoint(bytes);
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  };
  rejects(forged(40, 81), "corrupt part: its sizes contradict its fingerprint");
  rejects(forged(40, 0xffffffff), "corrupt checkpoint: its sizes are out of range");
  const std::uint32_t tiles = 80 + [&] {
    std::uint32_t bytes = 0;
    std::memcpy(&bytes, whole.data() + 72, 4);
    return bytes;
  }();
  rejects(forged(tiles, 3), "corrupt part: tile ");
  rejects(forged(tiles, 5), "corrupt checkpoint: invalid state of tile");
}

TEST_F(MergeTest, existing_images_stay_and_kinds_of_images_must_fit) {
  render_parts(k_render, "a.png", 2);
  const Words all = parts_of("a.png", 2);
  expect_rejection(all, "out.exr", "out.exr: the parts were rendered for PNG, JPEG or GeoTIFF");
  expect_rejection(all, "out.gif", "out.gif: unknown output format");
  expect_rejection(all, "out.tif", "a GeoTIFF requires an orthographic camera");
  write("a.png", "precious");
  const ProgramResult kept = run(with(with({"merge"}, all), {"-o", "a.png"}));
  EXPECT_EQ(kept.exit_code, 2);
  EXPECT_TRUE(contains(kept.err, "a.png: the file exists")) << kept.err;
  EXPECT_EQ(read("a.png"), "precious");
  ok(with(with({"merge"}, all), {"-o", "a.png", "--overwrite"}));
  EXPECT_EQ(read("a.png").substr(1, 3), "PNG");
}

TEST_F(MergeTest, mistakes_are_errors_before_the_work) {
  const auto expect = [&](const Words& words, const std::string& part) {
    const ProgramResult result = run(with(k_render, with(words, {"-o", "out.png"})));
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_TRUE(contains(result.err, part)) << result.err;
    EXPECT_EQ(names(), Words{"square.xyz"});
  };
  expect({"--part", "3"}, "--part: invalid value; expected I/N, such as 3/20, found '3'");
  expect({"--part", "0/3"}, "--part");
  expect({"--part", "4/3"}, "--part");
  expect({"--part", "1/0"}, "--part");
  expect({"--part", "1/3x"}, "--part");
  expect({"--part", "1/65537"}, "--part");
  expect({"--part", "1/2", "--time-limit", "5"}, "--time-limit excludes --part");
  expect({"--part", "1/2", "--target-noise", "0.1"}, "--target-noise excludes --part");
  expect({"--part", "1/2", "--preview", "now.png"}, "--preview excludes --part");
  EXPECT_EQ(run({"merge", "-o", "out.png"}).exit_code, 2);
  EXPECT_EQ(run({"merge", "absent", "-o", "out.png"}).exit_code, 2);
}

}  // namespace
}  // namespace alidade::test
