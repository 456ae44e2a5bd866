// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <filesystem>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "tests/docs/document.h"

// A block ```sh is run, in the order of the page, from the top of a copy of what a reader has after
// `./dev demo`: the sources, what it builds and output/courtyard.las (with fewer points). A block ```sh
// no-run may only hold what cannot be run inside a test. A block ```cpp FILE must be a copy of that file.

namespace alidade::test {
namespace {

namespace fs = std::filesystem;

const fs::path k_repository = ALIDADE_SOURCE_FOLDER;

int run_shell(const std::string& script) {
  const int status = std::system(fmt::format("bash -euo pipefail {}", script).c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

class DocumentsTest : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { document_ = read_document(k_repository, GetParam()); }
  Document document_;
};

/// Lays out the reader's folder.
class ReadersFolder {
 public:
  explicit ReadersFolder(const std::string& name)
      : path_(std::filesystem::temp_directory_path() / ("alidade_reader_" + name)) {
    fs::remove_all(path_);
    fs::create_directories(path_ / "build" / "release");
    fs::create_directories(path_ / "output");
    const fs::path build = ALIDADE_BUILD_FOLDER;
    for (const char* const made :
         {"alidade", "alidade_openimageio.so", "libalidade_sqlite.so", "examples", "postgres", "python"})
      if (fs::exists(build / made)) fs::create_symlink(build / made, path_ / "build" / "release" / made);
    for (const char* const part : {"scenes", "docs", "dev", "tests/support"}) {
      fs::create_directories((path_ / part).parent_path());
      fs::copy(k_repository / part, path_ / part, fs::copy_options::recursive);
    }
  }
  ~ReadersFolder() { fs::remove_all(path_); }
  ReadersFolder(const ReadersFolder&) = delete;
  ReadersFolder& operator=(const ReadersFolder&) = delete;

  int run(const std::string& commands) const {
    const fs::path script = path_ / "commands.sh";
    // Debian's Python comes first: the module is for it.
    std::ofstream(script) << "export PATH=/usr/bin:$PATH\ncd '" << path_.string() << "'\n" << commands;
    return run_shell(fmt::format("'{}'", script.string()));
  }

 private:
  fs::path path_;
};

TEST_P(DocumentsTest, every_shell_block_runs) {
  bool any = false;
  for (const Block& block : document_.blocks) any = any || (block.language == "sh" && block.remark.empty());
  if (!any) return;
  std::string name = GetParam();
  for (char& character : name) character = character == '/' || character == '.' ? '_' : character;
  const ReadersFolder folder(name);
  ASSERT_EQ(folder.run("build/release/alidade generate courtyard --points 1e5 -o output/courtyard.las -q\n"),
            0);
  for (const Block& block : document_.blocks) {
    if (block.language != "sh" || !block.remark.empty()) continue;
    EXPECT_EQ(folder.run(block.text), 0) << GetParam() << ":" << block.line << "\n" << block.text;
  }
}

TEST_P(DocumentsTest, blocks_that_are_not_run_only_fetch_or_call_dev) {
  for (const Block& block : document_.blocks) {
    if (block.language != "sh" || block.remark.empty()) continue;
    EXPECT_EQ(block.remark, "no-run") << GetParam() << ":" << block.line;
    std::istringstream lines(block.text);
    for (std::string line; std::getline(lines, line);) {
      const bool known = line.starts_with("git clone ") || line.starts_with("cd ") ||
                         line.starts_with("./dev ") || line.starts_with("sudo apt-get install ") ||
                         line.starts_with("#") || line.empty();
      EXPECT_TRUE(known) << GetParam() << ":" << block.line << ": " << line;
    }
  }
}

TEST_P(DocumentsTest, every_code_block_is_a_copy_of_a_compiled_example) {
  for (const Block& block : document_.blocks) {
    if (block.language != "cpp") continue;
    std::ifstream stream(k_repository / block.remark);
    ASSERT_TRUE(!block.remark.empty() && stream) << GetParam() << ":" << block.line << " names no file";
    std::ostringstream content;
    content << stream.rdbuf();
    EXPECT_EQ(block.text, content.str()) << GetParam() << ":" << block.line;
  }
}

TEST_P(DocumentsTest, every_link_leads_to_a_file) {
  for (const std::string& link : document_.links) {
    const fs::path target = k_repository / fs::path(GetParam()).parent_path() / link;
    EXPECT_TRUE(fs::exists(target)) << GetParam() << ": " << link;
  }
}

TEST_P(DocumentsTest, every_named_dev_command_exists) {
  for (const Block& block : document_.blocks) {
    std::istringstream lines(block.language == "sh" ? block.text : "");
    for (std::string line; std::getline(lines, line);) {
      if (!line.starts_with("./dev ")) continue;
      const std::string command = line.substr(6, line.find_first_of(" \n", 6) - 6);
      EXPECT_EQ(run_shell(fmt::format("-c '\"{}/dev\" --help | grep -q \"^  {} \"'", k_repository.string(),
                                      command)),
                0)
          << command;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Pages, DocumentsTest, ::testing::ValuesIn(document_names(k_repository)),
                         [](const auto& page) {
                           std::string name = page.param;
                           for (char& character : name)
                             character =
                                 std::isalnum(static_cast<unsigned char>(character)) ? character : '_';
                           return name;
                         });

}  // namespace
}  // namespace alidade::test
