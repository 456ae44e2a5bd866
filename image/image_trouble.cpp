// SPDX-License-Identifier: MIT
#include "image/image_trouble.h"

#include <algorithm>
#include <sstream>
#include <system_error>
#include <vector>

#include "base/error.h"

namespace alidade {

std::string image_trouble(const std::string& said) {
  std::vector<std::string> lines;
  std::istringstream stream(said);
  for (std::string line; std::getline(stream, line);) {
    line.erase(line.find_last_not_of(" \r\t") + 1);
    const auto holds_line = [&](const std::string& other) { return other.find(line) != std::string::npos; };
    if (std::ranges::any_of(lines, holds_line)) continue;
    std::erase_if(lines, [&](const std::string& other) { return line.find(other) != std::string::npos; });
    lines.push_back(line);
  }
  std::string text;
  for (const std::string& line : lines) text += (text.empty() ? "" : "; ") + line;
  return text.empty() ? "no reason told" : text;
}

std::uint64_t picture_file_size(const std::filesystem::path& file) {
  const auto fail = [&](const char* problem) { throw Error({.file = file.string(), .problem = problem}); };
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) fail("no such file");
  if (!std::filesystem::is_regular_file(status)) fail("not a regular file");
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) fail("cannot be read");
  return size;
}

}  // namespace alidade
