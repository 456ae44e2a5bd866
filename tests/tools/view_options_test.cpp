// SPDX-License-Identifier: MIT
// Selection and reprojection, which every command has that reads clouds.
#include <fmt/format.h>

#include <cmath>

#include "cloud/las/write_las.h"
#include "cloud/read_cloud.h"
#include "octree/index_file/index_file.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

class ViewOptionsTest : public ProgramTest {
 protected:
  /// A floor of 20 x 20 points in degrees or metres, alternately of class 2 and 5, with a system.
  void write_floor(const std::string& name, double step, const glm::dvec3& corner, const std::string& wkt) {
    PointCloud cloud;
    cloud.lattice = {.scale = glm::dvec3(step / 1000.0, step / 1000.0, 0.001), .offset = corner};
    for (int i = 0; i < 400; ++i) {
      cloud.positions.push_back({1000 * (i % 20), 1000 * (i / 20), 0});
      cloud.classifications.push_back(i % 2 == 0 ? 2 : 5);
      cloud.intensities.push_back(static_cast<std::uint16_t>(i));
    }
    cloud.crs.wkt = wkt;
    write_las(folder / name, cloud);
  }

  void SetUp() override {
    ProgramTest::SetUp();
    write_floor("floor.las", 1.0, {690000, 5325000, 500}, "");
  }

  PointCloud written(const Words& words, const std::string& output) {
    const ProgramResult result = run(with(words, {"-o", output, "-q"}));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return read_cloud(resolve_clouds(std::vector{folder / output}, index_and_file_formats()));
  }

  static constexpr const char* k_degrees =
      "GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,298.257223563]],"
      "PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433],AUTHORITY[\"EPSG\",\"4326\"]]";
};

TEST_F(ViewOptionsTest, every_command_sees_the_selected_points_alone) {
  const Words selection = {"--where", "classification = 5 AND intensity < 100"};
  EXPECT_EQ(written(with({"convert", "floor.las"}, selection), "some.las").size(), 50u);
  EXPECT_EQ(written(with({"index", "floor.las"}, selection), "some.alidade").size(), 50u);
  EXPECT_EQ(
      written(with({"visibility", "points", "floor.las", "--observer", "690005,5325005,502"}, selection),
              "seen.las")
          .size(),
      50u);
  const ProgramResult info = run(with({"info", "floor.las"}, selection));
  EXPECT_TRUE(contains(info.out, "points      50\n")) << info.out;
  const ProgramResult query = run(
      with({"query", "floor.las", "--box", "690000,5325000,0,690100,5325100,1000", "--count"}, selection));
  EXPECT_TRUE(contains(query.out, "50")) << query.out << query.err;
  const ProgramResult render = run(with({"render", "floor.las", "--mode", "flat", "--samples", "1", "--size",
                                         "16x16", "-o", "floor.png", "--color-by", "classification"},
                                        selection));
  EXPECT_TRUE(contains(render.err, "50 points")) << render.err;
  const ProgramResult load = run(with({"sql", "load", "floor.las", "floor.db"}, selection));
  EXPECT_TRUE(contains(load.err, "stored 50 points")) << load.err;
}

TEST_F(ViewOptionsTest, index_files_and_databases_are_selected_from_like_files) {
  ASSERT_EQ(run({"index", "floor.las", "-o", "floor.alidade", "-q"}).exit_code, 0);
  ASSERT_EQ(run({"sql", "load", "floor.las", "floor.db", "-q"}).exit_code, 0);
  const PointCloud expected = written({"convert", "floor.las", "--classes", "2"}, "expected.las");
  EXPECT_EQ(expected.size(), 200u);
  EXPECT_EQ(written({"convert", "floor.alidade", "--classes", "2"}, "a.las").positions, expected.positions);
  EXPECT_EQ(written({"convert", "floor.db?table=points", "--classes", "2"}, "b.las").positions,
            expected.positions);
  EXPECT_EQ(written({"convert", "floor.las", "--ignore-classes", "5,7"}, "c.las").positions,
            expected.positions);
  EXPECT_EQ(written({"convert", "floor.las", "--classes", "2,5", "--ignore-classes", "5"}, "d.las").positions,
            expected.positions);
}

TEST_F(ViewOptionsTest, columns_of_text_without_titles_are_named) {
  write("bare.xyz", "1 2 3 0.5 7 1000.25\n2 3 4 0.25 8 1001.25\n");
  const PointCloud cloud =
      written({"convert", "bare.xyz", "--columns", "y,x,z,Range [m],classification,gps_time"}, "named.las");
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_NEAR(cloud.world(0).x, 2.0, 1e-9);
  EXPECT_EQ(cloud.classifications, (std::vector<std::uint8_t>{7, 8}));
  EXPECT_EQ(cloud.gps_times, (std::vector<double>{1000.25, 1001.25}));
  EXPECT_EQ(cloud.extra_dimensions.at(0).name, "Range [m]");
  const ProgramResult feet = run({"info", "bare.xyz", "--stats", "--columns", "x [ft],y [ft],z [ft],a,b,c"});
  EXPECT_TRUE(contains(feet.out, "x, y ft; z ft")) << feet.out << feet.err;
  for (const auto& [words, message] : std::vector<std::pair<Words, std::string>>{
           {{"info", "floor.las", "--columns", "x,y,z"},
            "floor.las: --columns requires a text file; expected XYZ, CSV or PTS, found LAS"},
           {{"info", "bare.xyz", "--columns", "x,y,z"}, "expected 6 names, found 3"}}) {
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(contains(result.err, message)) << result.err;
  }
}

