// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace alidade {

/// Bytes of the letter that a text begins with: UTF-8 in its shortest form, without halves of UTF-16 and NUL.
/// 0 if it begins with none.
std::size_t utf8_letter_size(std::string_view text);

/// Whether a text is made of such letters.
bool is_utf8(std::string_view text);

/// What a file's name ends in, in small letters: ".csv" of "A.CSV".
inline std::string file_ending(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  for (char& letter : ending) {
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  }
  return ending;
}

}  // namespace alidade
