// SPDX-License-Identifier: MIT
#include "base/words.h"

namespace alidade {
namespace {

/// As its first byte says.
std::size_t stated_size(unsigned char first) {
  return first == 0     ? 0
         : first < 0x80 ? 1
         : first < 0xc2 ? 0
         : first < 0xe0 ? 2
         : first < 0xf0 ? 3
         : first < 0xf5 ? 4
                        : 0;
}

}  // namespace

std::size_t utf8_letter_size(std::string_view text) {
  if (text.empty()) return 0;
  const auto at = [&](std::size_t place) { return static_cast<unsigned char>(text[place]); };
  const std::size_t size = stated_size(at(0));
  if (size == 0 || size > text.size()) return 0;
  for (std::size_t place = 1; place < size; ++place) {
    if ((at(place) & 0xc0) != 0x80) return 0;
  }
  const bool is_long = (at(0) == 0xe0 && at(1) < 0xa0) || (at(0) == 0xf0 && at(1) < 0x90);
  const bool is_no_letter = (at(0) == 0xed && at(1) >= 0xa0) || (at(0) == 0xf4 && at(1) >= 0x90);
  return is_long || is_no_letter ? 0 : size;
}

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t size = utf8_letter_size(text);
    if (size == 0) return false;
    text.remove_prefix(size);
  }
  return true;
}

}  // namespace alidade
