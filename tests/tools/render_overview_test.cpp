// SPDX-License-Identifier: MIT
// Images without a scene: framing, brightness, background; and rasters of the ground.
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cloud/las/write_las.h"
#include "geo/raster_file.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

struct Pixels {
  int width = 0, height = 0, channels = 0;
  std::vector<unsigned char> values;

  const unsigned char* at(int x, int y) const {
    return &values[static_cast<std::size_t>((y * width + x) * channels)];
  }
};

class RenderOverviewTest : public ProgramTest {
 protected:
  /// A slope of 60 x 60 points, 0.1 m apart, of a grey, in two classes; higher to the east.
  void write_slope(const std::string& name, std::uint16_t grey) {
    PointCloud cloud;
    cloud.lattice = {.scale = glm::dvec3(0.01), .offset = {1000, 2000, 50}};
    for (int i = 0; i < 3600; ++i) {
      cloud.positions.push_back({10 * (i % 60), 10 * (i / 60), i % 60});
      if (grey > 0) cloud.colors.push_back(Color16(grey));
      cloud.classifications.push_back(i % 60 < 30 ? 2 : 6);
      cloud.intensities.push_back(static_cast<std::uint16_t>(100 + i % 60));
    }
    write_las(folder / name, cloud);
  }

  /// A frame of 60 x 40 pixels of a slanted wall before a depth camera, the upper half red and the lower half
  /// blue.
  void write_frame(const std::string& name) {
    std::string text =
        "VERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nWIDTH 60\nHEIGHT 40\n"
        "VIEWPOINT 0 0 0 1 0 0 0\nDATA ascii\n";
    for (int cell = 0; cell < 60 * 40; ++cell) {
      const double depth = 2.0 + 0.01 * (cell % 60);
      text += fmt::format("{} {} {} {}\n", depth * (cell % 60 - 29.5) / 50.0,
                          depth * (cell / 60 - 19.5) / 50.0, depth, cell < 60 * 20 ? 0xff0000 : 0x0000ff);
    }
    write(name, text);
  }

  Pixels pixels_of(const std::string& name) const {
    Pixels pixels;
    // Colours as they are in the file.
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    const auto input = OIIO::ImageInput::open((folder / name).string(), &config);
    if (!input) return pixels;
    const OIIO::ImageSpec& spec = input->spec();
    pixels = {spec.width, spec.height, spec.nchannels, {}};
    pixels.values.resize(static_cast<std::size_t>(spec.width * spec.height * spec.nchannels));
    input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeUInt8, pixels.values.data());
    return pixels;
  }

  ProgramResult render(const std::string& cloud, const Words& words) {
    return run(with({"render", cloud, "--samples", "4", "--size", "96x64"}, words));
  }
};

bool is_background(const unsigned char* rgb) {
  return rgb[0] == 222 && rgb[1] == 232 && rgb[2] == 242;
}

TEST_F(RenderOverviewTest, points_fill_the_image_before_a_plain_background) {
  write_slope("slope.las", 30000);
  ASSERT_EQ(render("slope.las", {"-o", "slope.png"}).exit_code, 0);
  const Pixels pixels = pixels_of("slope.png");
  int left = 96, right = 0, top = 64, bottom = 0;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 96; ++x) {
      if (is_background(pixels.at(x, y))) continue;
      left = std::min(left, x), right = std::max(right, x);
      top = std::min(top, y), bottom = std::max(bottom, y);
    }
  }
  // One pair of sides is touched up to the margin; the other has equal margins.
  EXPECT_TRUE(left + (95 - right) <= 10 || top + (63 - bottom) <= 8)
      << left << ' ' << right << ' ' << top << ' ' << bottom;
  EXPECT_LE(std::abs(left - (95 - right)), 3);
  EXPECT_LE(std::abs(top - (63 - bottom)), 3);
}

