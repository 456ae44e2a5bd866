// SPDX-License-Identifier: MIT
#include <algorithm>

#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

/// Five points on integers and halves, so that answers are known by hand:
///
///   z
///   2          3
///   0  0  1  2    4      (2 is at y = 0.5)
///      0  1  2  3  4  x
class QueryTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write("tiny.xyz", "0 0 0\n1 0 0\n2 0.5 0\n3 0 2\n4 0 0\n");
    write("rays.csv", "ox,oy,oz,dx,dy,dz\n-1,0,0,2,0,0\n0,5,0,0,0,1\n4,0,9,0,0,-1\n");
  }

  /// What `alidade query tiny.xyz WORDS...` writes to stdout.
  std::string query(Words words) {
    words.insert(words.begin(), {"query", "tiny.xyz", "-q"});
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_EQ(result.err, "");
    return result.out;
  }
};

TEST_F(QueryTest, rays_give_the_columns_scripts_rely_on_in_the_order_of_the_rays) {
  EXPECT_EQ(query({"--rays", "rays.csv", "--radius", "1", "--k", "2", "--measure", "entry"}),
            "ray_id,rank,point_id,x,y,z,t,distance,entry\n"
            "0,0,0,0,0,0,1,0,0\n"
            "0,1,1,1,0,0,2,0,1\n"
            "2,0,3,3,0,2,7,1,7\n"
            "2,1,4,4,0,0,9,0,8\n");
}

TEST_F(QueryTest, numbers_have_as_many_digits_as_they_need) {
  EXPECT_EQ(query({"--ray", "2,0.25,0.125,0,0.1,0", "--radius", "0.3", "--measure", "t"}),
            "ray_id,rank,point_id,x,y,z,t,distance,entry\n"
            "0,0,2,2,0.5,0,0.25,0.125,-0.022717802865892867\n");
}

TEST_F(QueryTest, measures_put_answers_into_their_order) {
  const Words ray = {"--ray", "0,0,0,1,0,0", "--radius", "2", "--t-min", "2", "--t-max", "4"};
  const auto ids = [&](const char* measure) {
    Words words = ray;
    words.insert(words.end(), {"--measure", measure});
    std::string order;
    const std::string answer = query(words);
    for (std::size_t line = answer.find('\n') + 1; line < answer.size(); line = answer.find('\n', line) + 1)
      order += answer[line + 4];
    return order;
  };
  EXPECT_EQ(ids("t"), "234");
  EXPECT_EQ(ids("distance"), "423");
  // Entries: 2 - sqrt(3.75), 3 - 0, 4 - 2.
  EXPECT_EQ(ids("entry"), "243");
}

TEST_F(QueryTest, count_and_occluded_give_one_row_for_every_ray) {
  EXPECT_EQ(query({"--rays", "rays.csv", "--radius", "1", "--count"}), "ray_id,count\n0,4\n1,0\n2,2\n");
  EXPECT_EQ(query({"--rays", "rays.csv", "--radius", "1", "--count", "--k", "3"}),
            "ray_id,count\n0,3\n1,0\n2,2\n");
  EXPECT_EQ(query({"--rays", "rays.csv", "--radius", "1", "--occluded"}), "ray_id,occluded\n0,1\n1,0\n2,1\n");
}

TEST_F(QueryTest, ray_without_radius_gives_the_nearest_point) {
  EXPECT_EQ(query({"--ray", "3,0,-5,0,0,1"}),
            "ray_id,rank,point_id,x,y,z,t,distance,entry\n0,0,3,3,0,2,7,0,-inf\n");
}

