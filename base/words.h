// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

namespace alidade {

/// What a file's name ends in, in small letters: ".csv" of "A.CSV".
inline std::string file_ending(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  for (char& letter : ending) {
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  }
  return ending;
}

}  // namespace alidade
