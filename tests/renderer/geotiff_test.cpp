// SPDX-License-Identifier: MIT
#include <gdal.h>
#include <gtest/gtest.h>
#include <ogr_srs_api.h>

#include <array>
#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "camera/camera.h"
#include "geo/gdal_reference.h"
#include "renderer/image_metadata.h"

namespace alidade::test {

using namespace geo;
using namespace image;
using namespace camera;
using namespace renderer;

namespace {

class GeotiffTest : public ::testing::Test {
 protected:
  void SetUp() override {
    GDALAllRegister();
    folder_ = std::filesystem::temp_directory_path() / "alidade_geotiff";
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  OutputSettings output(const std::string& name) const { return {.file = folder_ / name}; }
  std::string bytes_of(const std::string& name) const {
    std::ifstream stream(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  std::filesystem::path folder_;
};

/// 300 x 200 pixels of 0.5 m, so that tiles and rows are cut off at both edges.
Camera camera() {
  return orthophoto_camera({{690000, 5325000, 400}, {690150, 5325100, 420}}, 0.5);
}

Film film_of(const Camera& of) {
  Film film(of.width, of.height);
  for (int y = 0; y < of.height; ++y) {
    for (int x = 0; x < of.width; ++x) {
      film.color[film.index(x, y)] = {x / 300.0f, y / 200.0f, 0.25f};
      film.alpha[film.index(x, y)] = (x + y) % 2 == 0 ? 1.0f : 0.5f;
    }
  }
  return film;
}

Crs utm_32() {
  Crs crs;
  // GeoTIFF 1.1, chapter 7: version, revision, count; then projected type, raster type, EPSG 32632.
  crs.geotiff_keys = {1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32632};
  return crs;
}

std::string epsg_of(const char* wkt) {
  const OGRSpatialReferenceH reference = OSRNewSpatialReference(nullptr);
  char* text = const_cast<char*>(wkt);
  std::string code;
  if (OSRImportFromWkt(reference, &text) == OGRERR_NONE && OSRAutoIdentifyEPSG(reference) >= 0) {
    const char* const found = OSRGetAuthorityCode(reference, nullptr);
    if (found != nullptr) code = found;
  }
  OSRDestroySpatialReference(reference);
  return code;
}

TEST_F(GeotiffTest, pixels_lie_on_the_ground_and_in_the_reference_system) {
  ImageMetadata metadata;
  metadata.camera = camera();
  metadata.crs = utm_32();
  write_image(film_of(metadata.camera), output("a.tif"), metadata, false);
  const GDALDatasetH file = GDALOpen((folder_ / "a.tif").c_str(), GA_ReadOnly);
  ASSERT_NE(file, nullptr);
  EXPECT_EQ(GDALGetRasterXSize(file), 300);
  EXPECT_EQ(GDALGetRasterYSize(file), 200);
  std::array<double, 6> transform{};
  ASSERT_EQ(GDALGetGeoTransform(file, transform.data()), CE_None);
  EXPECT_EQ(transform, (std::array<double, 6>{690000, 0.5, 0, 5325100, 0, -0.5}));
  EXPECT_EQ(epsg_of(GDALGetProjectionRef(file)), "32632");
  EXPECT_EQ(GDALGetRasterCount(file), 4);
  EXPECT_EQ(GDALGetRasterColorInterpretation(GDALGetRasterBand(file, 4)), GCI_AlphaBand);
  EXPECT_NE(GDALGetMetadataItem(file, "alidade_camera_json", nullptr), nullptr);
  GDALClose(file);
}

TEST_F(GeotiffTest, values_are_those_of_a_png_with_alpha) {
  ImageMetadata metadata;
  metadata.camera = camera();
  const Film film = film_of(metadata.camera);
  write_image(film, output("a.tif"), metadata, false);
  write_image(film, output("a.png"), metadata, false);
  const GDALDatasetH tiff = GDALOpen((folder_ / "a.tif").c_str(), GA_ReadOnly);
  const GDALDatasetH png = GDALOpen((folder_ / "a.png").c_str(), GA_ReadOnly);
  ASSERT_TRUE(tiff != nullptr && png != nullptr);
  std::vector<std::uint8_t> a(300 * 200), b(300 * 200);
  for (int band = 1; band <= 4; ++band) {
    ASSERT_EQ(GDALRasterIO(GDALGetRasterBand(tiff, band), GF_Read, 0, 0, 300, 200, a.data(), 300, 200,
                           GDT_Byte, 0, 0),
              CE_None);
    if (band < 4) {
      ASSERT_EQ(GDALRasterIO(GDALGetRasterBand(png, band), GF_Read, 0, 0, 300, 200, b.data(), 300, 200,
                             GDT_Byte, 0, 0),
                CE_None);
      EXPECT_EQ(a, b) << band;
    } else {
      EXPECT_EQ(a[0], 255);
      EXPECT_EQ(a[1], 128);
    }
  }
  GDALClose(tiff);
  GDALClose(png);
}

TEST_F(GeotiffTest, same_film_gives_the_same_bytes) {
  ImageMetadata metadata;
  metadata.camera = camera();
  metadata.crs = utm_32();
  for (const char* const name : {"a.tif", "b.tif"})
    write_image(film_of(metadata.camera), output(name), metadata, false);
  EXPECT_GT(bytes_of("a.tif").size(), 1000u);
  EXPECT_TRUE(bytes_of("a.tif") == bytes_of("b.tif"));
}

TEST_F(GeotiffTest, a_reference_system_that_means_nothing_is_left_out) {
  ImageMetadata metadata;
  metadata.camera = camera();
  metadata.crs.wkt = "no reference system";
  write_image(film_of(metadata.camera), output("a.tif"), metadata, false);
  const GDALDatasetH file = GDALOpen((folder_ / "a.tif").c_str(), GA_ReadOnly);
  ASSERT_NE(file, nullptr);
  EXPECT_STREQ(GDALGetProjectionRef(file), "");
  GDALClose(file);
}

TEST_F(GeotiffTest, keys_of_any_kind_give_a_reference_system_or_nothing) {
  EXPECT_EQ(wkt_of(Crs()), "");
  Crs with_wkt = utm_32();
  with_wkt.wkt = "as it was";
  EXPECT_EQ(wkt_of(with_wkt), "as it was");
  EXPECT_EQ(epsg_of(wkt_of(utm_32()).c_str()), "32632");
  // Counts and indices beyond what is there.
  for (const std::vector<std::uint16_t>& keys : {std::vector<std::uint16_t>{1},
                                                 {1, 1, 0, 65535},
                                                 {1, 1, 0, 1, 3072, 34736, 200, 65535},
                                                 {1, 1, 0, 1, 1026, 34737, 65535, 65535},
                                                 {9, 9, 9, 9, 9, 9, 9}}) {
    Crs crs;
    crs.geotiff_keys = keys;
    EXPECT_NO_THROW(wkt_of(crs));
  }
}

TEST_F(GeotiffTest, a_camera_from_above_may_be_turned) {
  Camera turned = camera();
  turned.pose.right = {0.6, 0.8, 0.0};
  turned.pose.down = {0.8, -0.6, 0.0};
  turned.cx = 10.0;
  turned.cy = 20.0;
  const std::array<double, 6> transform = ground_transform(turned);
  // The camera is above pixel (10, 20).
  EXPECT_NEAR(transform[0] + 10.0 * transform[1] + 20.0 * transform[2], turned.pose.position.x, 1e-9);
  EXPECT_NEAR(transform[3] + 10.0 * transform[4] + 20.0 * transform[5], turned.pose.position.y, 1e-9);
  EXPECT_DOUBLE_EQ(transform[1], 0.3);
  EXPECT_DOUBLE_EQ(transform[4], 0.4);
  EXPECT_DOUBLE_EQ(transform[2], 0.4);
  EXPECT_DOUBLE_EQ(transform[5], -0.3);
}

TEST_F(GeotiffTest, other_cameras_are_an_error_and_leave_no_file) {
  ImageMetadata metadata;
  metadata.camera = pinhole_from_fov(8, 8, 50.0, look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}));
  EXPECT_THROW(write_image(Film(8, 8), output("a.tif"), metadata, false), Error);
  metadata.camera.lens = OrthographicLens{};
  metadata.camera.pose = look_at({0, 0, 5}, {1, 0, 0}, {0, 0, 1});
  EXPECT_THROW(write_image(Film(8, 8), output("a.tif"), metadata, false), Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

}  // namespace
}  // namespace alidade::test
