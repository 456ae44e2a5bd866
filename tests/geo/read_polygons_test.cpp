// SPDX-License-Identifier: MIT
#include "geo/vector_file.h"

#include "tests/geo/vector_file_test.h"

namespace alidade::test {

using namespace geo;

namespace {

namespace fs = std::filesystem;

class ReadPolygonsTest : public VectorFileTest {
 protected:
  /// Reads features of one geometry each, in the cloud's own system.
  std::vector<PlanePolygon> read(const std::vector<std::string>& geometries) const {
    std::string features;
    for (const std::string& geometry : geometries) {
      features += fmt::format(R"({}{{"type":"Feature","properties":{{}},"geometry":{}}})",
                              features.empty() ? "" : ",", geometry);
    }
    return read_polygons(
        write("p.geojson", fmt::format(R"({{"type":"FeatureCollection","features":[{}]}})", features)),
        k_own);
  }

  static std::string problem_of(const fs::path& path, const ObserverReference& reference) {
    return problem_in([&] { read_polygons(path, reference); });
  }

  /// One square in a new file of that driver; `epsg` 0: no reference system.
  fs::path write_square(const std::string& name, const char* driver, int epsg) const {
    return write_layer(name, driver, epsg, wkbPolygon, [](OGRLayerH layer) {
      const OGRFeatureH feature = OGR_F_Create(OGR_L_GetLayerDefn(layer));
      char wkt[] = "POLYGON((690000 5325000,690000 5325010,690010 5325010,690000 5325000))";
      char* text = wkt;
      OGRGeometryH polygon = nullptr;
      OGR_G_CreateFromWkt(&text, nullptr, &polygon);
      OGR_F_SetGeometryDirectly(feature, polygon);
      EXPECT_EQ(OGR_L_CreateFeature(layer, feature), OGRERR_NONE);
      OGR_F_Destroy(feature);
    });
  }

