// SPDX-License-Identifier: MIT
#include "geo/crs_library.h"

#include <cpl_conv.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cloud/axis_units.h"
#include "geo/gdal_reference.h"
#include "geo/reproject.h"
#include "tests/cloud/crs_of_keys.h"

namespace alidade::geo {
namespace {

using test::crs_of_keys;

/// A system by its code, in another form of WKT.
Crs written(const std::string& code, const char* format) {
  GdalReference reference(OSRNewSpatialReference(nullptr));
  EXPECT_EQ(OSRSetFromUserInput(reference.get(), code.c_str()), OGRERR_NONE);
  const char* const options[] = {format, nullptr};
  char* text = nullptr;
  EXPECT_EQ(OSRExportToWktEx(reference.get(), &text, options), OGRERR_NONE);
  const Crs crs = crs_of_wkt(text != nullptr ? text : "");
  CPLFree(text);
  return crs;
}

TEST(CompareSystemsTest, one_system_is_the_same_however_it_is_written) {
  for (const std::uint16_t code : {25832, 32632, 2154, 3005, 2903, 26910, 28992, 27700, 2056, 31287, 3857,
                                   2949, 2193, 5514, 3067, 2994, 32104}) {
    const std::string name = "EPSG:" + std::to_string(code);
    std::vector<Crs> forms = {crs_of_keys({1024, 1, 1025, 1, 3072, code}), crs_of_text(name)};
    for (const char* const format :
         {"FORMAT=WKT1", "FORMAT=WKT2_2015", "FORMAT=WKT2_2019", "FORMAT=WKT1_ESRI"})
      forms.push_back(written(name, format));
    for (const Crs& a : forms)
      for (const Crs& b : forms)
        EXPECT_EQ(compare_systems(a, b), CrsAgreement::same) << name << a.wkt << b.wkt;
  }
}

TEST(CompareSystemsTest, other_systems_are_different_however_they_are_written) {
  // Metres of Quebec and feet of Oregon.
  EXPECT_EQ(compare_systems(crs_of_keys({1024, 1, 3072, 2949}), written("EPSG:2994", "FORMAT=WKT1_ESRI")),
            CrsAgreement::different);
  // Other projections with the same parameters.
  EXPECT_EQ(compare_systems(crs_of_text("ESRI:54009"), crs_of_text("ESRI:54012")), CrsAgreement::different);
  // South and west, and east and north.
  EXPECT_EQ(compare_systems(crs_of_text("EPSG:5513"), crs_of_text("EPSG:5514")), CrsAgreement::different);
  EXPECT_EQ(compare_systems(crs_of_text("EPSG:3413"), written("EPSG:3413", "FORMAT=WKT1_ESRI")),
            CrsAgreement::same);
  const char* const codes[] = {"EPSG:25832", "EPSG:25833", "EPSG:32632", "EPSG:2991", "EPSG:2994",
                               "EPSG:26910", "EPSG:3740",  "EPSG:4326",  "EPSG:4978"};
  for (const char* const a : codes)
    for (const char* const b : codes)
      if (std::string(a) != b) {
        EXPECT_EQ(compare_systems(crs_of_text(a), written(b, "FORMAT=WKT2_2019")), CrsAgreement::different)
            << a << " " << b;
      }
}

TEST(CompareSystemsTest, names_of_datums_alone_do_not_make_systems_different) {
  // As three programs wrote Oregon's feet, with the code of one datum.
  const auto oregon = [](const std::string& datum, const std::string& flattening, const std::string& code) {
    return crs_of_wkt(
        R"(PROJCS["NAD_1983_HARN_Lambert_Conformal_Conic",GEOGCS["GCS_North_American_1983_HARN",DATUM[")" +
        datum + R"(",SPHEROID["GRS_1980",6378137,)" + flattening + "]" + code +
        R"(],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],)"
        R"(PROJECTION["Lambert_Conformal_Conic_2SP"],PARAMETER["standard_parallel_1",43],)"
        R"(PARAMETER["standard_parallel_2",45.5],PARAMETER["latitude_of_origin",41.75],)"
        R"(PARAMETER["central_meridian",-120.5],PARAMETER["false_easting",1312335.958005249],)"
        R"(PARAMETER["false_northing",0],UNIT["foot",0.3048,AUTHORITY["EPSG","9002"]]])");
  };
  const std::string code = R"(,AUTHORITY["EPSG","6152"])";
  const Crs regional = oregon("NAD83_High_Accuracy_Regional_Network", "298.257222101", code);
  EXPECT_EQ(
      compare_systems(regional, oregon("NAD83_High_Accuracy_Reference_Network", "298.2572221010002", code)),
      CrsAgreement::same);
  EXPECT_EQ(compare_systems(regional, crs_of_text("EPSG:2994")), CrsAgreement::same);
  // Without a code it is unknown.
  EXPECT_EQ(compare_systems(oregon("somebody's datum", "298.257222101", ""), crs_of_text("EPSG:2994")),
            CrsAgreement::unknown);
  EXPECT_EQ(compare_systems(oregon("somebody's datum", "299.1528128", ""), crs_of_text("EPSG:2994")),
            CrsAgreement::different);
}

