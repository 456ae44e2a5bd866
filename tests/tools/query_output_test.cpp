// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "cloud/read_cloud.h"
#include "tests/tools/run_program.h"

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

class QueryOutputTest : public ProgramTest {
 protected:
  void write_tiny() {
    write("tiny.csv",
          "x,y,z,intensity,red,green,blue,Depth\n"
          "0,0,0,10,0,0,65535,0.5\n1,0,0,11,1,2,3,1.5\n2,0.5,0,12,4,5,6,2.5\n");
  }
  /// More answers than a pipe holds, on their way into one that is not read yet.
  Program answer_into(const std::filesystem::path& pipe) {
    write_tiny();
    EXPECT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    std::string boxes = "min_x,min_y,min_z,max_x,max_y,max_z\n";
    for (int i = 0; i < 200000; ++i) boxes += "0,0,0,9,9,9\n";
    write("boxes.csv", boxes);
    return Program({"query", "tiny.csv", "-q", "--boxes", "boxes.csv"}, folder, pipe);
  }
  static inline const Words k_ray = {"--ray", "-1,0,0,1,0,0", "--ray", "2,0,0,0,1,0", "--radius", "0.5"};

  ProgramResult query(Words words, const Words& more) {
    words.insert(words.begin(), "query");
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  }
};

TEST_F(QueryOutputTest, json_lines_have_the_same_values_as_csv) {
  write_tiny();
  const std::string csv = query({"tiny.csv", "-q"}, k_ray).out;
  const std::string json = query({"tiny.csv", "-q", "--format", "jsonl"}, k_ray).out;
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
  EXPECT_EQ(query({"tiny.csv", "-q", "--format", "jsonl"}, {"--ray", "0,0,0,1,0,0"}).out,
            "{\"ray_id\":0,\"rank\":0,\"point_id\":0,\"x\":0,\"y\":0,\"z\":0,\"t\":0,\"distance\":0,"
            "\"entry\":null}\n");
}

TEST_F(QueryOutputTest, form_depends_on_the_name_of_the_file) {
  write_tiny();
  EXPECT_EQ(query({"tiny.csv", "-q", "-o", "out.csv"}, k_ray).exit_code, 0);
  EXPECT_EQ(query({"tiny.csv", "-q", "-o", "out.jsonl"}, k_ray).exit_code, 0);
  EXPECT_EQ(query({"tiny.csv", "-q", "-o", "out.las"}, k_ray).exit_code, 0);
  EXPECT_EQ(query({"tiny.csv", "-q", "-o", "out.txt", "--format", "csv"}, k_ray).exit_code, 0);
  EXPECT_EQ(read("out.csv"), query({"tiny.csv", "-q"}, k_ray).out);
  EXPECT_EQ(read("out.txt"), read("out.csv"));
  EXPECT_EQ(read("out.jsonl").front(), '{');
  EXPECT_EQ(read("out.las").substr(0, 4), "LASF");
}

TEST_F(QueryOutputTest, las_has_the_found_points_with_all_attributes_and_what_was_found) {
  write_tiny();
  ASSERT_EQ(query({"tiny.csv", "-q", "-o", "hits.las"}, k_ray).exit_code, 0);
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

TEST_F(QueryOutputTest, las_of_an_index_is_that_of_the_cloud_byte_for_byte) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "5000", "-o", "yard.las", "-q"}).exit_code, 0);
  ASSERT_EQ(run({"index", "yard.las", "-o", "yard.alidade", "-q"}).exit_code, 0);
  const Words box = {"--box", "-inf,-inf,-inf,inf,inf,inf"};
  ASSERT_EQ(query({"yard.las", "-q", "-o", "a.las"}, box).exit_code, 0);
  ASSERT_EQ(query({"yard.alidade", "-q", "-o", "b.las"}, box).exit_code, 0);
  EXPECT_TRUE(read("a.las") == read("b.las"));
  // All points of the site, in its order, with its coordinate reference system.
  const PointCloud yard = read_cloud(folder / "yard.las"), all = read_cloud(folder / "a.las");
  EXPECT_EQ(all.lattice, yard.lattice);
  EXPECT_TRUE(all.positions == yard.positions);
  EXPECT_TRUE(all.colors == yard.colors);
  EXPECT_TRUE(all.gps_times == yard.gps_times);
  EXPECT_TRUE(all.classifications == yard.classifications);
  EXPECT_EQ(all.crs.wkt, yard.crs.wkt);
  EXPECT_EQ(all.gps_time_is_standard, yard.gps_time_is_standard);
}

