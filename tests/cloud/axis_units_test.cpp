// SPDX-License-Identifier: MIT
// Units of the axes of reference systems, and clouds whose heights are in another unit than x and y.
#include "cloud/axis_units.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cloud/catalog.h"
#include "cloud/input_view.h"
#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/crs_of_keys.h"
#include "tests/cloud/las/las_builder.h"

namespace alidade {
namespace {

using test::build_las;
using test::crs_of_keys;
using test::error_of;
using test::LasFile;
using Bytes = std::vector<std::byte>;

const std::string k_geographic =
    R"(GEOGCS["NAD83",DATUM["North_American_Datum_1983",SPHEROID["GRS 1980",6378137,)"
    R"(298.257222101]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]])";

std::string plane(const std::string& unit) {
  return R"(PROJCS["Oregon LCC",)" + k_geographic +
         R"(,PROJECTION["Lambert_Conformal_Conic_2SP"],PARAMETER["false_easting",400000],)" + unit +
         R"(,AXIS["Easting",EAST],AUTHORITY["EPSG","2991"]])";
}

/// With heights, as GDAL writes it.
std::string with_heights(const std::string& unit, const std::string& height_unit,
                         const std::string& name = "NAVD88 height (ftUS)") {
  return R"(COMPD_CS["Oregon LCC + )" + name + R"(",)" + plane(unit) + R"(,VERT_CS[")" + name +
         R"(",VERT_DATUM["North American Vertical Datum 1988",2005,AUTHORITY["EPSG","5103"]],)" +
         height_unit +
         R"(,AXIS["Gravity-related height",UP],AUTHORITY["EPSG","6360"]],AUTHORITY["EPSG","9999"]])";
}

const std::string k_metres = R"(UNIT["metre",1,AUTHORITY["EPSG","9001"]])", k_feet = R"(UNIT["foot",0.3048])",
                  k_survey_feet = R"(UNIT["US survey foot",0.304800609601219])";

const std::string k_version_2 =
    R"~(COMPOUNDCRS["c",PROJCRS["a",BASEGEOGCRS["b",DATUM["d",ELLIPSOID["e",6378137,298,LENGTHUNIT["metre",1]]],
PRIMEM["g",0,ANGLEUNIT["degree",0.0174532925199433]]],CONVERSION["k",PARAMETER["p",1,LENGTHUNIT["kilometre",1000]]],
CS[Cartesian,2],AXIS["(E)",east,ORDER[1],LENGTHUNIT["US survey foot",0.304800609601219]],
AXIS["(N)",north,ORDER[2],LENGTHUNIT["US survey foot",0.304800609601219]]],
VERTCRS["h",VDATUM["v"],CS[vertical,1],AXIS["height (H)",up,LENGTHUNIT["metre",1]],ID["EPSG",5703]]])~";
const std::string k_three_axes =
    R"~(PROJCRS["a",BASEGEOGCRS["b"],CS[Cartesian,3],AXIS["(E)",east,LENGTHUNIT["metre",1]],
AXIS["(N)",north,LENGTHUNIT["metre",1]],AXIS["ellipsoidal height (h)",up,LENGTHUNIT["foot",0.3048]],ID["EPSG",1]])~";

/// "m", "us-ft m" where heights are stated, "-" for what is unknown.
std::string units_of(const Crs& crs) {
  const AxisUnits units = stated_units(crs);
  const auto name = [](const std::optional<LengthUnit>& unit) { return unit ? short_name(*unit) : "-"; };
  return name(units.plane) + (units.states_heights ? " " + name(units.heights) : "");
}

