// SPDX-License-Identifier: MIT
#include "tests/geo/vector_file_test.h"
#include "visibility/read_observers.h"

namespace alidade::test {

using namespace visibility;

namespace {

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
