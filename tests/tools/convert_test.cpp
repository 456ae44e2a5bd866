// SPDX-License-Identifier: MIT
#include <utility>

#include "cloud/las/write_las.h"
#include "cloud/read_cloud.h"
#include "octree/index_file/index_file.h"
#include "tests/cloud/las/las_builder.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

class ConvertTest : public ProgramTest {
 protected:
  /// Two points with all there is, in UTM zone 32N, and a COPC record that is not true of any other file.
  void write_survey() {
    PointCloud cloud;
    cloud.lattice = {.scale = {0.01, 0.01, 0.001}, .offset = {690000, 5325000, 500}};
    cloud.positions = {{1, 2, 3}, {400, 500, 600}, {401, 500, 600}, {500, 500, 600}};
    cloud.colors = {{1, 2, 3}, {1000, 2000, 3000}, {2000, 4000, 6000}, {7, 8, 9}};
    cloud.intensities = {1, 100, 300, 4};
    cloud.gps_times = {1.5, 2.5, 3.5, 4.5};
    cloud.classifications = {2, 5, 6, 2};
    cloud.gps_time_is_standard = true;
    cloud.file_source_id = 77;
    cloud.crs.wkt = k_utm;
    cloud.records.push_back(
        {.user_id = "a survey", .record_id = 9, .description = "kept", .data = {1, 2, 3}});
    ExtraDimension& extra = cloud.extra_dimensions.emplace_back();
    extra.name = "Reflectance";
    extra.type = ScalarType::float32;
    extra.byte_count = 4;
    extra.values.resize(16, 7);
    write_las(folder / "survey.las", cloud);
  }

  ProgramResult convert(const std::string& output, const Words& options = {}) {
    return run(with({"convert", "survey.las", "-o", output}, options));
  }

  PointCloud converted(const std::string& output, const Words& options = {}) {
    const ProgramResult result = convert(output, options);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.out, "");
    return read_cloud(resolve_clouds(std::vector{folder / output}, index_and_file_formats()));
  }

  void expect_error(const Words& words, const std::string& part) {
    const auto before = names();
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_TRUE(contains(result.err, part)) << result.err;
    EXPECT_EQ(names(), before);
  }

  static constexpr const char* k_utm =
      "PROJCS[\"ETRS89 / UTM zone "
      "32N\",GEOGCS[\"ETRS89\",DATUM[\"European_Terrestrial_Reference_System_1989\","
      "SPHEROID[\"GRS 1980\",6378137,298.257222101]],PRIMEM[\"Greenwich\",0],UNIT[\"degree\","
      "0.0174532925199433]],PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"latitude_of_origin\",0],"
      "PARAMETER[\"central_meridian\",9],PARAMETER[\"scale_factor\",0.9996],PARAMETER[\"false_easting\","
      "500000],PARAMETER[\"false_northing\",0],UNIT[\"metre\",1],AUTHORITY[\"EPSG\",\"25832\"]]";
};

TEST_F(ConvertTest, attributes_crs_records_extra_dimensions_and_lattice_are_kept) {
  write_survey();
  const PointCloud before = read_cloud(folder / "survey.las");
  for (const char* const output : {"out.las", "OUT.LAS", "out.laz", "out.alidade"}) {
    const PointCloud after = converted(output);
    EXPECT_EQ(after.lattice, before.lattice);
    EXPECT_EQ(after.positions, before.positions);
    EXPECT_EQ(after.colors, before.colors);
    EXPECT_EQ(after.intensities, before.intensities);
    EXPECT_EQ(after.gps_times, before.gps_times);
    EXPECT_EQ(after.classifications, before.classifications);
    EXPECT_EQ(after.gps_time_is_standard, before.gps_time_is_standard);
    EXPECT_EQ(after.file_source_id, 77);
    EXPECT_EQ(after.crs, before.crs);
    EXPECT_EQ(after.records, before.records);
    ASSERT_EQ(after.extra_dimensions.size(), 1u);
    EXPECT_EQ(after.extra_dimensions[0].name, "Reflectance");
    EXPECT_EQ(after.extra_dimensions[0].values, before.extra_dimensions[0].values);
  }
}

TEST_F(ConvertTest, to_ply_and_back_positions_and_attributes_are_the_same) {
  write_survey();
  const PointCloud ply = converted("out.ply");
  ASSERT_EQ(ply.size(), 4u);
  EXPECT_NEAR(ply.world(1).x, 690004.0, 1e-9);
  EXPECT_EQ(ply.classifications[1], 5);
  EXPECT_EQ(run({"convert", "out.ply", "-o", "back.las"}).exit_code, 0);
  EXPECT_EQ(read_cloud(folder / "back.las").gps_times, read_cloud(folder / "survey.las").gps_times);
}

