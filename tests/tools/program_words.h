// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace alidade::test {

/// Of a command line.
using Words = std::vector<std::string>;

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

inline Words with(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

}  // namespace alidade::test
