// SPDX-License-Identifier: MIT
// Elevation rasters beside and instead of points in the commands of `alidade visibility`.
#include <gdal.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "cloud/las/write_las.h"
#include "geo/raster_file.h"
#include "tests/tools/resume_test.h"
#include "tests/tools/wall_site.h"

namespace alidade::test {
namespace {

using Json = nlohmann::json;

constexpr float k_hole = std::numeric_limits<float>::quiet_NaN();
const std::string k_utm =
    R"(PROJCS["WGS 84 / UTM zone 32N",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",)"
    R"(6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433],)"
    R"(AUTHORITY["EPSG","4326"]],PROJECTION["Transverse_Mercator"],)"
    R"(PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",9],)"
    R"(PARAMETER["scale_factor",0.9996],PARAMETER["false_easting",500000],)"
    R"(PARAMETER["false_northing",0],UNIT["metre",1],AUTHORITY["EPSG","32632"]])";

class VisibilityTerrainTest : public WallSiteTest {
 protected:
  void SetUp() override {
    WallSiteTest::SetUp();
    GDALAllRegister();
    write_heights("ridge.tif", ridge());
  }

  /// Level ground at 0 from -10 to 10 in cells of 0.5, with a ridge 5 high along x = -1.75, from y = -3 to 3.
  static geo::Raster<float> ridge() {
    geo::Raster<float> heights({{-10, 10}, 0.5, 40, 40}, 0.0f);
    for (int row = 14; row < 26; ++row) heights.at(16, row) = 5.0f;
    return heights;
  }

  void write_heights(const std::string& name, const geo::Raster<float>& heights,
                     const std::string& wkt = {}) {
    geo::RasterContents contents{
        .grid = heights.grid,
        .bands = {{.values = std::span<const float>(heights.values), .no_data = -9999.0}},
        .crs = {}};
    contents.crs.wkt = wkt;
    geo::write_raster(folder / name, contents, true);
  }

  /// ridge.tif under another georeference.
  void write_virtual(const std::string& name, const std::string& transform, const std::string& system = {}) {
    write(name, "<VRTDataset rasterXSize=\"40\" rasterYSize=\"40\">" +
                    (system.empty() ? "" : "<SRS>" + system + "</SRS>") +
                    (transform.empty() ? "" : "<GeoTransform>" + transform + "</GeoTransform>") +
                    "<VRTRasterBand dataType=\"Float32\" band=\"1\"><SimpleSource><SourceFilename "
                    "relativeToVRT=\"1\">ridge.tif</SourceFilename><SourceBand>1</SourceBand></SimpleSource>"
                    "</VRTRasterBand></VRTDataset>\n");
  }

  ProgramResult visibility(const std::string& command, const Words& words) {
    ProgramResult result = run(with(with({"visibility", command}, words), {"--overwrite"}));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result;
  }

  void expect_error(const std::string& command, const Words& words, const std::string& part) {
    const ProgramResult result = run(with(with({"visibility", command}, words), {"--overwrite"}));
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_TRUE(contains(result.err, part)) << result.err;
  }

  /// Values of the first band of a map and its georeference.
  std::vector<double> read_map(const std::string& name, std::array<double, 6>& transform, int& columns) {
    const GDALDatasetH file = GDALOpen((folder / name).c_str(), GA_ReadOnly);
    if (file == nullptr) return {};
    GDALGetGeoTransform(file, transform.data());
    columns = GDALGetRasterXSize(file);
    const int rows = GDALGetRasterYSize(file);
    std::vector<double> values(static_cast<std::size_t>(columns) * rows);
    EXPECT_EQ(GDALRasterIO(GDALGetRasterBand(file, 1), GF_Read, 0, 0, columns, rows, values.data(), columns,
                           rows, GDT_Float64, 0, 0),
              CE_None);
    GDALClose(file);
    return values;
  }
};

