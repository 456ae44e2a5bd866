// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/tools/run_program.h"

// Small inputs of a folder that once gave wrong answers in silence: a row for each, with the right answer.

namespace alidade::test {

/// One command; "@" before a word is the folder of the cases.
struct Step {
  Words words;
  const char* output = "";  ///< the file that stdout goes to, if any
};

/// An input, and what the last of some commands prints about it.
struct Case {
  const char* name;  ///< of the input
  std::vector<Step> steps;
  std::vector<std::string> said;      ///< parts of its output and messages
  std::vector<std::string> not_said;  ///< of these none
  int exit_code = 0;
};

inline Step sql(const std::string& file, const std::string& statement) {
  return {{"sql", file, statement, "--csv"}};
}

class CasesTest : public ProgramTest {
 protected:
  void check(const Case& each, const std::filesystem::path& cases) {
    SCOPED_TRACE(each.name);
    ProgramResult last;
    for (const Step& step : each.steps) {
      Words words = step.words;
      for (std::string& word : words)
        if (word.starts_with('@')) word = (cases / word.substr(1)).string();
      const std::string output = step.output;
      last = run(words, output.empty() ? std::filesystem::path() : folder / output);
    }
    EXPECT_EQ(last.exit_code, each.exit_code) << last.err;
    const std::string all = last.out + last.err;
    for (const std::string& part : each.said)
      EXPECT_TRUE(contains(all, part)) << part << "\nis not in\n" << all;
    for (const std::string& part : each.not_said)
      EXPECT_FALSE(contains(all, part)) << part << "\nis in\n" << all;
    for (const std::string& name : names())
      if (name != "wall.xyz") std::filesystem::remove_all(folder / name);
  }
};

}  // namespace alidade::test
