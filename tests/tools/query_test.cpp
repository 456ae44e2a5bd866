// SPDX-License-Identifier: MIT
// What only the program does with queries (the work: tests/jobs/query_test.cpp): options, streams, signals.
#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <thread>

#include "cloud/read_cloud.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

constexpr const char* k_header = "ox,oy,oz,dx,dy,dz\n";

class QueryProgramTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write("tiny.xyz", "0 0 0\n1 0 0\n2 0.5 0\n3 0 2\n4 0 0\n");
    write("rays.csv", "ox,oy,oz,dx,dy,dz\n-1,0,0,2,0,0\n0,5,0,0,0,1\n4,0,9,0,0,-1\n");
  }

  /// More answers than a pipe holds, on their way into one that is not read yet.
  Program answer_into(const std::filesystem::path& pipe) {
    EXPECT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    std::string boxes = "min_x,min_y,min_z,max_x,max_y,max_z\n";
    for (int i = 0; i < 200000; ++i) boxes += "0,0,0,9,9,9\n";
    write("boxes.csv", boxes);
    return Program({"query", "tiny.xyz", "-q", "--boxes", "boxes.csv"}, folder, pipe);
  }
};

TEST_F(QueryProgramTest, answers_go_to_stdout_or_into_a_file_with_a_note) {
  const ProgramResult shown =
      run({"query", "tiny.xyz", "-q", "--rays", "rays.csv", "--radius=1", "--t-min=-inf", "--k", "2"});
  EXPECT_EQ(shown.exit_code, 0);
  EXPECT_EQ(shown.err, "");
  EXPECT_EQ(shown.out,
            "ray_id,rank,point_id,x,y,z,t,distance,entry\n"
            "0,0,0,0,0,0,1,0,0\n"
            "0,1,1,1,0,0,2,0,1\n"
            "2,0,3,3,0,2,7,1,7\n"
            "2,1,4,4,0,0,9,0,8\n");
  const ProgramResult written = run(
      {"query", "tiny.xyz", "--rays", "rays.csv", "--radius=1", "--t-min=-inf", "--k", "2", "-o", "out.csv"});
  EXPECT_EQ(written.out, "");
  EXPECT_TRUE(contains(written.err, "querying: 3 rays in ")) << written.err;
  EXPECT_TRUE(contains(written.err, "alidade: 4 points found in out.csv\n")) << written.err;
  EXPECT_EQ(read("out.csv"), shown.out);
}

TEST_F(QueryProgramTest, mistakes_are_rejected_before_the_cloud_is_read) {
  const std::pair<Words, const char*> wrong[] = {
      {{"--ray", "0,0,0,1,0,0", "--radius", "nan"}, "--radius: invalid value; expected a number"},
      {{"--ray", "0,0,0,1,0,0", "--count", "--occluded"}, "--occluded"},
      {{"--ray", "0,0,0,1,0,0", "--entry-min", "0"}, "--entry-min requires a radius"},
      {{"--ray", "1,2,3"}, "--ray: \"1,2,3\": not a ray; expected ox,oy,oz,dx,dy,dz"},
      {{"--rays", "absent.csv"}, "absent.csv: cannot open the file"},
      {{"--ray", "0,0,0,1,0,0", "-o", "rays.csv"}, "rays.csv: the file exists"},
      {{}, "missing targets"}};
  write("broken.las", "LASF");
  EXPECT_TRUE(contains(run({"query", "--help"}).out, "(alidade index"));
  for (const auto& [words, message] : wrong) {
    const ProgramResult result = run(with({"query", "broken.las"}, words));
    EXPECT_EQ(result.exit_code, 2) << message;
    EXPECT_TRUE(contains(result.err, message)) << result.err;
    EXPECT_EQ(names(), (Words{"broken.las", "rays.csv", "tiny.xyz"}));
  }
}

TEST_F(QueryProgramTest, standard_input_and_pipes_are_read_like_files) {
  const std::string text = std::string(k_header) + "0,0,0,1,0,0\n3,0,9,0,0,-1\n";
  const Words words = {"query", "tiny.xyz", "-q", "--rays", "-", "--radius", "1", "--count"};
  EXPECT_EQ(run_with_input(words, text).out, "ray_id,count\n0,4\n1,2\n");
  const ProgramResult empty = run_with_input(words, "");
  EXPECT_EQ(empty.exit_code, 2);
  EXPECT_TRUE(contains(empty.err, "standard input:1:1: contains no rays")) << empty.err;

  const std::filesystem::path pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  Program program({"query", "tiny.xyz", "-q", "--rays", "pipe", "--radius", "1", "--count"}, folder);
  write("pipe", text);
  EXPECT_EQ(program.wait().out, "ray_id,count\n0,4\n1,2\n");
}