TEST(CompareSystemsTest, heights_differ_by_unit_and_by_datum) {
  const auto compare = [](const std::string& a, const std::string& b) {
    return compare_systems(crs_of_text(a), crs_of_text(b));
  };
  EXPECT_EQ(compare("EPSG:26910+5703", "EPSG:26910+5703"), CrsAgreement::same);
  EXPECT_EQ(compare("EPSG:26910+5703", "EPSG:26910+6360"), CrsAgreement::different) << "metres and feet";
  EXPECT_EQ(compare("EPSG:26910+5703", "EPSG:26910+5714"), CrsAgreement::different) << "NAVD88 and sea level";
  EXPECT_EQ(compare("EPSG:26910+5703", "EPSG:26910"), CrsAgreement::same)
      << "not stated: the unit of x and y";
  EXPECT_EQ(compare("EPSG:26910+6360", "EPSG:26910"), CrsAgreement::different);
  EXPECT_EQ(compare_systems(crs_of_keys({3072, 26910, 4096, 5703}), crs_of_text("EPSG:26910+5703")),
            CrsAgreement::same);
  EXPECT_EQ(
      compare_systems(crs_of_keys({3072, 26910, 4096, 5703, 4099, 9003}), crs_of_text("EPSG:26910+5703")),
      CrsAgreement::different)
      << "the key states feet";
  EXPECT_EQ(
      compare_systems(crs_of_keys({3072, 26910, 4096, 5703, 4099, 9003}), crs_of_text("EPSG:26910+6360")),
      CrsAgreement::same);
  EXPECT_EQ(
      compare_systems(crs_of_keys({3072, 26910, 4096, 32767, 4099, 9001}), crs_of_text("EPSG:26910+5703")),
      CrsAgreement::unknown);
  // Heights that were converted are those of the system in metres.
  EXPECT_EQ(compare_systems(with_height_unit(crs_of_text("EPSG:26910+6360"), k_metre),
                            crs_of_text("EPSG:26910+5703")),
            CrsAgreement::same);
}

TEST(CompareSystemsTest, what_is_not_understood_is_not_compared) {
  const Crs known = crs_of_text("EPSG:25832");
  EXPECT_FALSE(compare_systems(crs_of_wkt("PROJCS[\"damaged"), known));
  EXPECT_FALSE(compare_systems(known, crs_of_keys({3072, 32767})));
  EXPECT_EQ(compare_systems(crs_of_wkt("LOCAL_CS[\"site\",UNIT[\"metre\",1]]"), known),
            CrsAgreement::unknown);
}

TEST(WholeWktTest, keys_keep_their_heights_and_the_unit_that_they_state) {
  const auto units_of = [](const std::vector<std::uint16_t>& keys) {
    const AxisUnits units = stated_units(crs_of_wkt(library_wkt(crs_of_keys(keys))));
    return short_name(units.plane.value_or(LengthUnit{"-"})) + " " +
           short_name(units.heights.value_or(LengthUnit{"-", 2}));
  };
  EXPECT_EQ(units_of({1024, 1, 3072, 3005, 4096, 5713}), "m m");
  EXPECT_EQ(units_of({1024, 1, 3072, 26910, 4096, 6360}), "m us-ft");
  EXPECT_EQ(units_of({1024, 1, 3072, 26910, 4096, 5703, 4099, 9003}), "m us-ft") << "the key states feet";
  EXPECT_EQ(units_of({1024, 1, 3072, 26910, 4099, 9002}), "m ft");
  EXPECT_EQ(units_of({1024, 1, 3072, 2994, 4096, 5703}), "ft m");
  EXPECT_EQ(library_wkt(crs_of_keys({3072, 32767})), "") << "GDAL invents a local system";
  EXPECT_EQ(library_wkt(crs_of_wkt("as it is")), "as it is");
}

}  // namespace
}  // namespace alidade::geo
