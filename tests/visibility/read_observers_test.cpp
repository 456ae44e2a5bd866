// SPDX-License-Identifier: MIT
#include "visibility/read_observers.h"

#include <cmath>

#include "tests/geo/vector_file_test.h"

namespace alidade::test {

using namespace geo;
using namespace visibility;

namespace {

namespace fs = std::filesystem;

class ReadObserversTest : public VectorFileTest {
 protected:
  std::vector<GivenObserver> read(const fs::path& path, const ObserverReference& reference = {}) const {
    return read_observers(path, reference);
  }
  std::string problem_of(const fs::path& path, const ObserverReference& reference = {}) const {
    return problem_in([&] { read(path, reference); });
  }
  /// Expects the problem to begin with the file's name and `location`, and to contain `part`.
  void expect_problem(const std::string& name, const std::string& text, const std::string& location,
                      const std::string& part) const {
    const fs::path path = write(name, text);
    const std::string problem = problem_of(path);
    EXPECT_EQ(problem.rfind(path.string() + location, 0), 0u) << text << "\n" << problem;
    EXPECT_NE(problem.find(part), std::string::npos) << text << "\n" << problem;
  }

  /// Points with attributes in a new file of that driver; `epsg` 0: no reference system.
  fs::path write_masts(const std::string& name, const char* driver, int epsg, OGRwkbGeometryType type,
                       int masts = 2) const {
    return write_layer(name, driver, epsg, type, [&](OGRLayerH layer) {
      for (const auto& [field, kind] :
           {std::pair("NAME", OFTString), std::pair("height", OFTReal), std::pair("elev_min", OFTInteger)}) {
        const OGRFieldDefnH definition = OGR_Fld_Create(field, kind);
        OGR_L_CreateField(layer, definition, TRUE);
        OGR_Fld_Destroy(definition);
      }
      for (int i = 0; i < masts; ++i) {
        const OGRFeatureH feature = OGR_F_Create(OGR_L_GetLayerDefn(layer));
        OGR_F_SetFieldString(feature, 0, fmt::format("mast {}", i).c_str());
        if (i == 1) OGR_F_SetFieldDouble(feature, 1, 12.5);
        if (i == 1) OGR_F_SetFieldInteger(feature, 2, -30);
        const OGRGeometryH point = OGR_G_CreateGeometry(type);
        if (OGR_GT_HasZ(type) != 0)
          OGR_G_SetPoint(point, 0, 690000.0 + i, 5325000.0, 600.0 + i);
        else
          OGR_G_SetPoint_2D(point, 0, 690000.0 + i, 5325000.0);
        OGR_F_SetGeometryDirectly(feature, point);
        EXPECT_EQ(OGR_L_CreateFeature(layer, feature), OGRERR_NONE);
        OGR_F_Destroy(feature);
      }
    });
  }
};

std::string geojson(const std::string& features) {
  return R"({"type":"FeatureCollection","features":[)" + features + "]}";
}

TEST_F(ReadObserversTest, csv_has_columns_by_name_in_any_order) {
  const auto observers = read(write("o.csv",
                                    "name,max_distance,y,x,z,height\r\n"
                                    "\"tower, north\",inf,5325000.5,690000.25,600,30\r\n\r\n"
                                    "second,,1,2,,\n"));
  ASSERT_EQ(observers.size(), 2u);
  EXPECT_EQ(observers[0].name, "tower, north");
  EXPECT_EQ(observers[0].position, glm::dvec2(690000.25, 5325000.5));
  EXPECT_EQ(observers[0].z, 600.0);
  EXPECT_EQ(observers[0].height, 30.0);
  EXPECT_TRUE(std::isinf(*observers[0].max_distance));
  EXPECT_FALSE(observers[1].z);
  EXPECT_FALSE(observers[1].height);
  EXPECT_FALSE(observers[1].max_distance);
  EXPECT_NE(observers[1].source.find("o.csv:line 4"), std::string::npos) << observers[1].source;
}

TEST_F(ReadObserversTest, csv_takes_all_columns_under_long_and_short_names) {
  for (const char* const header : {"x,y,azimuth_min,azimuth_max,elevation_min,elevation_max,max_distance",
                                   "x,y,azim_min,azim_max,elev_min,elev_max,max_dist"}) {
    const GivenObserver one = read(write("o.csv", std::string(header) + "\n1,2,3,4,5,6,7\n")).at(0);
    EXPECT_EQ(one.azimuth_min, 3.0);
    EXPECT_EQ(one.azimuth_max, 4.0);
    EXPECT_EQ(one.elevation_min, 5.0);
    EXPECT_EQ(one.elevation_max, 6.0);
    EXPECT_EQ(one.max_distance, 7.0);
  }
}

TEST_F(ReadObserversTest, wrong_csv_names_line_and_column) {
  expect_problem("a.csv", "", ": ", "contains no observers");
  expect_problem("a.csv", "x,y,z\n", ": ", "contains no observers");
  expect_problem("a.csv", "1,2,3\n", ":line 1: ", "missing header");
  expect_problem("a.csv", "x,z\n1,2\n", ":line 1: ", "missing column y");
  expect_problem("a.csv", "x,y,hight\n1,2,3\n", ":line 1: ", "\"hight\"");
  expect_problem("a.csv", "x,y,azim_min,azimuth_min\n1,2,3,4\n", ":line 1: ", "duplicate");
  expect_problem("a.csv", "x,y\n1,2\n\n3,\n", ":line 4: ", "invalid y; expected a number, found nothing");
  expect_problem("a.csv", "x,y,height\n1,2,3m\n", ":line 2: ", "invalid height");
  expect_problem("a.csv", "x,y,z\n1,2,nan\n", ":line 2: ", "invalid z");
  expect_problem("a.csv", "x,y\n1,2,3\n",
                 ":line 2: ", "too many columns; expected 2, separated by commas as in the header, found 3");
  expect_problem("a.csv", "x,y\n1\n", ":line 2: ", "too few columns");
}

TEST_F(ReadObserversTest, csv_is_in_the_clouds_system_unless_another_is_named) {
  const fs::path path = write("o.csv", "x,y,z\n11.5,48.05,600\n");
  EXPECT_EQ(read(path, {.cloud = utm()}).at(0).position, glm::dvec2(11.5, 48.05));
  const glm::dvec2 position = read(path, {.given = "EPSG:4326", .cloud = utm()}).at(0).position;
  // As gdaltransform has it.
  EXPECT_NEAR(position.x, 686302.267, 0.001);
  EXPECT_NEAR(position.y, 5324881.327, 0.001);
}

TEST_F(ReadObserversTest, geojson_points_are_turned_into_the_clouds_system) {
  const auto observers =
      read(write("o.geojson",
                 geojson(R"({"type":"Feature","properties":{"name":"a","height":"3.5","max_distance":70},
        "geometry":{"type":"Point","coordinates":[9.0,48.0]}},
        {"type":"Feature","properties":{},"geometry":{"type":"Point","coordinates":[9.0,48.0,250.0]}})")),
           {.cloud = utm()});
  ASSERT_EQ(observers.size(), 2u);
  EXPECT_EQ(observers[0].name, "a");
  EXPECT_EQ(observers[0].height, 3.5);
  EXPECT_EQ(observers[0].max_distance, 70.0);
  EXPECT_FALSE(observers[0].z);
  // 9 degrees east is the middle meridian of the zone; the northing is 0.9996 of its arc up to 48 degrees.
  EXPECT_NEAR(observers[0].position.x, 500000.0, 1e-3);
  EXPECT_NEAR(observers[0].position.y, 0.9996 * 5318427.59, 0.01);
  EXPECT_EQ(observers[1].z, 250.0);
}

TEST_F(ReadObserversTest, multi_point_is_as_many_observers) {
  const auto observers = read(write("o.geojson", geojson(R"({"type":"Feature","properties":{"height":2},
    "geometry":{"type":"MultiPoint","coordinates":[[1,2],[3,4]]}})")),
                              {.given = "cloud"});
  ASSERT_EQ(observers.size(), 2u);
  EXPECT_EQ(observers[0].position, glm::dvec2(1, 2));
  EXPECT_EQ(observers[1].position, glm::dvec2(3, 4));
  EXPECT_EQ(observers[1].height, 2.0);
}

TEST_F(ReadObserversTest, geopackage_and_shapefile_keep_positions_in_the_clouds_own_system_exactly) {
  for (const auto& [name, driver] : {std::pair("m.gpkg", "GPKG"), std::pair("m.shp", "ESRI Shapefile")}) {
    for (const OGRwkbGeometryType type : {wkbPoint, wkbPoint25D}) {
      const fs::path path =
          write_masts(fmt::format("{}_{}", static_cast<unsigned>(type), name), driver, 25832, type);
      const auto observers = read(path, {.cloud = utm()});
      ASSERT_EQ(observers.size(), 2u);
      EXPECT_EQ(observers[0].name, "mast 0");
      EXPECT_FALSE(observers[0].height) << *observers[0].height;
      EXPECT_EQ(observers[1].height, 12.5);
      EXPECT_EQ(observers[1].elevation_min, -30.0);
      EXPECT_EQ(observers[1].position, glm::dvec2(690001.0, 5325000.0));
      EXPECT_EQ(observers[1].z, type == wkbPoint ? std::optional<double>() : 601.0);
    }
  }
}

TEST_F(ReadObserversTest, known_against_unknown_system_is_an_error_with_a_way_out) {
  for (const auto& [name, driver] : {std::pair("m.gpkg", "GPKG"), std::pair("m.shp", "ESRI Shapefile")}) {
    const fs::path without = write_masts(std::string("without_") + name, driver, 0, wkbPoint);
    const fs::path with = write_masts(std::string("with_") + name, driver, 25832, wkbPoint);
    EXPECT_EQ(problem_of(without), "");
    EXPECT_NE(problem_of(without, {.cloud = utm()}).find("--observers-crs"), std::string::npos)
        << problem_of(without, {.cloud = utm()});
    EXPECT_NE(problem_of(with).find("--observers-crs cloud"), std::string::npos) << problem_of(with);
    EXPECT_EQ(problem_of(without, {.given = "EPSG:25832", .cloud = utm()}), "");
    EXPECT_EQ(problem_of(without, {.given = "cloud", .cloud = utm()}), "");
    EXPECT_EQ(problem_of(with, {.given = "cloud"}), "");
  }
}

TEST_F(ReadObserversTest, systems_that_are_not_understood_are_errors) {
  const fs::path path = write("o.csv", "x,y\n1,2\n");
  EXPECT_NE(problem_of(path, {.given = "EPSG:nonsense", .cloud = utm()}).find("EPSG:nonsense"),
            std::string::npos);
  Crs odd;
  odd.wkt = "PROJCS[odd";
  EXPECT_NE(problem_of(path, {.given = "EPSG:4326", .cloud = odd}).find("of the cloud is invalid"),
            std::string::npos);
  EXPECT_EQ(problem_of(path, {.given = "cloud", .cloud = odd}), "");
}

TEST_F(ReadObserversTest, position_outside_the_clouds_system_is_an_error) {
  const std::string problem =
      problem_of(write("o.csv", "x,y\n9,48\n9,95\n"), {.given = "EPSG:4326", .cloud = utm()});
  EXPECT_NE(problem.find("o.csv:line 3: "), std::string::npos) << problem;
}

TEST_F(ReadObserversTest, other_geometries_than_points_are_errors_naming_the_feature) {
  expect_problem("o.geojson", geojson(R"({"type":"Feature","id":7,"properties":{},
                   "geometry":{"type":"LineString","coordinates":[[1,2],[3,4]]}})"),
                 ":feature 7: ", "Line String");
  expect_problem("o.geojson", geojson(R"({"type":"Feature","id":8,"properties":{},"geometry":null})"),
                 ":feature 8: ", "no geometry");
}

TEST_F(ReadObserversTest, empty_and_damaged_files_are_errors) {
  expect_problem("o.geojson", geojson(""), ": ", "contains no observers");
  expect_problem("o.geojson", "{\"type\":\"FeatureCollection\",\"features\":[{", ": ", "cannot read");
  for (const auto& [name, driver] : {std::pair("e.gpkg", "GPKG"), std::pair("e.shp", "ESRI Shapefile")}) {
    const std::string problem = problem_of(write_masts(name, driver, 25832, wkbPoint, 0), {.cloud = utm()});
    EXPECT_NE(problem.find(std::string(name) + ": contains no observers"), std::string::npos) << problem;
  }
  expect_problem("o.gpkg", "no data base at all", ": ", "cannot read");
  expect_problem("o.shp", "no shapes", ": ", "cannot read");
  expect_problem("o.las", "LASF", ": ", "expected CSV, GeoJSON, GeoPackage or Shapefile");
  expect_problem("o.geojson", geojson(R"({"type":"Feature","id":3,"properties":{"height":"tall"},
                   "geometry":{"type":"Point","coordinates":[1,2]}})"),
                 ":feature 3: ", "invalid height");
  EXPECT_NE(problem_of(folder_ / "absent.gpkg").find("not a file"), std::string::npos);
  EXPECT_NE(problem_of(folder_ / "absent.csv").find("absent.csv: "), std::string::npos);
  EXPECT_NE(problem_of(geojson("")).find("not a file"), std::string::npos) << "text is not read as GeoJSON";
}

