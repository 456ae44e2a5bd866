// SPDX-License-Identifier: MIT
#include "cloud/cloud_files.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "cloud/cloud_inputs.h"
#include "base/error.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 10> k_endings = {"las", "laz", "ply", "pcd", "e57",
                                                        "pts", "ptx", "xyz", "txt", "csv"};

std::string lower_case(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

/// The letters behind the last '.', in lower case.
std::string ending_of(const fs::path& path) {
  const std::string extension = path.extension().string();
  return extension.empty() ? extension : lower_case(extension.substr(1));
}

bool has_cloud_ending(const fs::path& path) {
  return std::ranges::find(k_endings, ending_of(path)) != k_endings.end();
}

bool is_pattern(const std::string& text) {
  return text.find_first_of("*?[") != std::string::npos;
}

/// What a folder holds, sorted. Errors: it cannot be read.
std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code error;
  fs::directory_iterator entry(folder.empty() ? fs::path(".") : folder, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error))
    entries.push_back(folder / entry->path().filename());
  if (error) throw Error({.file = folder.string(), .problem = "cannot be looked into: " + error.message()});
  std::ranges::sort(entries, {}, &fs::path::native);
  return entries;
}

std::vector<fs::path> files_of_folder(const fs::path& folder) {
  const std::vector<fs::path> entries = entries_of(folder);
  std::vector<fs::path> files;
  for (const fs::path& entry : entries) {
    std::error_code error;
    const bool is_hidden = entry.filename().native().starts_with('.');
    if (!is_hidden && has_cloud_ending(entry) && !fs::is_directory(entry, error)) files.push_back(entry);
  }
  if (files.empty()) {
    throw Error({.file = folder.string(),
                 .problem = "the folder holds no cloud files",
                 .expected = fmt::format("names that end in .{}", fmt::join(k_endings, ", .")),
                 .found = entries.empty() ? "nothing" : fmt::format("{} other names", entries.size())});
  }
  return files;
}

/// Whether a last part of a pattern takes this file, which it matches. A link that leads nowhere is a file:
/// who opens it says so.
bool takes(const std::string& part, const fs::path& file) {
  std::error_code error;
  if (fs::is_directory(file, error)) return false;
  if (part.find('.') == std::string::npos) return has_cloud_ending(file);
  return ending_of(file) != "alidade" || ending_of(part) == "alidade";
}

/// What matches a pattern, folders only where its last part is the name of one.
std::vector<fs::path> matches_of(const fs::path& pattern) {
  std::vector<fs::path> found = {fs::path()};
  for (auto part = pattern.begin(); part != pattern.end(); ++part) {
    const std::string text = part->string();
    const bool is_last = std::next(part) == pattern.end();
    std::vector<fs::path> next;
    for (const fs::path& folder : found) {
      std::error_code error;
      if (fs::exists(folder / *part, error)) {
        next.push_back(folder / *part);
        continue;
      }
      // A folder that only some of the matches have is no error.
      if (!is_pattern(text)) continue;
      if (!folder.empty() && !fs::is_directory(folder, error)) continue;
      for (const fs::path& entry : entries_of(folder)) {
        if (fnmatch(text.c_str(), entry.filename().c_str(), FNM_PERIOD | FNM_NOESCAPE) != 0) continue;
        if (is_last ? takes(text, entry) : fs::is_directory(entry, error)) next.push_back(entry);
      }
    }
    found = std::move(next);
  }
  return found;
}

std::vector<fs::path> files_of_pattern(const fs::path& pattern) {
  std::vector<fs::path> files;
  for (const fs::path& match : matches_of(pattern)) {
    std::error_code error;
    if (fs::is_directory(match, error)) {
      std::ranges::move(files_of_folder(match), std::back_inserter(files));
    } else {
      files.push_back(match);
    }
  }
  if (files.empty()) {
    throw Error({.file = pattern.string(),
                 .problem = "no cloud file matches",
                 .expected = "a file, a folder, or a pattern that matches files in it"});
  }
  std::ranges::sort(files, {}, &fs::path::native);
  return files;
}

}  // namespace

std::vector<fs::path> expand_cloud_files(std::span<const fs::path> names) {
  std::vector<fs::path> files;
  for (const fs::path& name : names) {
    if (find_database_named(name.string()) != nullptr) {
      files.push_back(name);
      continue;
    }
    std::error_code error;
    const fs::file_status status = fs::status(name, error);
    std::vector<fs::path> some = fs::is_directory(status)                           ? files_of_folder(name)
                                 : !fs::exists(status) && is_pattern(name.string()) ? files_of_pattern(name)
                                                                                    : std::vector{name};
    std::ranges::move(some, std::back_inserter(files));
  }
  return files;
}

}  // namespace alidade
