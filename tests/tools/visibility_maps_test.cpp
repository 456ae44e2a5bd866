// SPDX-License-Identifier: MIT
// The files of all maps, as GDAL describes them.
#include <gdal.h>
#include <gdal_utils.h>

#include <nlohmann/json.hpp>

#include "cloud/las/write_las.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

using nlohmann::json;

/// The output of `gdalinfo -json` for a file; null if GDAL does not read it.
json map_info(const std::filesystem::path& file) {
  const GDALDatasetH dataset = GDALOpen(file.c_str(), GA_ReadOnly);
  if (dataset == nullptr) return nullptr;
  std::array<char, 6> option{"-json"};
  std::array<char*, 2> options{option.data(), nullptr};
  GDALInfoOptions* const parsed = GDALInfoOptionsNew(options.data(), nullptr);
  char* const text = GDALInfo(dataset, parsed);
  json info = json::parse(text);
  VSIFree(text);
  GDALInfoOptionsFree(parsed);
  GDALClose(dataset);
  return info;
}

/// 260 x 260 of ground in UTM zone 32, 2 between points, with a wall of 20 x 4 on it.
PointCloud field() {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(0.001), .offset = {690000, 5325000, 600}};
  for (int x = 0; x <= 130; ++x) {
    for (int y = 0; y <= 130; ++y) cloud.positions.emplace_back(2000 * x, 2000 * y, 0);
  }
  for (int x = 0; x <= 20; ++x) {
    for (int z = 1; z <= 4; ++z) cloud.positions.emplace_back(100000 + 1000 * x, 120000, 1000 * z);
  }
  for (const LatticePosition& position : cloud.positions)
    cloud.classifications.push_back(position.z > 0 ? 6 : 2);
  // GeoTIFF 1.1, chapter 7: version, revision, count; then projected type, raster type, EPSG 32632. So the
  // system is named by its code alone.
  cloud.crs.geotiff_keys = {1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32632};
  return cloud;
}

class VisibilityMapsTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    GDALAllRegister();
    write_las(folder / "field.las", field());
  }

  /// `alidade visibility COMMAND field.las -o NAME WORDS...`, which must end well, and what it wrote.
  json map_of(const std::string& command, const std::string& name, const Words& more) {
    Words words{"visibility", command, "field.las", "-o", name};
    words.insert(words.end(), more.begin(), more.end());
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return map_info(folder / name);
  }

  /// Runs a command that must fail before surfaces are measured, and write nothing.
  void expect_rejected_early(const std::string& command, const Words& more, const std::string& message) {
    Words words{"visibility", command, "field.las"};
    words.insert(words.end(), more.begin(), more.end());
    const std::vector<std::string> before = names();
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 2) << message;
    EXPECT_TRUE(contains(result.err, message)) << result.err;
    EXPECT_FALSE(contains(result.err, "discs block")) << "surfaces were measured before: " << result.err;
    EXPECT_EQ(names(), before);
  }
};

const Words k_cells = {"--resolution", "0.5", "--extent", "690000,5325000,690260,5325260"};
const Words k_eye = {"--observer", "690110,5325100,602"};
const Words k_day = {"--from", "2026-06-21", "--step", "240"};

/// What holds of every map of these cells.
void expect_map(const json& info, int cells = 520) {
  ASSERT_TRUE(info.is_object()) << "no map";
  EXPECT_EQ(info["driverShortName"], "GTiff");
  EXPECT_EQ(info["size"], (json{cells, cells}));
  EXPECT_EQ(info["geoTransform"], (json{690000.0, 260.0 / cells, 0.0, 5325260.0, 0.0, -260.0 / cells}));
  EXPECT_EQ(info["metadata"]["IMAGE_STRUCTURE"]["LAYOUT"], "COG");
  EXPECT_EQ(info["metadata"]["IMAGE_STRUCTURE"]["COMPRESSION"], "DEFLATE");
  EXPECT_EQ(info["bands"][0]["block"], (json{512, 512}));
  // Of maps within one block GDAL tells sometimes one, sometimes none.
  if (cells > 512) EXPECT_EQ(info["bands"][0]["overviews"].size(), 1u);
  EXPECT_TRUE(contains(info["coordinateSystem"]["wkt"], "32632"));
  const json& metadata = info["metadata"][""];
  EXPECT_EQ(metadata["AREA_OR_POINT"], "Area");
  EXPECT_EQ(metadata["alidade_cloud_files"], "field.las");
  EXPECT_EQ(metadata["alidade_occluder"], "auto");
  EXPECT_EQ(metadata["alidade_transparency"], "1");
  EXPECT_TRUE(contains(metadata["alidade_ground"], "classes 2, 9 and 11 in cells of"));
  EXPECT_TRUE(contains(metadata["alidade_what_blocks"], "discs block"));
  EXPECT_TRUE(contains(metadata["alidade_command"], "alidade visibility "));
  EXPECT_TRUE(contains(metadata["TIFFTAG_SOFTWARE"], "Alidade"));
}

