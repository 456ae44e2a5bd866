// SPDX-License-Identifier: MIT
// Clouds whose heights are in another unit than x and y, and files of different reference systems.
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "cloud/axis_units.h"
#include "cloud/las/write_las.h"
#include "cloud/read_cloud.h"
#include "tests/tools/units_site.h"

namespace alidade::test {
namespace {

TEST_F(UnitsTest, info_prints_the_unit_of_each_axis) {
  EXPECT_TRUE(contains(run({"info", "feet.las"}).out, "units       x, y m; z us-ft\n"));
  EXPECT_EQ(info("feet.las")["units"], (Json{{"x", "m"}, {"y", "m"}, {"z", "us-ft"}, {"z_is_stated", true}}));
  write_site("plane.las", k_oregon, 0.01);
  EXPECT_TRUE(contains(run({"info", "plane.las"}).out, "units       x, y m; z m (not stated)\n"));
  EXPECT_EQ(info("plane.las")["units"], (Json{{"x", "m"}, {"y", "m"}, {"z", "m"}, {"z_is_stated", false}}));
  write_square("none.csv");
  EXPECT_EQ(info("none.csv")["units"]["z"], Json());
}

TEST_F(UnitsTest, commands_that_measure_answer_as_for_metres) {
  expect_as_in_metres({"visibility", "horizon", "CLOUD", "--observer", "194510,259260,133", "--step", "15"});
  write("pairs.csv",
        "from_x,from_y,from_z,to_x,to_y,to_z\n194510,259260,133,194530,259260,133\n194510,259260,133,194510,"
        "259242,133\n");
  expect_as_in_metres({"visibility", "lines", "CLOUD", "--pairs", "pairs.csv", "-o", "OUT.csv"});
  expect_as_in_metres({"visibility", "summary", "CLOUD", "--observer", "194510,259260", "-o", "OUT.csv"});
  expect_as_in_metres({"query", "CLOUD", "--point", "194520.1,259260,133", "--k", "9"});
  expect_as_in_metres({"query", "CLOUD", "--ray", "194500,259260,132.5,1,0,0", "--radius", "0.2"});
  expect_as_in_metres({"sql", "CLOUD",
                       "SELECT id, x, y, z FROM points WHERE "
                       "dist_ray(194500, 259260, 133, 1, 0, 0, x, y, z) < 0.5 ORDER BY id"});
}

TEST_F(UnitsTest, outputs_are_in_metres_and_say_so) {
  const ProgramResult result =
      run({"visibility", "points", "feet.las", "--observer", "194510,259260", "-o", "seen.las"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json seen = info("seen.las");
  EXPECT_EQ(seen["units"]["z"], "m");
  EXPECT_NEAR(double(seen["bounds"]["max"][2]), 450.5 * k_foot_of_surveys, 0.01);
  EXPECT_TRUE(contains(std::string(seen["crs"]), "NAVD88 height\""));
  const PointCloud stored = read_cloud(folder / "feet.las"), written = read_cloud(folder / "seen.las");
  EXPECT_EQ(written.positions, stored.positions) << "no height is rounded";
  // Without a warning, since nothing is converted again.
  EXPECT_FALSE(contains(run({"query", "seen.las", "--point", "194520,259260,133"}).err, "converted"));
  ASSERT_EQ(
      run({"render", "--cloud", "feet.las", "-o", "feet.png", "--size", "60x40", "--samples", "2"}).exit_code,
      0);
  ASSERT_EQ(run({"render", "--cloud", "metres.las", "-o", "metres.png", "--size", "60x40", "--samples", "2"})
                .exit_code,
            0);
  EXPECT_EQ(run({"compare", "feet.png", "metres.png"}).exit_code, 0);
}

TEST_F(UnitsTest, copc_and_index_files_and_databases_answer_as_the_file) {
  ASSERT_EQ(run({"convert", "feet.las", "-o", "feet.copc.laz", "-q"}).exit_code, 0);
  ASSERT_EQ(run({"convert", "feet.las", "-o", "stored.alidade", "-q"}).exit_code, 0);
  ASSERT_EQ(run({"index", "feet.las", "-o", "feet.alidade", "-q"}).exit_code, 0);
  ASSERT_EQ(run({"sql", "load", "feet.las", "feet.db", "-q"}).exit_code, 0);
  EXPECT_EQ(info("feet.copc.laz")["units"]["z"], "us-ft");
  EXPECT_EQ(info("stored.alidade")["units"]["z"], "us-ft");
  EXPECT_EQ(info("feet.alidade")["units"]["z"], "m");
  const auto answer = [&](const std::string& cloud, const Words& more = {}) {
    Words words{"query", cloud, "--box", "194519,259250,132.5,194521,259251,134", "--count"};
    words.insert(words.end(), more.begin(), more.end());
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.out;
  };
  const std::string expected = answer("metres.las");
  EXPECT_EQ(answer("feet.las"), expected);
  EXPECT_EQ(answer("feet.copc.laz"), expected) << "in place";
  EXPECT_EQ(answer("feet.copc.laz", {"--load"}), expected);
  EXPECT_EQ(answer("stored.alidade"), expected);
  EXPECT_EQ(answer("feet.alidade"), expected);
  EXPECT_EQ(answer("feet.db?table=points"), expected);
  const auto rows = [&](const std::string& cloud) {
    return run({"sql", cloud, "SELECT count(*), min(z), max(z) FROM points", "--csv"}).out;
  };
  for (const char* const cloud : {"feet.las", "feet.copc.laz", "stored.alidade", "feet.alidade", "feet.db"})
    EXPECT_EQ(rows(cloud), rows("metres.las")) << cloud;
}

TEST_F(UnitsTest, convert_keeps_files_as_they_are_and_reproject_brings_heights_to_the_unit) {
  ASSERT_EQ(run({"convert", "feet.las", "-o", "same.las"}).exit_code, 0);
  EXPECT_EQ(info("same.las")["crs"], k_feet);
  ASSERT_EQ(run({"convert", "feet.las", "-o", "metres_too.las", "--reproject", "EPSG:2991"}).exit_code, 0);
  EXPECT_EQ(info("metres_too.las")["units"]["z"], "m");
  EXPECT_EQ(read_cloud(folder / "metres_too.las").positions, read_cloud(folder / "feet.las").positions);
  const ProgramResult utm = run({"convert", "feet.las", "-o", "utm.las", "--reproject", "EPSG:26910"});
  EXPECT_EQ(count_of(utm.err, "heights are converted from US survey foot to metre"), 1u) << utm.err;
  EXPECT_NEAR(double(info("utm.las")["bounds"]["max"][2]), 450.5 * k_foot_of_surveys, 0.02);
  for (const char* const option : {"--spacing=1", "--normals"})
    EXPECT_TRUE(contains(
        error({"convert", "feet.las", "-o", "x.las", option}),
        "the unit of x and y is metre, that of heights US survey foot; expected --reproject SYSTEM"));
  EXPECT_EQ(run({"convert", "feet.las", "-o", "y.las", "--spacing=1", "--reproject", "EPSG:2991"}).exit_code,
            0);
}

TEST_F(UnitsTest, a_unit_is_stated_for_files_that_state_none_and_never_against_them) {
  write_site("plane.las", k_oregon, 0.01);
  const auto answer = [&](const std::string& cloud, const Words& more) {
    Words words{"query", cloud, "--point", "194520.1,259260,133", "--k", "9"};
    words.insert(words.end(), more.begin(), more.end());
    return run(words).out;
  };
  EXPECT_EQ(answer("plane.las", {"--vertical-unit", "us-ft"}), answer("metres.las", {}));
  EXPECT_EQ(answer("feet.las", {"--vertical-unit", "us-ft"}), answer("metres.las", {}));
  EXPECT_TRUE(
      contains(error({"query", "feet.las", "--point", "0,0,0", "--vertical-unit", "m"}),
               "--vertical-unit contradicts the reference system of the file; expected US survey foot"));
  EXPECT_TRUE(
      contains(error({"query", "feet.las", "--point", "0,0,0", "--vertical-unit", "feet"}), "m|ft|us-ft"));
  write_square("none.csv");
  EXPECT_TRUE(contains(error({"query", "none.csv", "--point", "0,0,0", "--vertical-unit", "ft"}),
                       "the unit of x and y is unknown"));
  EXPECT_NE(run({"convert", "plane.las", "-o", "x.las", "--vertical-unit", "ft"}).exit_code, 0);
  ASSERT_EQ(
      run({"convert", "plane.las", "-o", "x.las", "--vertical-unit", "us-ft", "--reproject", "EPSG:2991"})
          .exit_code,
      0);
  EXPECT_NEAR(double(info("x.las")["bounds"]["max"][2]), 450.5 * k_foot_of_surveys, 0.01);
}

/// The WKT of a LAS file becomes GeoTIFF keys.
void write_keys(const std::filesystem::path& file, const std::vector<std::uint16_t>& keys) {
  PointCloud cloud = read_cloud(file);
  cloud.crs = Crs();
  cloud.crs.geotiff_keys = {1, 1, 0, static_cast<std::uint16_t>(keys.size() / 2)};
  for (std::size_t i = 0; i < keys.size(); i += 2)
    cloud.crs.geotiff_keys.insert(cloud.crs.geotiff_keys.end(), {keys[i], 0, 1, keys[i + 1]});
  write_las(file, cloud, {.overwrite = true});
}

TEST_F(UnitsTest, geotiff_keys_and_their_codes_alone_state_units) {
  for (const std::vector<std::uint16_t>& heights :
       {std::vector<std::uint16_t>{4096, 6360}, {4096, 5703, 4099, 9003}, {4099, 9003}}) {
    std::vector<std::uint16_t> keys = {1024, 1, 1025, 1, 3072, 2991};
    keys.insert(keys.end(), heights.begin(), heights.end());
    write_site("feet.las", "", 0.01);
    write_keys(folder / "feet.las", keys);
    EXPECT_EQ(info("feet.las")["units"],
              (Json{{"x", "m"}, {"y", "m"}, {"z", "us-ft"}, {"z_is_stated", true}}));
    expect_as_in_metres({"query", "CLOUD", "--point", "194520.1,259260,133", "--k", "9"});
  }
  EXPECT_TRUE(
      contains(run({"info", "feet.las"}).out, "CRS         NAD83 / Oregon LCC (m) + unknown (GeoTIFF keys"));
  for (const std::uint16_t code : {4321, 32767}) {
    write_keys(folder / "feet.las", {1024, 1, 1025, 1, 3072, 2991, 4096, code});
    EXPECT_TRUE(contains(error({"query", "feet.las", "--point", "0,0,0"}),
                         "the unit of heights is unknown; expected --vertical-unit m, ft or us-ft"));
    EXPECT_EQ(info("feet.las")["units"]["z"], Json());
    EXPECT_EQ(run({"query", "feet.las", "--point", "0,0,0", "--vertical-unit", "us-ft"}).exit_code, 0);
  }
}

TEST_F(UnitsTest, a_catalog_of_mixed_units_is_refused_with_the_remedy) {
  ASSERT_EQ(run({"catalog", "feet.las", "-o", "site.catalog.json"}).exit_code, 0);
  EXPECT_TRUE(contains(
      error({"query", "site.catalog.json", "--point", "0,0,0"}),
      "feet.las: a catalog of files whose heights are not in the unit of x and y; expected the files "
      "without the catalog"));
  EXPECT_EQ(run({"convert", "site.catalog.json", "-o", "x.las"}).exit_code, 0);
}

TEST_F(UnitsTest, a_raster_beside_the_cloud_is_converted_too) {
  // 10 x 10 cells of 4 m at 430 feet.
  std::string cells;
  for (int i = 0; i < 100; ++i) cells += "430 ";
  write("ground.asc", "ncols 10\nnrows 10\nxllcorner 194500\nyllcorner 259240\ncellsize 4\n" + cells + "\n");
  const std::string virtual_raster =
      R"(<VRTDataset rasterXSize="10" rasterYSize="10"><SRS>)" + k_feet +
      R"(</SRS><GeoTransform>194500,4,0,259280,0,-4</GeoTransform><VRTRasterBand dataType="Float32" band="1">)"
      R"(<SimpleSource><SourceFilename relativeToVRT="1">ground.asc</SourceFilename><SourceBand>1</SourceBand>)"
      R"(</SimpleSource></VRTRasterBand></VRTDataset>)";
  write("ground.vrt", virtual_raster);
  write("pairs.csv", "from_x,from_y,from_z,to_x,to_y,to_z\n194510,259260,133,194511,259260,133\n");
  const ProgramResult result = run({"visibility", "lines", "metres.las", "--terrain", "ground.vrt", "--pairs",
                                    "pairs.csv", "-o", "lines.csv"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "ground.vrt: heights are converted from US survey foot to metre"))
      << result.err;
  EXPECT_TRUE(contains(result.err, "131.064 to 131.064 high")) << result.err;
}

TEST_F(UnitsTest, heights_of_a_public_file_in_feet_give_the_sky_of_metres) {
  const auto file = shared_data("../cases/vertical_feet_bmx-2010.las");
  if (!file) GTEST_SKIP() << "../shared/cases is not there";
  const ProgramResult sky = run({"visibility", "sky", file->string(), "-o", "sky.tif"});
  EXPECT_EQ(sky.exit_code, 0);
  EXPECT_TRUE(contains(sky.err, "mean 0.99")) << sky.err;
}

TEST_F(UnitsTest, tiles_of_other_scales_and_flat_scans_are_joined) {
  const auto coarse = shared_data("../cases/L13_a.las"), fine = shared_data("../cases/L13_b.las"),
             flat = shared_data("../cases/Z1_scan2d_a.pcd"), raised = shared_data("../cases/Z1_scan2d_b.pcd");
  if (!coarse || !fine || !flat || !raised) GTEST_SKIP() << "../shared/cases is not there";
  const Json tiles = Json::parse(run({"info", "--json", coarse->string(), fine->string()}).out);
  EXPECT_EQ(tiles["scale"], (Json{0.001, 0.001, 0.001}));
  EXPECT_EQ(tiles["points"],
            info(coarse->string())["points"].get<int>() + info(fine->string())["points"].get<int>());
  EXPECT_EQ(tiles["rounding_error"], (Json{0.0, 0.0, 0.0}));
  EXPECT_EQ(info(flat->string())["scale"], (Json{1e-7, 1e-7, 1e-7}));
  ASSERT_EQ(run({"convert", flat->string(), "-o", "flat.las"}).exit_code, 0);
  ASSERT_EQ(run({"convert", raised->string(), "-o", "raised.las"}).exit_code, 0);
  const ProgramResult both = run({"info", "--json", "flat.las", "raised.las"});
  ASSERT_EQ(both.exit_code, 0) << both.err;
  EXPECT_EQ(Json::parse(both.out)["points"], 720);
}

/// Metres of Quebec by keys, and feet of Oregon in words.
class SystemsTest : public UnitsTest {
 protected:
  void SetUp() override {
    UnitsTest::SetUp();
    write_site("quebec.las", "", 0.01);
    write_keys(folder / "quebec.las", {1024, 1, 1025, 1, 3072, 2949});
    std::string feet = k_oregon;
    feet.replace(feet.find(R"(UNIT["metre",1])"), 15, R"(UNIT["foot",0.3048])");
    feet.replace(feet.find(R"(,AUTHORITY["EPSG","2991"])"), 24, "");
    write_site("oregon.las", feet, 0.01);
  }
};

TEST_F(SystemsTest, files_of_different_systems_are_never_one_cloud) {
  std::filesystem::create_directory(folder / "both");
  for (const char* const file : {"quebec.las", "oregon.las"})
    std::filesystem::copy_file(folder / file, folder / "both" / file);
  for (const Words& words : {Words{"info", "quebec.las", "oregon.las"},
                             Words{"convert", "quebec.las", "oregon.las", "-o", "both.las"},
                             Words{"query", "quebec.las", "oregon.las", "--point", "0,0,0"},
                             Words{"visibility", "summary", "oregon.las", "quebec.las", "--observer",
                                   "194510,259260", "-o", "x.csv"},
                             Words{"sql", "both", "SELECT count(*) FROM points"},
                             Words{"sql", "load", "quebec.las", "oregon.las", "both.db"}}) {
    const std::string said = error(words);
    EXPECT_TRUE(contains(said, "the coordinate reference system differs from that of")) << said;
    EXPECT_TRUE(contains(said, "--reproject")) << said;
  }
  EXPECT_TRUE(contains(error({"catalog", "quebec.las", "oregon.las", "-o", "x.gpkg"}),
                       "a GeoPackage of files of different reference systems"));
}

TEST_F(SystemsTest, one_system_written_differently_is_one_cloud_without_a_word) {
  write_keys(folder / "quebec.las", {1024, 1, 1025, 1, 3072, 2991});
  write_site("plane.las", k_oregon, 0.01, 1);
  std::string nameless = k_oregon;
  nameless.replace(nameless.find("NAD83 / Oregon LCC (m)"), 22, "site");
  nameless.replace(nameless.find(R"(,AUTHORITY["EPSG","2991"])"), 24, "");
  write_site("oregon.las", nameless, 0.01, 2);
  const ProgramResult result = run({"convert", "plane.las", "quebec.las", "oregon.las", "-o", "all.las"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_FALSE(contains(result.err, "reference system")) << result.err;
}

TEST_F(SystemsTest, a_system_that_nobody_understands_is_warned_of_by_both_names) {
  write_keys(folder / "quebec.las", {1024, 1, 1025, 1, 3072, 32767});
  const ProgramResult result = run({"info", "oregon.las", "quebec.las"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(
      contains(result.err,
               "quebec.las: the coordinate reference system is described differently (GeoTIFF keys without "
               "EPSG code) from the other files (NAD83 / Oregon LCC (m))"))
      << result.err;
  EXPECT_TRUE(contains(run({"info", "quebec.las"}).out, "CRS         unknown: GeoTIFF keys, no EPSG code"));
}

TEST_F(SystemsTest, keys_are_called_by_the_name_of_what_they_mean) {
  write_keys(folder / "quebec.las", {1024, 1, 1025, 1, 3072, 3005, 4096, 5713});
  EXPECT_TRUE(
      contains(run({"info", "quebec.las"}).out,
               "CRS         NAD83 / BC Albers + CGVD28 height (GeoTIFF keys, EPSG:3005, vertical EPSG:5713)\n"
               "units       x, y m; z m\n"));
  EXPECT_TRUE(contains(std::string(info("quebec.las")["crs"]), "NAD83 / BC Albers"));
}

}  // namespace
}  // namespace alidade::test
