// SPDX-License-Identifier: MIT
#include "geo/geopackage.h"

#include "tests/geo/vector_file_test.h"

namespace alidade::test {
namespace {

/// A square with a hole and a second one, and a row without geometry; a line.
std::vector<VectorLayer> some_layers() {
  const PlanePolygon with_hole{{{{0, 0}, {4, 0}, {4, 4}, {0, 4}}, {{1, 1}, {1, 2}, {2, 2}, {2, 1}}}};
  const PlanePolygon square{{{{10, 0}, {11, 0}, {11, 1}, {10, 1}}}};
  return {{.name = "areas",
           .description = "some areas",
           .shape = LayerShape::polygons,
           .columns = {{"number", ColumnType::whole_number},
                       {"name", ColumnType::text},
                       {"size", ColumnType::number}},
           .features = {{std::vector{with_hole, square}, {std::int64_t{7}, "first ü", 16.25}},
                        {std::vector<PlanePolygon>{}, {std::int64_t{8}, "none", std::monostate()}}}},
          {.name = "paths",
           .description = "a path",
           .shape = LayerShape::lines,
           .columns = {{"length", ColumnType::number}},
           .features = {{std::vector<glm::dvec3>{{0, 0, 5}, {3, 4, 6}}, {5.0}}}}};
}

class GeopackageTest : public VectorFileTest {
 protected:
  std::filesystem::path written(const Crs& crs) const {
    const std::filesystem::path file = folder_ / "layers.gpkg";
    write_geopackage(file, some_layers(), crs, true);
    return file;
  }
  static std::string bytes_of(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
};

TEST_F(GeopackageTest, gdal_reads_what_was_written) {
  const GdalDataset dataset(GDALOpenEx(written(utm()).c_str(), GDAL_OF_VECTOR, nullptr, nullptr, nullptr));
  ASSERT_TRUE(dataset);
  ASSERT_EQ(GDALDatasetGetLayerCount(dataset.get()), 2);
  const OGRLayerH areas = GDALDatasetGetLayerByName(dataset.get(), "areas");
  ASSERT_NE(areas, nullptr);
  EXPECT_EQ(wkbFlatten(OGR_L_GetGeomType(areas)), wkbMultiPolygon);
  ASSERT_NE(OGR_L_GetSpatialRef(areas), nullptr);
  EXPECT_STREQ(OSRGetAuthorityCode(OGR_L_GetSpatialRef(areas), nullptr), "25832");
  const GdalHandle<OGR_F_Destroy> first(OGR_L_GetNextFeature(areas)), second(OGR_L_GetNextFeature(areas));
  ASSERT_TRUE(first && second);
  EXPECT_EQ(OGR_F_GetFieldAsInteger64(first.get(), 0), 7);
  EXPECT_STREQ(OGR_F_GetFieldAsString(first.get(), 1), "first ü");
  EXPECT_EQ(OGR_F_GetFieldAsDouble(first.get(), 2), 16.25);
  const OGRGeometryH shape = OGR_F_GetGeometryRef(first.get());
  EXPECT_EQ(OGR_G_Area(shape), 16.0);
  EXPECT_EQ(OGR_G_GetGeometryCount(shape), 2);
  EXPECT_EQ(OGR_G_IsValid(shape), 1);
  EXPECT_EQ(OGR_F_GetGeometryRef(second.get()), nullptr);
  EXPECT_EQ(OGR_F_IsFieldNull(second.get(), 2), 1);

  const OGRLayerH paths = GDALDatasetGetLayerByName(dataset.get(), "paths");
  const GdalHandle<OGR_F_Destroy> path(OGR_L_GetNextFeature(paths));
  ASSERT_TRUE(path);
  EXPECT_EQ(OGR_G_GetZ(OGR_F_GetGeometryRef(path.get()), 1), 6.0);
}

TEST_F(GeopackageTest, without_a_reference_system_it_is_a_plane) {
  const GdalDataset dataset(GDALOpenEx(written({}).c_str(), GDAL_OF_VECTOR, nullptr, nullptr, nullptr));
  const OGRSpatialReferenceH reference = OGR_L_GetSpatialRef(GDALDatasetGetLayer(dataset.get(), 0));
  ASSERT_NE(reference, nullptr);
  EXPECT_EQ(OSRIsLocal(reference), 1);
  EXPECT_EQ(OSRIsGeographic(reference), 0);
}

TEST_F(GeopackageTest, the_same_layers_are_the_same_bytes) {
  const std::string first = bytes_of(written(utm()));
  EXPECT_TRUE(first == bytes_of(written(utm())));
  EXPECT_GT(first.size(), 10000u);
}

TEST_F(GeopackageTest, bad_outputs_are_errors) {
  const std::filesystem::path file = written({});
  EXPECT_NE(problem_in([&] { write_geopackage(file, some_layers(), {}, false); }).find("exists"),
            std::string::npos);
  EXPECT_NE(problem_in([&] {
              write_geopackage(folder_ / "a.shp", some_layers(), {}, false);
            }).find("expected the extension .gpkg"),
            std::string::npos);
  EXPECT_NE(problem_in([&] { write_geopackage(folder_ / "no" / "a.gpkg", some_layers(), {}, false); }), "");
}

}  // namespace
}  // namespace alidade::test