class ReadObjectsTest : public VectorFileTest {
 protected:
  static std::string feature(const std::string& geometry, const std::string& properties) {
    return R"({"type":"Feature","properties":{)" + properties + R"(},"geometry":)" + geometry + "}";
  }
  GivenObjects read(const std::string& name, const std::string& text) const {
    return read_objects(write(name, text), {.given = "cloud"});
  }
  GivenObjects read_feature(const std::string& geometry, const std::string& properties) const {
    return read("objects.geojson", feature(geometry, properties));
  }
  void expect_problem(const std::string& name, const std::string& text, const std::string& part) const {
    const std::string problem = problem_in([&] { read(name, text); });
    EXPECT_NE(problem.find(name), std::string::npos) << problem;
    EXPECT_NE(problem.find(part), std::string::npos) << problem;
  }
};

TEST_F(ReadObjectsTest, points_are_objects_of_their_own) {
  const GivenObjects objects = read_feature(R"({"type":"MultiPoint","coordinates":[[1,2,5],[3,4,6]]})",
                                            R"("height":12.5,"name":"turbine")");
  ASSERT_EQ(objects.parts.size(), 2u);
  EXPECT_EQ(objects.count(), 2u);
  EXPECT_EQ(objects.corners[0].position, glm::dvec2(1, 2));
  EXPECT_EQ(objects.corners[1].z, 6.0);
  EXPECT_EQ(objects.corners[1].height, 12.5);
  EXPECT_EQ(objects.corners[1].name, "turbine");
  EXPECT_FALSE(read_feature(R"({"type":"Point","coordinates":[1,2]})", R"("height":1)").corners[0].z);
}