TEST_F(VisibilityMapsTest, a_viewshed_is_a_cloud_optimised_geotiff_that_contains_what_was_used) {
  const json info = map_of("raster", "seen.TIF", with(k_cells, k_eye));
  expect_map(info);
  EXPECT_EQ(info["bands"].size(), 1u);
  EXPECT_EQ(info["bands"][0]["type"], "Byte");
  EXPECT_EQ(info["bands"][0]["noDataValue"], 254.0);
  EXPECT_EQ(info["metadata"][""]["alidade_mode"], "visible");
  EXPECT_TRUE(contains(info["metadata"][""]["alidade_observers"], "690110 5325100 602"));
}

TEST_F(VisibilityMapsTest, heights_are_floats_in_the_unit_of_the_cloud) {
  const json info = map_of("raster", "height.tif",
                           with(k_eye, {"--resolution", "4", "--mode", "height", "--preview", "height.PNG"}));
  ASSERT_TRUE(info.is_object());
  EXPECT_EQ(info["bands"][0]["type"], "Float32");
  EXPECT_EQ(info["bands"][0]["noDataValue"], -9999.0);
  EXPECT_EQ(info["bands"][0]["unit"], "m");
  EXPECT_TRUE(read("height.PNG").starts_with("\x89PNG"));
}

TEST_F(VisibilityMapsTest, the_unit_of_a_system_that_is_named_by_its_code_only_is_known) {
  // 0: no system.
  struct Case {
    int code;
    std::string unit, curvature;
  };
  for (const Case& one : {Case{32632, "m", "0.85714;"}, Case{2229, "ft", "0.85714;"}, Case{0, "", "0;"}}) {
    PointCloud cloud = field();
    if (one.code == 0) cloud.crs = {};
    if (one.code != 0) cloud.crs.geotiff_keys.back() = static_cast<std::uint16_t>(one.code);
    std::filesystem::remove(folder / "field.las");
    write_las(folder / "field.las", cloud);
    const json info = map_of("raster", std::to_string(one.code) + ".tif",
                             with(k_eye, {"--resolution", "4", "--mode", "height"}));
    ASSERT_TRUE(info.is_object());
    EXPECT_EQ(info["bands"][0].value("unit", ""), one.unit) << one.code;
    const std::string sight = info["metadata"][""]["alidade_sight"];
    EXPECT_TRUE(contains(sight, "curvature " + one.curvature)) << sight;
  }
}

TEST_F(VisibilityMapsTest, cells_are_by_default_no_finer_than_those_of_the_ground) {
  const json info = map_of("sky", "sky.tif", {"--directions", "2", "--ground-cell", "4"});
  ASSERT_TRUE(info.is_object());
  EXPECT_EQ(info["geoTransform"][1], 5.0);
  const json own =
      map_of("sky", "own.tif", {"--directions", "2", "--ground-cell", "4", "--resolution", "2.5"});
  EXPECT_EQ(own["geoTransform"][1], 2.5);
}

