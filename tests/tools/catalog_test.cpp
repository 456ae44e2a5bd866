// SPDX-License-Identifier: MIT
// Catalogs: made by `alidade catalog`, taken as a cloud by every command.
#include <gdal.h>
#include <ogr_api.h>
#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cloud/las/write_las.h"
#include "tests/cloud/copc/copc_builder.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

constexpr double k_side = 2 * k_copc_half_size;

class CatalogProgramTest : public ProgramTest {
 protected:
  /// COPC tiles of 400 points in a row to the east: tiles/tile_0.copc.laz and so on.
  void make_tiles(int count) {
    fs::create_directories(folder / "tiles");
    for (int i = 0; i < count; ++i) {
      CopcSample sample = build_copc(400, 40, static_cast<std::uint64_t>(i % 3 + 1));
      move(sample, k_side * i);
      save(fmt::format("tiles/tile_{}.copc.laz", i), sample.bytes);
    }
  }

  /// Offset and bounds of the header, and the centre of the octree.
  static void move(CopcSample& sample, double east) {
    for (const std::size_t byte :
         {std::size_t{155}, std::size_t{179}, std::size_t{187}, sample.info_offset}) {
      double x = 0.0;
      std::memcpy(&x, sample.bytes.data() + byte, sizeof x);
      x += east;
      std::memcpy(sample.bytes.data() + byte, &x, sizeof x);
    }
  }