TEST_F(VisibilityTerrainTest, a_raster_alone_is_seen_on_its_own_cells) {
  const ProgramResult result =
      visibility("raster", {"ridge.tif", "--observer", "-5.2,0", "-o", "seen.tif", "--preview", "seen.png"});
  EXPECT_TRUE(contains(result.err, "terrain of 40 x 40 cells of 0.5, 0 to 5 high, from ridge.tif"))
      << result.err;
  EXPECT_TRUE(contains(result.err, "eye at -5.200, 0.000, 2.000")) << result.err;
  std::array<double, 6> transform{};
  int columns = 0;
  const std::vector<double> values = read_map("seen.tif", transform, columns);
  ASSERT_EQ(values.size(), 1600u);
  EXPECT_EQ(transform, (std::array<double, 6>{-10, 0.5, 0, 10, 0, -0.5}));
  // Behind the ridge all is hidden in its shadow, and beside it nothing is.
  EXPECT_EQ(values[20 * 40 + 10], 255.0);
  EXPECT_EQ(values[20 * 40 + 30], 0.0);
  EXPECT_EQ(values[2 * 40 + 18], 255.0);
  EXPECT_EQ(values[20 * 40 + 16], 255.0) << "the ridge itself";
  // A part of it keeps the cells, and a resolution makes others.
  visibility("raster", {"ridge.tif", "--observer", "-5.2,0", "--extent", "-6.1,-1,3,2.2", "-o", "part.tif"});
  const std::vector<double> part = read_map("part.tif", transform, columns);
  EXPECT_EQ(transform, (std::array<double, 6>{-6.5, 0.5, 0, 2.5, 0, -0.5}));
  EXPECT_EQ(columns, 19);
  EXPECT_EQ(part.size(), 19u * 7u);
  EXPECT_EQ(part[0], values[15 * 40 + 7]);
  visibility("raster", {"ridge.tif", "--observer", "-5.2,0", "--resolution", "2", "-o", "coarse.tif"});
  EXPECT_EQ(read_map("coarse.tif", transform, columns).size(), 100u);
}

TEST_F(VisibilityTerrainTest, heights_are_seen_over_a_raster_alone) {
  visibility("raster", {"ridge.tif", "--observer", "-5.75,0.25,2", "--mode", "height", "-o", "height.tif"});
  std::array<double, 6> transform{};
  int columns = 0;
  const std::vector<double> values = read_map("height.tif", transform, columns);
  ASSERT_EQ(values.size(), 1600u);
  // Over the ridge 4 away and 3 above the eye, at 4.25 + 4 = 8 away: 2 + 6.
  EXPECT_NEAR(values[19 * 40 + 24], 8.0, 0.02);
  EXPECT_EQ(values[19 * 40 + 8], 0.0);
}

TEST_F(VisibilityTerrainTest, a_grid_in_text_is_a_raster_and_a_table_is_a_cloud) {
  std::string text = "ncols 4\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -1\n";
  text += "1 1 1 1\n1 5 1 1\n1 1 -1 1\n";
  write("small.asc", text);
  const ProgramResult result = visibility("raster", {"small.asc", "--observer", "0.6,1.5", "-o", "seen.tif"});
  EXPECT_TRUE(contains(result.err, "terrain of 4 x 3 cells of 1, 1 to 5 high")) << result.err;
  EXPECT_TRUE(contains(result.err, ", 1 cells without a value")) << result.err;
  const ProgramResult cloud = visibility("raster", {"site.csv", "--observer", "0.6,1.5", "-o", "seen.tif"});
  EXPECT_FALSE(contains(cloud.err, "terrain")) << cloud.err;
}

