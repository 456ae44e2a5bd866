// SPDX-License-Identifier: MIT
// What jobs write does not depend on the memory for points.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <tuple>
#include <utility>

#include "base/error.h"
#include "cloud/read_cloud.h"
#include "jobs/clouds/convert.h"
#include "jobs/clouds/index.h"
#include "jobs/clouds/info.h"
#include "jobs/field_table.h"
#include "tests/jobs/cloud_folder.h"

namespace alidade::extensions {
void set_up_scratch();
}

namespace alidade::test {
namespace {

using Json = nlohmann::ordered_json;
using Names = std::vector<std::string>;
/// Fields with their values; a flag has none.
using Given = std::vector<std::pair<std::string, std::vector<std::string>>>;

class CloudMemoryTest : public CloudFolderTest {
 protected:
  void SetUp() override {
    CloudFolderTest::SetUp();
    extensions::set_up_scratch();
    write("plain.xyz", "690002 5325000.25 601\n690003 5325000.5 602\n");
    write("colored.csv",
          "x,y,z,red,green,blue,height\n690000,5325000,600,1,2,3,0.5\n690001,5325000,600,7,8,9,1.5\n");
  }

  template <class Request>
  auto run_fields(void (*add_fields)(const jobs::Fields&, Request&), const Names& names, const Given& given) {
    Request wanted;
    const auto table = std::make_shared<jobs::FieldTable>("job");
    add_fields(jobs::Fields(table), wanted);
    Names paths;
    for (const std::string& name : names) paths.push_back((folder / name).string());
    table->give("files", paths);
    for (const auto& [name, texts] : given) table->give(name, texts);
    table->read();
    return run(plan(wanted), heard);
  }

  /// Compares what is written with much memory and with little.
  template <class Request>
  void expect_same_bytes(void (*add_fields)(const jobs::Fields&, Request&), const std::string& extension,
                         const Names& names, const Given& given = {}) {
    std::vector<std::uint64_t> points;
    for (const std::string memory : {"whole", "parts"}) {
      Given all = given;
      all.insert(all.end(), {{"overwrite", {}}, {"output", {(folder / (memory + extension)).string()}}});
      if (memory == "parts") all.push_back({"memory", {"1M"}});
      heard.notes.clear();
      points.push_back(run_fields(add_fields, names, all).point_count);
      notes[memory] = heard.text();
    }
    EXPECT_EQ(points[0], points[1]);
    EXPECT_TRUE(read("whole" + extension) == read("parts" + extension)) << extension << " of " << names[0];
  }
  void expect_same_index(const Names& names, const Given& given = {}) {
    expect_same_bytes(&jobs::add_index_fields, ".alidade", names, given);
  }

