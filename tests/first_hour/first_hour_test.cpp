// SPDX-License-Identifier: MIT
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/support/absent_data.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// The clouds of ../shared/data that take little time.
std::vector<fs::path> small_clouds() {
  constexpr std::uintmax_t k_largest = 700'000;  // bytes
  std::vector<fs::path> files;
  for (const char* const folder : {"airborne", "lidar", "lidar_rgb", "e57", "pcd", "ply", "text"}) {
    const fs::path path = fs::path(ALIDADE_SHARED_DATA) / folder;
    if (!fs::is_directory(path)) continue;
    for (const auto& entry : fs::directory_iterator(path))
      if (entry.file_size() <= k_largest) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

/// The luminance that half of the pixels do not reach, 0 to 1 of display values; background does not count.
double median_luminance(const fs::path& image) {
  const auto input = OIIO::ImageInput::open(image.string());
  if (!input) return -1.0;
  const OIIO::ImageSpec& spec = input->spec();
  const auto channels = static_cast<std::size_t>(spec.nchannels);
  std::vector<unsigned char> values(static_cast<std::size_t>(spec.width * spec.height) * channels);
  input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeUInt8, values.data());
  std::vector<double> luminances;
  for (std::size_t i = 0; i < values.size(); i += channels) {
    if (values[i] == 222 && values[i + 1] == 232 && values[i + 2] == 242) continue;
    luminances.push_back((0.2126 * values[i] + 0.7152 * values[i + 1] + 0.0722 * values[i + 2]) / 255.0);
  }
  if (luminances.empty()) return -1.0;
  const auto middle = luminances.begin() + static_cast<std::ptrdiff_t>(luminances.size() / 2);
  std::ranges::nth_element(luminances, middle);
  return *middle;
}

class FirstHourTest : public ProgramTest {
 protected:
  Json info(const fs::path& cloud) {
    const ProgramResult result = run({"info", cloud.string(), "--json"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.exit_code == 0 ? Json::parse(result.out) : Json();
  }

  void expect_success(const Words& words) {
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  }
};

TEST_F(FirstHourTest, any_cloud_is_described_drawn_converted_and_asked) {
  const std::vector<fs::path> clouds = small_clouds();
  if (clouds.empty()) GTEST_SKIP() << absent("../shared/data");
  std::size_t poorly_lit = 0;
  for (const fs::path& cloud : clouds) {
    SCOPED_TRACE(cloud.filename().string());
    const Json facts = info(cloud);
    expect_success({"info", cloud.string(), "--stats"});

    const Words overview = {"render", cloud.string(), "--size",       "150x100",    "--samples",
                            "4",      "-o",           "overview.png", "--overwrite"};
    ProgramResult drawn = run(overview);
    if (drawn.exit_code == 2 && drawn.err.find("degrees") != std::string::npos) {
      EXPECT_NE(drawn.err.find("--reproject auto"), std::string::npos) << drawn.err;
      drawn = run(with(overview, {"--reproject", "auto"}));
    }
    EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
    const double luminance = median_luminance(folder / "overview.png");
    poorly_lit += luminance < 0.35 || luminance > 0.65;

    // As many points in every format.
    for (const char* const copy : {"copy.laz", "copy.ply", "copy.csv", "copy.alidade"}) {
      expect_success({"convert", cloud.string(), "-o", copy, "--overwrite"});
      EXPECT_EQ(info(folder / copy).at("points"), facts.at("points")) << copy;
    }

    // The western half and the rest are all.
    const Json& low = facts.at("bounds").at("min");
    const Json& high = facts.at("bounds").at("max");
    const std::string middle = Json((low[0].get<double>() + high[0].get<double>()) / 2.0).dump();
    std::uint64_t sum = 0;
    for (const std::string& condition : {"x < " + middle, "x >= " + middle}) {
      const ProgramResult half = run({"info", cloud.string(), "--json", "--where", condition});
      if (half.exit_code == 0) sum += Json::parse(half.out).at("points").get<std::uint64_t>();
    }
    EXPECT_EQ(sum, facts.at("points"));

    // The point nearest to the vertical line through the middle of the box.
    const std::string ray = middle + "," + Json((low[1].get<double>() + high[1].get<double>()) / 2.0).dump() +
                            "," + Json(high[2].get<double>() + 1.0).dump() + ",0,0,-1";
    const ProgramResult nearest = run({"query", cloud.string(), "--ray", ray, "--k", "1"});
    EXPECT_EQ(nearest.exit_code, 0) << nearest.err;
    EXPECT_EQ(std::ranges::count(nearest.out, '\n'), 2) << nearest.out;
  }
  // A cube of pure red, green and blue is dark whatever the exposure.
  EXPECT_LE(poorly_lit, 2u);
}

}  // namespace
}  // namespace alidade::test
