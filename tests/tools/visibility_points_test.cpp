// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <signal.h>

#include <chrono>
#include <cstring>
#include <fstream>
#include <thread>

#include "cloud/las/write_las.h"
#include "cloud/read_cloud.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

/// A wall between two patches of ground, with attributes of all kinds: rows of the wall have class 6.
PointCloud garden() {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(0.001), .offset = {690000, 5325000, 600}};
  for (int x = 0; x <= 80; ++x) {
    for (int y = 0; y <= 80; ++y) cloud.positions.emplace_back(250 * x, 250 * y, 0);
  }
  for (int y = 0; y <= 80; ++y) {
    for (int z = 1; z <= 12; ++z) cloud.positions.emplace_back(10000, 250 * y, 250 * z);
  }
  ExtraDimension own;
  own.name = "Own";
  own.type = ScalarType::uint16;
  own.byte_count = 2;
  for (std::size_t id = 0; id < cloud.size(); ++id) {
    cloud.classifications.push_back(cloud.positions[id].z > 0 ? 6 : 2);
    cloud.intensities.push_back(static_cast<std::uint16_t>(7 * id));
    cloud.gps_times.push_back(0.5 * static_cast<double>(id));
    cloud.colors.emplace_back(static_cast<std::uint16_t>(id), 257, 65535);
    own.values.push_back(static_cast<std::uint8_t>(id));
    own.values.push_back(3);
  }
  cloud.extra_dimensions.push_back(own);
  cloud.crs.wkt = R"(LOCAL_CS["garden",UNIT["metre",1]])";
  cloud.records.push_back({.user_id = "garden", .record_id = 77, .description = "kept", .data = {1, 2, 3}});
  return cloud;
}

const ExtraDimension* find_dimension(const PointCloud& cloud, const std::string& name) {
  for (const ExtraDimension& dimension : cloud.extra_dimensions) {
    if (dimension.name == name) return &dimension;
  }
  return nullptr;
}

template <class Value>
std::vector<Value> values(const PointCloud& cloud, const std::string& name, ScalarType type) {
  const ExtraDimension* const dimension = find_dimension(cloud, name);
  if (dimension == nullptr || dimension->type != type) {
    ADD_FAILURE() << name << " is missing, or of another type";
    return std::vector<Value>(cloud.size());
  }
  std::vector<Value> all(cloud.size());
  std::memcpy(all.data(), dimension->values.data(), all.size() * sizeof(Value));
  return all;
}

/// A test of `visibility points`.
class VisibilityPointsTest : public ProgramTest {
 protected:
  void write_garden() { write_las(folder / "garden.las", garden()); }
  PointCloud read_output(const std::string& name) const { return read_cloud(folder / name); }
};

const Words k_points = {"visibility", "points", "garden.las"};
const std::string k_eye = "690005,5325010,601.7";

