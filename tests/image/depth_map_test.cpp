// SPDX-License-Identifier: MIT
#include "image/depth_map.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "base/error.h"
#include "image/image_file.h"

namespace alidade::image {
namespace {

constexpr float k_infinity = std::numeric_limits<float>::infinity();

TEST(DepthMap, the_extension_is_the_format) {
  for (const NamedDepthFormat& known : k_depth_formats) {
    EXPECT_EQ(k_depth_formats[static_cast<std::size_t>(known.format)].name, known.name);
    for (const std::string_view extension : known.extensions)
      if (!extension.empty()) {
        EXPECT_EQ(depth_format("folder.x/a" + std::string(extension)), known.format);
      }
  }
  EXPECT_EQ(depth_format("A.TIFF"), DepthFormat::tiff);
  EXPECT_EQ(depth_format("IMG_1.JPG.geometric.bin"), DepthFormat::colmap);
  EXPECT_THROW(depth_format("a.jpg"), Error);
  EXPECT_THROW(depth_format("a"), Error);
}

TEST(DepthMap, floats_in_metres_keep_every_bit_and_0_is_no_depth) {
  const std::vector<float> depths{0.1f, 1e-30f, 12345.678f, k_infinity, -2.0f, 0.0f, 3e38f};
  for (const DepthFormat format :
       {DepthFormat::exr, DepthFormat::npy, DepthFormat::tiff, DepthFormat::colmap}) {
    DepthLoss loss;
    const std::vector<float> values = depth_values(depths, format, default_depth_scale(format), loss);
    EXPECT_EQ(values, (std::vector<float>{0.1f, 1e-30f, 12345.678f, 0.0f, 0.0f, 0.0f, 3e38f}));
    EXPECT_EQ(loss.behind, 2u);
    EXPECT_EQ(loss.too_far, 0u);
  }
}

TEST(DepthMap, png16_rounds_to_the_nearest_step_and_counts_what_is_too_far) {
  const std::vector<float> depths{1.2344f, 1.2346f, 65.535f, 65.536f, 200.0f, 1e-6f, k_infinity};
  DepthLoss loss;
  EXPECT_EQ(depth_values(depths, DepthFormat::png16, 1000.0, loss),
            (std::vector<float>{1234.0f, 1235.0f, 65535.0f, 0.0f, 0.0f, 1.0f, 0.0f}));
  EXPECT_EQ(loss.too_far, 2u);
  EXPECT_EQ(loss.farthest, 200.0);
  EXPECT_EQ(depth_values(depths, DepthFormat::png16, 100.0, loss)[4], 20000.0f);
  EXPECT_EQ(loss.too_far, 2u);
}

TEST(DepthMap, heads_are_those_of_numpy_and_colmap) {
  for (const int width : {1, 640, 65536}) {
    const std::string head = depth_map_head(DepthFormat::npy, width, 7);
    EXPECT_EQ(head.size() % 64, 0u);
    EXPECT_EQ(head.substr(0, 8), std::string("\x93NUMPY\x01\x00", 8));
    EXPECT_EQ(static_cast<unsigned char>(head[8]) + 256u * static_cast<unsigned char>(head[9]),
              head.size() - 10);
    EXPECT_EQ(head.back(), '\n');
    EXPECT_NE(head.find("'shape': (7, " + std::to_string(width) + "), }"), std::string::npos) << head;
  }
  EXPECT_EQ(depth_map_head(DepthFormat::colmap, 640, 7), "640&7&1&");
}

std::string read_bytes(const std::filesystem::path& file) {
  std::ostringstream bytes;
  bytes << std::ifstream(file, std::ios::binary).rdbuf();
  return bytes.str();
}

/// All channels of an image as floats; whole numbers as they are.
std::vector<float> read_pixels(const std::filesystem::path& file, OIIO::ImageSpec& spec) {
  const auto image = OIIO::ImageInput::open(file.string());
  if (!image) return {};
  spec = image->spec();
  std::vector<float> values(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height) *
                            static_cast<std::size_t>(spec.nchannels));
  image->read_image(0, 0, 0, spec.nchannels, OIIO::TypeFloat, values.data());
  const float largest = spec.format == OIIO::TypeUInt16  ? 65535.0f
                        : spec.format == OIIO::TypeUInt8 ? 255.0f
                                                         : 1.0f;
  for (float& value : values) value = largest == 1.0f ? value : std::round(value * largest);
  return values;
}

TEST(DepthMap, files_hold_the_values_and_have_the_same_bytes_each_time) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "alidade_depth_map_test";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directory(folder);
  constexpr int k_width = 37, k_height = 70;  // more rows than are encoded at once
  std::vector<float> depths;
  for (int i = 0; i < k_width * k_height; ++i)
    depths.push_back(i % 5 == 0 ? k_infinity : 0.25f + 60.0f * static_cast<float>(i) / (k_width * k_height));
  for (const NamedDepthFormat& known : k_depth_formats) {
    DepthLoss loss;
    const std::vector<float> values =
        depth_values(depths, known.format, default_depth_scale(known.format), loss);
    const std::filesystem::path file = folder / ("map" + std::string(known.extensions[0]));
    write_depth_map(values, k_width, k_height, known.format, {{"alidade:depth", "text"}}, file, false);
    EXPECT_THROW(write_depth_map(values, k_width, k_height, known.format, {}, file, false), Error);
    const std::string bytes = read_bytes(file);
    write_depth_map(values, k_width, k_height, known.format, {{"alidade:depth", "text"}}, file, true);
    EXPECT_TRUE(read_bytes(file) == bytes) << known.name;
    if (known.format == DepthFormat::npy || known.format == DepthFormat::colmap) {
      const std::string head = depth_map_head(known.format, k_width, k_height);
      ASSERT_EQ(bytes.size(), head.size() + values.size() * sizeof(float));
      EXPECT_EQ(std::memcmp(bytes.data() + head.size(), values.data(), values.size() * sizeof(float)), 0);
      continue;
    }
    OIIO::ImageSpec spec;
    const std::vector<float> read = read_pixels(file, spec);
    const auto channels = static_cast<std::size_t>(known.format == DepthFormat::exr ? 2 : 1);
    ASSERT_EQ(read.size(), channels * values.size()) << known.name;
    for (std::size_t i = 0; i < read.size(); ++i) ASSERT_EQ(read[i], values[i / channels]) << known.name;
    if (known.format == DepthFormat::exr) {
      EXPECT_EQ(spec.channelnames, (std::vector<std::string>{"Y", "Z"}));
    }
    EXPECT_EQ(spec.format, known.format == DepthFormat::png16 ? OIIO::TypeUInt16 : OIIO::TypeFloat);
  }
  const std::filesystem::path mask = folder / "mask.png";
  write_depth_mask(depths, k_width, k_height, mask, false);
  OIIO::ImageSpec spec;
  const std::vector<float> read = read_pixels(mask, spec);
  ASSERT_EQ(read.size(), depths.size());
  for (std::size_t i = 0; i < read.size(); ++i) EXPECT_EQ(read[i], i % 5 == 0 ? 0.0f : 255.0f);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace alidade::image
