// SPDX-License-Identifier: MIT
// Queries of COPC files in place.
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <cstring>
#include <fstream>

#include "tests/cloud/copc/copc_builder.h"
#include "tests/jobs/query_job.h"

namespace alidade::test {
namespace {

class CopcQueryTest : public QueryJob {
 protected:
  void SetUp() override {
    QueryJob::SetUp();
    const CopcSample sample = build_copc(3000);
    std::ofstream file(folder / "site.copc.laz", std::ios::binary);
    file.write(reinterpret_cast<const char*>(sample.bytes.data()),
               static_cast<std::streamsize>(sample.bytes.size()));
    nodes_ = sample.keys.size();
    write("rays.csv",
          "ox,oy,oz,dx,dy,dz\n690000,5325000,600,0,0,-1\n690030,5324990,600,0.1,0,-1\n"
          "689950,5324950,480,1,1,0\n0,0,0,1,0,0\n");
  }

  std::string query(const Words& words) { return QueryJob::query("site.copc.laz", words); }

  /// Expects answers, and that those from the file in place and from the loaded cloud are the same bytes.
  void expect_same(const Words& words) {
    Words loaded = words;
    loaded.push_back("--load");
    const std::string in_place = query(words);
    EXPECT_EQ(in_place, query(loaded));
    EXPECT_GT(std::ranges::count(in_place, '\n'), 2);
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

TEST_F(CopcQueryTest, little_memory_gives_the_same_answers) {
  expect_same({"--rays", "rays.csv", "--radius", "2"});
  const Words words = {"--rays", "rays.csv", "--radius", "2"};
  Words narrow = words;
  narrow.insert(narrow.end(), {"--memory", "4k"});
  EXPECT_EQ(query(narrow), query(words));
}

TEST_F(CopcQueryTest, memory_without_a_copc_file_in_position_is_an_error) {
  for (const Words& words : {Words{"--load"}, Words{"--max-level", "2"}}) {
    Words all = {"--point", "0,0,0", "--memory", "1M"};
    all.insert(all.end(), words.begin(), words.end());
    const std::string error = rejected("site.copc.laz", all);
    EXPECT_TRUE(contains(error, "--memory requires a COPC query without --load")) << error;
    EXPECT_THROW((void)jobs::plan(request("site.copc.laz", all)), Error);
  }
}

TEST_F(CopcQueryTest, points_outside_their_cube_are_one_error_on_any_number_of_threads_and_none_when_loaded) {
  CopcSample sample = build_copc(3000);
  const double centre = 690003.0;
  std::memcpy(sample.bytes.data() + sample.info_offset, &centre, sizeof centre);
  write("moved.copc.laz", {reinterpret_cast<const char*>(sample.bytes.data()), sample.bytes.size()});
  std::string positions = "x,y,z\n";
  for (int i = 0; i < 300; ++i)
    positions +=
        std::to_string(690060 - i * 37 % 120) + "," + std::to_string(5325060 - i * 53 % 120) + ",480\n";
  write("positions.csv", positions);
  const Words words = {"--points", "positions.csv", "--k", "3"};
  std::string first;
  for (const int threads : {1, 4, 4, 2}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    tbb::task_arena arena(threads);
    const std::string error = arena.execute([&] { return rejected("moved.copc.laz", words); });
    EXPECT_TRUE(contains(error, "the point is outside the cube of its node; expected a position from"));
    if (first.empty()) first = error;
    EXPECT_EQ(error, first);
  }
  Words loaded = words;
  loaded.push_back("--load");
  EXPECT_NE(QueryJob::query("moved.copc.laz", loaded), "");
}

TEST_F(CopcQueryTest, answers_with_all_attributes_load_the_cloud) {
  query({"--point", "690000,5325000,480", "--k", "5", "-o", "found.las"});
  EXPECT_TRUE(std::filesystem::exists(folder / "found.las"));
}

TEST_F(CopcQueryTest, work_says_how_much_of_the_file_was_read) {
  const auto work = [&](const Words& words) {
    std::string text;
    for (const jobs::WorkCount& one : run(jobs::plan(request("site.copc.laz", words)), heard).work)
      text += one.name + " " + std::to_string(one.count) + " of " + std::to_string(one.of.value_or(0)) + "\n";
    return text;
  };
  const std::string all = work({"--box", "-inf,-inf,-inf,inf,inf,inf", "--explain", "--count"});
  const std::string nodes = std::to_string(nodes_);
  EXPECT_TRUE(contains(all, "nodes visited ")) << all;
  EXPECT_TRUE(contains(all, "\nchunks read " + nodes + " of " + nodes + "\nchunks decoded ")) << all;
  EXPECT_TRUE(contains(all, "\npoints decoded 3000 of 3000\n")) << all;
  EXPECT_FALSE(contains(work({"--point", "0,0,0", "--explain", "--load"}), "chunks"));
}

}  // namespace
}  // namespace alidade::test