TEST_F(VisibilityPointsTest, output_is_the_cloud_itself_with_extra_bytes) {
  write_garden();
  const ProgramResult result = run(with(k_points, {"--observer", k_eye, "-o", "seen.las"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, "");
  const PointCloud in = garden(), out = read_output("seen.las");
  EXPECT_EQ(out.lattice.scale, in.lattice.scale);
  EXPECT_EQ(out.lattice.offset, in.lattice.offset);
  EXPECT_EQ(out.positions, in.positions);
  EXPECT_EQ(out.classifications, in.classifications);
  EXPECT_EQ(out.intensities, in.intensities);
  EXPECT_EQ(out.gps_times, in.gps_times);
  EXPECT_EQ(out.colors, in.colors);
  EXPECT_EQ(out.crs.wkt, in.crs.wkt);
  EXPECT_EQ(out.records, in.records);
  ASSERT_EQ(out.extra_dimensions.size(), 4u);
  EXPECT_EQ(out.extra_dimensions[0].name, "Own");
  EXPECT_EQ(out.extra_dimensions[0].values, in.extra_dimensions[0].values);

  const auto visible = values<std::uint8_t>(out, "Visible", ScalarType::uint8);
  const auto count = values<std::uint32_t>(out, "VisibleCount", ScalarType::uint32);
  const auto blocker = values<std::int64_t>(out, "Blocker", ScalarType::int64);
  for (std::size_t id = 0; id < out.size(); ++id) {
    ASSERT_EQ(visible[id], count[id]);
    const glm::ivec3 position = out.positions[id];
    const bool is_in_shadow = position.x > 11000 && position.z == 0, is_before = position.x < 9500;
    if (is_in_shadow) {
      ASSERT_EQ(visible[id], 0) << id;
      // The blocker is before it, in the wall or at its foot.
      ASSERT_GE(blocker[id], 0) << id;
      ASSERT_NEAR(out.positions[static_cast<std::size_t>(blocker[id])].x, 10000, 300) << id;
    }
    if (is_before) {
      ASSERT_EQ(visible[id], 1) << id;
      ASSERT_EQ(blocker[id], -1) << id;
    }
  }
  EXPECT_TRUE(contains(result.err, "points are visible (")) << result.err;
  EXPECT_TRUE(
      contains(result.err, "points without a surface block 0.0 % of the lines that points block; point "))
      << result.err;
}

TEST_F(VisibilityPointsTest, a_bird_hides_one_point_and_is_said_to_be_without_a_surface) {
  // Ground, and one point right above one of it, whose neighbours are far away.
  PointCloud cloud = garden();
  cloud.resize(0);
  for (int i = 0; i < 100 * 100; ++i) cloud.positions.emplace_back(i % 100 * 100, i / 100 * 100, 0);
  cloud.positions.emplace_back(5000, 5000, 3000);
  cloud.resize(cloud.positions.size());
  write_las(folder / "bird.las", cloud);
  const Words look = {"visibility",         "points", "bird.las", "--observer",
                      "690005,5325005,606", "-o",     "bird.ply", "--overwrite"};
  const std::string typical = run(look).err, small = run(with(look, {"--radius-max", "0.001"})).err;
  EXPECT_TRUE(contains(typical, "points without a surface block 100.0 %")) << typical;
  EXPECT_TRUE(contains(typical, "point 10000 blocks most, 100 %")) << typical;
  EXPECT_TRUE(contains(typical, "10000 of 10001 points are visible")) << typical;
  EXPECT_TRUE(contains(small, "radii up to 0.001")) << small;
  const ProgramResult both = run(with(look, {"--radius-max", "1", "--radius", "1"}));
  EXPECT_EQ(both.exit_code, 2) << both.err;
}

TEST_F(VisibilityPointsTest, index_file_and_cloud_file_give_the_same_bytes) {
  write_garden();
  ASSERT_EQ(run({"index", "garden.las", "-o", "garden.alidade", "-q"}).exit_code, 0);
  const Words options = {"--observer", k_eye, "--fraction", "3", "-q"};
  ASSERT_EQ(run(with(with(k_points, options), {"-o", "a.las"})).exit_code, 0);
  ASSERT_EQ(run(with({"visibility", "points", "garden.alidade", "-o", "b.las", "--threads", "1"}, options))
                .exit_code,
            0);
  EXPECT_EQ(read("a.las"), read("b.las"));
}

TEST_F(VisibilityPointsTest, several_observers_have_bits_columns_and_lists) {
  write_garden();
  write("o.csv", "name,x,y,z\nbehind,690015,5325010,601.7\nabove,690010,5325010,620\n");
  const ProgramResult result =
      run(with(k_points, {"--observer", k_eye, "--observers", "o.csv", "--blockers", "all", "--lists",
                          "who.csv", "--fraction", "2", "-o", "seen.las"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const PointCloud out = read_output("seen.las");
  const auto count = values<std::uint32_t>(out, "VisibleCount", ScalarType::uint32);
  const auto by = values<std::uint64_t>(out, "VisibleBy", ScalarType::uint64);
  const auto fraction = values<float>(out, "VisibleFraction", ScalarType::float32);
  for (const char* const name : {"Blocker_1", "Blocker_2", "Blocker_3"}) {
    const auto blocker = values<std::int64_t>(out, name, ScalarType::int64);
    const int bit = name[8] - '1';
    for (std::size_t id = 0; id < out.size(); ++id)
      ASSERT_EQ(blocker[id] == -1, (by[id] >> bit & 1) == 1) << id;
  }
  EXPECT_EQ(find_dimension(out, "Blocker"), nullptr);
  std::string list = "observer,point_id\n";
  for (int observer = 0; observer < 3; ++observer) {
    for (std::size_t id = 0; id < out.size(); ++id) {
      if (by[id] >> observer & 1) list += fmt::format("{},{}\n", observer + 1, id);
    }
  }
  EXPECT_EQ(read("who.csv"), list);
  for (std::size_t id = 0; id < out.size(); ++id) {
    ASSERT_EQ(static_cast<int>(count[id]), __builtin_popcountll(by[id]));
    if (count[id] > 0) {
      ASSERT_GE(fraction[id], 0.5f);
    }
    // What the one before and the one behind the wall see of the ground is disjoint, but the one above sees
    // it all.
    if (out.positions[id].z == 0 && std::abs(out.positions[id].x - 10000) > 1000) {
      ASSERT_EQ(count[id], 2u) << id;
    }
  }
}

TEST_F(VisibilityPointsTest, ply_holds_the_same_values) {
  write_garden();
  const Words options = {"--observer", k_eye, "-q"};
  ASSERT_EQ(run(with(with(k_points, options), {"-o", "seen.las"})).exit_code, 0);
  ASSERT_EQ(run(with(with(k_points, options), {"-o", "seen.ply"})).exit_code, 0);
  const PointCloud las = read_output("seen.las"), ply = read_output("seen.ply");
  ASSERT_EQ(ply.size(), las.size());
  EXPECT_EQ(values<std::uint8_t>(ply, "Visible", ScalarType::uint8),
            values<std::uint8_t>(las, "Visible", ScalarType::uint8));
  const auto whole = values<std::int64_t>(las, "Blocker", ScalarType::int64);
  EXPECT_EQ(values<double>(ply, "Blocker", ScalarType::float64),
            std::vector<double>(whole.begin(), whole.end()));
}

TEST_F(VisibilityPointsTest, columns_of_an_earlier_run_give_way) {
  write_garden();
  ASSERT_EQ(run(with(k_points, {"--observer", k_eye, "-o", "a.las", "-q"})).exit_code, 0);
  const ProgramResult again = run({"visibility", "points", "a.las", "--observer", k_eye, "-o", "b.las"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_TRUE(contains(again.err, "warning: b.las: replacing the cloud's Visible")) << again.err;
  EXPECT_EQ(read("a.las"), read("b.las"));
}

TEST_F(VisibilityPointsTest, observers_without_z_are_on_the_ground) {
  write_garden();
  const ProgramResult result =
      run(with(k_points, {"--observer", "690005,5325010", "--observer-height", "1.5", "-o", "seen.las"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err,
                       "observer 1: eye at 690005.000, 5325010.000, 601.500; 1.50 above what is below it, "
                       "nothing overhead"))
      << result.err;
  EXPECT_FALSE(contains(result.err, "warning")) << result.err;
}

TEST_F(VisibilityPointsTest, and_all_that_have_observers_print_what_is_above_and_below_their_eyes) {
  std::string rows = "x,y,z\n";
  for (int x = 0; x <= 40; ++x) {
    for (int y = 0; y <= 40; ++y) {
      rows += fmt::format("{},{},0\n", 0.25 * x, 0.25 * y);
      if (std::abs(x - 20) < 12 && std::abs(y - 20) < 12)
        rows += fmt::format("{},{},5\n", 0.25 * x, 0.25 * y);
    }
  }
  write("roofed.csv", rows);
  write("places.csv", "x,y,name\n5,5,below\n0.5,0.5,beside\n");
  const Words below = {"--observer", "5,5"};
  const std::pair<std::string, Words> commands[] = {
      {"points", with(below, {"-o", "o.las"})},
      {"raster", with(below, {"-o", "o.tif"})},
      {"horizon", with(below, {"--step", "30", "-o", "o.csv"})},
      {"sun",
       with(below, {"--place", "48,11", "--from", "2026-06-21", "--to", "2026-06-21", "-o", "sun.csv"})},
      {"summary", with(below, {"-o", "summary.csv"})},
      {"lines", {"--places", "places.csv", "-o", "lines.csv"}}};
  for (const auto& [name, words] : commands) {
    const ProgramResult result = run(with({"visibility", name, "roofed.csv"}, words));
    ASSERT_EQ(result.exit_code, 0) << name << result.err;
    EXPECT_TRUE(contains(result.err,
                         "eye at 5.000, 5.000, 2.000; 2.00 above what is below it, "
                         "3.00 below what is overhead"))
        << name << result.err;
    EXPECT_TRUE(contains(result.err,
                         "has something 3.00 above its eye, which hides the sky; to look from its top, type "
                         "--observer=5.000,5.000,5.000 --observer-height 2"))
        << name << result.err;
    EXPECT_EQ(contains(result.err,
                       "beside: eye at 0.500, 0.500, 2.000; 2.00 above what is below it, nothing overhead"),
              name == "lines")
        << result.err;
  }
}

TEST_F(VisibilityPointsTest, observer_grid_is_on_the_ground_everywhere) {
  write_garden();
  const ProgramResult result = run(with(k_points, {"--observer-grid", "10", "-o", "seen.las"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "1-1: eye at 690005.000, 5325005.000, 602.000")) << result.err;
  EXPECT_TRUE(contains(result.err, "2-2: eye at 690015.000, 5325015.000, 602.000")) << result.err;
}

TEST_F(VisibilityPointsTest, noise_does_not_block_unless_requested) {
  PointCloud cloud = garden();
  for (std::size_t id = 0; id < cloud.size(); ++id) {
    if (cloud.classifications[id] == 6) cloud.classifications[id] = 7;
  }
  write_las(folder / "garden.las", cloud);
  const auto seen_with = [&](const Words& options) {
    const ProgramResult result = run(with(
        with(k_points, options), {"--observer", k_eye, "-o", "seen.las", "--overwrite", "--radius", "0.3"}));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(contains(result.err, "without classes 7, 18"), options.empty()) << result.err;
    std::size_t count = 0;
    const PointCloud out = read_output("seen.las");
    const auto visible = values<std::uint8_t>(out, "Visible", ScalarType::uint8);
    // Near the wall, surfaces are those of wall and ground together.
    for (std::size_t id = 0; id < out.size(); ++id) count += out.positions[id].x > 12000 && visible[id] == 1;
    return count;
  };
  EXPECT_EQ(seen_with({"--ignore-classes", "none"}), 0u);
  EXPECT_EQ(seen_with({}), 32u * 81u);
}

TEST_F(VisibilityPointsTest, wrong_input_is_a_clear_error_and_leaves_nothing) {
  write_garden();
  write("empty.csv", "x,y,z\n");
  write("bad.csv", "x,y,z\n1,2,3\n4,five,6\n");
  write("empty.geojson", R"({"type":"FeatureCollection","features":[]})");
  write(
      "o.geojson",
      R"({"type":"FeatureCollection","features":[{"type":"Feature","properties":{},"geometry":{"type":"Point","coordinates":[9,48]}}]})");
  write("empty.xyz", "");
  const std::vector<std::pair<Words, std::string>> wrong = {
      {{}, "missing observers"},
      {{"--observer", "690100,5325100"}, "no ground below the observer"},
      {{"--observer", "11.5,48.1"},
       "--observers-crs EPSG:4326 for longitude and latitude, x first; --anywhere"},
      {{"--observer", "5325010,690010,3"}, "expected x before y: the coordinates seem to be exchanged"},
      {{"--observer", "1,2,nan"}, "invalid position"},
      {{"--observer", "690005;5325010;3"}, "invalid position"},
      {{"--observer", k_eye, "--horizontal-fov", "5"}, "--horizontal-fov"},
      {{"--observer", k_eye, "--horizontal-fov", "5,5"}, "--horizontal-fov"},
      {{"--observer", k_eye, "--vertical-fov", "5,-5"}, "--vertical-fov"},
      {{"--observer", k_eye, "--vertical-fov", "-100,5"}, "--vertical-fov"},
      {{"--observer", k_eye, "--max-distance", "-1"}, "--max-distance"},
      {{"--observer", k_eye, "--observer-height", "-1"}, "--observer-height"},
      {{"--observer", k_eye, "--fraction", "1"}, "--fraction"},
      {{"--observer", k_eye, "--fraction", "256"}, "--fraction"},
      {{"--observer", k_eye, "--radius", "0"}, "--radius"},
      {{"--observer", k_eye, "--transparency", "0"}, "--transparency"},
      {{"--observer", k_eye, "--occluder", "cube"}, "--occluder"},
      {{"--observer", k_eye, "--ignore-classes", "300"}, "--ignore-classes"},
      {{"--observer", k_eye, "--observer-hight", "2"}, "did you mean '--observer-height'?"},
      {{"--observer-grid", "0"}, "--observer-grid"},
      {{"--observer-grid", "0.01"}, "too many positions in an observer grid of"},
      {{"--observers", "absent.csv"}, "absent.csv"},
      {{"--observers", "empty.csv"}, "empty.csv: contains no observers"},
      {{"--observers", "bad.csv"}, "bad.csv:line 3: invalid y"},
      {{"--observers", "empty.geojson"}, "empty.geojson: contains no observers"},
      {{"--observers", "o.geojson"}, "--observers-crs cloud"},
      {{"--observer", k_eye, "--observers-crs", "EPSG:x"}, "EPSG:x"},
      {{"--observer", k_eye, "--lists", "absent/who.csv"}, "absent/who.csv"}};
  const Words before = names();
  for (const auto& [options, part] : wrong) {
    const ProgramResult result = run(with(with(k_points, options), {"-o", "seen.las"}));
    EXPECT_EQ(result.exit_code, 2) << part << "\n" << result.err;
    EXPECT_TRUE(contains(result.err, "alidade: error: ")) << result.err;
    EXPECT_TRUE(contains(result.err, part)) << part << "\n" << result.err;
  }
  EXPECT_EQ(run({"visibility", "points", "empty.xyz", "--observer", k_eye, "-o", "seen.las"}).exit_code, 2);
  EXPECT_EQ(run(with(k_points, {"--observer", k_eye, "-o", "seen.csv"})).exit_code, 2);
  EXPECT_EQ(run(with(k_points, {"--observer", k_eye, "-o", "garden.las", "--overwrite"})).exit_code, 2);
  EXPECT_EQ(run(with(k_points, {"--observer", k_eye})).exit_code, 2);
  // Of 81 and of 64 observers.
  EXPECT_TRUE(
      contains(run(with(k_points, {"--observer-grid", "2.22", "--blockers", "all", "-o", "seen.las"})).err,
               "too many observers for a column of blockers each"));
  EXPECT_TRUE(contains(run(with(k_points, {"--observer-grid", "2.5", "-o", "seen.ply"})).err,
                       "expected the extension .las"));
  EXPECT_EQ(names(), before);
}

TEST_F(VisibilityPointsTest, strange_observers_are_warned_of) {
  write_garden();
  write("o.csv", "name,x,y,z\nfar,600000,5325010,601\nlow,690005,5325010,590\n");
  const ProgramResult result = run(with(k_points, {"--observers", "o.csv", "--anywhere", "-o", "seen.las"}));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "alidade: warning: far is 90000 outside the cloud")) << result.err;
  EXPECT_TRUE(contains(result.err, "alidade: warning: low is below all points near it")) << result.err;
  const ProgramResult quiet =
      run(with(k_points, {"--observers", "o.csv", "--anywhere", "-o", "quiet.las", "-q"}));
  EXPECT_EQ(quiet.err, "");
}

TEST_F(VisibilityPointsTest, clouds_in_degrees_are_rejected_by_every_command) {
  PointCloud cloud = garden();
  cloud.crs.wkt = R"(GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],)"
                  R"(PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]])";
  write_las(folder / "degrees.las", cloud);
  write("positions.csv", "x,y,z\n690005,5325010,602\n690006,5325010,602\n");
  for (const Words& words : {Words{"points", "degrees.las", "--observer", k_eye, "-o", "out.las"},
                             {"lines", "degrees.las", "--places", "positions.csv", "-o", "out.csv"},
                             {"horizon", "degrees.las", "--observer", k_eye},
                             {"sky", "degrees.las", "-o", "out.las"}}) {
    const ProgramResult result = run(with({"visibility"}, words));
    EXPECT_EQ(result.exit_code, 2) << words[0];
    EXPECT_TRUE(contains(result.err, "degrees.las: geographic coordinates (degrees) are not supported"))
        << result.err;
  }
}

TEST_F(VisibilityPointsTest, observers_at_any_distance_are_answered) {
  write_garden();
  for (const std::string location : {"1690005,5325010,700", "1e9,5325010,1e5", "-1e12,1e12,1e12"}) {
    const ProgramResult result =
        run(with(k_points, {"--observer", location, "--anywhere", "-o", "seen.las", "--overwrite"}));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(contains(result.err, "outside the cloud; check its reference system")) << result.err;
  }
  EXPECT_TRUE(contains(run(with(k_points, {"--observer", "1e13,0,0", "--anywhere", "-o", "no.las"})).err,
                       "position out of range"));
}

TEST_F(VisibilityPointsTest, help_names_units_columns_and_examples) {
  const ProgramResult group = run({"visibility", "--help"});
  EXPECT_EQ(group.exit_code, 0);
  EXPECT_TRUE(contains(group.out, "points")) << group.out;
  const ProgramResult result = run({"visibility", "points", "--help"});
  EXPECT_EQ(result.exit_code, 0);
  for (const char* const part : {"metres", "degrees", "VisibleFraction", "Blocker", "Examples:", "7,18"})
    EXPECT_TRUE(contains(result.out, part)) << part;
  EXPECT_TRUE(contains(run({"visibility", "pionts"}).err, "did you mean 'points'?"));
  EXPECT_TRUE(
      contains(run({"visibility", "points", "--obsrver", "1,2"}).err, "alidade visibility points --help"));
}

TEST_F(VisibilityPointsTest, existing_output_is_kept_without_overwrite) {
  write_garden();
  for (const char* const name : {"seen.las", "who.csv"}) {
    write(name, "precious");
    const Words words = with(k_points, {"--observer", k_eye, "-o", "seen.las", "--lists", "who.csv"});
    const ProgramResult rejected = run(words);
    EXPECT_EQ(rejected.exit_code, 2);
    EXPECT_TRUE(contains(rejected.err, std::string(name) + ": the file exists")) << rejected.err;
    EXPECT_EQ(read(name), "precious");
    EXPECT_EQ(run(with(words, {"--overwrite", "-q"})).exit_code, 0);
    EXPECT_NE(read(name), "precious");
    std::filesystem::remove(folder / "seen.las");
    std::filesystem::remove(folder / "who.csv");
  }
}

TEST_F(VisibilityPointsTest, what_is_no_regular_file_is_never_replaced) {
  write_garden();
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  const ProgramResult result =
      run(with(k_points, {"--observer", k_eye, "-o", "seen.las", "--lists", "/dev/full", "--overwrite"}));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "/dev/full: cannot replace the file: not a regular file")) << result.err;
  EXPECT_EQ(names(), Words{"garden.las"});
}

TEST_F(VisibilityPointsTest, a_full_disk_is_an_error_that_leaves_nothing) {
  write_garden();
  const Words words = with(k_points, {"-q", "--observer", k_eye});
  for (const std::string output : {"seen.las", "seen.ply", "who.csv"}) {
    const bool is_list = output == "who.csv";
    const Words whole =
        with(words, is_list ? Words{"-o", "seen.las", "--lists", output} : Words{"-o", output});
    ASSERT_EQ(run(whole).exit_code, 0);
    const std::uintmax_t size = std::filesystem::file_size(folder / output);
    std::filesystem::remove(folder / output);
    std::filesystem::remove(folder / "seen.las");
    // The beginning fits; all but the end fits. Of two files, the other one is as large.
    for (const std::uintmax_t bytes : {std::uintmax_t{4096}, size - 1}) {
      const ProgramResult full = run_on_full_disk(whole, bytes);
      EXPECT_EQ(full.exit_code, 2) << output << " " << bytes;
      EXPECT_TRUE(contains(full.err, ": cannot write the file")) << full.err;
      EXPECT_EQ(names(), Words{"garden.las"}) << output << " " << bytes;
    }
  }
}

TEST_F(VisibilityPointsTest, interrupted_it_ends_with_130_and_leaves_nothing) {
  write_garden();
  // So many observers that no machine ends before it is interrupted.
  Program program(with(k_points, {"--observer-grid", "0.05", "-o", "seen.las", "--lists", "who.csv"}),
                  folder);
  const auto limit = std::chrono::steady_clock::now() + std::chrono::minutes(5);
  while (program.running() && !contains(program.errors_so_far(), "placing observers: ") &&
         std::chrono::steady_clock::now() < limit)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  program.send(SIGINT);
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_EQ(names(), Words{"garden.las"});
}

}  // namespace
}  // namespace alidade::test
