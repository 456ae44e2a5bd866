// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <array>
#include <limits>

#include "cloud/las/write_las.h"
#include "cloud/read_cloud.h"
#include "octree/build.h"
#include "octree/index_file/save_index.h"
#include "tests/jobs/query_job.h"

namespace alidade::test {
namespace {

/// Five points on integers and halves, so that answers are known by hand:
///
///   z
///   2          3
///   0  0  1  2    4      (2 is at y = 0.5)
///      0  1  2  3  4  x
class QueryTest : public QueryJob {
 protected:
  void SetUp() override {
    QueryJob::SetUp();
    write("tiny.xyz", "0 0 0\n1 0 0\n2 0.5 0\n3 0 2\n4 0 0\n");
    write("rays.csv", "ox,oy,oz,dx,dy,dz\n-1,0,0,2,0,0\n0,5,0,0,0,1\n4,0,9,0,0,-1\n");
  }

  std::string query(const Words& words) { return QueryJob::query("tiny.xyz", words); }
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
    const std::string error = rejected("tiny.xyz", {"--ray", "0,0,0,1,0,0", limit[0], limit[1]});
    std::string name = limit[0].substr(2);
    std::ranges::replace(name, '-', '_');
    EXPECT_TRUE(contains(error, name + ": invalid value; expected a number")) << error;
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
  EXPECT_EQ(
      QueryJob::query("classes.csv", {"--ray", "0,0,0,1,0,0", "--radius", "1", "--class", "2,6", "--count"}),
      "ray_id,count\n0,3\n");
  const std::string error = rejected("tiny.xyz", {"--point", "0,0,0", "--class", "2"});
  EXPECT_TRUE(contains(error, "tiny.xyz: --classes requires classification")) << error;
}

TEST_F(QueryTest, index_file_gives_the_same_answers_as_the_cloud_it_was_made_of) {
  PointCloud cloud = read_cloud(folder / "tiny.xyz");
  save_index(folder / "tiny.alidade", build(cloud), cloud);
  const Words words = {"--ray", "0,1,0.5,0.9,-0.1,0.01", "--k", "4"};
  const std::string answers = query(words);
  EXPECT_EQ(std::ranges::count(answers, '\n'), 5);
  EXPECT_EQ(QueryJob::query("tiny.alidade", words), answers);
}

TEST_F(QueryTest, levels_thin_the_cloud_and_are_made_for_it) {
  std::string square;
  for (int i = 0; i < 400; ++i)
    square += fmt::format("{:.1f} {:.1f} 5.0\n", 100.0 + 0.1 * (i % 20), 200.0 + 0.1 * (i / 20));
  write("square.xyz", square);
  const auto count = [&](Words words) {
    words.insert(words.begin(), {"--box", "0,0,0,999,999,999", "--count"});
    return QueryJob::query("square.xyz", words);
  };
  EXPECT_EQ(count({}), "box_id,count\n0,400\n");
  EXPECT_EQ(count({"--max-level", "0"}), "box_id,count\n0,32\n");
  EXPECT_EQ(count({"--max-level", "20"}), "box_id,count\n0,400\n");
  const PointCloud cloud = read_cloud(folder / "square.xyz");
  for (const Organisation organisation :
       {Organisation::adaptive, Organisation::fixed, Organisation::layered}) {
    save_index(folder / "square.alidade", build(cloud, {.organisation = organisation}), cloud,
               {.overwrite = true});
    const Words words = {"--point", "0,0,0", "--max-level", "1"};
    if (organisation == Organisation::layered) {
      EXPECT_EQ(std::ranges::count(QueryJob::query("square.alidade", words), '\n'), 2);
    } else {
      const std::string error = rejected("square.alidade", words);
      EXPECT_TRUE(contains(error, "square.alidade: --max-level requires a layered index; expected a layered"))
          << error;
    }
  }
}

TEST_F(QueryTest, a_plan_states_the_memory_unless_only_a_part_of_the_cloud_is_held) {
  const Words words = {"--point", "0,0,0", "--k", "1"};
  const auto bytes_per_point = [&](const std::string& cloud) {
    return plan(request(cloud, words)).work().bytes_per_point;
  };
  const PointCloud cloud = read_cloud(folder / "tiny.xyz");
  write_las(folder / "tiny.las", cloud);
  save_index(folder / "tiny.alidade", build(cloud), cloud);
  EXPECT_EQ(bytes_per_point("tiny.las"), 13.0);
  EXPECT_EQ(bytes_per_point("tiny.alidade"), 6.0);
}

TEST_F(QueryTest, work_is_counted_in_all_and_the_answers_are_the_same) {
  const Words words = {"--rays", "rays.csv", "--radius", "1", "--k", "1"};
  Words explained = words;
  explained.push_back("--explain");
  EXPECT_EQ(query(explained), query(words));
  jobs::QueryRequest asked = request("tiny.xyz", explained);
  const jobs::QueryResult result = run(jobs::plan(asked), heard);
  std::vector<std::string> names;
  for (const jobs::WorkCount& one : result.work) names.push_back(one.name);
  EXPECT_EQ(names, (std::vector<std::string>{"rays", "nodes visited", "leaves visited", "points tested",
                                             "pruned by distance", "pruned by interval", "pruned by k",
                                             "rows answered"}));
  // All five points lie in one leaf, which two of three rays come near.
  EXPECT_EQ(result.work[3].count, 10u);
  EXPECT_EQ(result.work[7].count, 2u);
  EXPECT_TRUE(run(jobs::plan(request("tiny.xyz", words)), heard).work.empty());
}

TEST_F(QueryTest, numbers_in_and_rows_out_are_the_answers_of_texts) {
  constexpr double k_none = std::numeric_limits<double>::quiet_NaN();
  const std::array<double, 24> rays = {-1, 0, 0,      2,      0, 0, k_none, k_none, 0, 5,  0,      0,
                                       0,  1, k_none, k_none, 4, 0, 9,      0,      0, -1, k_none, 7.5};
  jobs::QueryRequest asked;
  asked.files = request("tiny.xyz", {}).files;
  asked.given(jobs::TargetFamily::rays).rows = rays;
  asked.radius = 1.0;
  asked.k = 2;
  const jobs::QueryResult result = run(jobs::plan(asked), heard);
  ASSERT_EQ(result.columns.size(), 9u);
  EXPECT_EQ(result.columns[7].name, "distance");
  ASSERT_EQ(result.rows.size(), 3u);
  EXPECT_EQ(result.rows[1].rank, 1u);
  EXPECT_EQ(result.rows[1].point_id, 1u);
  EXPECT_EQ(result.rows[1].position, glm::dvec3(1, 0, 0));
  EXPECT_EQ(result.rows[2].target_id, 2u);
  EXPECT_EQ(result.rows[2].*result.columns[7].real, 1.0);
  asked.count = true;
  EXPECT_EQ(run(jobs::plan(asked), heard).rows.size(), 3u);

  std::array<double, 24> wrong = rays;
  wrong[17] = k_none;
  asked.given(jobs::TargetFamily::rays).rows = wrong;
  try {
    (void)jobs::plan(asked);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()),
              "rays: row 2: missing value of oy; expected ox,oy,oz,dx,dy,dz[,t_min][,t_max]");
  }
  asked.given(jobs::TargetFamily::rays).rows = std::span(rays).first(23);
  EXPECT_THROW((void)jobs::plan(asked), Error);

  asked.given(jobs::TargetFamily::rays).rows = std::span(rays).first(0);
  EXPECT_TRUE(run(jobs::plan(asked), heard).rows.empty());
}

TEST_F(QueryTest, empty_cloud_gives_no_answers) {
  write("empty.ply",
        "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n");
  EXPECT_EQ(QueryJob::query("empty.ply", {"--rays", "rays.csv", "--radius", "1"}),
            "ray_id,rank,point_id,x,y,z,t,distance,entry\n");
  EXPECT_EQ(QueryJob::query("empty.ply", {"--rays", "rays.csv", "--radius", "1", "--count"}),
            "ray_id,count\n0,0\n1,0\n2,0\n");
}

}  // namespace
}  // namespace alidade::test