TEST(AxisUnitsTest, wkt_of_both_versions_states_the_unit_of_each_axis) {
  EXPECT_EQ(units_of(crs_of_wkt(plane(k_metres))), "m");
  EXPECT_EQ(units_of(crs_of_wkt(plane(k_survey_feet))), "us-ft");
  EXPECT_EQ(units_of(crs_of_wkt(plane(R"(UNIT["Foot_US",0.3048006096012192])"))), "us-ft");
  EXPECT_EQ(units_of(crs_of_wkt(plane(R"(UNIT["Foot",0.3048])"))), "ft");
  EXPECT_EQ(units_of(crs_of_wkt(plane(R"(UNIT["kilometre", 1000])"))), "kilometre");
  EXPECT_EQ(units_of(crs_of_wkt(with_heights(k_metres, k_survey_feet))), "m us-ft");
  EXPECT_EQ(units_of(crs_of_wkt(with_heights(k_feet, k_metres))), "ft m");
  EXPECT_EQ(units_of(crs_of_wkt(k_version_2)), "us-ft m");
  EXPECT_EQ(units_of(crs_of_wkt(k_three_axes)), "m ft");
  EXPECT_EQ(units_of(crs_of_wkt(R"(PROJCRS["a",CS[Cartesian,3],AXIS["h",up],LENGTHUNIT["foot",0.3048]])")),
            "ft")
      << "one unit of all axes";
  EXPECT_EQ(units_of(crs_of_wkt(k_geographic)), "-");
  EXPECT_EQ(units_of(crs_of_wkt(R"(PROJCS["without",)" + k_geographic + "]")), "-")
      << "degrees are no lengths";
  EXPECT_EQ(units_of({}), "-");
}

TEST(AxisUnitsTest, geotiff_keys_state_units_and_codes_of_heights) {
  EXPECT_EQ(units_of(crs_of_keys({3072, 26910, 3076, 9001})), "m");
  EXPECT_EQ(units_of(crs_of_keys({3072, 26910, 3076, 9001, 4099, 9003})), "m us-ft");
  EXPECT_EQ(units_of(crs_of_keys({3072, 26910, 4096, 5703})), "- -") << "by codes alone";
  EXPECT_EQ(units_of(crs_of_keys({3072, 26910, 4096, 5703, 4099, 9002})), "- ft");
  EXPECT_EQ(units_of(crs_of_keys({3072, 26910, 3076, 9001, 4096, 0})), "m");
}

TEST(UnitLabelTest, of_x_and_y_is_metres_feet_or_degrees) {
  const auto of_wkt = [](const char* wkt) { return plane_unit_label(crs_of_wkt(wkt)); };
  EXPECT_EQ(plane_unit_label({}), "");
  EXPECT_EQ(of_wkt("GEOGCS[\"WGS 84\",UNIT[\"degree\",0.0174532925199433]]"), "deg");
  EXPECT_EQ(of_wkt("GEOGCRS[\"WGS 84\",ANGLEUNIT[\"degree\",0.0174532925199433]]"), "deg");
  EXPECT_EQ(of_wkt("PROJCS[\"a\",GEOGCS[\"b\",UNIT[\"degree\",0.0174]],UNIT[\"metre\",1]]"), "m");
  EXPECT_EQ(of_wkt("PROJCS[\"a\",GEOGCS[\"b\",UNIT[\"degree\",0.0174]],UNIT[\"US survey foot\",0.3048006]]"),
            "ft");
  EXPECT_EQ(plane_unit_label(crs_of_keys({1024, 2, 2048, 4326})), "deg");
  // Oregon in feet with heights in metres, and the other way round, in both forms of WKT.
  EXPECT_EQ(
      of_wkt("COMPD_CS[\"c\",PROJCS[\"a [ft]\",GEOGCS[\"b\",UNIT[\"degree\",0.0174]],UNIT[\"foot\",0.3048]],"
             "VERT_CS[\"v\",VERT_DATUM[\"d\",2005],UNIT[\"metre\",1]]]"),
      "ft");
  EXPECT_EQ(of_wkt("COMPOUNDCRS[\"c\",PROJCRS[\"a\",BASEGEOGCRS[\"b\"],CS[Cartesian,2],AXIS[\"x\",east],"
                   "LENGTHUNIT[\"metre\",1]],VERTCRS[\"v\",AXIS[\"up\",up],LENGTHUNIT[\"US survey "
                   "foot\",0.3048006]]]"),
            "m");
  EXPECT_EQ(plane_unit_label(crs_of_keys({1024, 1, 3076, 9002, 4099, 9001})), "ft");
}