TEST_F(QueryTest, a_ray_begins_at_its_origin_and_a_line_does_not) {
  // From the point 1 on: it is at t = 0, and 0 lies behind.
  EXPECT_EQ(query({"--ray", "1,0,0,1,0,0", "--radius", "0.25"}),
            "ray_id,rank,point_id,x,y,z,t,distance,entry\n0,0,1,1,0,0,0,0,-0.25\n0,1,4,4,0,0,3,0,2.75\n");
  EXPECT_EQ(query({"--line", "1,0,0,1,0,0", "--radius", "0.25", "--count"}), "ray_id,count\n0,3\n");
  EXPECT_EQ(query({"--line", "1,0,0,1,0,0", "--radius", "0.25"}),
            query({"--ray", "1,0,0,1,0,0,-inf", "--radius", "0.25"}));
  EXPECT_EQ(query({"--line", "1,0,0,1,0,0", "--radius", "0.25", "--t-min", "0"}),
            query({"--ray", "1,0,0,1,0,0", "--radius", "0.25"}));
  // The nearest to the line through (4, 0, 2) is behind, the nearest ahead farther away.
  EXPECT_EQ(query({"--line", "3.5,0,2,1,0,0"}),
            "ray_id,rank,point_id,x,y,z,t,distance,entry\n0,0,3,3,0,2,-0.5,0,-inf\n");
  EXPECT_EQ(query({"--ray", "3.5,0,2,1,0,0"}),
            "ray_id,rank,point_id,x,y,z,t,distance,entry\n0,0,4,4,0,0,0.5,2,-inf\n");
  write("lines.csv", "ox,oy,oz,dx,dy,dz,t_min\n1,0,0,1,0,0,\n1,0,0,1,0,0,2\n");
  EXPECT_EQ(query({"--rays", "lines.csv", "--radius", "0.25", "--count"}), "ray_id,count\n0,2\n1,1\n");
  EXPECT_EQ(query({"--lines", "lines.csv", "--radius", "0.25", "--count"}), "ray_id,count\n0,3\n1,1\n");
  EXPECT_EQ(query({"--line", "3.5,0,2,1,0,0", "--radius", "0.1", "--occluded"}), "ray_id,occluded\n0,1\n");
  EXPECT_EQ(query({"--ray", "3.5,0,2,1,0,0", "--radius", "0.1", "--occluded"}), "ray_id,occluded\n0,0\n");
}

TEST_F(QueryTest, limits_of_a_ray_override_those_of_the_options) {
  write("limited.csv",
        "t_max,ox,oy,oz,dx,dy,dz,t_min\n,0,0,0,1,0,0,\n3,0,0,0,1,0,0,2.5\n-inf,0,0,0,1,0,0,inf\n");
  EXPECT_EQ(query({"--rays", "limited.csv", "--radius", "2", "--t-min", "1", "--count"}),
            "ray_id,count\n0,4\n1,1\n2,0\n");
}

TEST_F(QueryTest, limits_may_be_infinite_on_the_command_line_as_in_a_file) {
  const Words count = {"--rays", "rays.csv", "--count"};
  const auto counts = [&](const Words& limits) {
    Words words = count;
    words.insert(words.end(), limits.begin(), limits.end());
    return query(words);
  };
  const std::string all = "ray_id,count\n0,4\n1,0\n2,2\n", none = "ray_id,count\n0,0\n1,0\n2,0\n";
  EXPECT_EQ(counts({"--radius", "1", "--t-min", "-inf", "--t-max", "inf", "--entry-min", "-inf"}), all);
  EXPECT_EQ(counts({"--radius=1", "--t-min=-inf", "--t-max=inf"}), all);
  EXPECT_EQ(counts({"--radius", "1", "--t-min", "inf"}), none);
  EXPECT_EQ(counts({"--radius", "1", "--t-max", "-inf"}), none);
  EXPECT_EQ(counts({"--radius", "1", "--entry-min", "inf"}), none);
  // An infinite radius does not limit the query: the nearest point.
  EXPECT_EQ(query({"--ray", "3,0,-5,0,0,1", "--radius", "inf"}), query({"--ray", "3,0,-5,0,0,1"}));
  EXPECT_EQ(query({"--point", "3,0,-5", "--radius", "inf"}), query({"--point", "3,0,-5"}));
}

TEST_F(QueryTest, limits_that_are_no_numbers_are_rejected) {
  for (const Words& limit :
       {Words{"--t-min", "nan"}, Words{"--t-max", "1x"}, Words{"--radius", "-inf"}, Words{"--radius", "nan"},
        Words{"--entry-min", "nan"}, Words{"--radius", "-1"}}) {
    Words words = {"query", "tiny.xyz", "--ray", "0,0,0,1,0,0"};
    words.insert(words.end(), limit.begin(), limit.end());
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 2) << limit[1];
    EXPECT_NE(result.err.find(limit[0] + ": invalid value; expected a number"), std::string::npos)
        << result.err;
  }
}

TEST_F(QueryTest, levels_need_a_layered_index) {
  EXPECT_TRUE(contains(run({"query", "--help"}).out, "(alidade index"));
  for (const std::string organisation : {"adaptive", "fixed", "layered"}) {
    const std::string file = organisation + ".alidade";
    ASSERT_EQ(run({"index", "tiny.xyz", "-o", file, "--organisation", organisation, "-q"}).exit_code, 0);
    const ProgramResult result = run({"query", file, "--point", "0,0,0", "--max-level", "0", "-q"});
    EXPECT_EQ(result.exit_code, organisation == "layered" ? 0 : 2) << result.err;
    EXPECT_EQ(contains(result.err, file + ": --max-level requires a layered index; expected a layered index"),
              organisation != "layered")
        << result.err;
  }
}

