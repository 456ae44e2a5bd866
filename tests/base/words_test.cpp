// SPDX-License-Identifier: MIT
#include "base/words.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <memory>
#include <string>

namespace alidade {
namespace {

/// What a shell prints for `printf %s WORD`.
std::string read_by_shell(const std::string& word) {
  const std::unique_ptr<FILE, decltype(&pclose)> pipe(popen(("printf %s " + word).c_str(), "r"), &pclose);
  std::string text;
  for (int byte = 0; pipe && (byte = std::fgetc(pipe.get())) != EOF;) text += static_cast<char>(byte);
  return text;
}

TEST(ShellWordTest, shells_read_what_was_written) {
  for (const std::string word :
       {"",  "it's",          "'", "''",    "a b",  "$HOME", "`id`", "\\",        "a\nb", "*", "~", "=ls",
        "#", "yard_%04d.png", "!", "{a,b}", "Grün", "-crf",  "a\"b", "<>|&;()[]?"})
    EXPECT_EQ(read_by_shell(shell_word(word)), word);
}

TEST(ShellWordTest, plain_words_stay_plain) {
  for (const std::string word : {"ffmpeg", "-c:v", "/data/yard_1.png", "a,b", "1+1", "me@host"})
    EXPECT_EQ(shell_word(word), word);
}

}  // namespace
}  // namespace alidade
