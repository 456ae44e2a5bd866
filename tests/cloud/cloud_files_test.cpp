// SPDX-License-Identifier: MIT
// Folders and patterns as cloud files.
#include "cloud/cloud_inputs.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/las/las_builder.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;
using test::error_of;

class CloudFilesTest : public ::testing::Test {
 protected:
  void SetUp() override { folder_ = test::test_folder(); }

  void make(const std::vector<std::string>& names) const {
    for (const std::string& name : names) {
      fs::create_directories((folder_ / name).parent_path());
      test::write_text(folder_ / name, "x");
    }
  }

  /// The files that names inside the folder expand to, without the folder's own name.
  std::vector<std::string> expand(const std::vector<std::string>& names) const {
    std::vector<fs::path> paths;
    for (const std::string& name : names) paths.push_back(folder_ / name);
    std::vector<std::string> found;
    for (const fs::path& file : resolve_clouds(paths).names())
      found.push_back(file.lexically_relative(folder_));
    return found;
  }

  using Names = std::vector<std::string>;
  fs::path folder_;
};

TEST_F(CloudFilesTest, a_folder_is_the_cloud_files_in_it_sorted_by_bytes) {
  make({"tiles/b.laz", "tiles/a_2.las", "tiles/a_10.las", "tiles/C.PLY", "tiles/d.pcd", "tiles/e.e57",
        "tiles/f.pts", "tiles/g.ptx", "tiles/h.xyz", "tiles/i.txt", "tiles/j.csv"});
  EXPECT_EQ(expand({"tiles"}), (Names{"tiles/C.PLY", "tiles/a_10.las", "tiles/a_2.las", "tiles/b.laz",
                                      "tiles/d.pcd", "tiles/e.e57", "tiles/f.pts", "tiles/g.ptx",
                                      "tiles/h.xyz", "tiles/i.txt", "tiles/j.csv"}));
  EXPECT_EQ(expand({"tiles/"}), expand({"tiles"}));
}

TEST_F(CloudFilesTest, hidden_and_index_files_and_folders_inside_are_left_out_unless_named) {
  make({"tiles/a.las", "tiles/.b.las", "tiles/c.alidade", "tiles/d.md", "tiles/inside/e.las",
        "tiles/folder.las/f.las"});
  EXPECT_EQ(expand({"tiles"}), (Names{"tiles/a.las"}));
  EXPECT_EQ(expand({"tiles/*"}), (Names{"tiles/a.las"}));
  EXPECT_EQ(expand({"tiles/*.*"}), (Names{"tiles/a.las", "tiles/d.md"}));
  EXPECT_EQ(expand({"tiles/.*.las"}), (Names{"tiles/.b.las"}));
  EXPECT_EQ(expand({"tiles/*.alidade"}), (Names{"tiles/c.alidade"}));
  EXPECT_EQ(expand({"tiles/.b.las", "tiles/c.alidade"}), (Names{"tiles/.b.las", "tiles/c.alidade"}));
}

TEST_F(CloudFilesTest, patterns_match_names_of_files_and_folders) {
  make({"2019/a1.las", "2019/a2.las", "2019/b1.laz", "2020/a1.las", "notes/a1.txt"});
  EXPECT_EQ(expand({"2019/a?.las"}), (Names{"2019/a1.las", "2019/a2.las"}));
  EXPECT_EQ(expand({"2019/[!b]*"}), (Names{"2019/a1.las", "2019/a2.las"}));
  EXPECT_EQ(expand({"20*/a[1-1].las"}), (Names{"2019/a1.las", "2020/a1.las"}));
  EXPECT_EQ(expand({"20*/b1.laz"}), (Names{"2019/b1.laz"}));
}

TEST_F(CloudFilesTest, names_keep_the_order_given) {
  make({"b/2.las", "b/1.las", "a.las"});
  EXPECT_EQ(expand({"b", "a.las", "gone.las"}), (Names{"b/1.las", "b/2.las", "a.las", "gone.las"}));
}

TEST_F(CloudFilesTest, a_name_that_is_there_is_no_pattern) {
  make({"a[1].las", "a1.las"});
  EXPECT_EQ(expand({"a[1].las"}), (Names{"a[1].las"}));
}

TEST_F(CloudFilesTest, folders_that_are_there_are_no_patterns_either) {
  make({"site [1]/a1.las", "site [1]/a2.las", "site 1/b.las"});
  EXPECT_EQ(expand({"site [1]/a*.las"}), (Names{"site [1]/a1.las", "site [1]/a2.las"}));
  EXPECT_EQ(expand({"site [1-2]/*.las"}), (Names{"site 1/b.las"}));
}