  std::map<std::string, std::string> notes;  ///< of the last two runs
};

TEST_F(CloudMemoryTest, a_checkpoint_is_among_what_an_index_writes) {
  scan("site.las", 100);
  auto wanted = request<jobs::IndexRequest>({"site.las"}, "site.alidade");
  wanted.checkpoint.file = folder / "kept";
  wanted.memory = std::size_t{1} << 20;
  EXPECT_EQ(plan(wanted).work().writes, (std::vector{wanted.output, wanted.checkpoint.file}));
}

TEST_F(CloudMemoryTest, information_is_the_same) {
  scan("site.laz", 60'000);
  run(plan(request<jobs::IndexRequest>({"site.laz"}, "site.alidade")), heard);
  const auto files = request<jobs::InfoRequest>({"site.laz", "colored.csv"});
  jobs::InfoRequest statistics = files, cropped;
  statistics.stats = true;
  const auto table = std::make_shared<jobs::FieldTable>("info");
  add_info_fields(jobs::Fields(table), cropped);
  table->give("files", {(folder / "site.alidade").string()});
  table->give("crop", {"690000,5325000,690010,5325010"});
  table->give("stats", {});
  table->read();
  for (jobs::InfoRequest wanted : {files, statistics, cropped}) {
    const Json whole = info_json(run(plan(wanted), heard));
    EXPECT_GT(whole.at("points"), 1000);
    EXPECT_EQ(whole.contains("statistics"), wanted.stats);
    wanted.memory = std::size_t{1} << 20;
    EXPECT_EQ(info_json(run(plan(wanted), heard)), whole);
    // The points are in temporary files indeed.
    const char* const given = std::getenv("TMPDIR");
    const std::string before = given ? given : "";
    ::setenv("TMPDIR", "/nonexistent", 1);
    EXPECT_THROW(run(plan(wanted), heard), Error);
    given ? ::setenv("TMPDIR", before.c_str(), 1) : ::unsetenv("TMPDIR");
  }
}

const std::pair<std::string, Names> k_crop{"crop", {"690000,5325000,690010,5325010"}};

TEST_F(CloudMemoryTest, an_index_has_the_same_bytes) {
  scan("site.las", 200'000);
  expect_same_index({"site.las"});
  // Columns that come late and others that end early; 8-bit colours that turn out to be so at the end.
  expect_same_index({"colored.csv", "site.las", "plain.xyz"});
  expect_same_index({"plain.xyz", "colored.csv"});
  expect_same_index({"site.las"}, {k_crop});
  for (const char* const organisation : {"fixed", "layered"})
    expect_same_index({"site.las"}, {{"organisation", {organisation}}});
  expect_same_index({"site.las"}, {{"spacings", {"4"}}});
  expect_same_index({"site.las"}, {{"attributes", {"gps_time,color"}}});
}

TEST_F(CloudMemoryTest, an_index_has_the_same_surfaces) {
  scan("site.las", 60'000);
  expect_same_index({"site.las"}, {{"surfaces", {}}});
}

TEST_F(CloudMemoryTest, an_index_holds_clouds_that_are_sparse_for_their_lattice) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> position(0.0, 1e6);
  std::string text;
  for (int i = 0; i < 150'000; ++i)
    text += fmt::format("{:.3f} {:.3f} {:.3f}\n", position(random), position(random), position(random));
  write("sparse.xyz", text);
  expect_same_index({"sparse.xyz"});
}

TEST_F(CloudMemoryTest, an_index_keeps_all_points_of_repeated_tiles_and_warns) {
  scan("a.las", 2000);
  scan("a.laz", 2000);
  expect_same_index({"a.las", "a.laz", "a.las"});
  const std::string said = notes["parts"];
  EXPECT_NE(said.find("6000 points"), std::string::npos) << said;
  EXPECT_NE(said.find("a.las: given more than once; its points are repeated"), std::string::npos) << said;
  EXPECT_NE(said.find("a.laz: as many points within the same bounds as "), std::string::npos) << said;
}

TEST_F(CloudMemoryTest, converted_clouds_have_the_same_bytes) {
  scan("site.las", 60'000);
  const Names joined = {"site.las", "plain.xyz"}, one = {"site.las"};
  const Given all, every = {{"every", {"7"}}}, cropped = {k_crop};
  const std::tuple<const char*, Names, Given> cases[] = {
      {".las", joined, all},     {".las", one, cropped},     {".las", one, every},
      {".laz", joined, all},     {".laz", one, cropped},     {".copc.laz", joined, all},
      {".copc.laz", one, every}, {".ply", joined, all},      {".ply", one, cropped},
      {".csv", joined, all},     {".csv", one, every},       {".xyz", one, cropped},
      {".alidade", joined, all}, {".alidade", one, cropped},
  };
  for (const auto& [extension, names, given] : cases) {
    expect_same_bytes(&jobs::add_convert_fields, extension, names, given);
    const std::string note = "the points exceed --memory and lie in temporary files in " + folder.string();
    EXPECT_NE(notes["parts"].find(note), std::string::npos) << extension << notes["parts"];
    EXPECT_EQ(notes["whole"].find(note), std::string::npos) << extension;
  }
}

TEST_F(CloudMemoryTest, chosen_points_and_their_normals_have_the_same_bytes) {
  scan("site.las", 135'000);
  write(
      "station.pcd",
      "VERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\n"
      "VIEWPOINT 690000 5325000 590 1 0 0 0\nPOINTS 2\nDATA ascii\n690000 5325000 611\n690001 5325000 611\n");
  const Given thin = {{"spacing", {"0.5"}}}, every = {{"every", {"7"}}},
              normals = {{"spacing", {"1.5"}}, {"normals", {}}};
  const std::pair<const char*, Given> cases[] = {{".las", thin}, {".alidade", every}, {".alidade", normals}};
  for (const auto& [extension, given] : cases) {
    expect_same_bytes(&jobs::add_convert_fields, extension, {"site.las", "station.pcd"}, given);
    EXPECT_NE(notes["parts"].find("lie in temporary files"), std::string::npos) << extension;
    EXPECT_EQ(notes["whole"].find("lie in temporary files"), std::string::npos) << extension;
  }
  const PointCloud cloud = read_cloud(files({"parts.alidade"}));
  const auto downwards =
      std::ranges::count_if(cloud.normals, [](const glm::vec3& normal) { return normal.z < -0.5f; });
  EXPECT_GT(static_cast<std::size_t>(downwards), cloud.size() / 4) << "towards the scanner";
}

}  // namespace
}  // namespace alidade::test