TEST_F(VisibilityTerrainTest, horizon_lines_sky_and_sun_take_a_raster_alone) {
  const ProgramResult horizon =
      visibility("horizon", {"ridge.tif", "--observer", "-5.75,0.25,2", "--step", "90"});
  // 3 m higher than the eye and 4 m away.
  EXPECT_TRUE(contains(horizon.out, "\n90,36.86,4.9992,,-1.75")) << horizon.out;
  write("places.csv", "x,y,z,name\n-5,0,2,west\n5,0,2,east\n-5,5,2,north\n");
  visibility("lines", {"ridge.tif", "--places", "places.csv", "-o", "lines.json"});
  const Json lines = Json::parse(read("lines.json"))["lines"];
  EXPECT_EQ(lines[0]["visible"], false);
  EXPECT_TRUE(lines[0]["blocker"].is_null());
  EXPECT_NEAR(lines[0]["blocker_x"], -2.05, 1e-6);
  EXPECT_EQ(lines[1]["visible"], true);
  const ProgramResult sky = visibility("sky", {"ridge.tif", "--directions", "64", "-o", "sky.tif"});
  EXPECT_TRUE(contains(sky.err, "mean 0.9")) << sky.err;
  const ProgramResult sun = visibility(
      "sun", {"ridge.tif", "--from", "2026-06-21", "--step", "120", "--place", "48,11", "-o", "sun.tif"});
  EXPECT_TRUE(contains(sun.err, "hours of sun")) << sun.err;
}

TEST_F(VisibilityTerrainTest, beside_points_it_blocks_and_goes_on_as_the_ground) {
  const auto share = [&](const Words& words) {
    const ProgramResult result = visibility(
        "raster",
        with({"site.csv", "--observer", "-4,0,1.5", "--resolution", "0.5", "-o", "seen.tif"}, words));
    const std::size_t at = result.err.rfind("; visible ");
    return std::stod(result.err.substr(at + 10));
  };
  const double open = share({}), hidden = share({"--terrain", "ridge.tif"});
  EXPECT_LT(hidden, 0.8 * open);
  EXPECT_GT(hidden, 0.2 * open);
  // The cloud ends at 5, and its ground 10 beyond: here at the wall of it.
  const Words far = {"site.csv", "--observer", "-9.5,9", "--ground-reach", "0", "-o", "far.tif"};
  expect_error("raster", far, "no ground below the observer");
  const ProgramResult result = visibility(
      "raster", with(far, {"--terrain", "ridge.tif", "--extent", "-10,-10,10,10", "--resolution", "0.5"}));
  EXPECT_TRUE(contains(result.err, "map: 40 x 40 cells")) << result.err;
  EXPECT_TRUE(contains(result.err, ", 0 cells without a value")) << result.err;
  EXPECT_TRUE(contains(result.err, "; the terrain where it is higher")) << result.err;
  for (const Words& words : {Words{"points", "--observer", "-4,0", "-o", "out.las"},
                             Words{"sky", "--directions", "16", "-o", "out.las"}}) {
    const ProgramResult one = visibility(
        words[0], with(Words(words.begin() + 1, words.end()), {"site.csv", "--terrain", "ridge.tif"}));
    EXPECT_TRUE(contains(one.err, "; terrain of 40 x 40 cells of 0.5")) << one.err;
  }
}