  void save(const std::string& name, const std::vector<std::byte>& bytes) const {
    std::ofstream(folder / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }

  void make_catalog(const std::string& name = "site.catalog.json") {
    const ProgramResult result = run({"catalog", "tiles", "-o", name, "--overwrite", "-q"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }

  Json catalog() { return Json::parse(read("site.catalog.json")); }

  /// Answers through the catalog are those of the loaded files, byte for byte.
  void expect_same(const Words& targets) {
    Words in_place = {"query", "site.catalog.json", "-q"}, loaded = {"query", "tiles", "--load", "-q"};
    in_place.insert(in_place.end(), targets.begin(), targets.end());
    loaded.insert(loaded.end(), targets.begin(), targets.end());
    const ProgramResult some = run(in_place), all = run(loaded);
    EXPECT_EQ(some.exit_code, 0) << some.err;
    EXPECT_EQ(all.exit_code, 0) << all.err;
    EXPECT_GT(std::ranges::count(all.out, '\n'), 1) << "no answers to compare";
    EXPECT_EQ(some.out, all.out);
  }
};

TEST_F(CatalogProgramTest, answers_are_those_of_the_loaded_files) {
  make_tiles(5);
  make_catalog();
  expect_same({"--line", "690060,5325000,481,1,0.01,0", "--radius", "2", "--classes", "1,2,3,4,5"});
  expect_same({"--point", "690250,5325000,480", "--k", "30", "--format", "jsonl"});
  expect_same({"--cone", "690000,5325000,600,1,0,-0.2,5", "--count"});
  const Words narrow = {"query", "site.catalog.json", "--box", "690060,5325000,470,690300,5325020,490", "-q"};
  Words with_memory = narrow;
  with_memory.insert(with_memory.end(), {"--memory", "20k"});
  EXPECT_EQ(run(with_memory).out, run(narrow).out);
}

TEST_F(CatalogProgramTest, only_files_that_a_target_reaches_are_opened) {
  make_tiles(7);
  make_catalog();
  for (const int missing : {2, 3, 4, 6}) fs::remove(folder / fmt::format("tiles/tile_{}.copc.laz", missing));
  const std::string east = std::to_string(690000 + 5 * k_side);
  const Words words = {"query", "site.catalog.json", "--ray", east + ",5325000,640,0,0,-1", "--radius",
                       "12",    "--explain"};
  const ProgramResult result = run(words);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_GT(std::ranges::count(result.out, '\n'), 1);
  EXPECT_TRUE(contains(result.err, "files opened                         2          28.57%")) << result.err;
  // The same where files are loaded.
  Words loading = words;
  loading.insert(loading.end() - 1, "--load");
  loading.pop_back();
  EXPECT_EQ(run(loading).out, result.out);
  const Words missing = {"query", "site.catalog.json", "--box", "690200,0,0,690300,9e9,9e9"};
  EXPECT_TRUE(contains(run(missing).err, "tile_2.copc.laz: cannot open the file"));
}

TEST_F(CatalogProgramTest, other_commands_take_catalogs_and_crops_open_few_files) {
  make_tiles(4);
  make_catalog();
  const ProgramResult info = run({"info", "--json", "site.catalog.json"});
  ASSERT_EQ(info.exit_code, 0) << info.err;
  EXPECT_EQ(Json::parse(info.out).at("points"), 1600);
  fs::remove(folder / "tiles/tile_3.copc.laz");
  const Words crop = {"--crop", "690000,5324900,690100,5325100", "--overwrite", "-q"};
  const auto convert = [&](const std::string& cloud, const std::string& output) {
    Words words = {"convert", cloud, "-o", output};
    words.insert(words.end(), crop.begin(), crop.end());
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  };
  convert("site.catalog.json", "a.las");
  convert("tiles", "b.las");
  EXPECT_EQ(read("a.las"), read("b.las"));
}

TEST_F(CatalogProgramTest, sql_takes_catalogs_and_loads_their_points) {
  make_tiles(4);
  make_catalog();
  const std::string statement =
      "SELECT id, x, y, z, intensity, dist FROM points(690000,5325000,481, 1,0.01,0) WHERE dist <= 3 "
      "ORDER BY id";
  const auto answer = [&](const std::string& cloud) {
    const ProgramResult result = run({"sql", cloud, statement, "--csv", "-q"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.out;
  };
  const std::string expected = answer("tiles");
  EXPECT_GT(std::ranges::count(expected, '\n'), 20);
  EXPECT_EQ(answer("site.catalog.json"), expected);
  ASSERT_EQ(run({"sql", "load", "site.catalog.json", "site.db", "-q"}).exit_code, 0);
  EXPECT_EQ(answer("site.db"), expected);
  // A catalog of one COPC file is that file, which is not read as a whole.
  const std::string only = "tiles/tile_0.copc.laz";
  ASSERT_EQ(run({"catalog", only, "-o", "only.catalog.json", "-q"}).exit_code, 0);
  const Words nothing = {"sql", "only.catalog.json", "SELECT id FROM points WHERE x < 0", "--explain"};
  EXPECT_TRUE(contains(run(nothing).err, "alidade: read 0 of ")) << run(nothing).err;
  EXPECT_FALSE(contains(run(nothing).err, "reading: ")) << run(nothing).err;
  EXPECT_EQ(answer("only.catalog.json"), answer(only));
  // Tiles outside of a crop are not opened.
  fs::remove(folder / "tiles/tile_3.copc.laz");
  const ProgramResult cropped =
      run({"sql", "load", "site.catalog.json", "part.db", "--crop", "690000,5324900,690100,5325100"});
  EXPECT_EQ(cropped.exit_code, 0) << cropped.err;
  const ProgramResult missing = run({"sql", "site.catalog.json", statement});
  EXPECT_TRUE(contains(missing.err, "tile_3.copc.laz: cannot open the file")) << missing.err;
}

TEST_F(CatalogProgramTest, items_are_stac_with_footprints_on_the_globe) {
  fs::create_directories(folder / "tiles/a b");
  ASSERT_EQ(run({"generate", "courtyard", "--points", "2000", "-o", "tiles/a b/ä#1.las", "-q"}).exit_code, 0);
  ASSERT_EQ(run({"catalog", "tiles/a b", "-o", "site.catalog.json", "-q"}).exit_code, 0);
  const Json item = catalog().at("features").at(0);
  EXPECT_EQ(item.at("stac_version"), "1.0.0");
  EXPECT_EQ(item.at("assets").at("data").at("href"), "tiles/a%20b/%C3%A4%231.las");
  EXPECT_EQ(item.at("assets").at("data").at("file:size"), fs::file_size(folder / "tiles/a b/ä#1.las"));
  const Json properties = item.at("properties");
  EXPECT_EQ(properties.at("pc:count"), 2000);
  EXPECT_EQ(properties.at("pc:encoding"), "LAS");
  EXPECT_EQ(properties.at("pc:schemas").at(0), (Json{{"name", "X"}, {"size", 8}, {"type", "floating"}}));
  EXPECT_EQ(properties.at("proj:code"), "EPSG:32632");
  EXPECT_EQ(properties.at("proj:bbox").size(), 6u);
  EXPECT_TRUE(properties.at("datetime").is_string());
  // Easting 690000 and northing 5325000 of zone 32 is Munich.
  EXPECT_NEAR(item.at("bbox").at(0), 11.55, 0.1);
  EXPECT_NEAR(item.at("bbox").at(1), 48.05, 0.1);
  EXPECT_EQ(item.at("geometry").at("coordinates").at(0).size(), 9u);
  EXPECT_EQ(run({"info", "site.catalog.json", "-q"}).exit_code, 0);
}

TEST_F(CatalogProgramTest, gdal_opens_the_catalog_and_the_footprints) {
  make_tiles(3);
  make_catalog();
  ASSERT_EQ(run({"catalog", "site.catalog.json", "-o", "site.gpkg", "-q"}).exit_code, 0);
  GDALAllRegister();
  for (const char* const name : {"site.catalog.json", "site.gpkg"}) {
    const GDALDatasetH data =
        GDALOpenEx((folder / name).c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, nullptr, nullptr, nullptr);
    ASSERT_NE(data, nullptr) << name;
    const OGRLayerH layer = GDALDatasetGetLayer(data, 0);
    EXPECT_EQ(OGR_L_GetFeatureCount(layer, TRUE), 3) << name;
    GDALClose(data);
  }
}

TEST_F(CatalogProgramTest, files_without_a_usable_box_are_measured) {
  fs::create_directories(folder / "tiles");
  write("tiles/a.csv", "x,y,z\n1,2,3\n4,5,6\n");
  PointCloud point;
  point.positions.emplace_back(5000, 6000, 7000);
  write_las(folder / "tiles/b.las", point);
  point.positions.clear();
  write_las(folder / "tiles/c.las", point);
  make_catalog();
  const Json items = catalog().at("features");
  EXPECT_EQ(items.at(0).at("properties").at("proj:bbox"), (Json{1.0, 2.0, 3.0, 4.0, 5.0, 6.0}));
  EXPECT_EQ(items.at(1).at("properties").at("proj:bbox"), (Json{5.0, 6.0, 7.0, 5.0, 6.0, 7.0}));
  EXPECT_FALSE(items.at(2).at("properties").contains("proj:bbox"));
  EXPECT_TRUE(items.at(0).at("geometry").is_null());
  EXPECT_EQ(run({"query", "site.catalog.json", "--point", "5,6,7", "--k", "1", "-q"}).out,
            run({"query", "tiles", "--point", "5,6,7", "--k", "1", "-q"}).out);
}

TEST_F(CatalogProgramTest, tiles_that_overlap_or_repeat_are_all_there) {
  make_tiles(2);
  fs::copy_file(folder / "tiles/tile_0.copc.laz", folder / "tiles/tile_2.copc.laz");
  fs::create_hard_link(folder / "tiles/tile_0.copc.laz", folder / "tiles/tile_3.copc.laz");
  make_catalog();
  expect_same({"--box", "690000,5324990,470,690010,5325010,490"});
  expect_same({"--point", "690000,5325000,480", "--k", "12"});
}

TEST_F(CatalogProgramTest, a_tile_that_is_not_what_the_catalog_states_is_an_error_that_names_both) {
  make_tiles(3);
  make_catalog();
  const Words words = {"query", "site.catalog.json", "--box", "-inf,-inf,-inf,inf,inf,inf", "--count", "-q"};
  ASSERT_EQ(run(words).exit_code, 0);
  CopcSample moved = build_copc(400, 40, 2);
  move(moved, k_side + 1);
  save("tiles/tile_1.copc.laz", moved.bytes);
  // A header that says nothing is found out when points are read.
  const ProgramResult points = run(words);
  EXPECT_EQ(points.exit_code, 2);
  EXPECT_TRUE(contains(points.err, "the point is outside the box that a catalog states")) << points.err;
  const std::array<double, 6> bounds = {690200, 690066, 5325060, 5324940, 490, 470};
  std::memcpy(moved.bytes.data() + 179, bounds.data(), sizeof bounds);
  save("tiles/tile_1.copc.laz", moved.bytes);
  const ProgramResult box = run(words);
  EXPECT_EQ(box.exit_code, 2);
  EXPECT_TRUE(
      contains(box.err, "tile_1.copc.laz: site.catalog.json states another box: make the catalog again"))
      << box.err;
  EXPECT_EQ(run({"query", "site.catalog.json", "--box", "0,0,0,690000,9e9,9e9", "--count", "-q"}).exit_code,
            0);
  CopcSample fewer = build_copc(399, 40, 2);
  move(fewer, k_side);
  save("tiles/tile_1.copc.laz", fewer.bytes);
  EXPECT_TRUE(contains(run(words).err, "another number of points"));
}

TEST_F(CatalogProgramTest, what_a_catalog_cannot_be_is_an_error) {
  make_tiles(1);
  fs::create_directories(folder / "elsewhere");
  EXPECT_TRUE(contains(run({"catalog", "tiles", "-o", "elsewhere/site.catalog.json"}).err,
                       "a catalog cannot list files outside of its folder"));
  EXPECT_TRUE(
      contains(run({"catalog", "tiles", "-o", "site.json"}).err, "the extension .catalog.json or .gpkg"));
  make_catalog();
  EXPECT_TRUE(contains(run({"catalog", "tiles", "-o", "site.catalog.json"}).err, "the file exists"));
  EXPECT_TRUE(contains(run({"info", "missing.catalog.json"}).err, "missing.catalog.json"));
  write("loop.catalog.json", R"({"type": "FeatureCollection",
                                 "features": [{"assets": {"data": {"href": "loop.catalog.json"}}}]})");
  EXPECT_TRUE(contains(run({"info", "loop.catalog.json"}).err, "the catalog lists a catalog"));
  save("tiles/tile_0.copc.laz", {});
  EXPECT_EQ(run({"query", "site.catalog.json", "--point", "690000,5325000,480"}).exit_code, 2);
}

}  // namespace
}  // namespace alidade::test
