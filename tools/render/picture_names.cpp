// SPDX-License-Identifier: MIT
#include "tools/render/picture_names.h"

#include <fmt/format.h>

#include <map>

#include "base/error.h"

namespace alidade {
namespace {

/// A pattern taken apart: text, one field, text.
struct Pattern {
  std::string before, after;
  bool has_field = false, by_name = false;
  std::size_t width = 0;
};

[[noreturn]] void fail(const std::filesystem::path& pattern, const std::string& problem) {
  throw Error(
      {.file = pattern.string(),
       .problem = problem,
       .expected = "one %04d (number) or %s (name) in the name of the pictures, such as out_%04d.png"});
}

Pattern take_apart(const std::filesystem::path& file) {
  constexpr std::size_t k_largest_width = 9;
  Pattern pattern;
  const std::string text = file.string();
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string& part = pattern.has_field ? pattern.after : pattern.before;
    if (text[i] != '%') {
      part += text[i];
    } else if (text.compare(i, 2, "%%") == 0) {
      part += text[++i];
    } else {
      if (pattern.has_field) fail(file, "several numbers or names in one name");
      pattern.has_field = true;
      std::size_t end = i + 1;
      for (; end < text.size() && text[end] >= '0' && text[end] <= '9' && pattern.width <= k_largest_width;
           ++end)
        pattern.width = 10 * pattern.width + static_cast<std::size_t>(text[end] - '0');
      const char kind = end < text.size() ? text[end] : ' ';
      pattern.by_name = kind == 's' && end == i + 1;
      if ((kind != 'd' && !pattern.by_name) || pattern.width > k_largest_width)
        fail(file, "a percent sign that begins neither a number nor a name");
      i = end;
    }
  }
  return pattern;
}

std::string file_name_of(const std::string& name) {
  const std::size_t folder = name.find_last_of('/') + 1, dot = name.find_last_of('.');
  // A dot at the very beginning of a file's name begins no extension.
  const bool has_extension = dot != std::string::npos && dot > folder;
  std::string result = has_extension ? name.substr(0, dot) : name;
  for (char& c : result) {
    const bool fine = static_cast<unsigned char>(c) >= 0x20 && c != '/' && c != '\\' && c != ':' && c != 0x7F;
    if (!fine) c = '_';
  }
  return result;
}

}  // namespace

std::vector<std::filesystem::path> picture_names(const std::filesystem::path& pattern,
                                                 std::span<const View> views) {
  const Pattern parts = take_apart(pattern);
  if (!parts.has_field && views.size() > 1)
    fail(pattern,
         fmt::format("{} cameras, but the name of one picture (--camera-name chooses one)", views.size()));
  std::vector<std::filesystem::path> names;
  std::map<std::filesystem::path, std::string> taken;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const std::string field = !parts.has_field ? ""
                              : parts.by_name  ? file_name_of(views[i].name)
                                               : fmt::format("{:0{}}", i, parts.width);
    names.emplace_back(parts.before + field + parts.after);
    const auto [earlier, is_new] = taken.emplace(names.back(), views[i].name);
    if (!is_new) {
      fail(pattern, fmt::format("cameras '{}' and '{}' would both be {}", earlier->second, views[i].name,
                                names.back().string()));
    }
  }
  return names;
}

}  // namespace alidade