TEST_F(VisibilityMapsTest, a_map_of_the_sky_is_one_of_the_same_kind) {
  const json info =
      map_of("sky", "sky.tiff", with(k_cells, {"--directions", "4", "--tz", "0.5", "--max-distance", "100"}));
  expect_map(info);
  EXPECT_EQ(info["bands"].size(), 1u);
  EXPECT_EQ(info["bands"][0]["type"], "Float32");
  EXPECT_EQ(info["bands"][0]["noDataValue"], -9999.0);
  EXPECT_EQ(info["bands"][0]["description"], "SkyView");
  const json& metadata = info["metadata"][""];
  EXPECT_TRUE(contains(metadata["alidade_sky"], "4 directions"));
  EXPECT_EQ(metadata["alidade_target_height"], "0.5");
  EXPECT_EQ(metadata["alidade_max_distance"], "100");
}

TEST_F(VisibilityMapsTest, a_map_of_the_sun_has_hours) {
  // Few cells: with extensions they also receive the light of the sky.
  const Words cells{"--resolution", "5", "--extent", k_cells[3]};
  const json info = map_of("sun", "sun.tif", with(cells, k_day));
  expect_map(info, 52);
  EXPECT_EQ(info["bands"][0]["description"], "SunHours");
  EXPECT_EQ(info["bands"][0]["unit"], "h");
  EXPECT_EQ(info["bands"][0]["noDataValue"], -9999.0);
  const json& metadata = info["metadata"][""];
  EXPECT_EQ(metadata["alidade_sun_receiver"], "horizontal");
  EXPECT_TRUE(contains(metadata["alidade_sun_from"], "2026-06-2"));
  EXPECT_EQ(metadata["alidade_sun_step_minutes"], "240");
  EXPECT_EQ(metadata["alidade_sun_bin_degrees"], "exact");
  EXPECT_TRUE(contains(metadata["alidade_place"], "latitude 48.0"));
}

TEST_F(VisibilityMapsTest, a_map_of_the_sun_by_months_has_bands_for_each) {
  const json info =
      map_of("sun", "months.tif",
             {"--resolution", "20", "--from", "2026-03-31", "--to", "2026-04-02", "--place", "48,11",
              "--step", "240", "--per", "month", "--receiver", "surface", "--preview", "m.png"});
  const std::size_t bands = info["bands"].size();
  EXPECT_EQ(info["bands"][0]["description"], "SunHours_2026-03");
  EXPECT_EQ(info["bands"][bands / 2]["description"], "SunHours_2026-04");
  EXPECT_EQ(info["metadata"][""]["alidade_sun_receiver"], "slope of the ground");
}

TEST_F(VisibilityMapsTest, cells_without_ground_have_no_data_in_any_map) {
  // Points of a corner only; 10 beyond them the ground ends.
  PointCloud corner = field();
  corner.positions.clear();
  corner.classifications.clear();
  for (int i = 0; i < 400; ++i) corner.positions.emplace_back(500 * (i % 20), 500 * (i / 20), 0);
  corner.positions.emplace_back(60000, 60000, 0);
  corner.classifications.assign(corner.positions.size(), 2);
  write_las(folder / "corner.las", corner);
  for (const Words& words : {Words{"raster", "--observer", "690005,5325005,602", "--mode", "fraction"},
                             Words{"sky", "--directions", "4"}, with({"sun"}, k_day)}) {
    Words all = with({"visibility"}, words);
    all = with(all, {"corner.las", "--resolution", "4", "--ground-cell", "1", "-o", words[0] + ".tif"});
    const ProgramResult result = run(all);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const GDALDatasetH map = GDALOpen((folder / (words[0] + ".tif")).c_str(), GA_ReadOnly);
    ASSERT_NE(map, nullptr);
    for (int number = 1; number <= GDALGetRasterCount(map); ++number) {
      std::vector<float> values(15 * 15);
      ASSERT_EQ(GDALGetRasterXSize(map), 15);
      ASSERT_EQ(GDALRasterIO(GDALGetRasterBand(map, number), GF_Read, 0, 0, 15, 15, values.data(), 15, 15,
                             GDT_Float32, 0, 0),
                CE_None);
      EXPECT_EQ(values[15 * 7 + 7], -9999.0f) << words[0];
      // Level ground gets nothing from the ground around.
      const bool is_reflected =
          std::string(GDALGetDescription(GDALGetRasterBand(map, number))) == "ReflectedEnergy";
      EXPECT_GT(values[15 * 13 + 1], is_reflected ? -1.0f : 0.0f) << words[0];
    }
    GDALClose(map);
  }
}