TEST_F(VisibilityTerrainTest, rasters_that_lie_nowhere_or_in_another_way_are_rejected) {
  const auto reject = [&](const std::string& name, const std::string& part) {
    expect_error("raster", {name, "--observer", "0,0", "-o", "out.tif"}, part);
    expect_error("raster", {"site.csv", "--terrain", name, "--observer", "0,0", "-o", "out.tif"}, part);
  };
  write_virtual("turned.vrt", "-10, 0.5, 0.1, 10, 0.1, -0.5");
  reject("turned.vrt",
         "turned.vrt: the raster is rotated or sheared; expected columns along y, rows along x: "
         "resample it with gdalwarp");
  write_virtual("oblong.vrt", "-10, 0.5, 0, 10, 0, -0.6");
  reject("oblong.vrt",
         "the cells of the raster are not square; expected one cell size: resample with gdalwarp "
         "-tr SIZE SIZE, found 0.5 x 0.6");
  write_virtual("nowhere.vrt", "");
  reject("nowhere.vrt", "the raster has no georeference");
  write_virtual("degrees.vrt", "-10, 0.5, 0, 10, 0, -0.5", "EPSG:4326");
  reject("degrees.vrt",
         "geographic coordinates (degrees) are not supported; expected a projected reference "
         "system: reproject the raster with gdalwarp -t_srs, found WGS 84");
  write_heights("one.tif", geo::Raster<float>({{0, 1}, 1.0, 1, 1}, 3.0f));
  reject("one.tif",
         "one.tif: the raster has no surface; expected heights in 2 x 2 neighbouring cells, found 1 x 1");
  expect_error("raster", {"site.csv", "--terrain", "site.csv", "--observer", "0,0", "-o", "out.tif"},
               "not a raster");
  expect_error("raster", {"site.csv", "--terrain", "none.tif", "--observer", "0,0", "-o", "out.tif"},
               "none.tif");
  // What is upside down is turned over.
  write_virtual("south_up.vrt", "-10, 0.5, 0, -10, 0, 0.5");
  visibility("raster", {"south_up.vrt", "--observer", "-5.2,0", "-o", "seen.tif"});
}

TEST_F(VisibilityTerrainTest, the_reference_system_must_be_that_of_the_cloud) {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(0.001), .offset = {0, 0, 0}};
  for (int i = 0; i < 400; ++i) cloud.positions.emplace_back(500 * (i % 20) - 5000, 500 * (i / 20) - 5000, 0);
  cloud.crs.wkt = k_utm;
  write_las(folder / "utm.las", cloud);
  write_virtual("other.vrt", "-10, 0.5, 0, 10, 0, -0.5", "EPSG:25833");
  expect_error(
      "raster", {"utm.las", "--terrain", "other.vrt", "--observer", "0,0", "-o", "out.tif"},
      "other.vrt: the raster is in another reference system than the cloud; expected WGS 84 / UTM zone 32N: "
      "reproject the raster with gdalwarp -t_srs, found ETRS89 / UTM zone 33N");
  write_virtual("same.vrt", "-10, 0.5, 0, 10, 0, -0.5", "EPSG:32632");
  visibility("raster", {"utm.las", "--terrain", "same.vrt", "--observer", "0,0", "-o", "out.tif"});
  visibility("raster", {"utm.las", "--terrain", "ridge.tif", "--observer", "0,0", "-o", "out.tif"});
}

TEST_F(VisibilityTerrainTest, the_round_earth_hides_distant_targets_unless_told_otherwise) {
  // From 1.7 to 3 m above a plane sight ends after 11.7 km.
  write_heights("plane.tif", geo::Raster<float>({{0, 90}, 30.0, 620, 3}, 0.0f), k_utm);
  write("pairs.csv",
        "from_x,from_y,from_height,to_x,to_y,to_height\n15,45,1.7,8715,45,3\n15,45,1.7,18585,45,3\n");
  const auto answers = [&](const std::string& file, const Words& words) {
    visibility("lines", with({file, "--pairs", "pairs.csv", "-o", "lines.json"}, words));
    std::string text;
    const Json written = Json::parse(read("lines.json"));
    for (const Json& line : written.at("lines")) text += line.at("visible").get<bool>() ? "seen " : "hidden ";
    return text;
  };
  EXPECT_EQ(answers("plane.tif", {}), "seen hidden ");
  EXPECT_EQ(answers("plane.tif", {"--earth-radius-factor", "off"}), "seen seen ");
  EXPECT_EQ(answers("plane.tif", {"--transparency", "2"}), "seen seen ") << "which needs straight lines";
  visibility("raster", {"plane.tif", "--observer", "15,45", "--observer-height", "1.7", "--target-height",
                        "3", "-o", "seen.tif"});
  std::array<double, 6> transform{};
  int columns = 0;
  const std::vector<double> values = read_map("seen.tif", transform, columns);
  EXPECT_EQ(values[620 + 290], 255.0);
  EXPECT_EQ(values[620 + 619], 0.0);
  // In a unit that is not known the Earth's radius is not, either.
  write_heights("anywhere.tif", geo::Raster<float>({{0, 90}, 30.0, 620, 3}, 0.0f));
  EXPECT_EQ(answers("anywhere.tif", {}), "seen seen ");
}

