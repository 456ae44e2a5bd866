// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "cloud/las/write_las.h"
#include "cloud/read_cloud.h"
#include "tests/cloud/e57/e57_builder.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

const Words k_change = {"change", "before.las", "after.las", "--max-distance", "0.2"};
const Words k_origins = {"--origin-before", "690000,5324997,601.7", "--origin-after", "690000,5324997,601.7"};

/// Ground of 10 by 10 m and a wall behind it, in steps of 0.1 m; with a box on the ground or without.
PointCloud yard(bool with_box) {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(0.001), .offset = {690000, 5325000, 600}};
  cloud.crs.wkt = R"(LOCAL_CS["yard",UNIT["metre",1]])";
  for (int x = -50; x <= 50; ++x) {
    for (int y = -50; y <= 50; ++y) {
      const bool is_below = with_box && std::abs(x) < 5 && y > 0 && y < 10;
      if (!is_below) cloud.positions.emplace_back(100 * x, 100 * y, 0);
    }
    for (int z = 1; z <= 30; ++z) cloud.positions.emplace_back(100 * x, 5000, 100 * z);
  }
  for (int u = 0; with_box && u <= 20; ++u) {
    for (int v = 1; v <= 20; ++v) cloud.positions.emplace_back(50 * u - 500, 0, 50 * v);
    for (int v = 1; v <= 20; ++v) cloud.positions.emplace_back(50 * u - 500, 50 * v, 1000);
  }
  cloud.classifications.assign(cloud.size(), with_box ? 6 : 2);
  if (!with_box) cloud.intensities.assign(cloud.size(), 77);
  return cloud;
}

std::string utm(int zone) {
  return fmt::format(R"(PROJCS["WGS 84 / UTM zone {}N",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",)"
                     R"(6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],)"
                     R"(PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],)"
                     R"(PARAMETER["central_meridian",{}],PARAMETER["scale_factor",0.9996],)"
                     R"(PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["metre",1]])",
                     zone, 6 * zone - 183);
}

constexpr std::size_t k_box_points = 2 * 21 * 20;

template <class Value>
std::vector<Value> values(const PointCloud& cloud, const std::string& name) {
  for (const ExtraDimension& dimension : cloud.extra_dimensions) {
    if (dimension.name != name) continue;
    EXPECT_EQ(dimension.values.size(), cloud.size() * sizeof(Value)) << name;
    std::vector<Value> numbers(dimension.values.size() / sizeof(Value));
    std::memcpy(numbers.data(), dimension.values.data(), dimension.values.size());
    return numbers;
  }
  ADD_FAILURE() << name << " is missing";
  return std::vector<Value>(cloud.size());
}

class ChangeProgramTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_las(folder / "before.las", yard(true));
    write_las(folder / "after.las", yard(false));
  }

  PointCloud output(const std::string& name) { return read_cloud(folder / name); }
  /// The error message of the failing program.
  std::string error(const Words& words) {
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_EQ(result.out, "");
    return result.err;
  }
};

