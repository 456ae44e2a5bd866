// SPDX-License-Identifier: MIT
#include "geo/raster_file.h"

#include <gdal.h>
#include <gtest/gtest.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>

#include "base/error.h"

namespace alidade::test {

using namespace geo;

namespace {

class RasterFileTest : public ::testing::Test {
 protected:
  void SetUp() override {
    GDALAllRegister();
    folder_ = std::filesystem::temp_directory_path() / "alidade_raster_file";
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string bytes_of(const std::string& name) const {
    std::ifstream stream(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  std::filesystem::path folder_;
  RasterGrid grid_{{690000, 5325300}, 0.5, 1200, 600};
};

Crs utm_32() {
  Crs crs;
  // GeoTIFF 1.1, chapter 7: version, revision, count; then projected type, raster type, EPSG 32632.
  crs.geotiff_keys = {1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32632};
  return crs;
}

TEST_F(RasterFileTest, values_position_reference_system_and_metadata_come_back) {
  Raster<float> values(grid_, 0.0f);
  for (std::size_t i = 0; i < values.values.size(); ++i)
    values.values[i] = static_cast<float>(i % 977) * 0.25f;
  values.at(3, 2) = -9999.0f;
  RasterContents contents{.grid = grid_,
                          .bands = {{.values = std::span<const float>(values.values),
                                     .no_data = -9999.0,
                                     .description = "height"}},
                          .crs = utm_32(),
                          .metadata = {{"alidade_mode", "height"}}};
  write_raster(folder_ / "a.tif", contents, false);
  const GDALDatasetH file = GDALOpen((folder_ / "a.tif").c_str(), GA_ReadOnly);
  ASSERT_NE(file, nullptr);
  EXPECT_EQ(GDALGetRasterXSize(file), 1200);
  EXPECT_EQ(GDALGetRasterYSize(file), 600);
  std::array<double, 6> transform{};
  ASSERT_EQ(GDALGetGeoTransform(file, transform.data()), CE_None);
  EXPECT_EQ(transform, (std::array<double, 6>{690000, 0.5, 0, 5325300, 0, -0.5}));
  EXPECT_STREQ(GDALGetMetadataItem(file, "LAYOUT", "IMAGE_STRUCTURE"), "COG");
  EXPECT_STREQ(GDALGetMetadataItem(file, "AREA_OR_POINT", nullptr), "Area");
  EXPECT_STREQ(GDALGetMetadataItem(file, "alidade_mode", nullptr), "height");
  const OGRSpatialReferenceH reference = GDALGetSpatialRef(file);
  ASSERT_NE(reference, nullptr);
  EXPECT_STREQ(OSRGetAuthorityCode(reference, nullptr), "32632");
  const GDALRasterBandH band = GDALGetRasterBand(file, 1);
  EXPECT_EQ(GDALGetRasterDataType(band), GDT_Float32);
  EXPECT_EQ(GDALGetRasterNoDataValue(band, nullptr), -9999.0);
  EXPECT_STREQ(GDALGetDescription(band), "height");
  EXPECT_GE(GDALGetOverviewCount(band), 1);
  std::vector<float> read(grid_.size());
  ASSERT_EQ(GDALRasterIO(band, GF_Read, 0, 0, 1200, 600, read.data(), 1200, 600, GDT_Float32, 0, 0), CE_None);
  EXPECT_TRUE(std::ranges::equal(read, values.values));
  GDALClose(file);
}

TEST_F(RasterFileTest, every_kind_of_number_can_be_written) {
  const RasterGrid grid{{0, 2}, 1.0, 2, 2};
  const std::vector<std::uint8_t> bytes{0, 255, 1, 2};
  const std::vector<std::uint16_t> shorts{0, 65535, 1, 2};
  const std::vector<std::uint32_t> words{0, 4294967295u, 1, 2};
  const std::array<std::pair<RasterBand, GDALDataType>, 3> bands{
      {{{.values = std::span(bytes)}, GDT_Byte},
       {{.values = std::span(shorts)}, GDT_UInt16},
       {{.values = std::span(words)}, GDT_UInt32}}};
  for (const auto& [band, type] : bands) {
    write_raster(folder_ / "a.tif", {.grid = grid, .bands = {band}, .crs = {}}, true);
    const GDALDatasetH file = GDALOpen((folder_ / "a.tif").c_str(), GA_ReadOnly);
    ASSERT_NE(file, nullptr);
    EXPECT_EQ(GDALGetRasterDataType(GDALGetRasterBand(file, 1)), type);
    std::array<double, 4> read{};
    ASSERT_EQ(
        GDALRasterIO(GDALGetRasterBand(file, 1), GF_Read, 0, 0, 2, 2, read.data(), 2, 2, GDT_Float64, 0, 0),
        CE_None);
    EXPECT_GE(read[1], 255.0);
    EXPECT_EQ(read[3], 2.0);
    GDALClose(file);
  }
}

TEST_F(RasterFileTest, same_contents_give_the_same_bytes) {
  const Raster<std::uint8_t> values(grid_, 7);
  const RasterContents contents{
      .grid = grid_, .bands = {{.values = std::span(values.values)}}, .crs = utm_32()};
  write_raster(folder_ / "a.tif", contents, false);
  write_raster(folder_ / "b.tif", contents, false);
  EXPECT_GT(bytes_of("a.tif").size(), 500u);
  EXPECT_TRUE(bytes_of("a.tif") == bytes_of("b.tif"));
}

TEST_F(RasterFileTest, existing_files_stay_unless_they_may_be_replaced) {
  const Raster<std::uint8_t> values({{0, 1}, 1.0, 1, 1}, 7);
  const RasterContents contents{
      .grid = values.grid, .bands = {{.values = std::span(values.values)}}, .crs = {}};
  std::ofstream(folder_ / "a.tif") << "mine";
  EXPECT_THROW(write_raster(folder_ / "a.tif", contents, false), Error);
  EXPECT_EQ(bytes_of("a.tif"), "mine");
  EXPECT_NO_THROW(write_raster(folder_ / "a.tif", contents, true));
  EXPECT_NE(bytes_of("a.tif"), "mine");
}

TEST_F(RasterFileTest, bad_names_and_mixed_bands_are_errors) {
  const Raster<std::uint8_t> bytes({{0, 1}, 1.0, 1, 1}, 7);
  const Raster<float> floats({{0, 1}, 1.0, 1, 1}, 7.0f);
  const RasterBand byte_band{.values = std::span(bytes.values)},
      float_band{.values = std::span<const float>(floats.values)};
  EXPECT_THROW(write_raster(folder_ / "a.png", {.grid = bytes.grid, .bands = {byte_band}, .crs = {}}, false),
               Error);
  EXPECT_THROW(check_raster_name("map"), Error);
  EXPECT_NO_THROW(check_raster_name("map.TIFF"));
  EXPECT_THROW(write_raster(folder_ / "a.tif",
                            {.grid = bytes.grid, .bands = {byte_band, float_band}, .crs = {}}, false),
               Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

}  // namespace
}  // namespace alidade::test