TEST_F(VisibilityTerrainTest, holes_numbers_that_are_none_and_observers_outside) {
  geo::Raster<float> heights = ridge();
  heights.at(3, 3) = k_hole;
  heights.at(30, 5) = std::numeric_limits<float>::infinity();
  heights.at(31, 8) = -std::numeric_limits<float>::infinity();
  heights.at(20, 30) = -9999.0f;
  write_heights("holes.tif", heights);
  const ProgramResult result = visibility("raster", {"holes.tif", "--observer", "-5.2,0", "-o", "seen.tif"});
  EXPECT_TRUE(contains(result.err, "0 to 5 high")) << result.err;
  EXPECT_TRUE(contains(result.err, ", 4 cells without a value")) << result.err;
  std::array<double, 6> transform{};
  int columns = 0;
  EXPECT_EQ(read_map("seen.tif", transform, columns)[3 * 40 + 3], 254.0);
  expect_error("raster", {"holes.tif", "--observer", "50,0", "-o", "out.tif"},
               "no ground below the observer");
  visibility("raster", {"holes.tif", "--observer", "50,0,30", "-o", "out.tif"});
  for (float& height : heights.values) height = k_hole;
  write_heights("empty.tif", heights);
  expect_error("raster", {"empty.tif", "--observer", "0,0", "-o", "out.tif"}, "the raster has no surface");
}

TEST_F(VisibilityTerrainTest, results_of_points_and_other_options_of_points_need_points) {
  for (const Words& words :
       {Words{"points", "--observer", "0,0", "-o", "out.las"}, Words{"sky", "-o", "out.las"},
        Words{"sun", "--from", "2026-06-21", "-o", "out.las"}})
    expect_error(
        words[0], with(Words(words.begin() + 1, words.end()), {"ridge.tif"}),
        "ridge.tif: a raster has no points, which this result requires; expected a point cloud, and the "
        "raster as --terrain");
  const Words map = {"ridge.tif", "--observer", "0,0", "-o", "out.tif"};
  expect_error("raster", with(map, {"--terrain", "ridge.tif"}), "a second raster beside ridge.tif");
  expect_error("raster", with(map, {"--ground", "lowest"}), "do not apply to a raster");
  for (const Words& more : {Words{"--vertical-unit", "ft"}, Words{"--crs", "EPSG:25832"},
                            Words{"--crop", "0,0,1,1"}, Words{"--columns", "x,y,z"}})
    expect_error("raster", with(map, more),
                 "ridge.tif: options that select or convert points do not apply to a raster; expected");
  expect_error("raster", with(map, {"--extent", "100,100,110,110"}),
               "--extent contains no cells of the raster");
}

TEST_F(ResumeTest, a_run_is_resumed_with_the_same_terrain_only) {
  const auto grid = [](double height) {
    return fmt::format("ncols 2\nnrows 2\nxllcorner 99\nyllcorner 199\ncellsize 4\n{0} {0}\n{0} {0}\n",
                       height);
  };
  write("ground.asc", grid(4.5));
  const Words asked = {"visibility", "points", "square.xyz", "--observer-grid", "0.05", "--fraction",
                       "255",        "-o",     "seen.las",   "--checkpoint",    "state"};
  interrupt(with(asked, {"--terrain", "ground.asc"}));
  write("ground.asc", grid(4.25));
  const ProgramResult other = run(with(asked, {"--terrain", "ground.asc", "--resume"}));
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_TRUE(contains(other.err, "state: this checkpoint belongs to another run: it has terrain "))
      << other.err;
}

}  // namespace
}  // namespace alidade::test
