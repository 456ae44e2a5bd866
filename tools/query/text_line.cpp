// SPDX-License-Identifier: MIT
#include "tools/query/text_line.h"

#include <algorithm>

#include "base/error.h"
#include "base/text_scanner.h"

namespace alidade {

void TextLine::fail(std::size_t offset, std::string problem, std::string expected, std::string found) const {
  const std::string_view before = text.substr(0, std::min(offset, text.size()));
  const auto column = 1 + std::ranges::count_if(
                              before, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; });
  throw Error(
      {.file = std::string(source),
       .place = is_command_line ? " " + quote(text) : std::to_string(number) + ":" + std::to_string(column),
       .problem = std::move(problem),
       .expected = std::move(expected),
       .found = std::move(found)});
}

}  // namespace alidade