TEST_F(ConvertTest, las_packed_and_unpacked_again_is_the_same_byte_for_byte) {
  for (const auto& [version, format] : {std::pair(2, 3), std::pair(3, 4), std::pair(4, 7), std::pair(0, 0)}) {
    const std::vector<std::byte> bytes = build_las(sample_las(version, format, 2000));
    write("survey.las", {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    const ProgramResult packed = convert("packed.laz", {"--overwrite"});
    EXPECT_EQ(packed.exit_code, 0) << packed.err;
    EXPECT_TRUE(contains(packed.err, "wrote all 2000 points to packed.laz, with unchanged records"))
        << packed.err;
    EXPECT_EQ(read("packed.laz")[25], version);
    EXPECT_EQ(run({"convert", "packed.laz", "-o", "again.las", "--overwrite", "-q"}).exit_code, 0);
    EXPECT_TRUE(read("again.las") == read("survey.las")) << version << " " << format;
  }
}

TEST_F(ConvertTest, what_is_chosen_is_written_as_laz_too) {
  write_survey();
  EXPECT_EQ(converted("half.laz", {"--every", "2"}).gps_times, (std::vector<double>{1.5, 3.5}));
  EXPECT_EQ(static_cast<unsigned char>(read("half.laz")[104]), 0x87);
  // Of several files, and of other formats.
  EXPECT_EQ(run({"convert", "survey.las", "half.laz", "-o", "both.laz"}).exit_code, 0);
  EXPECT_EQ(read_cloud(folder / "both.laz").size(), 6u);
  write_square("square.xyz");
  EXPECT_EQ(run({"convert", "square.xyz", "-o", "square.laz"}).exit_code, 0);
  EXPECT_EQ(read_cloud(folder / "square.laz").size(), 400u);
}

TEST_F(ConvertTest, every_command_that_writes_las_writes_laz) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "60000", "-o", "site.laz", "-q"}).exit_code, 0);
  ASSERT_EQ(run({"generate", "courtyard", "--points", "60000", "-o", "site.las", "-q"}).exit_code, 0);
  EXPECT_EQ(run({"convert", "site.laz", "-o", "again.las", "-q"}).exit_code, 0);
  EXPECT_TRUE(read("again.las") == read("site.las"));
  const Words query = {"query", "site.las", "--point", "690005,5324990,601", "--radius", "1", "-q", "-o"};
  EXPECT_EQ(run(with(query, {"near.las"})).exit_code, 0);
  EXPECT_EQ(run(with(query, {"near.laz"})).exit_code, 0);
  EXPECT_EQ(read_cloud(folder / "near.laz").positions, read_cloud(folder / "near.las").positions);
  const Words look = {"visibility", "points", "site.las", "--observer", "690005,5324990,601.7", "-q", "-o"};
  EXPECT_EQ(run(with(look, {"seen.laz"})).exit_code, 0);
  EXPECT_EQ(read_cloud(folder / "seen.laz").size(), 60000u);
}