TEST_F(RenderOverviewTest, a_frame_of_a_depth_camera_is_shown_as_the_camera_saw_it_from_index_files_too) {
  write_frame("frame.pcd");
  ASSERT_EQ(run({"index", "frame.pcd", "-o", "frame.alidade"}).exit_code, 0);
  for (const char* const cloud : {"frame.pcd", "frame.alidade"}) {
    const ProgramResult result = render(cloud, {"-o", "frame.png", "--overwrite"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const Pixels pixels = pixels_of("frame.png");
    for (int x = 4; x < 92; ++x) {
      const unsigned char *const top = pixels.at(x, 8), *const bottom = pixels.at(x, 55);
      EXPECT_GT(top[0], 2 * top[2]) << x;
      EXPECT_GT(bottom[2], 2 * bottom[0]) << x;
    }
  }
  EXPECT_TRUE(contains(run({"info", "frame.alidade"}).out, "depth camera at 0 0 0"));
}

TEST_F(RenderOverviewTest, scans_are_shown_from_the_side_where_their_scanner_stood) {
  // A wall from west to east that slopes up to the north, with a scanner in the north; its south-west corner
  // is red.
  std::string text = "20\n20\n0 9 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 9 0 1\n";
  for (int cell = 0; cell < 400; ++cell) {
    const double x = 0.1 * (cell % 20 - 9.5), y = 0.1 * (cell / 20 - 9.5);
    text +=
        fmt::format("{} {} 0 0.5 {} 0 {}\n", x, y - 9.0, x < 0 && y < 0 ? 255 : 0, x < 0 && y < 0 ? 0 : 255);
  }
  write("site.ptx", text);
  ASSERT_EQ(render("site.ptx", {"-o", "site.png"}).exit_code, 0);
  const Pixels pixels = pixels_of("site.png");
  // From the north, west is to the right and south is at the top.
  int red_right = 0, red_elsewhere = 0;
  for (int i = 0; i < 96 * 64; ++i) {
    const unsigned char* const pixel = pixels.at(i % 96, i / 96);
    if (pixel[0] > 2 * pixel[2]) (i % 96 >= 47 && i / 96 <= 33 ? red_right : red_elsewhere) += 1;
  }
  EXPECT_GT(red_right, 100);
  EXPECT_LT(red_elsewhere, red_right / 10);
}

TEST_F(RenderOverviewTest, dark_and_bright_clouds_get_the_same_brightness) {
  for (const int grey : {12000, 60000}) {
    write_slope("slope.las", static_cast<std::uint16_t>(grey));
    const ProgramResult result = render("slope.las", {"-o", "slope.png", "--overwrite"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(contains(result.err, "exposure ")) << result.err;
    const Pixels pixels = pixels_of("slope.png");
    std::vector<int> greens;
    for (int i = 0; i < 96 * 64; ++i)
      if (!is_background(pixels.at(i % 96, i / 96))) greens.push_back(pixels.at(i % 96, i / 96)[1]);
    std::ranges::sort(greens);
    EXPECT_NEAR(greens[greens.size() / 2] / 255.0, 0.47, 0.06) << grey;
    std::filesystem::remove(folder / "slope.las");
  }
}

TEST_F(RenderOverviewTest, a_given_exposure_and_other_modes_are_not_changed) {
  write_slope("slope.las", 30000);
  EXPECT_FALSE(contains(render("slope.las", {"-o", "a.png", "--exposure", "0"}).err, "exposure "));
  EXPECT_FALSE(contains(render("slope.las", {"-o", "b.png", "--mode", "flat"}).err, "exposure "));
  EXPECT_FALSE(contains(render("slope.las", {"-o", "c.exr"}).err, "exposure "));
}

TEST_F(RenderOverviewTest, parts_and_threads_give_the_bytes_of_the_whole) {
  write_slope("slope.las", 30000);
  const auto image = [&](const Words& words) { ASSERT_EQ(render("slope.las", words).exit_code, 0); };
  image({"-o", "whole.png", "--threads", "1"});
  image({"-o", "parts.png", "--part", "1/2"});
  image({"-o", "parts.png", "--part", "2/2"});
  ASSERT_EQ(run({"merge", "parts.png.part1of2", "parts.png.part2of2", "-o", "merged.png"}).exit_code, 0);
  EXPECT_EQ(pixels_of("merged.png").values, pixels_of("whole.png").values);
}

TEST_F(RenderOverviewTest, transparent_images_have_alpha_where_no_surface_is) {
  write_slope("slope.las", 30000);
  ASSERT_EQ(render("slope.las", {"-o", "slope.png", "--transparent"}).exit_code, 0);
  const Pixels pixels = pixels_of("slope.png");
  ASSERT_EQ(pixels.channels, 4);
  EXPECT_EQ(pixels.at(0, 0)[3], 0);
  EXPECT_EQ(pixels.at(48, 32)[3], 255);
  int between = 0;
  for (int i = 0; i < 96 * 64; ++i) {
    const unsigned char* const pixel = pixels.at(i % 96, i / 96);
    if (pixel[3] == 0 || pixel[3] == 255) continue;
    ++between;
    // Edges are as bright as what they are the edge of: nothing of the sky is in them.
    EXPECT_LT(pixel[0], 215);
  }
  EXPECT_GT(between, 10);
  EXPECT_TRUE(contains(render("slope.las", {"-o", "slope.jpg", "--transparent"}).err, "JPEG has no alpha"));
}

TEST_F(RenderOverviewTest, rasters_of_the_ground_are_those_of_the_points) {
  write_slope("slope.las", 0);
  const ProgramResult result =
      run({"render", "slope.las", "--orthographic", "top", "--resolution", "0.5", "--samples", "2", "-o",
           "site.tif", "--layers", "color,elevation,intensity,classification,density,count"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(names(), (std::vector<std::string>{"site.tif", "site_classification.tif", "site_count.tif",
                                               "site_density.tif", "site_elevation.tif", "site_intensity.tif",
                                               "slope.las"}));
  const geo::Raster<float> heights = geo::read_heights(folder / "site_elevation.tif").heights;
  const geo::Raster<float> counts = geo::read_heights(folder / "site_count.tif").heights;
  double points = 0.0;
  for (int row = 0; row < heights.grid.rows; ++row) {
    for (int column = 0; column < heights.grid.columns; ++column) {
      const float count = counts.at(column, row);
      points += std::isnan(count) ? 0.0 : count;
      const glm::dvec2 center = heights.grid.center(column, row);
      const bool is_inside = center.x > 1000.2 && center.x < 1005.7 && center.y > 2000.2 && center.y < 2005.7;
      if (is_inside) {
        EXPECT_NEAR(heights.at(column, row), 50.0 + 0.1 * (center.x - 1000.0), 0.01);
        EXPECT_EQ(count, 25.0f);
      }
    }
  }
  EXPECT_EQ(points, 3600.0);
  ASSERT_EQ(run({"render", "slope.las", "--orthographic", "top", "--resolution", "0.5", "-o", "dsm.tif",
                 "--layers", "elevation"})
                .exit_code,
            0);
  EXPECT_EQ(geo::read_heights(folder / "dsm.tif").heights.values.size(), heights.values.size());
  const std::string info = shell_output("gdalinfo site_classification.tif", folder);
  if (!info.empty()) {
    EXPECT_TRUE(contains(info, "Type=Byte")) << info;
    EXPECT_TRUE(contains(info, "NoData Value=255")) << info;
    EXPECT_TRUE(contains(info, "LAYOUT=COG")) << info;
  }
}

TEST_F(RenderOverviewTest, rasters_without_an_orthophoto_are_an_error) {
  write_slope("slope.las", 30000);
  EXPECT_TRUE(contains(render("slope.las", {"-o", "a.png", "--layers", "elevation"}).err,
                       "layers of the ground require an orthophoto; expected --orthographic top"));
  EXPECT_TRUE(contains(render("slope.las", {"-o", "a.tif", "--layers", "hight"}).err, "unknown layer"));
}

}  // namespace
}  // namespace alidade::test