TEST_F(QueryTest, entry_min_leaves_out_spheres_the_ray_starts_in) {
  EXPECT_EQ(query({"--ray", "0,0,0,1,0,0,0", "--radius", "0.25", "--entry-min", "0", "--count"}),
            "ray_id,count\n0,2\n");
}

TEST_F(QueryTest, cones) {
  // The limit is 1 + t: entries are 2 - sqrt(9) and 3 - sqrt(16 - 4), but for the last bits of tan(45
  // degrees).
  EXPECT_EQ(query({"--cone", "1,0,2,1,0,0,45,1"}),
            "cone_id,rank,point_id,x,y,z,t,distance,entry\n"
            "0,0,3,3,0,2,2,0,-1\n"
            "0,1,4,4,0,0,3,2,-0.46410161513775394\n");
  EXPECT_EQ(query({"--cone", "0,0,0,1,0,0,10", "--count"}), "cone_id,count\n0,3\n");
  EXPECT_EQ(query({"--cone", "0,0,0,1,0,0,10", "--t-min", "1.5", "--occluded"}), "cone_id,occluded\n0,1\n");
}

TEST_F(QueryTest, path_prints_segment_and_way) {
  write("path.csv", "x,y,z,path\n0,0,0,4\n2,0,0,4\n2,2,0,4\n9,9,9,7\n9,9,10,7\n");
  EXPECT_EQ(query({"--path", "path.csv", "--radius", "1"}),
            "path_id,rank,point_id,x,y,z,segment,t,distance\n"
            "4,0,0,0,0,0,0,0,0\n"
            "4,1,1,1,0,0,0,1,0\n"
            "4,2,2,2,0.5,0,1,2.5,0\n");
  EXPECT_EQ(query({"--vertex", "0,0,0", "--vertex", "2,0,0", "--radius", "1", "--t-min", "1", "--count"}),
            "path_id,count\n0,2\n");
}

TEST_F(QueryTest, planes_of_one_number_are_one_region) {
  // The slab 1 <= x <= 3 and, apart from it, all above z = 1.
  write("planes.csv", "px,py,pz,nx,ny,nz,region\n1,0,0,7,0,0,2\n3,0,0,-1,0,0,2\n0,0,1,0,0,1,5\n");
  EXPECT_EQ(query({"--planes", "planes.csv"}),
            "region_id,rank,point_id,x,y,z,distance\n"
            "2,0,1,1,0,0,0\n"
            "2,1,2,2,0.5,0,1\n"
            "2,2,3,3,0,2,2\n"
            "5,0,3,3,0,2,1\n");
  EXPECT_EQ(query({"--plane", "1,0,0,1,0,0", "--plane", "3,0,0,-1,0,0", "--count"}),
            "region_id,count\n0,3\n");
}

TEST_F(QueryTest, boxes_hold_their_faces) {
  EXPECT_EQ(query({"--box", "1,0,0,3,0.5,2", "--box", "3,0,0,1,0.5,2", "--box", "-inf,-1,-1,0,inf,1"}),
            "box_id,rank,point_id,x,y,z\n"
            "0,0,1,1,0,0\n"
            "0,1,2,2,0.5,0\n"
            "0,2,3,3,0,2\n"
            "2,0,0,0,0,0\n");
}

TEST_F(QueryTest, points_have_neighbours) {
  EXPECT_EQ(query({"--point", "0.5,0,0", "--k", "2", "--point", "4,0,0", "--radius", "1"}),
            "query_id,rank,point_id,x,y,z,distance\n"
            "0,0,0,0,0,0,0.5\n"
            "0,1,1,1,0,0,0.5\n"
            "1,0,4,4,0,0,0\n");
  EXPECT_EQ(query({"--point", "9,0,0"}), "query_id,rank,point_id,x,y,z,distance\n0,0,4,4,0,0,5\n");
}

