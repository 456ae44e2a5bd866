// SPDX-License-Identifier: MIT
// A cloud in a database is taken wherever cloud files are.
#include <algorithm>

#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

class DatabaseCloudTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    ASSERT_EQ(run({"generate", "courtyard", "--points", "20000", "-o", "yard.las"}).exit_code, 0);
    ASSERT_EQ(run({"sql", "load", "yard.las", "yard.db"}).exit_code, 0);
  }

  std::string done(const Words& words) {
    const ProgramResult result = run(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.out;
  }
};

TEST_F(DatabaseCloudTest, answers_and_images_are_those_of_the_file) {
  const auto query = [&](const std::string& cloud) {
    return done({"query", cloud, "--ray", "690000,5325000,650,0.01,0,-1", "--radius", "3", "--class", "2"});
  };
  const std::string answers = query("yard.las");
  EXPECT_GT(std::ranges::count(answers, '\n'), 10);
  EXPECT_EQ(query("yard.db"), answers);
  EXPECT_EQ(query("yard.db?table=points"), answers);

  // Images contain the name of their cloud, so both get the same name.
  for (const char* const kind : {"las", "db"}) {
    std::filesystem::rename(folder / (std::string("yard.") + kind), folder / "cloud");
    done({"render", "--cloud", "cloud", "--size", "60x40", "--samples", "2", "-o",
          std::string(kind) + ".png"});
    std::filesystem::rename(folder / "cloud", folder / (std::string("yard.") + kind));
  }
  EXPECT_TRUE(read("db.png") == read("las.png"));
  EXPECT_TRUE(contains(done({"info", "yard.db"}), "20000"));
  EXPECT_TRUE(contains(done({"info", "yard.db?table=points"}), "20000"));
}

/// Few chunks are read, and answers are those of the file, by the numbers of its points.
TEST_F(DatabaseCloudTest, queries_read_the_chunks_they_need) {
  write("rays.csv",
        "ox,oy,oz,dx,dy,dz,t_min,t_max\n690000,5325000,650,0.01,0,-1,0,60\n"
        "689960,5325010,602,1,0.2,0,-inf,inf\n690000,5325000,650,0,0,1,0,inf\n");
  const std::vector<Words> questions = {
      {"--rays", "rays.csv", "--radius", "0.8"},
      {"--rays", "rays.csv", "--radius", "0.8", "--k", "3", "--measure", "distance", "--class", "2,6"},
      {"--rays", "rays.csv", "--radius", "0.8", "--count"},
      {"--cone", "690000,5325000,650,0,0,-1,1"},
      {"--box", "690000,5325000,600,690002,5325003,603"},
      {"--plane", "690000,5324950,602,0,-1,0"},
      {"--point", "690001,5325001,601", "--radius", "2", "--k", "4"},
      {"--point", "690001,5325001,601", "--k", "4"}};
  for (const Words& question : questions) {
    const std::string file = done(with({"query", "yard.las", "-q"}, question));
    EXPECT_GT(std::ranges::count(file, '\n'), 2) << question[1];
    EXPECT_EQ(done(with({"query", "yard.db", "-q"}, question)), file) << question[1];
  }
  const ProgramResult explained = run(with({"query", "yard.db", "--explain"}, questions[0]));
  EXPECT_TRUE(contains(explained.err, "chunks")) << explained.err;
  EXPECT_EQ(run(with({"query", "yard.db", "-o", "a.las"}, questions[0])).exit_code, 0);
  EXPECT_EQ(run(with({"query", "yard.las", "-o", "b.las"}, questions[0])).exit_code, 0);
  EXPECT_EQ(done({"info", "a.las", "--json"}).substr(60), done({"info", "b.las", "--json"}).substr(60));

  const Words nowhere = {"--box", "0,0,0,1,1,1", "-o"};
  for (const char* const cloud : {"yard.db", "yard.las"})
    done(with(with({"query", cloud}, nowhere), {std::string(cloud) + ".none.las"}));
  EXPECT_TRUE(read("yard.db.none.las") == read("yard.las.none.las"));
}

/// Where no light comes from elsewhere, the part in view makes the same image.
TEST_F(DatabaseCloudTest, images_of_what_the_camera_sees) {
  write("camera.json",
        R"({"version": 1, "model": "pinhole", "width": 60, "height": 40, "intrinsics": {"horizontal_fov": 40},
    "pose": {"look_at": {"eye": [689975, 5324975, 603], "target": [689985, 5324985, 601]}}})");
  const auto image = [&](const std::string& name, const Words& options) {
    const ProgramResult result = run(with({"render", "--cloud", "yard.db", "--camera", "camera.json",
                                           "--radius", "0.2", "--color", "rgb", "--samples", "4", "-o", name},
                                          options));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.err;
  };
  image("whole.png", {"--mode", "flat"});
  EXPECT_TRUE(contains(image("part.png", {"--mode", "flat", "--in-view"}), "read "));
  const auto pixels = [&](const std::string& name) { return done({"compare", "whole.png", name, "--json"}); };
  EXPECT_TRUE(contains(pixels("part.png"), "\"max_abs\": 0.0")) << pixels("part.png");

  const ProgramResult of_file =
      run({"render", "--cloud", "yard.las", "--camera", "camera.json", "--in-view", "-o", "no.png"});
  EXPECT_EQ(of_file.exit_code, 2);
  EXPECT_TRUE(contains(of_file.err, "--in-view requires a single cloud in a database")) << of_file.err;
}

TEST_F(DatabaseCloudTest, what_is_no_cloud_is_an_error) {
  for (const char* const name : {"yard.db?table=other", "no.db?table=points", "yard.las?table=points"}) {
    const ProgramResult result = run({"info", name});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(contains(result.err, std::string(name).substr(0, 4))) << result.err;
  }
}

}  // namespace
}  // namespace alidade::test