TEST_F(ViewOptionsTest, one_name_of_an_attribute_everywhere) {
  write("names.csv",
        "x,y,z,t,dist,ring,dx,dy,dz,rank\n1,1,1,100,0.5,0,0.1,0.2,0.3,1\n2,1,1,200,0.6,1,0.1,0.2,0.3,2\n");
  const PointCloud cloud =
      written({"convert", "names.csv", "--where", "t > 150 AND dist > 0.5 AND dx < 1"}, "some.csv");
  EXPECT_EQ(cloud.size(), 1u);
  EXPECT_TRUE(read("some.csv").starts_with("x,y,z,t,dist,ring,dx,dy,dz,rank\n")) << read("some.csv");
  ASSERT_EQ(run({"sql", "load", "names.csv", "names.db", "-q"}).exit_code, 0);
  for (const char* const source : {"names.csv", "names.db"}) {
    const ProgramResult result =
        run({"sql", source, "SELECT t, dist, dx, rank FROM points ORDER BY t", "--csv", "-q"});
    EXPECT_EQ(result.out, "t,dist,dx,rank\n100.0,0.5,0.1,1.0\n200.0,0.6,0.1,2.0\n") << result.err;
  }
  EXPECT_TRUE(contains(run({"sql", "names.csv", "SELECT ray_t FROM points(0,0,0, 1,0,0)"}).err,
                       "the t of a line is ray_t"));
}

TEST_F(ViewOptionsTest, selecting_nothing_and_wrong_conditions_are_errors) {
  const auto error = [&](const Words& words) { return run(with({"info", "floor.las"}, words)).err; };
  EXPECT_TRUE(contains(error({"--classes", "9"}),
                       "floor.las: no points are selected; expected a selection that some "
                       "points meet, found none of 400 points"))
      << error({"--classes", "9"});
  EXPECT_TRUE(
      contains(error({"--where", "nir > 2"}), "no such column: nir; expected a condition on x, y, z, "));
  EXPECT_TRUE(contains(error({"--where", "z >"}), "--where: invalid condition 'z >': incomplete input"));
  EXPECT_TRUE(contains(error({"--crop-crs", "EPSG:4326"}), "--crop"));
}

TEST_F(ViewOptionsTest, degrees_become_metres_of_the_zone_they_lie_in) {
  // 20 columns of 1e-5 degrees of longitude at 48 degrees north: 0.7455 m each.
  write_floor("degrees.las", 1e-5, {11.5, 48.0, 500}, k_degrees);
  const ProgramResult result = run({"render", "degrees.las", "--size", "16x16", "-o", "no.png"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err,
                       "degrees.las: geographic coordinates (degrees) are not supported; expected a "
                       "projected reference system: --reproject auto"))
      << result.err;
  const PointCloud metres = written({"convert", "degrees.las", "--reproject", "auto"}, "metres.las");
  ASSERT_EQ(metres.size(), 400u);
  EXPECT_NE(metres.crs.wkt.find("UTM zone 32N"), std::string::npos) << metres.crs.wkt;
  EXPECT_NEAR(metres.world(19).x - metres.world(0).x, 19 * 0.7455, 0.02);
  EXPECT_NEAR(metres.world(0).z, 500.0, 1e-9);
  EXPECT_EQ(metres.intensities[399], 399);
  const ProgramResult image = run(
      {"render", "degrees.las", "--reproject", "auto", "--size", "16x16", "--samples", "1", "-o", "yes.png"});
  EXPECT_EQ(image.exit_code, 0) << image.err;
}

TEST_F(ViewOptionsTest, a_stated_system_is_the_one_that_points_are_moved_from) {
  const PointCloud stated = written({"convert", "floor.las", "--crs", "EPSG:25832"}, "stated.las");
  EXPECT_NE(stated.crs.wkt.find("25832"), std::string::npos);
  const PointCloud moved =
      written({"convert", "floor.las", "--crs", "EPSG:25832", "--reproject", "EPSG:25833"}, "moved.las");
  // Source: gdaltransform of GDAL 3.6.
  EXPECT_NEAR(moved.world(0).x, 242882.423, 0.002);
  EXPECT_NEAR(moved.world(0).y, 5327616.110, 0.002);
  const ProgramResult contradiction = run({"info", "stated.las", "--crs", "EPSG:25833"});
  EXPECT_TRUE(contains(contradiction.err,
                       "the file states the reference system ETRS89 / UTM zone 32N; ETRS89 / "
                       "UTM zone 33N is used instead"))
      << contradiction.err;
  EXPECT_TRUE(contains(run({"info", "floor.las", "--reproject", "EPSG:25833"}).err,
                       "the reference system is unknown; expected --crs EPSG:n"));
}

TEST_F(ViewOptionsTest, other_programs_read_the_system_that_is_written) {
  write_floor("degrees.las", 1e-5, {11.5, 48.0, 500}, k_degrees);
  written({"convert", "degrees.las", "--reproject", "EPSG:25832"}, "metres.las");
  ASSERT_EQ(run({"visibility", "raster", "metres.las", "--observer", "686380,5319470,510", "--resolution",
                 "1", "--ground", "lowest", "-o", "map.tif"})
                .exit_code,
            0);
  const std::string said = shell_output("gdalsrsinfo -o epsg map.tif", folder);
  if (said.empty()) GTEST_SKIP() << "gdalsrsinfo of Debian's gdal-bin is not there";
  EXPECT_TRUE(contains(said, "EPSG:25832")) << said;
}

}  // namespace
}  // namespace alidade::test
