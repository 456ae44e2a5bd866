// SPDX-License-Identifier: MIT
#include "compare/pair_list.h"

#include <gtest/gtest.h>
#include <filesystem>

#include <fstream>

#include "base/error.h"

namespace alidade::test {

using namespace compare;

namespace {

namespace fs = std::filesystem;

class PairListTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        std::filesystem::temp_directory_path() /
        ("alidade_pairs_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const std::string& name, const std::string& text = "") const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  std::vector<ImagePair> pairs() const { return pairs_of_folders(folder_ / "a", folder_ / "b"); }
  std::string problem_of_table(const std::string& text) const {
    write("pairs.csv", text);
    try {
      read_pairs(folder_ / "pairs.csv");
    } catch (const Error& error) {
      return error.parts().location + ": " + error.parts().problem;
    }
    return "none";
  }

  fs::path folder_;
};

TEST_F(PairListTest, folders_are_paired_by_path_and_name) {
  for (const char* const name :
       {"a/one.png", "b/one.png", "a/deep/two.exr", "b/deep/two.exr", "a/notes.txt", "b/README"})
    write(name);
  const std::vector<ImagePair> found = pairs();
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].name, "deep/two.exr");
  EXPECT_EQ(found[0].test, folder_ / "b/deep/two.exr");
  EXPECT_EQ(found[1].reference, folder_ / "a/one.png");
}

TEST_F(PairListTest, another_extension_is_no_other_image_if_only_one_can_be_meant) {
  for (const char* const name : {"a/one.exr", "b/one.PNG", "a/two.png", "b/two.jpg", "b/two.exr"})
    write(name);
  const std::vector<ImagePair> found = pairs();
  ASSERT_EQ(found.size(), 4u);
  EXPECT_EQ(found[0].reference, folder_ / "a/one.exr");
  EXPECT_EQ(found[0].test, folder_ / "b/one.PNG");
  for (std::size_t i = 1; i < 4; ++i)
    EXPECT_TRUE(found[i].reference.empty() || found[i].test.empty()) << found[i].name;
}

TEST_F(PairListTest, images_without_counterpart_are_pairs_with_one_side) {
  write("a/gone.png");
  write("b/new.png");
  const std::vector<ImagePair> found = pairs();
  ASSERT_EQ(found.size(), 2u);
  EXPECT_TRUE(found[0].test.empty());
  EXPECT_TRUE(found[1].reference.empty());
}

TEST_F(PairListTest, folders_without_images_and_what_is_no_folder_are_errors) {
  EXPECT_THROW(pairs(), Error);
  write("a/notes.txt");
  write("b/notes.txt");
  EXPECT_THROW(pairs(), Error);
}

TEST_F(PairListTest, tables_keep_their_order_and_name_pairs) {
  write("t/pairs.csv",
        "\xEF\xBB\xBFreference,test,name\r\na.png,b.png,\"first, of \"\"all\"\"\"\r\n\r\n/c.png,d.png,\r\n");
  const std::vector<ImagePair> found = read_pairs(folder_ / "t/pairs.csv");
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].name, "first, of \"all\"");
  EXPECT_EQ(found[0].reference, folder_ / "t/a.png");
  EXPECT_EQ(found[1].name, "d.png");
  EXPECT_EQ(found[1].reference, "/c.png");
}

TEST_F(PairListTest, wrong_lines_are_reported_by_their_number) {
  EXPECT_EQ(problem_of_table("a,b\n"), "line 1: missing header");
  EXPECT_EQ(problem_of_table("reference,test\na.png\n"), "line 2: invalid pair of images");
  EXPECT_EQ(problem_of_table("reference,test\na.png,b.png\n,b.png\n"), "line 3: invalid pair of images");
  EXPECT_EQ(problem_of_table("reference,test\n\"a.png,b.png\n"), "line 2: missing closing quotation mark");
  EXPECT_EQ(problem_of_table("reference,test\n"), ": contains no pairs of images");
  EXPECT_EQ(problem_of_table(""), ": contains no pairs of images");
}

}  // namespace
}  // namespace alidade::test
