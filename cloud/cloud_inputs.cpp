// SPDX-License-Identifier: MIT
#include "cloud/cloud_inputs.h"

#include <fmt/format.h>
#include <fnmatch.h>
#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/error.h"
#include "base/words.h"

namespace alidade {
namespace {

std::vector<CloudDatabase>& databases() {
  static std::vector<CloudDatabase> all;
  return all;
}

template <class Condition>
const CloudDatabase* find(const Condition& condition) {
  const auto found = std::ranges::find_if(databases(), condition);
  return found == databases().end() ? nullptr : &*found;
}

}  // namespace

void add_cloud_database(const CloudDatabase& database) {
  databases().push_back(database);
}

const CloudDatabase* find_database_named(const std::string& name) {
  return find([&](const CloudDatabase& database) { return database.is_named(name); });
}

const CloudDatabase* find_database_begun_by(const std::string& bytes) {
  return find([&](const CloudDatabase& database) { return database.is_begun_by(bytes); });
}

bool lies_in_database(const std::filesystem::path& name) {
  if (find_database_named(name.string()) != nullptr) return true;
  std::error_code error;
  if (!std::filesystem::is_regular_file(name, error)) return false;
  constexpr std::size_t k_looked_at = 16;
  InputFile file(name);
  const std::span<const std::byte> bytes = file.view_up_to(0, k_looked_at);
  return find_database_begun_by({reinterpret_cast<const char*>(bytes.data()), bytes.size()}) != nullptr;
}

InputFile cloud_input(const std::filesystem::path& name) {
  if (find_database_named(name.string()) != nullptr)
    return InputFile(std::span<const std::byte>(), name.string());
  return InputFile(name);
}

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

namespace {

constexpr std::size_t k_looked_at = 4096;
constexpr const char* k_supported = "LAS, LAZ, PLY, PCD, E57, PTX, PTS, CSV, XYZ or an index file";

/// The next line without spaces at its ends; `text` keeps what follows.
std::string_view next_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = trim(text.substr(0, end));
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

/// Neither NUL nor any other control character that text does not have.
bool is_text(std::string_view start) {
  return std::none_of(start.begin(), start.end(), [](char c) {
    const unsigned char byte = static_cast<unsigned char>(c);
    return (byte < 0x20 && c != '\t' && c != '\n' && c != '\r' && c != '\f') || byte == 0x7f;
  });
}

/// A PCD header begins with one of its keywords, after comments.
bool is_pcd(std::string_view start) {
  static constexpr std::array<std::string_view, 10> k_keywords = {
      "VERSION", "FIELDS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "POINTS", "VIEWPOINT", "DATA"};
  if (start.starts_with("# .PCD")) return true;
  while (!start.empty()) {
    const std::string_view line = next_line(start);
    if (line.empty() || line.front() == '#') continue;
    const std::string_view word = line.substr(0, line.find_first_of(" \t"));
    return std::find(k_keywords.begin(), k_keywords.end(), word) != k_keywords.end();
  }
  return false;
}

/// How many numbers a line holds; -1 if it holds anything else.
int count_numbers(std::string_view line) {
  if (line.find_first_not_of("0123456789+-.eE \t") != std::string_view::npos) return -1;
  int count = 0;
  for (std::size_t place = 0; (place = line.find_first_not_of(" \t", place)) != std::string_view::npos;
       ++count) {
    place = std::min(line.find_first_of(" \t", place), line.size());
  }
  return count;
}

/// A PTX scan begins with columns, rows, four lines of three numbers (the scanner) and four of four (the
/// transform).
bool is_ptx(std::string_view start) {
  for (const int expected : {1, 1, 3, 3, 3, 3, 4, 4, 4, 4}) {
    if (count_numbers(next_line(start)) != expected) return false;
  }
  return true;
}

}  // namespace

std::unique_ptr<CloudReader> open_cloud(InputFile file, Damage damage) {
  if (const CloudDatabase* const database = find_database_named(file.name()))
    return database->open(file.name());
  const std::span<const std::byte> bytes = file.view_up_to(0, k_looked_at);
  // A copy, because the file is handed on.
  const std::string copy(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::string_view start = copy;
  if (start.empty()) throw Error({.file = file.name(), .problem = "is empty", .expected = k_supported});
  if (start.starts_with("LASF")) return open_las(std::move(file), damage);
  if (start.starts_with(std::string_view("ALIDADE\0", 8))) return open_index_cloud(std::move(file));
  if (start.starts_with("ASTM-E57")) return open_e57(std::move(file));
  if (const CloudDatabase* const database = find_database_begun_by(copy)) return database->open(file.name());
  // Every reader of text skips a byte order mark.
  if (start.starts_with(k_byte_order_mark)) start.remove_prefix(k_byte_order_mark.size());
  if (start.starts_with("ply") && start.size() > 3 && (is_blank(start[3]) || start[3] == '\n')) {
    return open_ply(std::move(file), damage);
  }
  if (is_pcd(start)) return open_pcd(std::move(file), damage);
  if (!is_text(start)) {
    throw Error({.file = file.name(),
                 .problem = "is of no known format",
                 .expected = k_supported,
                 .found = "binary data"});
  }
  if (is_ptx(start)) return open_ptx(std::move(file), damage);
  return open_text(std::move(file), damage);
}

}  // namespace alidade
