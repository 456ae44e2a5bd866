// SPDX-License-Identifier: MIT
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "cloud/read_cloud.h"
#include "tests/jobs/query_job.h"

namespace alidade::test {
namespace {

using Json = nlohmann::json;

const ExtraDimension& dimension(const PointCloud& cloud, const std::string& name) {
  for (const ExtraDimension& dimension : cloud.extra_dimensions) {
    if (dimension.name == name) return dimension;
  }
  throw std::runtime_error("no dimension " + name);
}

template <class Value>
std::vector<Value> values(const PointCloud& cloud, const std::string& name) {
  const ExtraDimension& column = dimension(cloud, name);
  std::vector<Value> values(cloud.size());
  EXPECT_EQ(column.values.size(), cloud.size() * sizeof(Value));
  std::memcpy(values.data(), column.values.data(), column.values.size());
  return values;
}

class QueryOutputTest : public QueryJob {
 protected:
  void SetUp() override {
    QueryJob::SetUp();
    write("tiny.csv",
          "x,y,z,intensity,red,green,blue,Depth\n"
          "0,0,0,10,0,0,65535,0.5\n1,0,0,11,1,2,3,1.5\n2,0.5,0,12,4,5,6,2.5\n");
  }
  static inline const Words k_ray = {"--ray", "-1,0,0,1,0,0", "--ray", "2,0,0,0,1,0", "--radius", "0.5"};