TEST_F(ConvertTest, several_files_are_joined_in_their_order) {
  write_survey();
  const ProgramResult result = run({"convert", "survey.las", "survey.las", "-o", "twice.las", "-q"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.out + result.err, "");
  const PointCloud twice = read_cloud(folder / "twice.las");
  ASSERT_EQ(twice.size(), 8u);
  EXPECT_EQ(twice.gps_times[4], 1.5);
}

TEST_F(ConvertTest, tiles_outside_the_box_are_counted_but_not_read) {
  write_survey();
  std::filesystem::create_directory(folder / "tiles");
  std::filesystem::rename(folder / "survey.las", folder / "tiles" / "a.las");
  PointCloud far;
  far.lattice = {.scale = {0.01, 0.01, 0.001}, .offset = {690000, 5325000, 500}};
  far.positions = {{100000, 0, 0}, {100001, 1, 1}};
  far.crs.wkt = k_utm;
  write_las(folder / "tiles" / "b.las", far);
  const ProgramResult result =
      run({"convert", "tiles", "-o", "out.las", "--crop", "690004,5325000,690006,5325010"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "wrote 3 of 6 points to out.las")) << result.err;
  EXPECT_EQ(read_cloud(folder / "out.las").gps_times, (std::vector<double>{2.5, 3.5, 4.5}));
  expect_error({"convert", "tiles", "-o", "none.las", "--crop", "0,0,1,1"}, "no points are selected");
  expect_error({"convert", "tiles", "-o", "tiles/a.las", "--overwrite"},
               "tiles/a.las: the output is also an input");
}

TEST_F(ConvertTest, an_index_is_what_alidade_index_makes) {
  write_survey();
  converted("out.alidade");
  EXPECT_EQ(run({"index", "survey.las", "-o", "index.alidade", "-q"}).exit_code, 0);
  EXPECT_EQ(read("out.alidade"), read("index.alidade"));
}

TEST_F(ConvertTest, an_index_file_becomes_a_las_file_again) {
  write_survey();
  converted("out.alidade");
  EXPECT_EQ(run({"convert", "out.alidade", "-o", "again.las"}).exit_code, 0);
  EXPECT_EQ(read("again.las"), read("survey.las"));
}

TEST_F(ConvertTest, crop_gives_the_same_points_of_an_index_file_whose_border_it_touches) {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(0.01), .offset = glm::dvec3(0.0)};
  // 35 steps of 0.01 round to a number just above 0.35.
  cloud.positions = {{35, 0, 0}, {45, 10, 10}};
  ASSERT_GT(cloud.world(0).x, 0.35);
  write_las(folder / "survey.las", cloud);
  EXPECT_EQ(run({"index", "survey.las", "-o", "survey.alidade", "-q"}).exit_code, 0);
  for (const char* const input : {"survey.las", "survey.alidade"}) {
    const ProgramResult result =
        run({"convert", input, "-o", "out.las", "--overwrite", "--crop", "-1,-1,0.35,1"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(contains(result.err, "wrote 1 of 2 points to out.las")) << result.err;
  }
  expect_error({"convert", "survey.alidade", "-o", "none.las", "--crop", "7,7,8,8"},
               "no points are selected; expected a selection that some points meet, found none of 2 points");
}

TEST_F(ConvertTest, messages_contain_the_points_written_and_read) {
  write_survey();
  const ProgramResult result = convert("out.las", {"--every", "3"});
  EXPECT_TRUE(contains(result.err, "wrote 2 of 4 points to out.las")) << result.err;
}

TEST_F(ConvertTest, crop_takes_a_box_in_the_plane_or_in_space_with_its_border) {
  write_survey();
  EXPECT_EQ(converted("a.las", {"--crop", "690004,5325005,690004.01,5325005"}).size(), 2u);
  EXPECT_EQ(converted("b.las", {"--crop=690000,5325000,500.003,690001,5325001,500.003"}).size(), 1u);
  EXPECT_EQ(converted("c.ply", {"--crop=-1e9,-1e9,1e9,1e9"}).size(), 4u);
}

TEST_F(ConvertTest, crop_takes_polygons_in_another_reference_system) {
  write_survey();
  // About 690003.7 to 690004.5 east, all north.
  write("area.geojson",
        R"({"type":"Feature","properties":{},"geometry":{"type":"Polygon","coordinates":[[
        [690003.7,5324990],[690004.5,5324990],[690004.5,5325010],[690003.7,5325010],[690003.7,5324990]]]}})");
  EXPECT_EQ(converted("a.las", {"--crop", "area.geojson", "--crop-crs", "cloud"}).size(), 2u);
  EXPECT_EQ(converted("b.las", {"--crop", "area.geojson", "--crop-crs", "EPSG:25832"}).size(), 2u);
  // GeoJSON without a reference system is in degrees, where there is no such position.
  expect_error({"convert", "survey.las", "-o", "c.las", "--crop", "area.geojson"}, "area.geojson");
  write("degrees.geojson",
        R"({"type":"Feature","properties":{},"geometry":{"type":"Polygon","coordinates":[[
        [11,48],[12,48],[12,49],[11,49],[11,48]]]}})");
  EXPECT_EQ(converted("d.las", {"--crop", "degrees.geojson"}).size(), 4u);
}

TEST_F(ConvertTest, spacing_leaves_real_points_with_mean_colours_and_intensities) {
  write_survey();
  const PointCloud thin = converted("out.las", {"--spacing", "0.5"});
  ASSERT_EQ(thin.size(), 3u);
  EXPECT_EQ(thin.positions[1], LatticePosition(400, 500, 600));
  EXPECT_EQ(thin.colors[1], Color16(1500, 3000, 4500));
  EXPECT_EQ(thin.intensities[1], 200);
  EXPECT_EQ(thin.classifications[1], 5);
}

