// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>

#include "tests/tools/run_program.h"

namespace alidade::test {

using nlohmann::json;

/// `alidade compare` on images that the program itself renders, or that are written as text.
class CompareTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_square("square.csv");
  }
  /// An image of the square from above, of so many pixels.
  void render(const std::string& file, const std::string& size = "32x24",
              const std::vector<std::string>& further = {}) {
    std::vector<std::string> words{"render",    "--cloud", "square.csv", "--size", size,
                                   "--samples", "2",       "-q",         "-o",     file};
    words.insert(words.end(), further.begin(), further.end());
    const ProgramResult result = run(words);
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }
  /// Words between single spaces.
  ProgramResult compare(const std::string& words) {
    std::vector<std::string> list{"compare"};
    for (std::size_t begin = 0; begin < words.size();) {
      const std::size_t end = std::min(words.find(' ', begin), words.size());
      list.push_back(words.substr(begin, end - begin));
      begin = end + 1;
    }
    return run(list);
  }
  /// What it prints with --json.
  json found(const std::string& words) {
    const ProgramResult result = compare(words + " --json -q");
    EXPECT_EQ(result.exit_code, 0) << words << ": " << result.err;
    return result.exit_code == 0 ? json::parse(result.out) : json::object();
  }
};

}  // namespace alidade::test
