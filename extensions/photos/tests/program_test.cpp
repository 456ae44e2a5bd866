// SPDX-License-Identifier: MIT
#include <cpl_vsi.h>
#include <gdal.h>
#include <ogr_api.h>
#include <ogrsf_frmts.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "cloud/read_cloud.h"
#include "geo/gdal_reference.h"
#include "tests/cloud/e57/e57_builder.h"
#include "tests/tools/wall_site.h"

namespace alidade::test {
namespace {

/// The wall site with a COLMAP model of two cameras, west and east of the wall and towards it, and their
/// photos, a red and a green one.
class VisibilityPhotosTest : public WallSiteTest {
 protected:
  void SetUp() override {
    WallSiteTest::SetUp();
    std::filesystem::create_directories(folder / "sparse");
    std::filesystem::create_directories(folder / "images");
    write("sparse/cameras.txt", "1 PINHOLE 80 60 60 60 40 30\n");
    write_images("images/", {-4, 0, 1}, {4, 0, 1});
    write("sparse/points3D.txt", "");
    write_photo("images/west.ppm", 80, 60, "200 0 0 ");
    write_photo("images/east.ppm", 80, 60, "0 100 0 ");
  }
  /// Cameras that look to +x and -x.
  void write_images(const std::string& prefix, const glm::dvec3& west, const glm::dvec3& east) {
    write("sparse/images.txt",
          fmt::format("1 0.5 0.5 -0.5 0.5 {} {} {} 1 {}west.ppm\n\n", west.y, west.z, -west.x, prefix) +
              fmt::format("2 0.5 0.5 0.5 -0.5 {} {} {} 1 {}east.ppm\n\n", -east.y, east.z, east.x, prefix));
  }
  void write_photo(const std::string& name, int width, int height, const std::string& pixel) {
    std::string text = fmt::format("P3\n{} {}\n255\n", width, height);
    for (int i = 0; i < width * height; ++i) text += pixel + (i % 5 == 4 ? "\n" : "");
    write(name, text);
  }
  ProgramResult photos(const Words& more) {
    return run(with({"visibility", "photos", "site.csv", "--camera", "sparse"}, more));
  }
  void expect_problem(const Words& more, const std::string& part) {
    const ProgramResult result = photos(more);
    EXPECT_EQ(result.exit_code, 2) << part;
    EXPECT_TRUE(contains(result.err, part)) << result.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "seen.las"));
    EXPECT_FALSE(std::filesystem::exists(folder / "foot.gpkg"));
  }
};

template <class Value>
std::vector<Value> column(const PointCloud& cloud, const std::string& name, ScalarType type) {
  std::vector<Value> values(cloud.size());
  for (const ExtraDimension& dimension : cloud.extra_dimensions) {
    if (dimension.name != name || dimension.type != type) continue;
    std::memcpy(values.data(), dimension.values.data(), values.size() * sizeof(Value));
    return values;
  }
  ADD_FAILURE() << name << " is missing, or of another type";
  return values;
}

const Words k_colored = {"--photos", ".", "--colorize", "-o", "seen.las"};

TEST_F(VisibilityPhotosTest, points_have_counts_photos_and_colours_of_their_own_side) {
  const ProgramResult result = photos(k_colored);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const PointCloud cloud = read_cloud(folder / "seen.las");
  const auto counts = column<std::uint32_t>(cloud, "PhotoCount", ScalarType::uint32);
  const auto best = column<std::uint32_t>(cloud, "BestPhoto", ScalarType::uint32);
  const auto sampling = column<float>(cloud, "GroundSampling", ScalarType::float32);
  ASSERT_EQ(cloud.colors.size(), cloud.size());
  std::size_t west = 0, both = 0;
  for (std::size_t id = 0; id < cloud.size(); ++id) {
    const glm::dvec3 at = cloud.world(id);
    ASSERT_EQ(std::isnan(sampling[id]), counts[id] == 0);
    if (counts[id] == 0) {
      ASSERT_EQ(cloud.colors[id], Color16(0, 0, 0));
    }
    both += counts[id] == 2;
    if (counts[id] != 1 || std::fabs(at.x) < 0.5 || std::fabs(at.y) > 2.0) continue;
    // By name the eastern one is the first.
    ASSERT_EQ(best[id], at.x < 0 ? 2u : 1u) << at.x << " " << at.y;
    ASSERT_EQ(cloud.colors[id], at.x < 0 ? Color16(200 * 257, 0, 0) : Color16(0, 100 * 257, 0));
    west += at.x < 0;
  }
  EXPECT_GT(west, 50u);
  EXPECT_GT(both, 400u) << "the wall";
  EXPECT_TRUE(contains(result.err, "points: no photo sees ")) << result.err;
  EXPECT_TRUE(contains(result.err, "2 photos; median ground sampling distance 0.0")) << result.err;
  EXPECT_TRUE(contains(result.err, " are black")) << result.err;
}

