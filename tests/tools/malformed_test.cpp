// SPDX-License-Identifier: MIT
#include <algorithm>

#include "tests/cloud/las/las_builder.h"
#include "tests/support/absent_data.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

class MalformedTest : public ProgramTest {
 protected:
  /// Every file of the folder ends with a result or an error that names it; nothing is left of a failed
  /// image.
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
  if (!data) GTEST_SKIP() << absent("../shared/data/malformed");
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

/// Files of a few megabytes made so that work grows with the square of what they hold; run_program.h ends a
/// program that does that work.
class HostileTest : public ProgramTest {
 protected:
  void write_las(const std::string& name, const LasFile& file) {
    const std::vector<std::byte> bytes = build_las(file);
    write(name, std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  }

  static std::string repeated(const std::string& text, int count) {
    std::string result;
    result.reserve(text.size() * static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) result += text;
    return result;
  }

  /// Runs `alidade info` on these files and expects this exit code.
  ProgramResult expect_exit(int exit_code, std::vector<std::string> files) {
    files.insert(files.begin(), "info");
    const ProgramResult result = run(files);
    EXPECT_EQ(result.signal, 0) << "it took too much processor time, or crashed";
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    return result;
  }
};

TEST_F(HostileTest, a_header_of_nothing_but_fields_is_an_error) {
  constexpr int k_count = 500000;
  for (const std::string& field : {std::string(" a"), std::string(" rgb")}) {
    const int count = field == " a" ? k_count : k_count / 2;
    write("fields.pcd", "VERSION .7\nFIELDS" + repeated(field, count) + "\nSIZE" + repeated(" 4", count) +
                            "\nTYPE" + repeated(" F", count) + "\nWIDTH 0\nDATA ascii\n");
    EXPECT_NE(expect_exit(2, {"fields.pcd"}).err.find("line 2: too many columns"), std::string::npos);
  }
  write("names.csv", "x,y,z" + repeated(",a", k_count) + "\n");
  EXPECT_NE(expect_exit(2, {"names.csv"}).err.find("line 1: too many columns"), std::string::npos);
  write("properties.ply",
        "ply\nformat ascii 1.0\nelement vertex 0\n" + repeated("property int a\n", k_count) + "end_header\n");
  EXPECT_NE(expect_exit(2, {"properties.ply"}).err.find("too many columns"), std::string::npos);
}

TEST_F(HostileTest, sixty_thousand_extra_dimensions_of_one_name_are_read) {
  LasFile file;
  file.version_minor = 4;
  file.point_format = 6;
  file.extra_bytes = 65000;
  file.points = random_las_points(6, 1, file.extra_bytes, 1);
  const std::vector<std::vector<std::uint8_t>> entries(65000, las_extra_bytes_entry(1, 0, "same"));
  file.extended_records = {las_extra_bytes_record(entries)};
  write_las("dimensions.las", file);
  const ProgramResult result = expect_exit(0, {"dimensions.las", "dimensions.las"});
  EXPECT_NE(result.err.find("more than 341 dimensions"), std::string::npos);
}

TEST_F(HostileTest, sixty_thousand_records_in_each_of_five_files_are_joined) {
  LasFile file;
  file.points.resize(1);
  for (int i = 0; i < 60000; ++i) file.records.push_back({"", i, "", {}});
  std::vector<std::string> names;
  for (const char character : {'a', 'b', 'c', 'd', 'e'}) {
    for (LasRecord& record : file.records) record.user_id = character;
    names.push_back(std::string(1, character) + ".las");
    write_las(names.back(), file);
  }
  expect_exit(0, names);
}

}  // namespace
}  // namespace alidade::test