TEST(UnitLabelTest, of_z_the_vertical_system_counts_else_the_horizontal_one) {
  const auto of_wkt = [](const char* wkt) { return height_unit_label(crs_of_wkt(wkt)); };
  EXPECT_EQ(height_unit_label(Crs()), "m");
  EXPECT_EQ(of_wkt(R"(PROJCS["x",GEOGCS["y",UNIT["degree",0.0174]],UNIT["metre",1]])"), "m");
  EXPECT_EQ(of_wkt(R"(PROJCS["x",GEOGCS["y",UNIT["degree",0.0174]],UNIT["US survey foot",0.3048]])"), "ft");
  EXPECT_EQ(
      of_wkt(
          R"(COMPD_CS["a",PROJCS["x",UNIT["US survey foot",0.304800609601219]],VERT_CS["h",UNIT["metre",1]]])"),
      "m");
  EXPECT_EQ(
      of_wkt(R"(COMPOUNDCRS["a",PROJCRS["x",LENGTHUNIT["metre",1]],VERTCRS["h",LENGTHUNIT["foot",0.3048]]])"),
      "ft");
  EXPECT_EQ(of_wkt(R"(GEOGCS["y",UNIT["degree",0.0174]])"), "m");
  EXPECT_EQ(of_wkt(R"(LOCAL_CS["y",UNIT["furlong",201.168]])"), "");
  EXPECT_EQ(of_wkt("UNIT[\"met"), "");
  // A vertical part without a known unit does not take that of x and y.
  EXPECT_EQ(of_wkt(R"(COMPD_CS["a",PROJCS["x",UNIT["metre",1]],VERT_CS["h",UNIT["furlong",201.168]]])"), "");
  EXPECT_EQ(of_wkt(R"(COMPD_CS["a",PROJCS["x",UNIT["metre",1]],VERT_CS["h",VERT_DATUM["d",2005]]])"), "");
  EXPECT_EQ(height_unit_label(crs_of_keys({3076, 9003})), "ft");
  EXPECT_EQ(height_unit_label(crs_of_keys({3076, 9003, 4099, 9001})), "m");
  for (const std::uint16_t unknown : {9005, 32767})
    EXPECT_EQ(height_unit_label(crs_of_keys({3076, 9001, 4099, unknown})), "") << unknown;
  EXPECT_EQ(height_unit_label(crs_of_keys({3076, 9001, 4096, 32767})), "");
  EXPECT_EQ(height_unit_label(crs_of_keys({3072, 2229})), "");
}

TEST(AxisUnitsTest, damaged_wkt_is_no_trouble) {
  const std::string whole = with_heights(k_metres, k_survey_feet);
  for (std::size_t length = 1; length < whole.size(); ++length) {
    const Crs part = crs_of_wkt(std::string(whole, 0, length));
    stated_units(part);
    with_height_unit(part, k_metre);
  }
  for (const char* const wkt :
       {"UNIT[", "UNIT[\"", "UNIT[\"m\"", "PROJCS[UNIT[\"m\",]", "PROJCS[UNIT[\"m\",nan]]",
        "VERT_CS[UNIT[\"m\",0]]", "VERT_CS[\"\",UNIT[\"m\",-1]]"})
    EXPECT_FALSE(stated_units(crs_of_wkt(wkt)).heights) << wkt;
}

TEST(AxisUnitsTest, the_time_for_nodes_within_nodes_grows_with_their_number) {
  for (const std::string key : {"UNIT[", "AXIS["}) {
    std::string open = "PROJCS[\"a\",", closing;
    for (int i = 0; i < 400'000; ++i) open += key, closing += ']';
    for (const std::string& wkt : {open, open + closing + "]"})
      EXPECT_EQ(units_of(with_height_unit(crs_of_wkt(wkt), k_metre)), "-") << key;
  }
}

