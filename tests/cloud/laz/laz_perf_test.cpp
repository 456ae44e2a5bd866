// SPDX-License-Identifier: MIT
// What is packed here is unpacked by laz-perf, which npm delivers: another program by other people. Skipped
// with a message without node, npm or a network.
#include <gtest/gtest.h>

#include <cstdlib>

#include "cloud/las/las_header.h"
#include "cloud/las/repack_las.h"
#include "cloud/las/write_las.h"
#include "tests/cloud/chosen_points.h"
#include "tests/cloud/las/las_builder.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;
using test::read_bytes;
using test::shared_data;

constexpr const char* k_package = "laz-perf@0.0.7";

/// The folder of laz-perf, fetched on first use into the build; empty if it cannot be had.
fs::path laz_perf_folder() {
  const fs::path folder = fs::path(ALIDADE_BUILD_FOLDER) / "laz_perf";
  const fs::path package = folder / "node_modules" / "laz-perf";
  if (fs::exists(package / "package.json")) return package;
  fs::create_directories(folder);
  const std::string command = "npm install --silent --no-audit --no-fund --prefix '" + folder.string() +
                              "' " + k_package + " > /dev/null 2>&1";
  return std::system(command.c_str()) == 0 && fs::exists(package / "package.json") ? package : fs::path();
}

class LazPerfTest : public ::testing::Test {
 protected:
  void SetUp() override {
    package_ = laz_perf_folder();
    if (package_.empty()) GTEST_SKIP() << "laz-perf cannot be had: node, npm or the network is missing";
    folder_ = test::test_folder();
  }

  /// Expects laz-perf to find the records of LAS files in the LAZ files, `name`.las and `name`.laz.
  void expect_same_records(const std::vector<std::string>& names) const {
    std::string command =
        "node '" ALIDADE_SOURCE_FOLDER "/tests/cloud/laz/laz_perf_records.cjs' '" + package_.string() + "'";
    for (const std::string& name : names)
      command += " '" + file(name + ".laz").string() + "' '" + file(name + ".records").string() + "'";
    ASSERT_EQ(std::system(command.c_str()), 0);
    for (const std::string& name : names) {
      InputFile las(file(name + ".las"));
      std::vector<std::string> warnings;
      const LasHeader header = read_las_header(las, warnings);
      std::vector<std::byte> records(static_cast<std::size_t>(header.points_end() - header.points_offset));
      las.read_at(header.points_offset, records);
      EXPECT_TRUE(records == read_bytes(file(name + ".records"))) << name;
    }
  }

  fs::path file(const std::string& name) const { return folder_ / name; }

  fs::path package_, folder_;
};

TEST_F(LazPerfTest, unpacks_random_points_of_every_format_it_knows) {
  std::vector<std::string> names;
  for (const int format : {0, 1, 2, 3, 6, 7, 8}) {
    // Two formats also fill more than a chunk.
    for (const std::size_t count : {1u, 2u, format == 3 || format == 7 ? 50100u : 700u}) {
      const std::string name = std::to_string(format) + "_" + std::to_string(count);
      test::write_bytes(file(name + ".las"), test::build_las(test::sample_las(4, format, count, count)));
      repack_las(file(name + ".las"), file(name + ".laz"));
      names.push_back(name);
    }
  }
  expect_same_records(names);
}

TEST_F(LazPerfTest, unpacks_what_las_writer_packs) {
  const PointCloud cloud = test::full_cloud(110000, 3000, 1);
  write_las(file("out.las"), cloud);
  write_las(file("out.laz"), cloud);
  expect_same_records({"out"});
}

TEST_F(LazPerfTest, unpacks_every_las_file_that_others_wrote) {
  if (shared_data("lidar").empty()) GTEST_SKIP() << test::absent("../shared/data/lidar", 12);
  std::vector<std::string> names;
  for (const char* const part : {"lidar", "lidar_rgb"}) {
    for (const auto& entry : fs::directory_iterator(shared_data(part))) {
      if (entry.path().extension() != ".las") continue;
      names.push_back(entry.path().stem());
      fs::copy(entry.path(), file(entry.path().filename()));
      repack_las(entry.path(), file(names.back() + ".laz"));
    }
  }
  expect_same_records(names);
}

}  // namespace
}  // namespace alidade