TEST_F(ReadObjectsTest, lines_and_polygons_of_a_feature_are_one_object) {
  const GivenObjects lines = read_feature(
      R"({"type":"MultiLineString","coordinates":[[[0,0],[1,0],[1,1]],[[5,5],[6,6]]]})", R"("height":2)");
  EXPECT_EQ(lines.count(), 1u);
  ASSERT_EQ(lines.parts.size(), 2u);
  EXPECT_EQ(lines.parts[0].shape, ObjectShape::wall);
  EXPECT_EQ(lines.parts[1].begin, 3u);
  EXPECT_EQ(lines.parts[1].end, 5u);
  const GivenObjects house = read_feature(
      R"({"type":"Polygon","coordinates":[[[0,0],[9,0],[9,9],[0,9],[0,0]],[[2,2],[4,2],[4,4],[2,2]]]})",
      R"("height":7,"z":100)");
  EXPECT_EQ(house.count(), 1u);
  ASSERT_EQ(house.parts.size(), 1u) << "without the courtyard";
  EXPECT_EQ(house.parts[0].shape, ObjectShape::outline);
  EXPECT_EQ(house.parts[0].end - house.parts[0].begin, 4u) << "without the last vertex, which is the first";
  EXPECT_EQ(house.corners[0].z, 100.0);
}

