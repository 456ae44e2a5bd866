// SPDX-License-Identifier: MIT
#include "cloud/laz/laz_layout.h"

#include <gtest/gtest.h>

#include "cloud/las/las_header.h"

namespace alidade {
namespace {

TEST(LazLayoutTest, items_cover_the_record_of_every_format) {
  for (int format = 0; format < k_las_point_formats; ++format) {
    const std::size_t size =
        static_cast<std::size_t>(k_las_point_layouts[static_cast<std::size_t>(format)].size);
    EXPECT_EQ(standard_laz_layout(format, size).record_size(), size) << format;
    EXPECT_EQ(standard_laz_layout(format, size + 7).record_size(), size + 7) << format;
  }
}

TEST(LazLayoutTest, old_formats_are_pointwise_and_new_ones_layered) {
  for (int format = 0; format < k_las_point_formats; ++format) {
    EXPECT_EQ(standard_laz_layout(format, 100).compressor,
              format < 6 ? LazCompressor::pointwise_chunked : LazCompressor::layered);
  }
}

TEST(LazLayoutTest, items_are_those_that_writers_agree_on) {
  const std::vector<LazItem> of_5 = {{LazItemKind::point10, 20, 2},
                                     {LazItemKind::gps_time11, 8, 2},
                                     {LazItemKind::rgb12, 6, 2},
                                     {LazItemKind::wave_packet13, 29, 1},
                                     {LazItemKind::byte, 2, 2}};
  EXPECT_EQ(standard_laz_layout(5, 65).items, of_5);
  const std::vector<LazItem> of_10 = {{LazItemKind::point14, 30, 3},
                                      {LazItemKind::rgb_nir14, 8, 3},
                                      {LazItemKind::wave_packet14, 29, 3},
                                      {LazItemKind::byte14, 1, 3}};
  EXPECT_EQ(standard_laz_layout(10, 68).items, of_10);
  const std::vector<LazItem> of_7 = {{LazItemKind::point14, 30, 3}, {LazItemKind::rgb14, 6, 3}};
  EXPECT_EQ(standard_laz_layout(7, 36).items, of_7);
}

TEST(LazLayoutTest, chunks_have_50000_points_unless_a_writer_decides_otherwise) {
  EXPECT_EQ(standard_laz_layout(0, 20).chunk_size, 50000u);
  EXPECT_EQ(standard_laz_layout(0, 20, 256).chunk_size, 256u);
}

}  // namespace
}  // namespace alidade