TEST_F(VisibilityMapsTest, cells_that_nobody_scanned_have_no_data_in_any_map) {
  // A field of 20 x 20 with a pond of 8 x 8 without echoes: its ground is closed, but not known.
  PointCloud field_with_pond = field();
  field_with_pond.positions.clear();
  for (int i = 0; i < 80 * 80; ++i) {
    const int column = i % 80, row = i / 80;
    if (column > 24 && column < 56 && row > 24 && row < 56) continue;
    field_with_pond.positions.emplace_back(250 * column, 250 * row, 0);
  }
  field_with_pond.classifications.assign(field_with_pond.positions.size(), 2);
  write_las(folder / "pond.las", field_with_pond);
  const auto middle_of = [&](const Words& words) {
    const ProgramResult result = run(with(
        with({"visibility"}, words), {"pond.las", "--resolution", "2", "--overwrite", "-o", "pond.tif"}));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const GDALDatasetH map = GDALOpen((folder / "pond.tif").c_str(), GA_ReadOnly);
    float middle = 0.0f, corner = 0.0f;
    GDALRasterBandH band = GDALGetRasterBand(map, 1);
    EXPECT_EQ(GDALRasterIO(band, GF_Read, 5, 5, 1, 1, &middle, 1, 1, GDT_Float32, 0, 0), CE_None);
    EXPECT_EQ(GDALRasterIO(band, GF_Read, 1, 1, 1, 1, &corner, 1, 1, GDT_Float32, 0, 0), CE_None);
    const double nodata = GDALGetRasterNoDataValue(band, nullptr);
    GDALClose(map);
    EXPECT_NE(corner, nodata) << words[0];
    return middle == nodata;
  };
  for (const Words& words : {Words{"raster", "--observer", "690001,5325001,602"},
                             Words{"raster", "--observer", "690001,5325001,602", "--mode", "count"},
                             Words{"sky", "--directions", "4"}, with({"sun"}, k_day)}) {
    EXPECT_TRUE(middle_of(words)) << words[0];
    EXPECT_FALSE(middle_of(with(words, {"--ground-reach", "10"}))) << words[0] << ": the user says so";
  }
}

TEST_F(VisibilityMapsTest, mistakes_of_users_are_errors_before_surfaces_are_measured) {
  const Words raster = with({"-o", "seen.tif"}, k_eye);
  expect_rejected_early("raster", {"-o", "seen.tif", "--observers", "nobody.csv"}, "nobody.csv");
  expect_rejected_early("raster", {"-o", "seen.tif", "--observer", "690900,5325100"},
                        "no ground below the observer");
  expect_rejected_early("raster", with(raster, {"--resolution", "0.0001"}), "cells");
  expect_rejected_early("raster", with(raster, {"--extent", "0,0,1,1"}), "--extent");
  expect_rejected_early("raster", with(raster, {"--ground", "class", "--preview", "seen.jpg"}), ".png");
  write("there.tif", "mine");
  expect_rejected_early("raster", with({"-o", "there.tif"}, k_eye), "there.tif");
  expect_rejected_early("sky", {"-o", "there.tif"}, "there.tif");
  expect_rejected_early("sky", {"-o", "sky.tif", "--extent", "0,0,1,1"}, "--extent");
  expect_rejected_early("sky", {"-o", "sky.tif", "--resolution", "0.001"}, "cells");
  expect_rejected_early("sky", {"-o", "sky.las", "--ground", "lowest"}, "--ground");
  expect_rejected_early("sun", with({"-o", "sun.las", "--extent", "0,0,1,1"}, k_day), "--extent");
}

TEST_F(VisibilityMapsTest, the_command_in_a_map_does_not_contain_where_it_was_written) {
  ASSERT_EQ(map_of("sky", "one.tif", {"--resolution", "8", "--directions", "2", "-q"}).is_object(), true);
  ASSERT_EQ(
      map_of("sky", "two.tif", {"--resolution", "8", "--directions", "2", "--threads", "1"}).is_object(),
      true);
  EXPECT_TRUE(read("one.tif") == read("two.tif"));
}

}  // namespace
}  // namespace alidade::test
