// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <string>
#include <tuple>
#include <utility>

#include "tests/jobs/query_job.h"

namespace alidade::test {
namespace {

constexpr const char* k_header = "ox,oy,oz,dx,dy,dz\n";
constexpr const char* k_answer = "ray_id,count\n0,5\n1,1\n";

class QueryInputTest : public QueryJob {
 protected:
  void SetUp() override {
    QueryJob::SetUp();
    write("tiny.xyz", "0 0 0\n1 0 0\n2 0.5 0\n3 0 2\n4 0 0\n");
  }

  std::string count_rays(const std::string& text) {
    write("targets", text);
    return query("tiny.xyz", {"--rays", "targets", "--radius", "2", "--count"});
  }

  /// The error for targets that are not good.
  std::string rejected(const std::string& option, const std::string& text) {
    write("targets", text);
    return QueryJob::rejected("tiny.xyz", {option, "targets", "--count"});
  }
};

TEST_F(QueryInputTest, csv_and_json_lines_are_equivalent) {
  EXPECT_EQ(count_rays("ox,oy,oz,dx,dy,dz\n0,0,0,1,0,0\n3,0,9,0,0,-1\n").substr(0, 17),
            "ray_id,count\n0,5\n");
  const std::string csv = count_rays("ox,oy,oz,dx,dy,dz,t_max\n0,0,0,1,0,0,\n3,0,9,0,0,-1,7.5\n");
  EXPECT_EQ(csv, k_answer);
  for (const char* const text :
       {"\xEF\xBB\xBFox,oy,oz,dx,dy,dz,t_max\r\n0,0,0,1,0,0,inf\r\n\r\n3,0,9,0,0,-1,7.5",
        "\n  \ndz , dy,dx,\"oz\",oy,ox,t_max\n0,0,1,0,0,0,\n+ 1\n",
        "{\"origin\": [0, 0, 0], \"direction\": [1, 0, 0]}\n"
        "{\"t_max\": 7.5, \"direction\": [0, 0, -1], \"origin\": [3, 0, 9]}\n",
        "{\"ox\": 0, \"oy\": 0, \"oz\": 0, \"dx\": 1, \"dy\": 0, \"dz\": 0, \"t_max\": null}\n"
        "[3, 0, 9, 0, 0, -1, \"-inf\", 7.5]\n"}) {
    if (contains(text, "+ 1")) {
      EXPECT_TRUE(contains(rejected("--rays", text), "targets:5:4: too few columns")) << text;
    } else {
      EXPECT_EQ(count_rays(text), k_answer) << text;
    }
  }
}

TEST_F(QueryInputTest, wrong_csv_is_rejected_with_line_and_column) {
  const std::string header = k_header;
  const std::pair<std::string, const char*> wrong[] = {
      {"", "targets:1:1: contains no rays; expected CSV with the header ox,oy,oz,dx,dy,dz[,t_min][,t_max]"},
      {"\n\r\n \t\n", "targets:1:1: contains no rays"},
      {"1,2,3,4,5,6\n", "targets:1:1: missing header"},
      {"ox,oy,oz\n", "targets:1:9: missing column dx"},
      {"ox,oy,oz,dx,dy,dz,time\n", "targets:1:19: unknown column \"time\"; expected one of ox, oy, oz, dx"},
      {"ox,oy,oz,dx,oy,dz\n", "targets:1:13: duplicate column oy"},
      {"\x89PNG\r\n\x1a\n", "targets:1:1: unknown column \"\\x89PNG\""},
      {header + "1,2,3,4,5\n", "targets:2:10: too few columns; expected 6, found 5"},
      {header + "1,2,3,4,5,6,7\n", "targets:2:13: too many columns; expected 6, found 7"},
      {header + "0,0,0,1,0,0\n\n1,2,abc,4,5,6\n",
       "targets:4:5: invalid oz; expected a number, found \"abc\""},
      {header + "1,2,3m,4,5,6\n", "targets:2:5: invalid oz"},
      {header + "1,,3,4,5,6\n", "targets:2:3: invalid oy; expected a number, found nothing"},
      {header + "1,2,nan,4,5,6\n", "targets:2:5: oz out of range; expected a finite number, found \"nan\""},
      {header + "1,2,3,4,inf,6\n", "targets:2:9: dy out of range"},
      {header + "1,2,1e999,4,5,6\n", "targets:2:5: oz out of range"},
      {header + "1,2,3,0,-0,0\n", "targets:2:7: direction of the ray is zero"},
      {"ox,oy,oz,dx,dy,dz,t_min\n1,2,3,4,5,6,nan\n", "targets:2:13: t_min out of range"}};
  for (const auto& [text, message] : wrong) {
    const std::string error = rejected("--rays", text);
    EXPECT_TRUE(contains(error, message)) << text << "\n" << error;
  }
}

TEST_F(QueryInputTest, wrong_json_lines_are_rejected_with_line_and_column) {
  const std::string good = "[0, 0, 0, 1, 0, 0]\n";
  const std::pair<std::string, const char*> wrong[] = {
      {"{\"ox\": 1,}\n", "targets:1:10: invalid JSON"},
      {good + "{\"ox\": 1", "targets:2:9: invalid JSON"},
      {good + "\n7\n", "targets:3:1: not a ray; expected an object or an array"},
      {good + "[1, 2, 3]\n", "targets:2:1: not a ray"},
      {good + "[1, 2, 3, 4, 5, 6, 7, 8, 9]\n", "targets:2:1: not a ray"},
      {good + "[1, 2, \"3\", 4, 5, 6]\n", "targets:2:8: invalid oz; expected a number, found \"3\""},
      {good + "[1, 2, null, 4, 5, 6]\n", "targets:2:8: invalid oz"},
      {good + "[1, 2, \"inf\", 4, 5, 6]\n", "targets:2:8: oz out of range"},
      {good + "[1, 2, 3, 0, 0, 0]\n", "targets:2:11: direction of the ray is zero"},
      {good + "{\"origin\": [1, 2], \"direction\": [0, 0, 1]}\n", "targets:2:12: invalid origin"},
      {good + "{\"origin\": [1, 2, 3], \"direktion\": [0, 0, 1]}\n",
       "targets:2:23: unknown key \"direktion\""},
      {good + "{\"origin\": [1, 2, 3]}\n", "targets:2:1: missing value of dx"},
      {good + "{\"origin\": [1, 2, 3], \"oy\": 5}\n", "targets:2:29: duplicate oy"},
      {good + "{\"ox\": 1, \"ox\": 5}\n", "targets:2:11: duplicate key \"ox\""}};
  for (const auto& [text, message] : wrong) {
    const std::string error = rejected("--rays", text);
    EXPECT_TRUE(contains(error, message)) << text << "\n" << error;
  }
}

TEST_F(QueryInputTest, wrong_targets_of_other_kinds_are_rejected) {
  const std::tuple<const char*, std::string, const char*> wrong[] = {
      {"--cones", "ox,oy,oz,dx,dy,dz,half_angle\n0,0,0,1,0,0,90\n", "targets:2:13: half_angle out of range"},
      {"--cones", "ox,oy,oz,dx,dy,dz,half_angle,radius\n0,0,0,1,0,0,9,-1\n",
       "targets:2:15: radius out of range"},
      {"--cones", "ox,oy,oz,dx,dy,dz\n0,0,0,1,0,0\n", "targets:1:18: missing column half_angle"},
      {"--planes", "px,py,pz,nx,ny,nz\n0,0,0,0,0,0\n", "targets:2:7: normal of the region is zero"},
      {"--planes", "px,py,pz,nx,ny,nz,region\n0,0,0,1,0,0,0.5\n", "targets:2:13: region out of range"},
      {"--path", "x,y,z\n1,2,3\n1,2,3\n", "targets:2:1: too few distinct path vertices"},
      {"--path", "x,y,z,path\n1,2,3,1\n1,2,4,1\n5,5,5,0\n",
       "targets:4:1: path numbers are not in ascending order"},
      {"--boxes", "min_x,min_y,min_z,max_x,max_y,max_z\n0,0,0,1,nan,1\n", "targets:2:9: max_y out of range"},
      {"--points", "x,y,z\n0,0,inf\n", "targets:2:5: z out of range"}};
  for (const auto& [option, text, message] : wrong) {
    const std::string error = rejected(option, text);
    EXPECT_TRUE(contains(error, message)) << text << "\n" << error;
  }
}

TEST_F(QueryInputTest, first_bad_line_of_many_is_reported) {
  std::string text = k_header;
  for (int i = 0; i < 20000; ++i) text += i % 5000 == 4999 ? "0,0,0,0,0,0\n" : "0,0,0,1,0,0\n";
  for (const int threads : {1, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    tbb::task_arena arena(threads);
    const std::string error = arena.execute([&] { return rejected("--rays", text); });
    EXPECT_TRUE(contains(error, "targets:5001:7: ")) << error;
  }
}

TEST_F(QueryInputTest, line_without_end_is_rejected) {
  const std::string error = rejected("--rays", std::string(3'000'000, 'x'));
  EXPECT_TRUE(contains(error, "targets:1:1: line too long")) << error;
  const std::string later = rejected("--rays", std::string(k_header) + std::string(3'000'000, '1'));
  EXPECT_TRUE(contains(later, "targets:2:1: line too long")) << later;
}

TEST_F(QueryInputTest, targets_across_blocks_of_the_text_are_read_once) {
  // Lines of all lengths, so that some straddle the ends of blocks.
  std::string text = k_header;
  for (int i = 0; i < 60000; ++i) text += fmt::format("{},0,0,1,0,{:.{}f}\n", -i, 0.0, 1 + i % 40);
  write("targets", text);
  const std::string text_of_answers =
      query("tiny.xyz", {"--rays", "targets", "--radius", "0.1", "--k", "1", "--measure", "t"});
  std::string expected = "ray_id,rank,point_id,x,y,z,t,distance,entry\n";
  for (int i = 0; i < 60000; ++i) expected += fmt::format("{0},0,0,0,0,0,{0},0,{1}\n", i, i - 0.1);
  EXPECT_TRUE(text_of_answers == expected) << text_of_answers.substr(0, 300);
}

TEST_F(QueryInputTest, targets_of_the_command_line_are_quoted_in_errors) {
  const std::pair<Words, const char*> wrong[] = {
      {{"--ray", "1,2,3"},
       "--ray: \"1,2,3\": not a ray; expected ox,oy,oz,dx,dy,dz[,t_min][,t_max], found 3 values"},
      {{"--ray", "0,0,0,1,0,0", "--ray", "0,0,0,1,y,0"}, "--ray: \"0,0,0,1,y,0\": invalid dy"},
      {{"--ray", "0,0,0,0,0,0"}, "direction of the ray is zero"},
      {{"--ray", ""}, "--ray: contains no rays"},
      {{"--line", "0,0,0,0,0,0"}, "--line: \"0,0,0,0,0,0\": direction of the line is zero"},
      {{"--vertex", "1,2,3"}, "--vertex: too few distinct path vertices"},
      {{"--ray", "0,0,0,1,0,0", "--point", "0,0,0"}, "rays and points are different kinds of targets"},
      {{"--point", "0,0,0", "--points", "targets"}, "--points and --point exclude each other"},
      {{}, "missing targets; expected one of --rays, --lines, --cones, --path, --planes, --boxes, --points"},
      {{"--rays", "absent.csv"}, "absent.csv: cannot open the file"},
      {{"--rays", "."}, ".: cannot read the file"}};
  for (const auto& [words, message] : wrong) {
    const std::string error = QueryJob::rejected("tiny.xyz", words);
    EXPECT_TRUE(contains(error, message)) << error;
  }
}

TEST_F(QueryInputTest, conditions_that_mean_nothing_are_rejected) {
  const Words ray = {"--ray", "0,0,0,1,0,0"}, box = {"--box", "0,0,0,1,1,1"},
              cone = {"--cone", "0,0,0,1,0,0,5"}, path = {"--vertex", "0,0,0", "--vertex", "1,0,0"};
  const std::tuple<Words, Words, const char*> wrong[] = {
      {ray, {"--radius", "-1"}, "radius"},
      {ray, {"--radius", "nan"}, "radius"},
      {ray, {"--k", "0"}, "k: invalid value; expected an integer from 1"},
      {ray, {"--k", "-1"}, "k: "},
      {ray, {"--measure", "depth"}, "measure: invalid value; expected distance|t|entry"},
      {ray, {"--measure", "entry"}, "--measure entry requires a radius"},
      {ray, {"--entry-min", "0"}, "--entry-min requires a radius"},
      {ray, {"--class", "2,256"}, "classes: "},
      {ray, {"--class", "2,"}, "classes: "},
      {ray, {"--max-level", "-1"}, "max_level: "},
      {ray, {"--count", "--occluded"}, "count excludes occluded"},
      {ray, {"-o", "out.xyz"}, "out.xyz: unknown output format"},
      {ray, {"--format", "las"}, "LAS output requires a file"},
      {ray, {"--count", "-o", "out.las"}, "out.las: LAS cannot store"},
      {box, {"--radius", "1"}, "--radius does not apply to boxes"},
      {box, {"--measure", "t"}, "--measure does not apply to boxes"},
      {cone, {"--radius", "1"}, "--radius does not apply to cones"},
      {cone, {"--entry-min", "1"}, "--entry-min does not apply to cones"},
      {path, {"--measure", "entry"}, "--measure entry does not apply to paths"},
      {{"--point", "0,0,0"}, {"--t-min", "1"}, "--t-min does not apply to points"}};
  for (const auto& [target, condition, message] : wrong) {
    Words words = target;
    words.insert(words.end(), condition.begin(), condition.end());
    const std::string error = QueryJob::rejected("tiny.xyz", words);
    EXPECT_TRUE(contains(error, message)) << message << "\n" << error;
  }
}

}  // namespace
}  // namespace alidade::test