  std::string query(Words words, const Words& more, const std::string& cloud = "tiny.csv") {
    words.insert(words.end(), more.begin(), more.end());
    return QueryJob::query(cloud, words);
  }
};

TEST_F(QueryOutputTest, json_lines_have_the_same_values_as_csv) {
  const std::string csv = query({}, k_ray);
  const std::string json = query({"--format", "jsonl"}, k_ray);
  std::istringstream csv_lines(csv), json_lines(json);
  std::string header, csv_line, json_line;
  std::getline(csv_lines, header);
  int rows = 0;
  while (std::getline(csv_lines, csv_line)) {
    ASSERT_TRUE(std::getline(json_lines, json_line));
    const Json row = Json::parse(json_line);
    EXPECT_EQ(row.size(), 9u);
    std::istringstream names(header), cells(csv_line);
    std::string name, cell;
    while (std::getline(names, name, ',')) {
      std::getline(cells, cell, ',');
      EXPECT_EQ(row.at(name).get<double>(), std::stod(cell)) << json_line;
    }
    ++rows;
  }
  EXPECT_EQ(rows, 4);
  EXPECT_FALSE(std::getline(json_lines, json_line));
  EXPECT_EQ(query({"--format", "jsonl"}, {"--ray", "0,0,0,1,0,0"}),
            "{\"ray_id\":0,\"rank\":0,\"point_id\":0,\"x\":0,\"y\":0,\"z\":0,\"t\":0,\"distance\":0,"
            "\"entry\":null}\n");
}

TEST_F(QueryOutputTest, form_depends_on_the_name_of_the_file) {
  EXPECT_EQ(query({"-o", "out.csv"}, k_ray), "");
  EXPECT_EQ(query({"-o", "out.jsonl"}, k_ray), "");
  EXPECT_EQ(query({"-o", "out.las"}, k_ray), "");
  EXPECT_EQ(query({"-o", "out.txt", "--format", "csv"}, k_ray), "");
  EXPECT_EQ(read("out.csv"), query({}, k_ray));
  EXPECT_EQ(read("out.txt"), read("out.csv"));
  EXPECT_EQ(read("out.jsonl").front(), '{');
  EXPECT_EQ(read("out.las").substr(0, 4), "LASF");
}

TEST_F(QueryOutputTest, las_has_the_found_points_with_all_attributes_and_what_was_found) {
  EXPECT_EQ(query({"-o", "hits.las"}, k_ray), "");
  const PointCloud cloud = read_cloud(folder / "tiny.csv"), hits = read_cloud(folder / "hits.las");
  const std::vector<std::size_t> ids = {0, 1, 2, 2};
  ASSERT_EQ(hits.size(), ids.size());
  EXPECT_EQ(hits.lattice, cloud.lattice);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    EXPECT_EQ(hits.positions[i], cloud.positions[ids[i]]);
    EXPECT_EQ(hits.intensities[i], cloud.intensities[ids[i]]);
    EXPECT_EQ(hits.colors[i], cloud.colors[ids[i]]);
  }
  EXPECT_EQ(values<double>(hits, "Depth"), (std::vector<double>{0.5, 1.5, 2.5, 2.5}));
  EXPECT_EQ(values<double>(hits, "Distance"), (std::vector<double>{0.0, 0.0, 0.5, 0.0}));
  EXPECT_EQ(values<double>(hits, "RayT"), (std::vector<double>{1.0, 2.0, 3.0, 0.5}));
  EXPECT_EQ(values<std::uint64_t>(hits, "RayId"), (std::vector<std::uint64_t>{0, 0, 0, 1}));
  EXPECT_EQ(dimension(hits, "Distance").type, ScalarType::float64);
  EXPECT_EQ(dimension(hits, "RayT").type, ScalarType::float64);
  EXPECT_EQ(dimension(hits, "RayId").type, ScalarType::uint64);
}

TEST_F(QueryOutputTest, las_of_a_query_can_be_queried_again) {
  EXPECT_EQ(query({"-o", "hits.las"}, k_ray), "");
  query({"-o", "again.las"}, {"--vertex", "1,0,0", "--vertex", "9,0,0", "--radius", "1"}, "hits.las");
  ASSERT_EQ(heard.warnings.size(), 1u) << heard.text();
  EXPECT_TRUE(contains(heard.warnings[0], "again.las: replacing the cloud's Distance")) << heard.text();
  ASSERT_EQ(heard.notes.size(), 1u) << heard.text();
  EXPECT_TRUE(heard.notes[0].starts_with("4 points found in ")) << heard.text();
  const PointCloud again = read_cloud(folder / "again.las");
  EXPECT_EQ(values<double>(again, "Distance"), (std::vector<double>{1.0, 0.0, 0.5, 0.5}));
  EXPECT_EQ(values<double>(again, "PathT"), (std::vector<double>{0.0, 0.0, 1.0, 1.0}));
  EXPECT_EQ(values<double>(again, "RayT"), (std::vector<double>{1.0, 2.0, 3.0, 0.5}));
  EXPECT_EQ(again.extra_dimensions.size(), 6u);
}

TEST_F(QueryOutputTest, no_answers_are_a_file_without_points) {
  EXPECT_EQ(query({"-o", "none.las"}, {"--box", "7,7,7,8,8,8"}), "");
  EXPECT_EQ(read_cloud(folder / "none.las").size(), 0u);
  EXPECT_EQ(query({"-o", "none.csv"}, {"--box", "7,7,7,8,8,8"}), "");
  EXPECT_EQ(read("none.csv"), "box_id,rank,point_id,x,y,z\n");
}

TEST_F(QueryOutputTest, bad_targets_leave_no_output) {
  std::string rays = "ox,oy,oz,dx,dy,dz\n";
  for (int i = 0; i < 100000; ++i) rays += "-1,0,0,1,0,0\n";
  write("rays.csv", rays + "1,2,3\n");
  for (const char* const name : {"out.csv", "out.las"}) {
    const std::string error = rejected("tiny.csv", {"--rays", "rays.csv", "--radius", "1", "-o", name});
    EXPECT_TRUE(contains(error, "rays.csv:100002:6: too few columns")) << error;
  }
}

TEST_F(QueryOutputTest, answers_far_more_than_targets_stay_complete_and_in_order) {
  // Boxes with one and with all of 20,000 points in turn: the latter are queried again one by one.
  std::string points, boxes = "min_x,min_y,min_z,max_x,max_y,max_z\n",
                      expected = "box_id,rank,point_id,x,y,z\n";
  for (int i = 0; i < 20000; ++i) points += std::to_string(i) + " 0 0\n";
  write("line.xyz", points);
  for (int box = 0; box < 40; ++box) {
    const int last = box % 10 == 3 ? 19999 : 0;
    boxes += "0,0,0," + std::to_string(last) + ",0,0\n";
    for (int i = 0; i <= last; ++i) {
      const std::string id = std::to_string(i);
      expected += std::to_string(box) + "," + id + "," + id + "," + id + ",0,0\n";
    }
  }
  write("boxes.csv", boxes);
  const std::string text = query({"--boxes", "boxes.csv"}, {}, "line.xyz");
  EXPECT_TRUE(text == expected) << text.substr(0, 300);
  const jobs::QueryResult result = run(jobs::plan(request("line.xyz", {"--boxes", "boxes.csv"})), heard);
  EXPECT_EQ(result.rows.size() + 1, static_cast<std::size_t>(std::ranges::count(expected, '\n')));
}

TEST_F(QueryOutputTest, existing_output_is_kept_without_overwrite_and_replaced_with_it) {
  for (const char* const name : {"out.csv", "out.las"}) {
    write(name, "precious");
    Words words = k_ray;
    words.insert(words.end(), {"-o", name});
    const std::string error = rejected("tiny.csv", words);
    EXPECT_TRUE(contains(error, std::string(name) + ": the file exists")) << error;
    EXPECT_EQ(read(name), "precious");
    EXPECT_EQ(query({"--overwrite"}, words), "");
    EXPECT_NE(read(name), "precious");
  }
}

}  // namespace
}  // namespace alidade::test