TEST_F(ConvertTest, crop_comes_first_then_every_then_spacing) {
  write_survey();
  // Of points 1 to 3 every second are 1 and 3; before cropping it would be 2 alone, and after thinning 1.
  const PointCloud some =
      converted("out.las", {"--spacing", "0.1", "--every", "2", "--crop", "690004,5325000,690006,5325010"});
  EXPECT_EQ(some.gps_times, (std::vector<double>{2.5, 4.5}));
}

TEST_F(ConvertTest, where_no_point_is_left_nothing_is_written) {
  write_survey();
  expect_error({"convert", "survey.las", "-o", "out.las", "--crop", "0,0,1,1"},
               "survey.las: no points are selected; expected a selection that some points meet, found none "
               "of 4 points "
               "from 690000.01, 5325000.02, 500.003 to 690005, 5325005, 500.6");
  write(
      "area.geojson",
      R"({"type":"Feature","properties":{},"geometry":{"type":"Polygon","coordinates":[[[0,0],[1,0],[0,1],[0,0]]]}})");
  expect_error({"convert", "survey.las", "-o", "out.las", "--crop", "area.geojson", "--crop-crs", "cloud"},
               "survey.las: no points are selected");
}

TEST_F(ConvertTest, a_file_without_points_becomes_one_without_points) {
  PointCloud cloud;
  cloud.crs.wkt = k_utm;
  write_las(folder / "survey.las", cloud);
  EXPECT_EQ(converted("out.las").size(), 0u);
  EXPECT_EQ(converted("cropped.las", {"--crop", "0,0,1,1", "--spacing", "1"}).crs.wkt, k_utm);
}

TEST_F(ConvertTest, wrong_options_are_errors_before_anything_is_read) {
  write("survey.las", "no cloud at all, which nobody gets to know");
  const Words words = {"convert", "survey.las", "-o", "out.las"};
  expect_error({"convert", "survey.las", "-o", "out.txt"},
               "out.txt: unknown output format; expected the extension .las");
  expect_error({"convert", "survey.las", "-o", "survey.las", "--overwrite"}, "the output is also an input");
  expect_error(with(words, {"--crop", ""}), "--crop: missing value; expected a box or a file");
  expect_error(with(words, {"--crop", "1,2,3"}), "--crop: invalid value; expected x0,y0,x1,y1 or");
  expect_error(with(words, {"--crop", "1,2,0,3"}), "expected the lower x first, found x from 1 to 0");
  expect_error(with(words, {"--crop", "1,2,5,3,4,4"}), "expected the lower z first");
  expect_error(with(words, {"--crop", "1,2,x,4"}), "expected a number, found 'x'");
  expect_error(with(words, {"--crop", "absent.gpkg"}), "absent.gpkg: not a file");
  expect_error(with(words, {"--crop", "1,2,3,4", "--crop-crs", "EPSG:4326"}),
               "--crop-crs: requires a polygon file; expected --crop FILE, found a box");
  expect_error(with(words, {"--every", "0"}), "--every");
  expect_error(with(words, {"--spacing", "0"}), "expected a positive length, found '0'");
  expect_error(with(words, {"--spacing", "-1"}), "--spacing");
  write("out.las", "precious");
  expect_error(words, "out.las: the file exists");
  EXPECT_EQ(read("out.las"), "precious");
}

TEST_F(ConvertTest, overwrite_replaces_and_a_failed_run_does_not) {
  write_survey();
  write("out.las", "precious");
  expect_error({"convert", "survey.las", "-o", "out.las", "--overwrite", "--crop", "0,0,1,1"}, "no point");
  EXPECT_EQ(read("out.las"), "precious");
  EXPECT_EQ(converted("out.las", {"--overwrite"}).size(), 4u);
}

TEST_F(ConvertTest, on_a_full_disk_nothing_is_left) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "20000", "-o", "survey.las", "-q"}).exit_code, 0);
  for (const char* const output : {"out.las", "out.laz", "out.ply", "out.alidade"}) {
    const ProgramResult result = run_on_full_disk({"convert", "survey.las", "-o", output, "-q"}, 100000);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(contains(result.err, output)) << result.err;
    EXPECT_EQ(names(), std::vector<std::string>{"survey.las"});
  }
}

TEST_F(ConvertTest, the_bytes_do_not_depend_on_the_number_of_threads) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "50000", "-o", "survey.las", "-q"}).exit_code, 0);
  for (const char* const threads : {"1", "4"}) {
    EXPECT_EQ(
        convert(std::string(threads) + ".las", {"--spacing", "0.3", "--threads", threads, "-q"}).exit_code,
        0);
  }
  EXPECT_EQ(read("1.las"), read("4.las"));
}

}  // namespace
}  // namespace alidade::test