TEST(HeightUnitTest, a_system_with_heights_in_another_unit_has_lost_codes_but_no_datum) {
  EXPECT_EQ(with_height_unit(crs_of_wkt(with_heights(k_metres, k_survey_feet)), k_metre).wkt,
            R"(COMPD_CS["Oregon LCC + NAVD88 height",)" + plane(k_metres) +
                R"(,VERT_CS["NAVD88 height",VERT_DATUM[)"
                R"("North American Vertical Datum 1988",2005,AUTHORITY["EPSG","5103"]],UNIT["metre",1],)"
                R"(AXIS["Gravity-related height",UP]]])");
  const std::string feet =
      with_height_unit(crs_of_wkt(with_heights(k_survey_feet, k_metres, "NAVD88 height")), k_survey_foot).wkt;
  EXPECT_NE(feet.find("VERT_CS[\"NAVD88 height (ftUS)\""), std::string::npos) << feet;
  EXPECT_EQ(units_of(crs_of_wkt(feet)), "us-ft us-ft");
  const std::string iso = with_height_unit(crs_of_wkt(k_version_2), k_survey_foot).wkt;
  EXPECT_EQ(units_of(crs_of_wkt(iso)), "us-ft us-ft");
  EXPECT_EQ(iso.find("5703"), std::string::npos);
  const std::string solid = with_height_unit(crs_of_wkt(k_three_axes), k_metre).wkt;
  EXPECT_EQ(units_of(crs_of_wkt(solid)), "m m");
  EXPECT_EQ(solid.find("ID["), std::string::npos);
  // Nothing to do.
  for (const Crs& crs : {crs_of_wkt(plane(k_metres)), crs_of_wkt(with_heights(k_metres, k_metres)), Crs()})
    EXPECT_EQ(with_height_unit(crs, k_metre), crs);
  // Keys that no library explains keep x and y.
  EXPECT_EQ(with_height_unit(crs_of_keys({3072, 26910, 4096, 6360, 4099, 9003}), k_metre),
            crs_of_keys({3072, 26910}));
}

double factor_of(const Crs& crs, const std::optional<LengthUnit>& stated = {}) {
  return heights_in_plane_unit(crs, stated, "site.las").factor;
}

TEST(HeightUnitTest, heights_get_the_unit_of_x_and_y) {
  EXPECT_EQ(factor_of(crs_of_wkt(with_heights(k_metres, k_survey_feet))), 1200.0 / 3937.0);
  EXPECT_EQ(factor_of(crs_of_wkt(with_heights(k_metres, k_feet))), 0.3048);
  EXPECT_EQ(factor_of(crs_of_wkt(with_heights(k_feet, k_metres))), 1.0 / 0.3048);
  EXPECT_EQ(factor_of(crs_of_keys({3076, 9001, 4099, 9003})), 1200.0 / 3937.0);
  for (const Crs& crs :
       {crs_of_wkt(plane(k_metres)), crs_of_wkt(plane(k_survey_feet)), crs_of_wkt(k_geographic), Crs(),
        crs_of_wkt(with_heights(k_metres, k_metres)), crs_of_keys({3072, 26910}),
        crs_of_wkt(R"(COMPD_CS["c",)" + k_geographic + R"(,VERT_CS["h",)" + k_feet + "]]")}) {
    const HeightChange change = heights_in_plane_unit(crs, {}, "site.las");
    EXPECT_EQ(change.factor, 1.0);
    EXPECT_EQ(change.crs, crs);
    EXPECT_TRUE(change.note.empty());
  }
}

TEST(HeightUnitTest, a_unit_can_be_stated_where_the_file_states_none) {
  EXPECT_EQ(factor_of(crs_of_wkt(plane(k_metres)), k_survey_foot), 1200.0 / 3937.0);
  EXPECT_EQ(factor_of(crs_of_wkt(plane(k_metres)), k_metre), 1.0);
  EXPECT_DOUBLE_EQ(factor_of(crs_of_keys({3076, 9003}), k_metre), 3937.0 / 1200.0);
  EXPECT_EQ(factor_of(crs_of_wkt(with_heights(k_metres, k_survey_feet)), k_survey_foot), 1200.0 / 3937.0)
      << "agrees";
  EXPECT_EQ(heights_in_plane_unit(crs_of_wkt(plane(k_metres)), k_foot, "site.las").crs,
            crs_of_wkt(plane(k_metres)));
}

