// SPDX-License-Identifier: MIT
// Queries of COPC files in place.
#include <algorithm>
#include <cstring>
#include <fstream>

#include "tests/cloud/copc/copc_builder.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

class CopcQueryTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    const CopcSample sample = build_copc(3000);
    std::ofstream file(folder / "site.copc.laz", std::ios::binary);
    file.write(reinterpret_cast<const char*>(sample.bytes.data()),
               static_cast<std::streamsize>(sample.bytes.size()));
    nodes_ = sample.keys.size();
    write("rays.csv",
          "ox,oy,oz,dx,dy,dz\n690000,5325000,600,0,0,-1\n690030,5324990,600,0.1,0,-1\n"
          "689950,5324950,480,1,1,0\n0,0,0,1,0,0\n");
  }

  ProgramResult query(Words words) {
    words.insert(words.begin(), {"query", "site.copc.laz", "-q"});
    return run(words);
  }

  /// Expects answers, and that those from the file in place and from the loaded cloud are the same bytes.
  void expect_same(const Words& words) {
    Words loaded = words;
    loaded.push_back("--load");
    const ProgramResult in_place = query(words), expected = query(loaded);
    EXPECT_EQ(in_place.exit_code, 0) << in_place.err;
    EXPECT_EQ(in_place.out, expected.out);
    EXPECT_GT(std::count(in_place.out.begin(), in_place.out.end(), '\n'), 2);
  }

  std::size_t nodes_ = 0;
};

TEST_F(CopcQueryTest, answers_in_position_have_the_bytes_of_those_of_the_loaded_cloud) {
  expect_same({"--rays", "rays.csv", "--radius", "2"});
  expect_same({"--rays", "rays.csv", "--radius", "3", "--k", "2", "--measure", "t"});
  expect_same({"--rays", "rays.csv", "--radius", "2", "--count"});
  expect_same({"--rays", "rays.csv", "--radius", "2", "--occluded"});
  expect_same({"--rays", "rays.csv", "--format", "jsonl"});
  expect_same({"--cone", "690000,5325000,600,0,0,-1,5"});
  expect_same({"--vertex", "689940,5324940,480", "--vertex", "690060,5325060,482", "--radius", "3"});
  expect_same({"--plane", "690000,5325000,480,1,0,0", "--plane", "690003,5325000,480,-1,0,0"});
  expect_same({"--box", "690000,5325000,470,690010,5325020,490"});
  expect_same({"--point", "690000,5325000,480", "--k", "12"});
  expect_same({"--point", "690000,5325000,480", "--k", "12", "--class", "3,7,200,201,202,203,204,205"});
}

TEST_F(CopcQueryTest, explain_prints_how_much_of_the_file_was_read) {
  const ProgramResult result = query({"--ray", "690000,5325000,600,0,0,-1", "--radius", "0.5", "--explain"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(contains(result.err, "nodes visited"));
  EXPECT_TRUE(contains(result.err, "chunks"));
  EXPECT_TRUE(contains(result.err, "points decoded"));
  const ProgramResult all = query({"--box", "-inf,-inf,-inf,inf,inf,inf", "--explain", "--count"});
  EXPECT_TRUE(contains(all.err, "100.00%")) << all.err;
  EXPECT_TRUE(contains(all.err, std::to_string(nodes_))) << all.err;
  EXPECT_FALSE(contains(query({"--point", "0,0,0", "--explain", "--load"}).err, "chunks"));
}

TEST_F(CopcQueryTest, little_memory_gives_the_same_answers) {
  expect_same({"--rays", "rays.csv", "--radius", "2"});
  const Words words = {"--rays", "rays.csv", "--radius", "2"};
  Words narrow = words;
  narrow.insert(narrow.end(), {"--memory", "4k"});
  EXPECT_EQ(query(narrow).out, query(words).out);
}

TEST_F(CopcQueryTest, memory_without_a_copc_file_in_position_is_an_error) {
  for (const Words& words : {Words{"--load"}, Words{"--max-level", "2"}}) {
    Words all = {"--point", "0,0,0", "--memory", "1M"};
    all.insert(all.end(), words.begin(), words.end());
    const ProgramResult result = query(all);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(contains(result.err, "--memory requires a COPC query without --load")) << result.err;
  }
}

TEST_F(CopcQueryTest, points_outside_their_cube_are_one_error_on_any_number_of_threads_and_none_when_loaded) {
  CopcSample sample = build_copc(3000);
  const double centre = 690003.0;
  std::memcpy(sample.bytes.data() + sample.info_offset, &centre, sizeof centre);
  std::ofstream(folder / "moved.copc.laz", std::ios::binary)
      .write(reinterpret_cast<const char*>(sample.bytes.data()),
             static_cast<std::streamsize>(sample.bytes.size()));
  std::string positions = "x,y,z\n";
  for (int i = 0; i < 300; ++i)
    positions +=
        std::to_string(690060 - i * 37 % 120) + "," + std::to_string(5325060 - i * 53 % 120) + ",480\n";
  write("positions.csv", positions);
  const Words words = {"query", "moved.copc.laz", "-q", "--points", "positions.csv", "--k", "3"};
  std::string first;
  for (const char* const threads : {"1", "4", "4", "2"}) {
    Words all = words;
    all.insert(all.end(), {"--threads", threads});
    const ProgramResult result = run(all);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(contains(result.err, "the point is outside the cube of its node; expected a position from"));
    if (first.empty()) first = result.err;
    EXPECT_EQ(result.err, first);
  }
  Words loaded = words;
  loaded.push_back("--load");
  EXPECT_EQ(run(loaded).exit_code, 0);
}

TEST_F(CopcQueryTest, answers_with_all_attributes_load_the_cloud) {
  EXPECT_EQ(query({"--point", "690000,5325000,480", "--k", "5", "-o", "found.las"}).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(folder / "found.las"));
}

TEST_F(CopcQueryTest, info_prints_levels_nodes_and_spacing) {
  const ProgramResult result = run({"info", "site.copc.laz"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(contains(result.out, "COPC 1.4, point format 7, 3000 points")) << result.out;
  EXPECT_TRUE(contains(result.out, std::to_string(nodes_) + " nodes with points, spacing 1.5 in the root"));
}

}  // namespace
}  // namespace alidade::test
