// SPDX-License-Identifier: MIT
// Images of COPC files: the bytes are those of the decoded cloud, and there is something to see before all
// points are read.
#include <algorithm>
#include <fstream>

#include "cloud/copc/copc_file.h"
#include "tests/cloud/copc/copc_builder.h"
#include "tests/support/absent_data.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

class CopcRenderTest : public ProgramTest {
 protected:
  void write_copc(const CopcSample& sample) const {
    std::ofstream file(folder / "site", std::ios::binary);
    file.write(reinterpret_cast<const char*>(sample.bytes.data()),
               static_cast<std::streamsize>(sample.bytes.size()));
  }

  ProgramResult render(const std::string& image, Words more = {}) {
    Words words = {"render", "--cloud", "site", "--size=90x60", "--samples=4", "-o", image};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  }
};

TEST_F(CopcRenderTest, the_image_is_that_of_the_decoded_cloud_byte_for_byte) {
  const auto file = shared_data("lidar_rgb/lion_takanawa.copc.laz");
  if (!file) GTEST_SKIP() << absent("../shared/data/lidar_rgb/lion_takanawa.copc.laz");
  // Images name their clouds.
  std::filesystem::copy_file(*file, folder / "site");
  ASSERT_EQ(render("direct.png").exit_code, 0);
  const ProgramResult converted = run({"convert", "site", "-o", "decoded.las"});
  ASSERT_EQ(converted.exit_code, 0) << converted.err;
  std::filesystem::rename(folder / "decoded.las", folder / "site");
  ASSERT_TRUE(contains(run({"info", "site"}).out, "LAS 1.4"));
  std::filesystem::rename(folder / "direct.png", folder / "kept.png");
  ASSERT_EQ(render("direct.png").exit_code, 0);
  EXPECT_TRUE(read("kept.png") == read("direct.png"));
}

TEST_F(CopcRenderTest, first_looks_are_shown_before_the_cloud_is_loaded_and_change_nothing) {
  write_copc(build_copc(20000, 200));
  ASSERT_EQ(render("plain.png").exit_code, 0);
  const ProgramResult looked = render("out.png", {"--preview", "now.png", "--preview-points", "1000"});
  ASSERT_EQ(looked.exit_code, 0) << looked.err;
  const std::size_t coarse = looked.err.find("of 20 k points"), finer = looked.err.rfind("of 20 k points");
  EXPECT_LT(coarse, finer) << looked.err;
  EXPECT_LT(finer, looked.err.find("20000 points, coloured by")) << looked.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "now.png"));
  std::filesystem::rename(folder / "plain.png", folder / "kept.png");
  ASSERT_EQ(render("plain.png").exit_code, 0);
  EXPECT_TRUE(read("kept.png") == read("plain.png"));
}

TEST_F(CopcRenderTest, a_first_look_stays_if_the_rest_of_the_cloud_is_damaged) {
  CopcSample sample = build_copc(20000, 200);
  const CopcFile whole(InputFile(sample.bytes, "whole"));
  // The sizes of a deepest chunk's layers follow its first point and the count.
  const std::uint64_t deepest = whole.hierarchy().nodes.back().chunk.offset;
  std::fill_n(sample.bytes.begin() + static_cast<std::ptrdiff_t>(deepest) + 40, 16, std::byte{0xff});
  write_copc(sample);
  const ProgramResult result = render("out.png", {"--preview", "now.png", "--preview-points", "300"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "corrupt")) << result.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "out.png"));
  EXPECT_TRUE(std::filesystem::exists(folder / "now.png"));
}

TEST_F(CopcRenderTest, nothing_is_written_if_not_requested) {
  write_copc(build_copc(20000, 200));
  EXPECT_FALSE(contains(render("a.png", {"--preview", "now.png", "--preview-points", "0"}).err, "shows"));
  EXPECT_FALSE(contains(render("b.png", {"--preview", "now.png", "--overwrite"}).err, "shows"));
  const ProgramResult bad = render("c.png", {"--preview-points", "5"});
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_TRUE(contains(bad.err, "--preview")) << bad.err;
}

TEST_F(CopcRenderTest, info_prints_levels_nodes_and_spacing) {
  const CopcSample sample = build_copc(3000);
  write_copc(sample);
  const ProgramResult result = run({"info", "site"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(contains(result.out, "COPC 1.4, point format 7, 3000 points")) << result.out;
  EXPECT_TRUE(contains(result.out,
                       std::to_string(sample.keys.size()) + " nodes with points, spacing 1.5 in the root"));
}

}  // namespace
}  // namespace alidade::test