TEST(HeightUnitTest, unknown_and_contradictory_units_are_errors_that_name_the_remedy) {
  EXPECT_EQ(
      error_of([] {
        factor_of(crs_of_keys({3076, 9001, 4096, 5703}));
      }),
      "site.las: the unit of heights is unknown; expected --vertical-unit m, ft or us-ft, or a file that "
      "'alidade convert --reproject' wrote with it, found vertical EPSG:5703");
  EXPECT_EQ(factor_of(crs_of_keys({3076, 9001, 4096, 5703}), k_foot), 0.3048);
  EXPECT_EQ(error_of([] { factor_of(crs_of_wkt(with_heights(k_metres, k_survey_feet)), k_foot); }),
            "site.las: --vertical-unit contradicts the reference system of the file; expected US survey "
            "foot, or no "
            "--vertical-unit, found foot");
  EXPECT_EQ(error_of([] { factor_of({}, k_foot); }),
            "site.las: the unit of x and y is unknown, but heights are in foot; expected --crs EPSG:n, which "
            "states "
            "another system, found none");
}

/// Three points at heights 1, 2.5 and 100, and a header with these bounds.
Bytes tile(const std::string& wkt, double offset = 0.0) {
  LasFile file;
  file.point_format = 0;
  file.scale = {0.01, 0.01, 0.01};
  file.offset = {500000, 4800000, offset};
  for (const double z : {1.0, 2.5, 100.0}) {
    file.points.emplace_back().z = static_cast<std::int32_t>(std::lround((z - offset) / 0.01));
    file.points.back().x = static_cast<std::int32_t>(file.points.size());
  }
  if (!wkt.empty()) {
    file.records = {{"LASF_Projection", 2112, "", {wkt.begin(), wkt.end()}}};
    file.records[0].data.push_back(0);
  }
  Bytes bytes = build_las(file);
  const double box[] = {500000.03, 500000.01, 4800000, 4800000, 100, 1};
  std::memcpy(bytes.data() + 179, box, sizeof box);
  return bytes;
}

CloudInputs clouds(const std::vector<Bytes>& tiles) {
  CloudInputs files;
  for (std::size_t i = 0; i < tiles.size(); ++i)
    files.inputs.push_back(cloud_in_memory(tiles[i], "tile_" + std::to_string(i)));
  return files;
}

constexpr double k_factor = 1200.0 / 3937.0;

TEST(OneUnitTest, heights_are_converted_on_the_lattice_and_stated_once) {
  const std::string wkt = with_heights(k_metres, k_survey_feet);
  const std::vector<Bytes> tiles = {tile(wkt), tile(wkt), tile(wkt)};
  const PointCloud stored = read_cloud(clouds(tiles)), cloud = read_cloud(in_one_unit(clouds(tiles)));
  EXPECT_EQ(cloud.positions, stored.positions) << "no height is rounded";
  EXPECT_EQ(cloud.lattice.scale, glm::dvec3(0.01, 0.01, 0.01 * k_factor));
  EXPECT_EQ(cloud.world(1).z, 250 * (0.01 * k_factor));
  EXPECT_EQ(units_of(cloud.crs), "m m");
  EXPECT_EQ(cloud.warnings,
            (std::vector<std::string>{
                "tile_0 and 2 more files: heights are converted from US survey foot to metre, "
                "the unit of x and y; heights in options are in metre, too"}));
  EXPECT_EQ(stored.crs.wkt, wkt);
  EXPECT_TRUE(stored.warnings.empty());
  EXPECT_NEAR(cloud.files[0].stated_bounds->max.z, 100 * k_factor, 1e-12);
}