TEST_F(ReadObjectsTest, geopackages_are_read_and_transformed) {
  const std::filesystem::path path =
      write_layer("walls.gpkg", "GPKG", 25833, wkbLineString25D, [](OGRLayerH layer) {
        const OGRFieldDefnH definition = OGR_Fld_Create("height", OFTReal);
        OGR_L_CreateField(layer, definition, TRUE);
        OGR_Fld_Destroy(definition);
        const OGRFeatureH feature = OGR_F_Create(OGR_L_GetLayerDefn(layer));
        OGR_F_SetFieldDouble(feature, 0, 3.0);
        const OGRGeometryH line = OGR_G_CreateGeometry(wkbLineString25D);
        OGR_G_AddPoint(line, 250000, 5325000, 600);
        OGR_G_AddPoint(line, 250010, 5325000, 601);
        OGR_F_SetGeometryDirectly(feature, line);
        EXPECT_EQ(OGR_L_CreateFeature(layer, feature), OGRERR_NONE);
        OGR_F_Destroy(feature);
      });
  const GivenObjects walls = read_objects(path, {.cloud = utm()});
  ASSERT_EQ(walls.corners.size(), 2u);
  EXPECT_GT(walls.corners[0].position.x, 600000.0) << "in the zone to the west it lies far east";
  EXPECT_EQ(walls.corners[1].z, 601.0);
  EXPECT_EQ(walls.corners[1].height, 3.0);
}

