// SPDX-License-Identifier: MIT
// Help texts, manual pages and completions, which are made of what commands declare.
#include <algorithm>
#include <filesystem>
#include <sstream>

#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

namespace fs = std::filesystem;

class ManualTest : public ProgramTest {
 protected:
  std::vector<fs::path> written() {
    const ProgramResult result = run({"manual", "share"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder / "share"))
      if (entry.is_regular_file()) files.push_back(entry.path());
    std::ranges::sort(files);
    return files;
  }

  bool is_installed(const std::string& program) {
    return !shell_output("command -v " + program, folder).empty();
  }

  /// The completions that bash offers for the last word of a command line.
  std::string completed(const std::string& words) {
    return shell_output("bash -c 'source share/bash-completion/completions/alidade; COMP_WORDS=(alidade " +
                            words +
                            "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _alidade; echo \"${COMPREPLY[@]}\"'",
                        folder);
  }
};

TEST_F(ManualTest, there_is_a_page_for_every_command_and_a_completion_for_every_shell) {
  const std::vector<fs::path> files = written();
  for (const char* const name :
       {"man/man1/alidade.1", "man/man1/alidade-convert.1", "man/man1/alidade-visibility-raster.1",
        "bash-completion/completions/alidade", "zsh/site-functions/_alidade",
        "fish/vendor_completions.d/alidade.fish"})
    EXPECT_TRUE(std::ranges::find(files, folder / "share" / name) != files.end()) << name;
  EXPECT_EQ(run({"manual", "share"}).exit_code, 2) << "replaced files without --overwrite";
  EXPECT_EQ(run({"manual", "share", "--overwrite"}).exit_code, 0);
}

TEST_F(ManualTest, lines_of_help_have_at_most_100_columns) {
  for (const fs::path& page : written()) {
    if (page.extension() != ".1") continue;
    std::string name = page.stem();
    Words words;
    for (std::stringstream parts(name); std::getline(parts, name, '-');) words.push_back(name);
    // The one command with a hyphen in its name.
    if (words.back() == "plan") words = {"alidade", "sql", "shard-plan"};
    words.erase(words.begin());
    words.push_back("--help");
    std::stringstream help(run(words).out);
    for (std::string line; std::getline(help, line);)
      EXPECT_LE(line.size(), 100u) << page.stem() << ": " << line;
  }
}

TEST_F(ManualTest, pages_have_no_mistake_that_mandoc_finds) {
  const auto files = written();
  if (!is_installed("mandoc")) GTEST_SKIP() << "mandoc of Debian's mandoc is not there";
  EXPECT_EQ(shell_output("{ mandoc -Tlint -Wwarning share/man/man1/*.1; true; }", folder), "");
  const std::string page = shell_output("mandoc -Tutf8 share/man/man1/alidade-convert.1 | col -b", folder);
  EXPECT_TRUE(contains(page, "--reproject SYSTEM|auto")) << page;
}

TEST_F(ManualTest, bash_completes_commands_options_and_choices) {
  written();
  EXPECT_TRUE(contains(completed("vis"), "visibility"));
  EXPECT_TRUE(contains(completed("visibility ra"), "raster"));
  EXPECT_FALSE(contains(completed("visibility ra"), "render"));
  EXPECT_TRUE(contains(completed("visibility raster --obs"), "--observer"));
  EXPECT_EQ(completed("convert --color-depth 1"), "16\n");
  EXPECT_EQ(completed("convert site.l"), "\n");
}

TEST_F(ManualTest, other_shells_read_their_completions) {
  written();
  if (is_installed("zsh"))
    EXPECT_NE(shell_output("zsh -n share/zsh/site-functions/_alidade && echo good", folder), "");
  if (is_installed("fish"))
    EXPECT_NE(
        shell_output("fish --no-execute share/fish/vendor_completions.d/alidade.fish && echo good", folder),
        "");
  const std::string fish = read("share/fish/vendor_completions.d/alidade.fish");
  EXPECT_TRUE(contains(fish, "complete -c alidade -n 'not __fish_seen_subcommand_from info "))
      << fish.substr(0, 400);
  EXPECT_TRUE(contains(fish, "-l color-depth -x -a '8 16'"));
}

}  // namespace
}  // namespace alidade::test