TEST_F(QueryTest, classes_choose_points) {
  write("classes.csv", "x,y,z,classification\n0,0,0,2\n1,0,0,5\n2,0,0,6\n3,0,0,2\n");
  const ProgramResult result = run(
      {"query", "classes.csv", "-q", "--ray", "0,0,0,1,0,0", "--radius", "1", "--class", "2,6", "--count"});
  EXPECT_EQ(result.out, "ray_id,count\n0,3\n") << result.err;
  const ProgramResult without = run({"query", "tiny.xyz", "--point", "0,0,0", "--class", "2"});
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_TRUE(contains(without.err, "tiny.xyz: --classes requires classification")) << without.err;
}

TEST_F(QueryTest, index_file_gives_the_same_answers_as_the_cloud_it_was_made_of) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "20000", "-o", "yard.las", "-q"}).exit_code, 0);
  ASSERT_EQ(run({"index", "yard.las", "-o", "yard.alidade", "-q"}).exit_code, 0);
  const Words conditions = {"--ray", "690000,5325000,601,0.3,0.4,-0.01", "--k", "50", "-q"};
  std::string answers[2];
  for (const char* const cloud : {"yard.las", "yard.alidade"}) {
    Words words = {"query", cloud};
    words.insert(words.end(), conditions.begin(), conditions.end());
    answers[cloud[5] == 'a'] = run(words).out;
  }
  EXPECT_EQ(std::count(answers[0].begin(), answers[0].end(), '\n'), 51);
  EXPECT_EQ(answers[0], answers[1]);
}

TEST_F(QueryTest, levels_thin_the_cloud_and_are_made_for_it) {
  write_square("square.xyz");
  const auto count = [&](Words words) {
    words.insert(words.begin(), {"query", "square.xyz", "-q", "--box", "0,0,0,999,999,999", "--count"});
    return run(words).out;
  };
  EXPECT_EQ(count({}), "box_id,count\n0,400\n");
  EXPECT_EQ(count({"--max-level", "0"}), "box_id,count\n0,32\n");
  EXPECT_EQ(count({"--max-level", "20"}), "box_id,count\n0,400\n");
  ASSERT_EQ(run({"index", "square.xyz", "-o", "square.alidade", "-q"}).exit_code, 0);
  const ProgramResult result = run({"query", "square.alidade", "--point", "0,0,0", "--max-level", "1"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "square.alidade: --max-level requires a layered index")) << result.err;
}

TEST_F(QueryTest, answers_do_not_depend_on_threads_or_on_being_explained) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "20000", "-o", "yard.las", "-q"}).exit_code, 0);
  std::string rays = "ox,oy,oz,dx,dy,dz\n";
  for (int i = 0; i < 3000; ++i)
    rays +=
        "690000,5325000,602," + std::to_string(i % 60 - 30) + "," + std::to_string(i / 60 - 25) + ".5,-3\n";
  write("many.csv", rays);
  const Words words = {"query", "yard.las", "--rays", "many.csv", "--radius", "0.4", "-q"};
  std::vector<std::string> answers;
  for (const Words& more : {Words{"--threads", "1"}, Words{"--threads", "5"}, Words{"--explain"}}) {
    Words all = words;
    all.insert(all.end(), more.begin(), more.end());
    answers.push_back(run(all).out);
  }
  EXPECT_GT(std::count(answers[0].begin(), answers[0].end(), '\n'), 3000);
  EXPECT_EQ(answers[1], answers[0]);
  EXPECT_EQ(answers[2], answers[0]);
}

TEST_F(QueryTest, explain_prints_the_work_on_stderr) {
  const ProgramResult result =
      run({"query", "tiny.xyz", "-q", "--rays", "rays.csv", "--radius", "1", "--k", "1", "--explain"});
  EXPECT_EQ(result.exit_code, 0);
  for (const char* const name : {"in all", "per ray", "nodes visited", "leaves visited", "points tested",
                                 "pruned by distance", "pruned by interval", "pruned by k"}) {
    EXPECT_TRUE(contains(result.err, name)) << name << " in\n" << result.err;
  }
  // All five points lie in one leaf, which two of three rays come near.
  EXPECT_TRUE(contains(result.err, "points tested                       10            3.33")) << result.err;
}

TEST_F(QueryTest, empty_cloud_gives_no_answers) {
  write("empty.ply",
        "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n");
  EXPECT_EQ(run({"query", "empty.ply", "-q", "--rays", "rays.csv", "--radius", "1"}).out,
            "ray_id,rank,point_id,x,y,z,t,distance,entry\n");
  EXPECT_EQ(run({"query", "empty.ply", "-q", "--rays", "rays.csv", "--radius", "1", "--count"}).out,
            "ray_id,count\n0,0\n1,0\n2,0\n");
}

}  // namespace
}  // namespace alidade::test