  const ObserverReference k_own{.given = "cloud", .option = "--crop-crs", .whose = "polygons"};
};

constexpr const char* k_square = R"({"type":"Polygon","coordinates":[[[0,0],[4,0],[4,4],[0,4],[0,0]]]})";

TEST_F(ReadPolygonsTest, polygons_of_all_features_come_with_their_holes) {
  const auto polygons = read(
      {k_square,
       R"({"type":"Polygon","coordinates":[[[10,0],[14,0],[14,4],[10,0]],[[12,1],[13,1],[13,2],[12,1]]]})"});
  ASSERT_EQ(polygons.size(), 2u);
  ASSERT_EQ(polygons[0].rings.size(), 1u);
  EXPECT_EQ(polygons[0].rings[0], (std::vector<glm::dvec2>{{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0}}));
  ASSERT_EQ(polygons[1].rings.size(), 2u);
  EXPECT_EQ(polygons[1].rings[1][0], glm::dvec2(12, 1));
}

TEST_F(ReadPolygonsTest, multi_polygons_and_collections_are_as_many_polygons) {
  EXPECT_EQ(read({R"({"type":"MultiPolygon","coordinates":[[[[0,0],[1,0],[1,1],[0,0]]],
                                                           [[[5,0],[6,0],[6,1],[5,0]]]]})"})
                .size(),
            2u);
  EXPECT_EQ(
      read({fmt::format(R"({{"type":"GeometryCollection","geometries":[{0},{0},{0}]}})", k_square)}).size(),
      3u);
}

TEST_F(ReadPolygonsTest, heights_are_passed_over) {
  const auto polygons = read({R"({"type":"Polygon","coordinates":[[[0,0,7],[4,0,8],[4,4,9],[0,0,7]]]})"});
  ASSERT_EQ(polygons.size(), 1u);
  EXPECT_EQ(polygons[0].rings[0][1], glm::dvec2(4, 0));
}

TEST_F(ReadPolygonsTest, other_geometries_are_errors_naming_the_feature) {
  for (const auto& [geometry, found] :
       {std::pair(R"({"type":"Point","coordinates":[1,2]})", "Point"),
        std::pair(R"({"type":"LineString","coordinates":[[1,2],[3,4]]})", "Line String"),
        std::pair("null", "no geometry")}) {
    const fs::path path = write(
        "p.geojson", fmt::format(R"({{"type":"Feature","id":7,"properties":{{}},"geometry":{}}})", geometry));
    const std::string problem = problem_of(path, k_own);
    EXPECT_EQ(problem, fmt::format("{}:feature 7: unsupported geometry; expected polygons, found {}",
                                   path.string(), found));
  }
}

TEST_F(ReadPolygonsTest, files_without_polygons_or_damaged_are_errors) {
  const auto problem = [&](const std::string& text) { return problem_of(write("p.geojson", text), k_own); };
  EXPECT_NE(problem(R"({"type":"FeatureCollection","features":[]})").find("contains no polygons"),
            std::string::npos);
  EXPECT_NE(
      problem(R"({"type":"Feature","properties":{},"geometry":{"type":"MultiPolygon","coordinates":[]}})")
          .find("contains no polygons"),
      std::string::npos);
  EXPECT_NE(problem("{\"type\":").find("cannot read the file as polygons"), std::string::npos);
  EXPECT_NE(problem_of(folder_ / "absent.gpkg", k_own).find("not a file"), std::string::npos);
}

TEST_F(ReadPolygonsTest, corners_are_transformed_into_the_clouds_system) {
  const fs::path path = write("p.geojson",
                              R"({"type":"Feature","properties":{},"geometry":{"type":"Polygon",
          "coordinates":[[[9,48],[9.001,48],[9,48.001],[9,48]]]}})");
  ObserverReference reference = k_own;
  reference.given = "";
  reference.cloud = utm();
  const auto polygons = read_polygons(path, reference);
  ASSERT_EQ(polygons.size(), 1u);
  // 9 degrees east is the middle meridian of the zone; the northing is 0.9996 of its arc up to 48 degrees.
  EXPECT_NEAR(polygons[0].rings[0][0].x, 500000.0, 1e-3);
  EXPECT_NEAR(polygons[0].rings[0][0].y, 0.9996 * 5318427.59, 0.01);
}

TEST_F(ReadPolygonsTest, positions_in_the_clouds_own_system_stay_exactly_what_they_are) {
  for (const auto& [name, driver] : {std::pair("p.gpkg", "GPKG"), std::pair("p.shp", "ESRI Shapefile")}) {
    ObserverReference reference = k_own;
    reference.given = "";
    reference.cloud = utm();
    const auto polygons = read_polygons(write_square(name, driver, 25832), reference);
    ASSERT_EQ(polygons.size(), 1u);
    EXPECT_EQ(polygons[0].rings[0][2], glm::dvec2(690010, 5325010));
  }
}

TEST_F(ReadPolygonsTest, known_against_unknown_system_is_an_error_with_a_way_out) {
  const fs::path without = write_square("without.shp", "ESRI Shapefile", 0);
  const fs::path with = write_square("with.shp", "ESRI Shapefile", 25832);
  ObserverReference nowhere = k_own, somewhere = k_own;
  nowhere.given = somewhere.given = "";
  somewhere.cloud = utm();
  EXPECT_EQ(problem_of(without, nowhere), "");
  EXPECT_EQ(problem_of(without, somewhere),
            without.string() +
                ": the reference system of the polygons is unknown, but that of the cloud is known; expected "
                "--crop-crs SYSTEM, or --crop-crs cloud if they are in the cloud's");
  EXPECT_EQ(problem_of(with, nowhere),
            with.string() +
                ": the reference system of the cloud is unknown, but that of the polygons is known; expected "
                "--crop-crs cloud if they are in the cloud's own");
  EXPECT_EQ(problem_of(with, k_own), "");
}

}  // namespace
}  // namespace alidade::test