TEST(OneUnitTest, tiles_of_other_offsets_and_of_metres_are_joined_with_them) {
  const std::string feet = with_heights(k_metres, k_survey_feet);
  const PointCloud offsets = read_cloud(in_one_unit(clouds({tile(feet), tile(feet, 50.0)})));
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(offsets.positions[i].z, offsets.positions[i + 3].z);
  const std::vector<Bytes> both = {tile(feet), tile(with_heights(k_metres, k_metres, "NAVD88 height"))};
  const PointCloud cloud = read_cloud(in_one_unit(clouds(both)));
  EXPECT_NEAR(cloud.world(2).z, 100 * k_factor, 0.01);
  EXPECT_NEAR(cloud.world(5).z, 100, 0.01);
}

TEST(OneUnitTest, selections_and_regions_are_in_the_unit_of_x_and_y) {
  InputView view;
  view.has_one_unit = true;
  view.selection.box = Bounds{{0, 0, 29}, {1e9, 1e9, 31}};
  const std::vector<Bytes> tiles = {tile(with_heights(k_metres, k_survey_feet))};
  CloudInputs files = clouds(tiles);
  files.inputs[0].view = std::make_shared<const InputView>(view);
  EXPECT_EQ(read_cloud(files).size(), 1u);
  view.selection.box = Bounds{{0, 0, 99}, {1e9, 1e9, 101}};
  files.inputs[0].view = std::make_shared<const InputView>(view);
  EXPECT_NE(error_of([&] { read_cloud(files); }).find("no points are selected"), std::string::npos);
  EXPECT_NEAR(stated_box(in_one_unit(clouds(tiles))).max.z, 100 * k_factor, 0.1);
}

TEST(OneUnitTest, a_file_without_a_system_cannot_follow) {
  const std::string wkt = with_heights(k_metres, k_survey_feet);
  EXPECT_EQ(error_of([&] {
              read_cloud(in_one_unit(clouds({tile(wkt), tile("")})));
            }),
            "tile_1: no coordinate reference system, and the heights of tile_0 are converted to the unit of "
            "x and y; "
            "expected --crs EPSG:n, which states one");
  EXPECT_EQ(read_cloud(clouds({tile(wkt), tile("")})).size(), 6u);
}

TEST(OneUnitTest, a_catalog_of_such_files_is_an_error_because_its_boxes_are_as_stored) {
  const std::vector<Bytes> tiles = {tile(with_heights(k_metres, k_survey_feet))};
  CloudInputs files = in_one_unit(clouds(tiles));
  files.inputs[0].stated =
      std::make_shared<const StatedFile>(StatedFile{"a catalog", {glm::dvec3(-1e9), glm::dvec3(1e9)}, 3});
  EXPECT_NE(error_of([&] {
              read_cloud(files);
            }).find("a catalog of files whose heights are not in the unit of x and y"),
            std::string::npos);
}

TEST(OneUnitTest, files_without_a_lattice_get_one_for_the_converted_heights) {
  const std::string text = "x,y,z\n500000,4800000,1\n500001,4800000,2.5\n";
  const auto bytes = std::as_bytes(std::span(text));
  InputView view;
  view.has_one_unit = true;
  view.change_reference = [](const std::filesystem::path&, const FileFacts&) {
    return ReferenceChange{.crs = crs_of_wkt(with_heights(k_metres, k_feet))};
  };
  const std::vector<Bytes> tiles = {{bytes.begin(), bytes.end()}};
  CloudInputs files = clouds(tiles);
  files.inputs[0].view = std::make_shared<const InputView>(view);
  const PointCloud cloud = read_cloud(files);
  EXPECT_LE(cloud.lattice.scale.z, 0.01 * 0.1 * 0.3048) << "much finer than the tenths of feet of the file";
  EXPECT_NEAR(cloud.world(0).z, 0.3048, 0.5 * cloud.lattice.scale.z + 1e-9);
  EXPECT_NEAR(cloud.world(1).z, 0.762, 0.5 * cloud.lattice.scale.z + 1e-9);
  EXPECT_EQ(units_of(cloud.crs), "m m");
}

}  // namespace
}  // namespace alidade