TEST_F(ChangeProgramTest, both_epochs_are_in_one_file_with_their_classes) {
  const ProgramResult result = run(with(with(k_change, k_origins), {"-o", "change.las"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const PointCloud out = output("change.las"), before = yard(true), after = yard(false);
  ASSERT_EQ(out.size(), before.size() + after.size());
  EXPECT_EQ(out.lattice, before.lattice);
  EXPECT_EQ(out.crs, before.crs);
  EXPECT_TRUE(std::equal(before.positions.begin(), before.positions.end(), out.positions.begin()));
  EXPECT_TRUE(std::equal(after.positions.rbegin(), after.positions.rend(), out.positions.rbegin()));
  EXPECT_EQ(out.classifications.front(), 6);
  EXPECT_EQ(out.classifications.back(), 2);
  EXPECT_EQ(out.intensities.front(), 0) << "BEFORE has none";
  EXPECT_EQ(out.intensities.back(), 77);
  const auto epochs = values<std::uint8_t>(out, "Epoch"), classes = values<std::uint8_t>(out, "Change");
  EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(epochs, 1)), before.size());
  EXPECT_EQ(epochs.back(), 2);
  const auto gone = static_cast<std::size_t>(std::ranges::count(classes, 2));
  EXPECT_GT(gone, 9 * k_box_points / 10);
  EXPECT_LE(gone, k_box_points);
  EXPECT_EQ(std::ranges::count(classes, 3), 0) << "ground that the box hid is not new";
  EXPECT_GT(std::ranges::count(classes, 4), 0) << "it was never seen";
  const auto distances = values<float>(out, "M3C2Distance"), levels = values<float>(out, "LoD95");
  for (std::size_t id = 0; id < out.size(); ++id) {
    ASSERT_EQ(std::isnan(distances[id]), std::isnan(levels[id]));
    if (classes[id] == 1) {
      ASSERT_GT(std::fabs(distances[id]), levels[id]);
    }
  }
  EXPECT_TRUE(contains(result.out, "BEFORE ")) << result.out;
  EXPECT_TRUE(contains(result.out, "gone ")) << result.out;
}

TEST_F(ChangeProgramTest, threads_index_files_and_laz_do_not_change_the_answer) {
  ASSERT_EQ(run(with(with(k_change, k_origins), {"-o", "a.las", "--threads", "1", "-q"})).exit_code, 0);
  ASSERT_EQ(run(with(with(k_change, k_origins), {"-o", "b.las", "--threads", "3", "-q"})).exit_code, 0);
  EXPECT_EQ(read("a.las"), read("b.las"));
  ASSERT_EQ(run({"index", "before.las", "-o", "before.alidade", "-q"}).exit_code, 0);
  Words indexed = with(with(k_change, k_origins), {"-o", "c.las", "-q"});
  indexed[1] = "before.alidade";
  ASSERT_EQ(run(indexed).exit_code, 0);
  EXPECT_EQ(read("a.las"), read("c.las"));
  ASSERT_EQ(run(with(with(k_change, k_origins), {"-o", "d.laz", "-q"})).exit_code, 0);
  EXPECT_EQ(values<std::uint8_t>(output("d.laz"), "Change"), values<std::uint8_t>(output("a.las"), "Change"));
  ASSERT_EQ(run(with(with(k_change, k_origins), {"-o", "e.ply", "-q"})).exit_code, 0);
  EXPECT_EQ(values<std::uint8_t>(output("e.ply"), "Change"), values<std::uint8_t>(output("a.las"), "Change"));
  EXPECT_EQ(output("e.ply").intensities.back(), 77);
}

TEST_F(ChangeProgramTest, memory_does_not_change_the_answer) {
  if (!contains(run({"change", "--help"}).out, "--memory")) GTEST_SKIP() << "without the extension scratch";
  for (const char* const name : {"a.las", "b.las", "c.las"}) {
    Words words = with(with(k_change, k_origins), {"-o", name, "-q"});
    if (name[0] != 'a') words.insert(words.end(), {"--memory", "1M"});
    if (name[0] == 'c') {
      ASSERT_EQ(run({"index", "before.las", "-o", "before.alidade", "-q"}).exit_code, 0);
      words[1] = "before.alidade";
    }
    ASSERT_EQ(run(words).exit_code, 0);
    EXPECT_TRUE(read(name) == read("a.las")) << name;
  }
}

TEST_F(ChangeProgramTest, json_has_the_same_counts_as_the_output) {
  const ProgramResult result = run(with(with(k_change, k_origins), {"-o", "change.las", "--json", "-q"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json summary = nlohmann::json::parse(result.out);
  const auto classes = values<std::uint8_t>(output("change.las"), "Change");
  std::int64_t all = 0;
  for (const auto& [name, one] : summary.at("before").at("classes").items()) {
    const std::int64_t points = one.at("points"),
                       later = summary.at("after").at("classes").at(name).at("points");
    EXPECT_EQ(points + later, std::ranges::count(classes, one.at("code").get<int>())) << name;
    all += points;
  }
  EXPECT_EQ(summary.at("before").at("points"), all);
  EXPECT_NEAR(summary.at("before").at("classes").at("gone").at("area"), 2.0, 0.6);
}

TEST_F(ChangeProgramTest, scanner_positions_come_from_files_and_from_poses) {
  write("scanners.csv", "x,y,z,height\n690000,5324997,600,1.7\n690001,5324997,601.7,\n");
  ASSERT_EQ(run(with(k_change, {"--origins-before", "scanners.csv", "--origins-after", "scanners.csv", "-o",
                                "change.las", "-q"}))
                .exit_code,
            0);
  E57Builder builder;
  std::vector<double> x, y, z;
  for (const LatticePosition& position : yard(false).positions) {
    x.push_back(0.001 * position.x);
    y.push_back(0.001 * position.y + 3.0);
    z.push_back(0.001 * position.z - 1.7);
  }
  builder.add_scan(
      pose_element("1 0 0 0", "690000 5324997 601.7"),
      {float64_column("cartesianX", x), float64_column("cartesianY", y), float64_column("cartesianZ", z)});
  write("after.e57", builder.file());
  const ProgramResult result =
      run({"change", "before.las", "after.e57", "--origin-before", "690000,5324997,601.7", "-o", "e57.las"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.err, "AFTER: 13231 points, 1 scanner position")) << result.err;
  EXPECT_TRUE(contains(result.err, "only BEFORE states a reference system")) << result.err;
  EXPECT_GT(std::ranges::count(values<std::uint8_t>(output("e57.las"), "Change"), 2), 700);
}

TEST_F(ChangeProgramTest, a_depth_camera_is_no_scanner_that_has_seen_all_around) {
  std::string frame = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 20\nHEIGHT 20\nDATA ascii\n";
  for (int i = 0; i < 400; ++i) {
    const double depth = 2.0 + 0.05 * (i % 20);
    frame += fmt::format("{} {} {}\n", 0.05 * depth * (i % 20 - 9.5), 0.05 * depth * (i / 20 - 9.5), depth);
  }
  write("frame.pcd", frame);
  EXPECT_TRUE(contains(error({"change", "frame.pcd", "frame.pcd", "-o", "change.las"}),
                       "frame.pcd: unknown scanner positions"));
}

TEST_F(ChangeProgramTest, without_scanner_positions_it_says_what_to_do) {
  const std::string said = error(with(k_change, {"-o", "change.las"}));
  EXPECT_TRUE(contains(said, "before.las: unknown scanner positions: what is new cannot be distinguished"))
      << said;
  EXPECT_TRUE(contains(said, "--origin-before X,Y,Z")) << said;
  EXPECT_TRUE(contains(error(with(k_change, {"-o", "change.las", "--origin-before", "690000,5324997,601.7"})),
                       "after.las: unknown scanner positions: what is gone"));
  ASSERT_EQ(run(with(k_change, {"-o", "change.las", "--no-sight", "-q"})).exit_code, 0);
  const auto classes = values<std::uint8_t>(output("change.las"), "Change");
  EXPECT_GT(std::ranges::count(classes, 5), 700);
  EXPECT_EQ(std::ranges::count(classes, 2) + std::ranges::count(classes, 4), 0);
}

/// A point about every metre, in rows that no two points share.
std::string thin_ground(double height) {
  std::string text = "x,y,z\n";
  for (int x = 0; x < 30; ++x)
    for (int y = 0; y < 30; ++y)
      text += fmt::format("{},{},{}\n", x + 0.17 * ((7 * x + 3 * y) % 5 - 2) / 2,
                          y + 0.17 * ((5 * x + 11 * y) % 7 - 3) / 3, height + 0.01 * ((x + 2 * y) % 3 - 1));
  return text;
}

TEST_F(ChangeProgramTest, points_without_a_distance_are_not_measured_and_the_reasons_counted) {
  write("before.csv", thin_ground(0.0));
  write("after.csv", thin_ground(0.5));
  const Words all = {"change", "before.csv", "after.csv", "--no-sight", "-o", "change.las", "--overwrite"};
  const ProgramResult measured =
      run(with(all, {"--normal-radius", "1.1", "--cylinder-radius", "2", "--max-distance", "2", "--json"}));
  ASSERT_EQ(measured.exit_code, 0) << measured.err;
  EXPECT_TRUE(
      contains(measured.err, "BEFORE: --normal-radius holds too few points for a normal at 900 of 900"))
      << measured.err;
  const nlohmann::json before = nlohmann::json::parse(measured.out).at("before").at("classes");
  EXPECT_EQ(before.at("same").at("points"), 0);
  EXPECT_GT(before.at("moved").at("with_distance"), 880);
  EXPECT_NEAR(before.at("moved").at("median_distance"), 0.5, 0.02);
  const ProgramResult small = run(with(all, {"--cylinder-radius", "0.6", "--max-distance", "2"}));
  ASSERT_EQ(small.exit_code, 0) << small.err;
  EXPECT_TRUE(contains(small.out, "\nnot measured               900")) << small.out;
  EXPECT_TRUE(contains(small.out, "\n  too few points           900\n")) << small.out;
  EXPECT_FALSE(contains(small.out, "same")) << small.out;
  EXPECT_TRUE(contains(small.err, "900 of 900 points are not measured: 0 have no normal")) << small.err;
  EXPECT_EQ(std::ranges::count(values<std::uint8_t>(output("change.las"), "Change"), 7), 1800);
}

TEST_F(ChangeProgramTest, epochs_on_other_lattices_share_the_finest_scale) {
  PointCloud after = yard(false);
  after.lattice = {.scale = glm::dvec3(0.0005), .offset = {689999.5, 5325000, 600}};
  for (LatticePosition& position : after.positions) position = 2 * position + LatticePosition(1000, 0, 0);
  write_las(folder / "after.las", after, {.overwrite = true});
  ASSERT_EQ(run(with(with(k_change, k_origins), {"-o", "change.las", "-q"})).exit_code, 0);
  const PointCloud out = output("change.las"), before = yard(true);
  EXPECT_EQ(out.lattice.scale, glm::dvec3(0.0005));
  for (std::size_t id = 0; id < before.size(); ++id)
    ASSERT_LT(glm::length(out.world(id) - before.world(id)), 1e-9);
  for (std::size_t id = 0; id < after.size(); ++id)
    ASSERT_LT(glm::length(out.world(before.size() + id) - after.world(id)), 1e-9);
}

TEST_F(ChangeProgramTest, classes_that_are_ignored_are_not_compared) {
  ASSERT_EQ(
      run(with(with(k_change, k_origins), {"-o", "change.las", "--ignore-classes", "6", "-q"})).exit_code, 0);
  const auto classes = values<std::uint8_t>(output("change.las"), "Change");
  EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(classes, 6)), yard(true).size());
}

TEST_F(ChangeProgramTest, epochs_that_cannot_be_compared_are_errors) {
  const Words all = with(with(k_change, k_origins), {"-o", "change.las"});
  PointCloud after = yard(false);
  after.lattice.offset.x += 1000.0;
  write_las(folder / "after.las", after, {.overwrite = true});
  EXPECT_TRUE(contains(error(all), "the epochs do not overlap"));
  after = yard(false);
  PointCloud before = yard(true);
  before.crs.wkt = utm(32);
  after.crs.wkt = utm(33);
  write_las(folder / "before.las", before, {.overwrite = true});
  write_las(folder / "after.las", after, {.overwrite = true});
  EXPECT_TRUE(
      contains(error(all),
               "after.las: AFTER is in another reference system than BEFORE; expected "
               "WGS 84 / UTM zone 32N: --reproject SYSTEM brings both to one, found WGS 84 / UTM zone 33N"));
  after.crs.wkt = R"(GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],)"
                  R"(PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]])";
  write_las(folder / "after.las", after, {.overwrite = true});
  EXPECT_TRUE(contains(error(all), "degrees"));
  after.resize(0);
  after.crs = {};
  write_las(folder / "after.las", after, {.overwrite = true});
  EXPECT_TRUE(contains(error(all), "after.las: the cloud has no points"));
  write("after.las", read("before.las").substr(0, 3000));
  EXPECT_TRUE(contains(error(all), "after.las"));
  EXPECT_EQ(names(), (std::vector<std::string>{"after.las", "before.las"}));
}

TEST_F(ChangeProgramTest, wrong_options_are_errors) {
  const Words all = with(k_change, k_origins);
  EXPECT_TRUE(contains(error(with(all, {"-o", "change.tif"})), "the extension .las, .laz or .ply"));
  EXPECT_TRUE(contains(error(with(all, {"-o", "before.las", "--overwrite"})), "before.las"));
  write("mine.las", "mine");
  EXPECT_TRUE(contains(error(with(all, {"-o", "mine.las"})), "mine.las"));
  EXPECT_EQ(read("mine.las"), "mine");
  const std::pair<Words, const char*> wrong[] = {
      {{"--registration-error", "-1"}, "--registration-error"},
      {{"--registration-error", "nan"}, "--registration-error"},
      {{"--max-distance", "0"}, "--max-distance"},
      {{"--cylinder-radius", "inf"}, "--cylinder-radius"},
      {{"--normal-radius", "1m"}, "--normal-radius"},
      {{"--max-range", "0"}, "--max-range"},
      {{"--origin-after", "1,2"}, "--origin-after: invalid value; expected X,Y,Z"},
      {{"--origin-after", "1,2,nan"}, "--origin-after"},
      {{"--ignore-classes", "300"}, "--ignore-classes"}};
  for (const auto& [words, part] : wrong) {
    const std::string said = error(with(with(all, {"-o", "change.las"}), words));
    EXPECT_TRUE(contains(said, part)) << said;
  }
  EXPECT_TRUE(contains(error({"change", "before.las", "-o", "change.las"}),
                       "missing AFTER; expected alidade change [OPTIONS] BEFORE AFTER"));
}

TEST_F(ChangeProgramTest, most_points_moved_a_little_is_called_a_matter_of_registration) {
  PointCloud after = yard(true);
  for (LatticePosition& position : after.positions) {
    position += LatticePosition(3, 3, 3);
    position.z += static_cast<int>(&position - after.positions.data()) % 5;
  }
  write_las(folder / "after.las", after, {.overwrite = true});
  const Words all = with(with(k_change, k_origins), {"-o", "change.las", "--overwrite"});
  EXPECT_TRUE(contains(run(all).err, "most surfaces have moved, half of them by less than 0.00"));
  EXPECT_FALSE(contains(run(with(all, {"--registration-error", "0.005"})).err, "most surfaces have moved"));
}

TEST_F(ChangeProgramTest, help_has_units_classes_and_examples) {
  const ProgramResult help = run({"change", "--help"});
  EXPECT_EQ(help.exit_code, 0);
  for (const char* const part :
       {"metres", "never seen", "M3C2Distance", "LoD95", "--no-sight", "Examples:", "alidade change"})
    EXPECT_TRUE(contains(help.out, part)) << part;
}

}  // namespace
}  // namespace alidade::test