TEST_F(QueryProgramTest, interrupt_while_waiting_for_targets_ends_with_130) {
  const std::filesystem::path pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  Program program({"query", "tiny.xyz", "-q", "--rays", "-", "--radius", "1", "-o", "out.csv"}, folder, {},
                  pipe);
  {
    // More than the program reads at once, so that it answers and then waits for the rest.
    std::ofstream writer(pipe);
    writer << k_header;
    for (int i = 0; i < 100000; ++i) writer << "0,0,0,1,0,0\n";
    writer.flush();
    const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (names().size() < 4 && std::chrono::steady_clock::now() < limit)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    program.send(SIGINT);
    EXPECT_EQ(program.wait().exit_code, 130);
  }
  EXPECT_EQ(names(), (Words{"pipe", "rays.csv", "tiny.xyz"}));
}

TEST_F(QueryProgramTest, an_index_that_is_cut_below_the_program_ends_it_with_a_message) {
  // The program may end before it has read all that is written to it.
  const auto before = ::signal(SIGPIPE, SIG_IGN);
  ASSERT_EQ(run({"generate", "courtyard", "--points", "100000", "-o", "site.las", "-q"}).exit_code, 0);
  ASSERT_EQ(run({"index", "site.las", "-o", "site.alidade", "-q"}).exit_code, 0);
  for (const std::uintmax_t left : {std::uintmax_t{0}, std::uintmax_t{4096}, std::uintmax_t{300'001}}) {
    std::filesystem::copy_file(folder / "site.alidade", folder / "cut.alidade",
                               std::filesystem::copy_options::overwrite_existing);
    const std::filesystem::path pipe = folder / "pipe";
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    Program program(
        {"query", "cut.alidade", "-q", "--rays", "-", "--radius", "1", "--k", "1", "-o", "out.csv"}, folder,
        {}, pipe);
    {
      std::ofstream writer(pipe);
      writer << k_header;
      const auto write_rays = [&] {
        // More than the program reads at once, so that it answers.
        for (int i = 0; i < 100000; ++i)
          writer << 689980 + i % 40 << "," << 5324980 + i / 40 % 40 << ",700,0,0,-1\n";
        writer.flush();
      };
      write_rays();
      const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(60);
      const auto has_begun = [&] {
        return std::ranges::any_of(names(),
                                   [](const std::string& name) { return name.starts_with(".out.part-"); });
      };
      while (!has_begun() && std::chrono::steady_clock::now() < limit)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      std::filesystem::resize_file(folder / "cut.alidade", left);
      write_rays();
    }
    const ProgramResult result = program.wait();
    EXPECT_EQ(result.exit_code, 2) << result.signal << " " << result.err;
    EXPECT_TRUE(contains(result.err,
                         "cut.alidade: the file became shorter, or its disk failed, while it was in use; "
                         "expected "))
        << result.err;
    std::filesystem::remove(pipe);
    // As after a killed process: no output, and what was begun of it stays until the next run.
    ASSERT_TRUE(names().front().starts_with(".out.part-")) << names().front();
    std::filesystem::remove(folder / names().front());
    EXPECT_EQ(names(), (Words{"cut.alidade", "rays.csv", "site.alidade", "site.las", "tiny.xyz"}));
  }
  ::signal(SIGPIPE, before);
}

TEST_F(QueryProgramTest, answers_do_not_depend_on_threads_or_on_being_explained) {
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

TEST_F(QueryProgramTest, explain_prints_the_work_on_stderr) {
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

TEST_F(QueryProgramTest, las_of_an_index_is_that_of_the_cloud_byte_for_byte) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "5000", "-o", "yard.las", "-q"}).exit_code, 0);
  ASSERT_EQ(run({"index", "yard.las", "-o", "yard.alidade", "-q"}).exit_code, 0);
  const Words box = {"--box", "-inf,-inf,-inf,inf,inf,inf"};
  ASSERT_EQ(run(with({"query", "yard.las", "-q", "-o", "a.las"}, box)).exit_code, 0);
  ASSERT_EQ(run(with({"query", "yard.alidade", "-q", "-o", "b.las"}, box)).exit_code, 0);
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

TEST_F(QueryProgramTest, stdout_without_space_is_an_error) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  const ProgramResult result = run({"query", "tiny.xyz", "-q", "--ray", "-1,0,0,1,0,0"}, "/dev/full");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "standard output: cannot write")) << result.err;
}

TEST_F(QueryProgramTest, reader_that_goes_away_ends_the_program) {
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

TEST_F(QueryProgramTest, interrupt_is_heard_while_a_reader_is_waited_for) {
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

TEST_F(QueryProgramTest, messages_that_nobody_reads_do_not_keep_the_answers_from_being_written) {
  const std::filesystem::path messages = folder / "messages", targets = folder / "targets";
  ASSERT_EQ(::mkfifo(messages.c_str(), 0600), 0);
  ASSERT_EQ(::mkfifo(targets.c_str(), 0600), 0);
  Program program({"query", "tiny.xyz", "--points", "targets", "-o", "out.csv"}, folder, {}, "/dev/null",
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
  EXPECT_EQ(names(), (Words{"messages", "out.csv", "rays.csv", "targets", "tiny.xyz"}));
}

}  // namespace
}  // namespace alidade::test
