// SPDX-License-Identifier: MIT
#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/tools/wall_site.h"

namespace alidade::test {
namespace {

using Json = nlohmann::json;

class VisibilityPlaceTest : public WallSiteTest {
 protected:
  ProgramResult run_place(std::vector<std::string> words) {
    words.insert(words.begin(), {"visibility", "place", "site.csv", "-q"});
    return run(words);
  }
  /// One near each side of the wall, one far off, one right beside the first.
  void write_candidates() {
    write("candidates.csv", "x,y,z,name\n-3,0,1.5,west\n3,0,1.5,east\n-4.5,4.5,0.2,corner\n-3,0.2,1.5,too\n");
  }
};

TEST_F(VisibilityPlaceTest, a_position_on_either_side_of_the_wall_is_chosen) {
  write_candidates();
  const ProgramResult result =
      run({"visibility", "place", "site.csv", "--observers", "candidates.csv", "--count", "2",
           "--target-spacing", "0.5", "-o", "best.json", "--curve", "best.png"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("2 positions see "), std::string::npos) << result.err;
  const Json file = Json::parse(read("best.json"));
  ASSERT_EQ(file["places"].size(), 2u);
  const Json &first = file["places"][0], &second = file["places"][1];
  EXPECT_NE(first["x"].get<double>() < 0.0, second["x"].get<double>() < 0.0);
  EXPECT_EQ(first["covered"], first["gain"]);
  EXPECT_EQ(second["covered"].get<double>(), first["gain"].get<double>() + second["gain"].get<double>());
  EXPECT_GT(second["share"], 0.95);
  EXPECT_LE(second["covered"], file["best_possible"]);
  EXPECT_LE(file["best_possible"], file["total"]);
  EXPECT_EQ(read("best.png").substr(1, 3), "PNG");
}

TEST_F(VisibilityPlaceTest, csv_has_the_curve_and_geojson_is_read_as_positions) {
  write("two.csv", "x,y,z,name\n-3,0,1.5,west\n3,0,1.5,east\n");
  const std::vector<std::string> words = {"--observers", "two.csv", "--count", "3"};
  for (const char* const output : {"best.csv", "best.geojson"}) {
    std::vector<std::string> with = words;
    with.insert(with.end(), {"-o", output});
    ASSERT_EQ(run_place(with).exit_code, 0);
  }
  const std::string csv = read("best.csv");
  EXPECT_EQ(csv.substr(0, csv.find('\n')), "place,candidate,name,x,y,z,gain,covered,share");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3);
  const ProgramResult lines = run({"visibility", "lines", "site.csv", "-q", "--places", "best.geojson",
                                   "--places-crs", "cloud", "-o", "l.csv"});
  EXPECT_EQ(lines.exit_code, 0) << lines.err;
  for (const char* const name : {",west,", ",east,"})
    EXPECT_NE(read("l.csv").find(name), std::string::npos) << read("l.csv");
}

TEST_F(VisibilityPlaceTest, classes_heights_and_weights_choose_what_is_to_be_seen) {
  write_candidates();
  const auto total = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"--observers", "candidates.csv", "--count",    "1",
                                      "-o",          "b.json",         "--overwrite"};
    words.insert(words.end(), more.begin(), more.end());
    const ProgramResult result = run_place(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return Json::parse(read("b.json"))["total"].get<double>();
  };
  const double all = total({}), floor = total({"--target-classes", "2"}),
               wall = total({"--target-classes", "6"});
  EXPECT_GT(floor, wall);
  EXPECT_GE(floor + wall, all);
  EXPECT_EQ(total({"--target-classes", "6", "--class-weights", "6=2.5"}), 2.5 * wall);
  EXPECT_EQ(total({"--target-classes", "2", "--class-weights", "6=2.5"}), floor);
  EXPECT_GT(total({"--target-spacing", "0.5"}), 2.0 * all);
  EXPECT_EQ(total({"--target-height", "1"}), all);
}

TEST_F(VisibilityPlaceTest, nobody_who_sees_anything_is_the_answer_no) {
  write("blind.csv", "x,y,z,max_distance\n-3,0,1,0.1\n");
  const ProgramResult result = run_place({"--observers", "blind.csv", "--count", "1", "-o", "b.csv"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("no candidate sees any target with a positive weight; writing nothing"),
            std::string::npos)
      << result.err;
  EXPECT_EQ(names(), (std::vector<std::string>{"blind.csv", "site.csv"}));
}

TEST_F(VisibilityPlaceTest, what_cannot_be_done_is_an_error) {
  write_candidates();
  write_square("plain.xyz");
  const std::vector<std::string> usual = {"--observers", "candidates.csv", "--count", "1", "-o", "b.csv"};
  const auto fails_with = [&](const std::vector<std::string>& more, const std::string& part) {
    std::vector<std::string> words = usual;
    words.insert(words.end(), more.begin(), more.end());
    const ProgramResult result = run_place(words);
    EXPECT_EQ(result.exit_code, 2) << part;
    EXPECT_NE(result.err.find(part), std::string::npos) << result.err;
  };
  fails_with({"--curve", "c.jpg"}, "c.jpg: unknown output format");
  fails_with({"--curve", "b.csv"}, "b.csv: ");
  fails_with({"--class-weights", "6:2"}, "expected CLASS=WEIGHT, such as 6=2.5, found");
  fails_with({"--class-weights", "6=1,6=2"}, "duplicate weight of class 6");
  fails_with({"--class-weights", "256=1"}, "--class-weights");
  fails_with({"--target-classes", "40"}, "site.csv: the cloud has no points of the target classes");
  fails_with({"--target-spacing", "1e-6"}, "target spacing too small for the extent of the cloud");
  fails_with({"--count", "0"}, "--count");
  const ProgramResult nobody = run_place({"--count", "1", "-o", "b.csv"});
  EXPECT_EQ(nobody.exit_code, 2);
  EXPECT_NE(nobody.err.find("--observer-grid"), std::string::npos) << nobody.err;
  const ProgramResult plain = run({"visibility", "place", "plain.xyz", "-q", "--observer", "100,200,7",
                                   "--count", "1", "--target-classes", "2", "-o", "b.csv"});
  EXPECT_EQ(plain.exit_code, 2);
  EXPECT_NE(plain.err.find("the cloud has no classification for targets"), std::string::npos) << plain.err;
}

TEST_F(VisibilityPlaceTest, a_full_disk_is_an_error_but_the_run_continues_without_checkpoints) {
  const std::vector<std::string> words = {"visibility", "place",   "site.csv", "-q", "--observer-grid",
                                          "0.5",        "--count", "60",       "-o", "best.json"};
  ASSERT_EQ(run(words).exit_code, 0);
  const std::string best = read("best.json");
  std::filesystem::remove(folder / "best.json");
  const ProgramResult full = run_on_full_disk(words, best.size() - 1);
  EXPECT_EQ(full.exit_code, 2);
  EXPECT_NE(full.err.find("best.json: cannot write the file"), std::string::npos) << full.err;
  EXPECT_EQ(names(), std::vector<std::string>{"site.csv"});

  // Of the 400 parts of the checkpoint, 48 bytes each at least, the first ones fit.
  std::vector<std::string> kept = words;
  kept.insert(kept.end(), {"--checkpoint", "state", "--checkpoint-interval", "0.001"});
  const std::uint64_t limit = 12'000;
  ASSERT_LT(best.size(), limit);
  const ProgramResult result = run_on_full_disk(kept, limit);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("no checkpoint: state: cannot write the file"), std::string::npos) << result.err;
  EXPECT_EQ(read("best.json"), best);
  EXPECT_EQ(names(), (std::vector<std::string>{"best.json", "site.csv"}));
}

TEST_F(VisibilityPlaceTest, help_gives_units_and_examples) {
  const ProgramResult result = run({"visibility", "place", "--help"});
  EXPECT_EQ(result.exit_code, 0);
  for (const char* const part : {"metres", "candidates", "63 %", "Exit codes", "Examples:"})
    EXPECT_NE(result.out.find(part), std::string::npos) << part;
}

}  // namespace
}  // namespace alidade::test