TEST_F(ReadObjectsTest, csv_has_segments) {
  const GivenObjects objects = read("masts.csv", "name,x,y,height\na,1,2,30\nb,3,4,40\n");
  ASSERT_EQ(objects.count(), 2u);
  EXPECT_EQ(objects.parts[1].shape, ObjectShape::segment);
  EXPECT_EQ(objects.corners[1].name, "b");
  EXPECT_EQ(objects.corners[1].height, 40.0);
}

TEST_F(ReadObjectsTest, what_has_no_objects_is_an_error) {
  expect_problem("empty.geojson", R"({"type":"FeatureCollection","features":[]})", "contains no objects");
  expect_problem("hollow.geojson", feature(R"({"type":"LineString","coordinates":[]})", R"("height":2)"),
                 "contains no objects");
  expect_problem("null.geojson", feature("null", R"("height":2)"), "unsupported geometry");
  expect_problem("word.geojson", feature(R"({"type":"Point","coordinates":[1,2]})", R"("height":"tall")"),
                 "invalid height");
  expect_problem("broken.geojson", R"({"type":)", "");
  expect_problem("empty.csv", "x,y,height\n", "observers");
  EXPECT_NE(problem_in([&] { read_objects("missing.gpkg", {}); }).find("not a file"), std::string::npos);
}

}  // namespace

}  // namespace alidade::test
