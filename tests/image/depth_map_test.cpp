// SPDX-License-Identifier: MIT
#include "image/depth_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "base/error.h"

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

}  // namespace
}  // namespace alidade::image
