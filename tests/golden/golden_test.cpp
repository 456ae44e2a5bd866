// SPDX-License-Identifier: MIT
#include <cstdlib>
#include <filesystem>

#include "base/output_file.h"
#include "compare/report/report_page.h"
#include "tests/tools/run_program.h"

// Images that must stay as they are: the last net behind the tests of light, cameras and colours. The same
// compiler gives the same bytes; other ones may round elsewhere, which the thresholds allow.
//
// After an intended change of images, write them again and check the differences before committing them:
//   ALIDADE_WRITE_GOLDEN=1 build/release/tests/golden/golden_test

namespace alidade::test {

using namespace image;
using namespace compare;

namespace {

namespace fs = std::filesystem;

const fs::path k_sources = ALIDADE_SOURCE_FOLDER;

class GoldenTest : public ProgramTest {
 protected:
  void render(std::vector<std::string> words, const std::string& image) {
    words.insert(words.begin(), "render");
    words.insert(words.end(), {"--seed", "1", "-q", "-o", image});
    const ProgramResult result = run(words);
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }

  /// Puts a camera beside the scan: the default camera and radius depend on which points are sampled, and so
  /// on the order of the octree.
  void scan_courtyard() {
    fs::copy_file(k_sources / "scenes/courtyard.camera.json", folder / "camera.json");
    const ProgramResult result =
        run({"generate", "courtyard", "--points", "6e4", "--seed", "1", "-q", "-o", "courtyard.las"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }

  /// Judges an image of the test's folder by the one of that name beside this file; where it fails, leaves a
  /// report to look at.
  void expect_golden(const std::string& image, const std::string& thresholds) const {
    const fs::path golden = k_sources / "tests/golden" / image;
    if (std::getenv("ALIDADE_WRITE_GOLDEN") != nullptr) {
      fs::copy_file(folder / image, golden, fs::copy_options::overwrite_existing);
      GTEST_SKIP() << golden << " was written again";
    }
    ComparisonOptions options;
    options.keep_images = true;
    options.find_changes = ChangeMap::color;
    const Comparison comparison = compare_files(golden, folder / image, options);
    const Verdict verdict = judge(comparison, parse_thresholds(thresholds));
    if (verdict.pass()) return;
    const fs::path report = std::filesystem::temp_directory_path() / ("golden_" + image + ".html");
    write_text_file(report, report_page(comparison, verdict, ImagePacking::png), true);
    std::string failures;
    for (const JudgedThreshold& judged : verdict.judged)
      if (judged.fails) failures += to_text(judged.threshold) + ": " + std::to_string(judged.value) + "\n";
    ADD_FAILURE() << image << " has changed:\n" << failures << "see " << report;
  }
};

TEST_F(GoldenTest, courtyard_by_sun_and_sky) {
  scan_courtyard();
  render({"--cloud", "courtyard.las", "--radius", "0.5", "--camera", "camera.json", "--size", "150x100",
          "--samples", "16"},
         "courtyard.png");
  expect_golden("courtyard.png", "flip=0.02,psnr<35,p95=0.02");
}

TEST_F(GoldenTest, materials_of_all_kinds) {
  fs::copy_file(k_sources / "scenes/materials.json", folder / "materials.json");
  render({"materials.json", "--size", "160x80", "--samples", "16"}, "materials.png");
  expect_golden("materials.png", "flip=0.02,psnr<35,p95=0.02");
}

TEST_F(GoldenTest, heights_from_straight_above) {
  scan_courtyard();
  render({"--cloud", "courtyard.las", "--orthographic", "top", "--resolution", "0.5", "--mode", "headlight",
          "--color-by", "height", "--surface", "sphere", "--samples", "4"},
         "heights.png");
  expect_golden("heights.png", "flip=0.01,psnr<40,max=0.5");
}

TEST_F(GoldenTest, layers_of_the_courtyard) {
  scan_courtyard();
  render({"--cloud", "courtyard.las", "--radius", "0.5", "--camera", "camera.json", "--size", "60x40",
          "--samples", "1", "--mode", "flat", "--layers", "color,depth,normal,id"},
         "layers.exr");
  expect_golden("layers.exr", "flip=0.02,depth_p95=0.001,depth_one_sided=0.2,normal_mean=0.1,ids<99.5");
}

}  // namespace
}  // namespace alidade::test