TEST_F(CloudFilesTest, a_pattern_that_ends_in_the_name_of_a_folder_is_the_files_in_each) {
  make({"2019/tiles/a.las", "2019/tiles/notes.md", "2020/tiles/b.laz", "2021/tiles"});
  EXPECT_EQ(expand({"20[12]?/tiles"}), (Names{"2019/tiles/a.las", "2020/tiles/b.laz", "2021/tiles"}));
  EXPECT_EQ(expand({"20[12]?/tiles/"}), (Names{"2019/tiles/a.las", "2020/tiles/b.laz"}));
  make({"2022/tiles/notes.md"});
  EXPECT_NE(error_of([&] { expand({"20?2/tiles"}); }).find("2022/tiles: the folder contains no cloud files"),
            std::string::npos);
}

TEST_F(CloudFilesTest, links_are_what_they_lead_to_and_an_error_if_that_is_gone) {
  make({"tiles/a.las", "elsewhere/b.las"});
  fs::create_symlink(folder_ / "elsewhere/b.las", folder_ / "tiles/b.las");
  fs::create_directory_symlink(folder_ / "elsewhere", folder_ / "tiles/c.las");
  EXPECT_EQ(expand({"tiles"}), (Names{"tiles/a.las", "tiles/b.las"}));
  fs::remove(folder_ / "elsewhere/b.las");
  for (const char* const name : {"tiles", "tiles/*", "tiles/?.las"})
    EXPECT_EQ(expand({name}), (Names{"tiles/a.las", "tiles/b.las"})) << "who opens it says that it is gone";
}

TEST_F(CloudFilesTest, a_file_that_is_given_twice_is_warned_of) {
  test::LasFile tile;
  tile.points.emplace_back();
  for (const char* const name : {"a.las", "b.las"}) test::write_bytes(folder_ / name, test::build_las(tile));
  const auto warnings = [](const std::vector<fs::path>& names) { return read_cloud(names).warnings; };
  const fs::path a = folder_ / "a.las", b = folder_ / "b.las", link = folder_ / "c.las";
  EXPECT_TRUE(warnings({a, b}).empty());
  const std::string given = ": given more than once; its points are repeated";
  EXPECT_EQ(warnings({a, b, a}), (Names{a.string() + given}));
  EXPECT_EQ(warnings({folder_, folder_ / "*.las", a}), (Names{a.string() + " and 2 more files" + given}));
  fs::create_symlink(a, link);
  EXPECT_EQ(warnings({folder_}), (Names{link.string() + given}));
}

TEST_F(CloudFilesTest, copies_under_other_names_are_warned_of) {
  test::LasFile tile;
  for (int i = 0; i < 1000; ++i) tile.points.push_back({.x = i, .y = 2 * i});
  const auto write = [&](const char* name) { test::write_bytes(folder_ / name, test::build_las(tile)); };
  write("a.las");
  write("b.las");
  tile.points.pop_back();
  write("c.las");
  const std::string copy = (folder_ / "b.las").string() + ": as many points within the same bounds as " +
                           (folder_ / "a.las").string() + "; the points may be repeated";
  EXPECT_EQ(read_cloud(folder_).warnings, Names{copy});
  const fs::path c = folder_ / "c.las";
  const std::vector<fs::path> twice = {folder_, c};
  EXPECT_EQ(read_cloud(twice).warnings,
            (Names{c.string() + ": given more than once; its points are repeated", copy}));
  fs::remove(folder_ / "b.las");
  EXPECT_EQ(read_cloud(folder_).warnings, Names{});
}

TEST_F(CloudFilesTest, nothing_found_is_an_error_that_names_what_was_expected) {
  make({"tiles/readme.md"});
  fs::create_directories(folder_ / "empty");
  const std::string other = error_of([&] { expand({"tiles"}); });
  EXPECT_NE(other.find("tiles: the folder contains no cloud files; expected the extension .las, .laz"),
            std::string::npos)
      << other;
  EXPECT_NE(other.find("found 1 other files"), std::string::npos) << other;
  EXPECT_NE(error_of([&] { expand({"empty"}); }).find("found nothing"), std::string::npos);
  const std::string pattern = error_of([&] { expand({"tiles/*.laz"}); });
  EXPECT_NE(pattern.find("tiles/*.laz: no matching cloud file"), std::string::npos) << pattern;
  EXPECT_NE(error_of([&] { expand({"none/*/x.las"}); }).find("no matching cloud file"), std::string::npos);
}

TEST_F(CloudFilesTest, a_cloud_is_read_from_a_folder_or_a_pattern) {
  for (int i = 0; i < 3; ++i) {
    test::LasFile tile;
    tile.points.emplace_back().x = i;
    test::write_bytes(folder_ / ("tile_" + std::to_string(i) + ".las"), test::build_las(tile));
  }
  for (const fs::path& name : {folder_, folder_ / "tile_*.las"}) {
    const PointCloud cloud = read_cloud(name);
    ASSERT_EQ(cloud.size(), 3u);
    EXPECT_EQ(cloud.positions[2].x, 2);
    EXPECT_EQ(cloud.files[1].path, folder_ / "tile_1.las");
  }
}

}  // namespace
}  // namespace alidade