TEST_F(QueryOutputTest, las_of_a_query_can_be_queried_again) {
  write_tiny();
  ASSERT_EQ(query({"tiny.csv", "-q", "-o", "hits.las"}, k_ray).exit_code, 0);
  const ProgramResult result =
      query({"hits.las", "-o", "again.las"}, {"--vertex", "1,0,0", "--vertex", "9,0,0", "--radius", "1"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(contains(result.err, "again.las: replacing the cloud's Distance")) << result.err;
  const PointCloud again = read_cloud(folder / "again.las");
  EXPECT_EQ(values<double>(again, "Distance"), (std::vector<double>{1.0, 0.0, 0.5, 0.5}));
  EXPECT_EQ(values<double>(again, "PathT"), (std::vector<double>{0.0, 0.0, 1.0, 1.0}));
  EXPECT_EQ(values<double>(again, "RayT"), (std::vector<double>{1.0, 2.0, 3.0, 0.5}));
  EXPECT_EQ(again.extra_dimensions.size(), 6u);
}

TEST_F(QueryOutputTest, no_answers_are_a_file_without_points) {
  write_tiny();
  ASSERT_EQ(query({"tiny.csv", "-q", "-o", "none.las"}, {"--box", "7,7,7,8,8,8"}).exit_code, 0);
  EXPECT_EQ(read_cloud(folder / "none.las").size(), 0u);
  ASSERT_EQ(query({"tiny.csv", "-q", "-o", "none.csv"}, {"--box", "7,7,7,8,8,8"}).exit_code, 0);
  EXPECT_EQ(read("none.csv"), "box_id,rank,point_id,x,y,z\n");
}

TEST_F(QueryOutputTest, existing_output_is_kept_without_overwrite_and_replaced_with_it) {
  write_tiny();
  for (const char* const name : {"out.csv", "out.las"}) {
    write(name, "precious");
    const ProgramResult rejected = query({"absent.las", "-o", name}, k_ray);
    EXPECT_EQ(rejected.exit_code, 2);
    EXPECT_TRUE(contains(rejected.err, std::string(name) + ": the file exists")) << rejected.err;
    EXPECT_EQ(read(name), "precious");
    EXPECT_EQ(query({"tiny.csv", "-q", "--overwrite", "-o", name}, k_ray).exit_code, 0);
    EXPECT_NE(read(name), "precious");
  }
}

TEST_F(QueryOutputTest, bad_targets_leave_no_output) {
  write_tiny();
  std::string rays = "ox,oy,oz,dx,dy,dz\n";
  for (int i = 0; i < 100000; ++i) rays += "-1,0,0,1,0,0\n";
  write("rays.csv", rays + "1,2,3\n");
  for (const char* const name : {"out.csv", "out.las"}) {
    const ProgramResult result =
        run({"query", "tiny.csv", "-q", "--rays", "rays.csv", "--radius", "1", "-o", name});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(contains(result.err, "rays.csv:100002:6: too few columns")) << result.err;
    EXPECT_EQ(names(), (Words{"rays.csv", "tiny.csv"}));
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
  const ProgramResult result = run({"query", "line.xyz", "-q", "--boxes", "boxes.csv"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(result.out == expected) << result.out.substr(0, 300);
}

TEST_F(QueryOutputTest, stdout_without_space_is_an_error) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  write_tiny();
  Words words = {"query", "tiny.csv", "-q"};
  words.insert(words.end(), k_ray.begin(), k_ray.end());
  const ProgramResult result = run(words, "/dev/full");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "standard output: cannot write")) << result.err;
}

TEST_F(QueryOutputTest, reader_that_goes_away_ends_the_program) {
  const std::filesystem::path pipe = folder / "pipe";
  Program program = answer_into(pipe);
  {
    std::ifstream reader(pipe);
    std::string line;
    std::getline(reader, line);
    EXPECT_EQ(line, "box_id,rank,point_id,x,y,z");
  }
  EXPECT_EQ(program.wait().signal, SIGPIPE);
}

TEST_F(QueryOutputTest, interrupt_is_heard_while_a_reader_is_waited_for) {
  const std::filesystem::path pipe = folder / "pipe";
  Program program = answer_into(pipe);
  std::ifstream reader(pipe);
  std::string line;
  std::getline(reader, line);
  EXPECT_EQ(line, "box_id,rank,point_id,x,y,z");
  program.send(SIGINT);
  const auto limit = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (program.running() && std::chrono::steady_clock::now() < limit)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  ASSERT_FALSE(program.running()) << "waits for the reader still";
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, 130) << result.err;
}

TEST_F(QueryOutputTest, messages_that_nobody_reads_do_not_keep_the_answers_from_being_written) {
  write_tiny();
  const std::filesystem::path messages = folder / "messages", targets = folder / "targets";
  ASSERT_EQ(::mkfifo(messages.c_str(), 0600), 0);
  ASSERT_EQ(::mkfifo(targets.c_str(), 0600), 0);
  Program program({"query", "tiny.csv", "--points", "targets", "-o", "out.csv"}, folder, {}, "/dev/null",
                  messages);
  std::ifstream(messages).close();
  // Only now can the program come to its last message.
  int writer = -1;
  while (writer < 0 && program.running()) writer = ::open(targets.c_str(), O_WRONLY | O_NONBLOCK);
  const std::string text = "x,y,z\n1,0,0\n";
  EXPECT_EQ(::write(writer, text.data(), text.size()), static_cast<::ssize_t>(text.size()));
  ::close(writer);
  EXPECT_EQ(program.wait().exit_code, 0);
  EXPECT_EQ(read("out.csv"), "query_id,rank,point_id,x,y,z,distance\n0,0,1,1,0,0,0\n");
  EXPECT_EQ(names(), (Words{"messages", "out.csv", "targets", "tiny.csv"}));
}

}  // namespace
}  // namespace alidade::test