TEST_F(VisibilityPhotosTest, points_that_no_photo_sees_keep_their_colour) {
  ASSERT_EQ(photos(k_colored).exit_code, 0);
  // The photos are found without the folder of their names, too.
  const ProgramResult again = run({"visibility", "photos", "seen.las", "--camera", "sparse", "--camera-name",
                                   "west.ppm", "--photos", "images", "--colorize", "-o", "again.las"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_TRUE(contains(again.err, " keep the colour they had")) << again.err;
  EXPECT_TRUE(contains(again.err, "replacing the cloud's PhotoCount")) << again.err;
  const PointCloud first = read_cloud(folder / "seen.las"), second = read_cloud(folder / "again.las");
  const auto counts = column<std::uint32_t>(second, "PhotoCount", ScalarType::uint32);
  std::size_t green = 0;
  for (std::size_t id = 0; id < second.size(); ++id) {
    ASSERT_EQ(second.colors[id], counts[id] > 0 ? Color16(200 * 257, 0, 0) : first.colors[id]);
    green += second.colors[id].g > 0;
  }
  EXPECT_GT(green, 50u);
}

TEST_F(VisibilityPhotosTest, gdal_opens_footprints_and_overlaps) {
  const ProgramResult result = photos({"--footprints", "foot.gpkg", "--footprint-cell", "0.5"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  RegisterOGRGeoPackage();
  const geo::GdalDataset dataset(
      GDALOpenEx((folder / "foot.gpkg").c_str(), GDAL_OF_VECTOR, nullptr, nullptr, nullptr));
  ASSERT_TRUE(dataset);
  const OGRLayerH layer = GDALDatasetGetLayerByName(dataset.get(), "footprints");
  ASSERT_NE(layer, nullptr);
  ASSERT_EQ(OGR_L_GetFeatureCount(layer, 1), 2);
  double east_points = 0.0;
  while (const geo::GdalHandle<OGR_F_Destroy> feature{OGR_L_GetNextFeature(layer)}) {
    const auto number = [&](const char* name) {
      return OGR_F_GetFieldAsDouble(feature.get(), OGR_F_GetFieldIndex(feature.get(), name));
    };
    const bool is_east = number("number") == 1.0;
    EXPECT_STREQ(OGR_F_GetFieldAsString(feature.get(), 1), is_east ? "images/east.ppm" : "images/west.ppm");
    EXPECT_NEAR(number("x"), is_east ? 4 : -4, 1e-12);
    EXPECT_NEAR(number("z"), 1.0, 1e-12);
    EXPECT_NEAR(number("share"), number("points") / (51 * 51 + 61 * 20), 1e-12);
    EXPECT_GT(number("overlap"), 0.5);
    EXPECT_NEAR(number("sampling"), 4.0 / 60, 0.02);
    EXPECT_NEAR(number("distance"), 4.0, 1.0);
    const OGRGeometryH shape = OGR_F_GetGeometryRef(feature.get());
    ASSERT_NE(shape, nullptr);
    EXPECT_EQ(OGR_G_IsValid(shape), 1);
    EXPECT_GT(OGR_G_Area(shape), 4.0);
    if (is_east) east_points = number("points");
  }
  const OGRLayerH overlaps = GDALDatasetGetLayerByName(dataset.get(), "overlaps");
  ASSERT_EQ(OGR_L_GetFeatureCount(overlaps, 1), 1);
  const geo::GdalHandle<OGR_F_Destroy> pair(OGR_L_GetNextFeature(overlaps));
  EXPECT_NEAR(OGR_F_GetFieldAsDouble(pair.get(), 5),
              static_cast<double>(OGR_F_GetFieldAsInteger64(pair.get(), 4)) / east_points, 1e-2);
}

TEST_F(VisibilityPhotosTest, outputs_do_not_depend_on_threads_or_checkpoints) {
  for (const char* const threads : {"1", "2"}) {
    const std::string name = threads;
    ASSERT_EQ(photos({"--photos", ".", "--colorize", "-o", "p" + name + ".las", "--footprints",
                      "f" + name + ".gpkg", "--threads", name, "--checkpoint", "state" + name})
                  .exit_code,
              0);
    EXPECT_FALSE(std::filesystem::exists(folder / ("state" + name)));
  }
  EXPECT_TRUE(read("p1.las") == read("p2.las"));
  EXPECT_TRUE(read("f1.gpkg") == read("f2.gpkg"));
}

TEST_F(VisibilityPhotosTest, photos_without_a_point_are_named) {
  // East of everything and towards the east.
  write("sparse/images.txt", read("sparse/images.txt") + "3 0.5 0.5 -0.5 0.5 0 1 -100 1 away.ppm\n\n");
  const ProgramResult some = photos({"-o", "seen.las"});
  EXPECT_EQ(some.exit_code, 0) << some.err;
  EXPECT_TRUE(contains(some.err, "1 of 3 photos see no point: 'away.ppm'")) << some.err;
}

TEST_F(VisibilityPhotosTest, bad_photos_are_errors) {
  std::filesystem::remove(folder / "images/west.ppm");
  expect_problem(k_colored,
                 "the photo of camera 'images/west.ppm' is missing; expected a file of that name, or "
                 "--camera-name to choose cameras, found 1 of 2 photos");
  write_photo("images/west.ppm", 40, 30, "1 2 3 ");
  expect_problem(
      k_colored,
      "west.ppm: the size of the photo differs from that of camera 'images/west.ppm'; expected 80 x 60 "
      "pixels: the photo that the camera was computed for, found 40 x 30");
  write_photo("images/west.ppm", 60, 80, "1 2 3 ");
  expect_problem(k_colored, "expected 80 x 60 pixels, not turned, found 60 x 80");
}

TEST_F(VisibilityPhotosTest, bad_requests_are_errors) {
  expect_problem({}, "missing output");
  expect_problem({"--colorize", "-o", "seen.las"}, "--colorize requires the photos");
  expect_problem({"--footprints", "foot.shp"}, "expected the extension .gpkg");
  expect_problem({"-o", "seen.las", "--camera-name", "west", "--camera-name", "west.ppm"},
                 "sparse: duplicate camera 'images/west.ppm'; expected each --camera-name once");
}

TEST_F(VisibilityPhotosTest, cameras_elsewhere_are_an_error_that_guesses_why) {
  write_images("", {690000, 5325000, 600}, {690008, 5325000, 600});
  expect_problem(
      {"-o", "seen.las"},
      "sparse: no point of the cloud is in the frame of any photo; expected cameras in the reference "
      "system of the cloud: theirs is another one, found cameras at x 690000 to 690008");
}

/// A file of GDAL's format "PNG" or "JPEG" in one colour.
std::string encoded_photo(const char* format, int width, int height,
                          const std::array<std::uint8_t, 3>& color) {
  GDALAllRegister();
  const geo::GdalDataset plain(
      GDALCreate(GDALGetDriverByName("MEM"), "", width, height, 3, GDT_Byte, nullptr));
  for (int band = 0; band < 3; ++band)
    GDALFillRaster(GDALGetRasterBand(plain.get(), band + 1), color[static_cast<std::size_t>(band)], 0.0);
  const char* const name = "/vsimem/photo";
  GDALClose(GDALCreateCopy(GDALGetDriverByName(format), name, plain.get(), 0, nullptr, nullptr, nullptr));
  vsi_l_offset size = 0;
  const auto* bytes = reinterpret_cast<const char*>(VSIGetMemFileBuffer(name, &size, 0));
  std::string photo(bytes, size);
  VSIUnlink(name);
  return photo;
}

/// A floor and the wall across it in one E57 file, with a red photo west of the wall and a green panorama
/// east of it.
class VisibilityE57PhotosTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write("site.e57", site(encoded_photo("PNG", 80, 60, {200, 0, 0})));
  }
  static std::string site(const std::string& west_photo) {
    std::vector<double> x, y, z;
    for (int i = 0; i < 51 * 51; ++i) {
      x.push_back(0.2 * (i % 51) - 5.0);
      y.push_back(0.2 * (i / 51) - 5.0);
      z.push_back(0.0);
    }
    for (int i = 0; i < 61 * 20; ++i) {
      x.push_back(0.0);
      y.push_back(0.1 * (i % 61) - 3.0);
      z.push_back(0.1 * (i / 61 + 1));
    }
    E57Builder builder;
    builder.add_scan(
        pose_element("1 0 0 0", "100 200 5"),
        {float64_column("cartesianX", x), float64_column("cartesianY", y), float64_column("cartesianZ", z)});
    const auto image = [&](const std::string& name, const std::string& pose, const std::string& projection,
                           const std::string& photo, const std::string& facts) {
      builder.add_image("<name type=\"String\">" + name + "</name>" + pose + "<" + projection +
                        "Representation type=\"Structure\"><" + photo + "/>" + facts + "</" + projection +
                        "Representation>");
    };
    const auto number = [](const std::string& name, double value) {
      return fmt::format("<{0} type=\"Float\">{1}</{0}>", name, value);
    };
    // The camera's axes, right, up and backward, are -y, z and -x of the site.
    image("west", pose_element("0.5 0.5 -0.5 -0.5", "96 200 6"), "pinhole",
          "pngImage" + builder.add_blob(west_photo),
          number("imageWidth", 80) + number("imageHeight", 60) + number("focalLength", 0.06) +
              number("pixelWidth", 0.001) + number("pixelHeight", 0.001) + number("principalPointX", 40) +
              number("principalPointY", 30));
    const double pixel = 0.0490874;  // 2 pi / 128, rounded
    image("around", pose_element("1 0 0 0", "104 200 6"), "spherical",
          "jpegImage" + builder.add_blob(encoded_photo("JPEG", 128, 64, {0, 100, 0})),
          number("imageWidth", 128) + number("imageHeight", 64) + number("pixelWidth", pixel) +
              number("pixelHeight", pixel));
    return builder.file();
  }
  ProgramResult photos(const Words& more) {
    return run(with({"visibility", "photos", "site.e57", "--camera", "site.e57"}, more));
  }
};

TEST_F(VisibilityE57PhotosTest, points_get_the_colours_of_the_photos_in_their_own_file) {
  const ProgramResult result = photos({"--colorize", "-o", "seen.las"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const PointCloud cloud = read_cloud(folder / "seen.las");
  const auto counts = column<std::uint32_t>(cloud, "PhotoCount", ScalarType::uint32);
  ASSERT_EQ(cloud.colors.size(), cloud.size());
  std::size_t west = 0, east = 0;
  for (std::size_t id = 0; id < cloud.size(); ++id) {
    const glm::dvec3 at = cloud.world(id) - glm::dvec3(100, 200, 5);
    if (std::fabs(at.x) < 0.5 || std::fabs(at.y) > 2.0) continue;
    // The panorama sees all of its side, also below itself; at its edges discs of the wall may hide points.
    if (at.x > 1.5) {
      ASSERT_EQ(counts[id], 1u) << at.x << " " << at.y;
    }
    if (counts[id] != 1) continue;
    const Color16 color = cloud.colors[id];
    ASSERT_NEAR(color.r, at.x < 0 ? 200 * 257 : 0, 3 * 257) << at.x << " " << at.y;
    ASSERT_NEAR(color.g, at.x < 0 ? 0 : 100 * 257, 3 * 257) << at.x << " " << at.y;
    ++(at.x < 0 ? west : east);
  }
  EXPECT_GT(west, 50u);
  EXPECT_GT(east, 300u);
}

TEST_F(VisibilityE57PhotosTest, cameras_are_chosen_by_name_and_rendered) {
  const ProgramResult one = photos({"--camera-name", "west", "--colorize", "-o", "west.las"});
  ASSERT_EQ(one.exit_code, 0) << one.err;
  EXPECT_TRUE(contains(one.err, "1 photo;")) << one.err;
  const ProgramResult rendered = run({"render", "--cloud", "site.e57", "--camera", "site.e57", "--mode",
                                      "flat", "--samples", "1", "-o", "%s.png", "-q"});
  EXPECT_EQ(rendered.exit_code, 0) << rendered.err;
  EXPECT_EQ(names(), (Words{"around.png", "site.e57", "west.las", "west.png"}));
}

TEST_F(VisibilityE57PhotosTest, bad_photos_are_errors) {
  const auto expect_problem = [&](const std::string& photo, const std::string& part) {
    write("site.e57", site(photo));
    const ProgramResult result = photos({"--colorize", "-o", "seen.las"});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(contains(result.err, part)) << result.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "seen.las"));
  };
  expect_problem(
      encoded_photo("PNG", 40, 30, {1, 2, 3}),
      "site.e57/west.png: the size of the photo differs from that of camera 'west'; expected 80 x 60");
  expect_problem("no picture", "site.e57/west.bin: cannot read the image");
  const std::string photo = encoded_photo("PNG", 80, 60, {200, 0, 0});
  expect_problem(photo.substr(0, photo.size() / 2), "site.e57/west.png: ");
}

TEST_F(VisibilityE57PhotosTest, files_without_photos_are_errors) {
  E57Builder builder;
  builder.add_scan("", {float64_column("cartesianX", {1}), float64_column("cartesianY", {1}),
                        float64_column("cartesianZ", {1})});
  write("bare.e57", builder.file());
  const ProgramResult result =
      run({"visibility", "photos", "site.e57", "--camera", "bare.e57", "--colorize", "-o", "seen.las"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "bare.e57: the E57 file has no photos")) << result.err;
}

}  // namespace
}  // namespace alidade::test
