// SPDX-License-Identifier: MIT
#include <gdal.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "geo/raster_file.h"

namespace alidade::test {

using namespace geo;

namespace {

class ReadHeightsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    GDALAllRegister();
    folder_ = std::filesystem::temp_directory_path() / "alidade_read_heights";
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// 3 x 2 cells: the 16-bit numbers 1 to 6, in decimetres above 100; 5 is the no-data value.
  std::filesystem::path decimetres(std::array<double, 6> transform) const {
    const std::filesystem::path file = folder_ / "decimetres.tif";
    const GDALDatasetH raster =
        GDALCreate(GDALGetDriverByName("GTiff"), file.c_str(), 3, 2, 1, GDT_Int16, nullptr);
    GDALSetGeoTransform(raster, transform.data());
    const GDALRasterBandH band = GDALGetRasterBand(raster, 1);
    GDALSetRasterNoDataValue(band, 5.0);
    GDALSetRasterScale(band, 0.1);
    GDALSetRasterOffset(band, 100.0);
    std::array<std::int16_t, 6> values = {1, 2, 3, 4, 5, 6};
    EXPECT_EQ(GDALRasterIO(band, GF_Write, 0, 0, 3, 2, values.data(), 3, 2, GDT_Int16, 0, 0), CE_None);
    GDALClose(raster);
    return file;
  }

  std::filesystem::path folder_;
};

TEST_F(ReadHeightsTest, scale_offset_and_no_data_hold) {
  const HeightRaster raster = read_heights(decimetres({690000, 2, 0, 5325000, 0, -2}));
  EXPECT_EQ(raster.heights.grid, (RasterGrid{{690000, 5325000}, 2.0, 3, 2}));
  EXPECT_TRUE(raster.crs.empty());
  EXPECT_FLOAT_EQ(raster.heights.at(0, 0), 100.1f);
  EXPECT_FLOAT_EQ(raster.heights.at(2, 1), 100.6f);
  EXPECT_TRUE(std::isnan(raster.heights.at(1, 1)));
}

TEST_F(ReadHeightsTest, rows_come_from_the_north) {
  const HeightRaster raster = read_heights(decimetres({690000, 2, 0, 5324996, 0, 2}));
  EXPECT_EQ(raster.heights.grid, (RasterGrid{{690000, 5325000}, 2.0, 3, 2}));
  EXPECT_FLOAT_EQ(raster.heights.at(0, 1), 100.1f);
  EXPECT_TRUE(std::isnan(raster.heights.at(1, 0)));
}

TEST_F(ReadHeightsTest, rotated_sheared_and_oblong_cells_are_errors) {
  for (const std::array<double, 6>& transform : {std::array<double, 6>{0, 2, 0.1, 0, 0, -2},
                                                 {0, 2, 0, 0, 0.1, -2},
                                                 {0, 2, 0, 0, 0, -2.1},
                                                 {0, -2, 0, 0, 0, -2},
                                                 {0, 0, 2, 0, 2, 0},
                                                 {0, std::nan(""), 0, 0, 0, -2}})
    EXPECT_THROW(read_heights(decimetres(transform)), Error) << transform[1] << " " << transform[2];
}

TEST_F(ReadHeightsTest, an_undeclared_no_data_value_is_an_error) {
  Raster<float> heights({{0, 2}, 1.0, 2, 2}, 5.0f);
  for (const float height : {-3.4028235e38f, 2e6f}) {
    heights.at(1, 0) = height;
    write_raster(
        folder_ / "a.tif",
        {.grid = heights.grid, .bands = {{.values = std::span<const float>(heights.values)}}, .crs = {}},
        true);
    EXPECT_THROW(read_heights(folder_ / "a.tif"), Error) << height;
  }
}

TEST_F(ReadHeightsTest, rasters_are_told_by_their_content) {
  std::filesystem::rename(decimetres({0, 1, 0, 0, 0, -1}), folder_ / "heights");
  EXPECT_TRUE(is_raster(folder_ / "heights"));
  std::ofstream(folder_ / "points.xyz") << "0 0 1\n1 0 1\n0 1 1\n1 1 1\n";
  EXPECT_FALSE(is_raster(folder_ / "points.xyz"));
  std::ofstream(folder_ / "table.tif") << "x,y,z\n1,2,3\n";
  EXPECT_FALSE(is_raster(folder_ / "table.tif"));
  EXPECT_FALSE(is_raster(folder_ / "missing.tif"));
  EXPECT_THROW(read_heights(folder_ / "table.tif"), Error);
  EXPECT_THROW(read_heights(folder_ / "missing.tif"), Error);
}

TEST_F(ReadHeightsTest, reading_can_be_cancelled) {
  const std::filesystem::path file = decimetres({0, 1, 0, 0, 0, -1});
  EXPECT_THROW(read_heights(file, [](std::uint64_t, std::uint64_t) { return false; }), Cancelled);
}

}  // namespace
}  // namespace alidade::test
