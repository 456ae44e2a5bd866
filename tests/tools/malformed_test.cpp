// SPDX-License-Identifier: MIT
#include <algorithm>

#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

class MalformedTest : public ProgramTest {
 protected:
  /// Every file of the folder ends with a result or an error that names it; nothing is left of a failed
  /// picture.
  void expect_result_or_named_error(const std::filesystem::path& file) {
    for (const std::vector<std::string>& words :
         std::vector<std::vector<std::string>>{{"info", file},
                                               {"info", "--json", file},
                                               {"render", "--cloud", file, "--size", "16x12", "--samples",
                                                "1", "-o", "out.png", "--overwrite"}}) {
      const ProgramResult result = run(words);
      SCOPED_TRACE(words[0] + " " + file.string() + "\n" + result.err);
      EXPECT_EQ(result.signal, 0);
      EXPECT_TRUE(result.exit_code == 0 || result.exit_code == 2) << result.exit_code;
      if (result.exit_code == 2) {
        EXPECT_NE(result.err.find("alidade: error: " + file.string()), std::string::npos);
        EXPECT_EQ(names(), std::vector<std::string>{});
      }
      std::filesystem::remove(folder / "out.png");
    }
  }
};

TEST_F(MalformedTest, every_odd_file_gives_a_result_or_an_error_that_names_it) {
  const auto data = shared_data("malformed");
  if (!data) GTEST_SKIP() << "../shared/data/malformed is not there";
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(*data)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  ASSERT_FALSE(files.empty());
  for (const std::filesystem::path& file : files) expect_result_or_named_error(file);
}

TEST_F(MalformedTest, files_of_other_kinds_give_an_error_that_names_them) {
  const std::string files = folder.string() + "_files";
  std::filesystem::create_directories(files);
  const std::vector<std::pair<std::string, std::string>> contents = {
      {"empty.las", ""},
      {"only_magic.las", "LASF"},
      {"zeros.las", std::string(4096, '\0')},
      {"picture.png", "\x89PNG\r\n\x1a\n" + std::string(100, 'x')},
      {"page.html", "<html><body>1 2 3</body></html>"},
      {"ply_without_end.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"},
      {"ply_promise.ply",
       "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nproperty float "
       "y\nproperty float z\nend_header\n"}};
  for (const auto& [name, content] : contents) {
    write("../" + std::filesystem::path(files).filename().string() + "/" + name, content);
    expect_result_or_named_error(files + "/" + name);
  }
  std::filesystem::remove_all(files);
}

}  // namespace
}  // namespace alidade::test
