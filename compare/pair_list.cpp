// SPDX-License-Identifier: MIT
#include "compare/pair_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <map>

#include "base/error.h"
#include "base/words.h"

namespace alidade::compare {
namespace {

namespace fs = std::filesystem;

bool is_image(const fs::path& file) {
  constexpr std::array<std::string_view, 14> k_extensions = {".png",  ".jpg", ".jpeg", ".exr", ".tif",
                                                             ".tiff", ".hdr", ".bmp",  ".tga", ".webp",
                                                             ".gif",  ".ppm", ".pgm",  ".pfm"};
  return std::ranges::find(k_extensions, file_extension(file)) != k_extensions.end();
}

/// Path inside the folder -> file.
std::map<std::string, fs::path> images_in(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error))
    throw Error(
        {.file = folder.string(), .problem = "not a folder", .expected = "two folders or two images"});
  std::map<std::string, fs::path> images;
  try {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
      if (entry.is_regular_file() && is_image(entry.path()))
        images.emplace(entry.path().lexically_relative(folder).generic_string(), entry.path());
  } catch (const fs::filesystem_error& problem) {
    throw Error({.file = folder.string(), .problem = "cannot list the folder: " + problem.code().message()});
  }
  return images;
}

std::string stem_of(const std::string& name) {
  return fs::path(name).replace_extension().generic_string();
}

/// Name without extension -> how many images have it, and the last of those.
struct Stem {
  int count = 0;
  std::string name;
};
std::map<std::string, Stem> stems_of(const std::map<std::string, fs::path>& images) {
  std::map<std::string, Stem> stems;
  for (const auto& [name, file] : images) {
    Stem& stem = stems[stem_of(name)];
    ++stem.count;
    stem.name = name;
  }
  return stems;
}

/// The fields of a line. Errors: a quote that does not end.
std::vector<std::string> fields_of(const std::string& line, const fs::path& file, std::size_t number) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (quoted && line[i] == '"' && line.compare(i, 2, "\"\"") == 0) {
      fields.back() += line[i++];
    } else if (line[i] == '"') {
      quoted = !quoted;
    } else if (line[i] == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += line[i];
    }
  }
  if (quoted) throw Error(file.string(), fmt::format("line {}", number), "missing closing quotation mark");
  return fields;
}

}  // namespace

std::vector<ImagePair> pairs_of_folders(const fs::path& reference, const fs::path& test) {
  std::map<std::string, fs::path> references = images_in(reference), tests = images_in(test);
  std::vector<ImagePair> pairs;
  const auto take = [&](std::map<std::string, fs::path>::iterator first,
                        std::map<std::string, fs::path>::iterator second) {
    pairs.push_back({second->first, first->second, second->second});
    references.erase(first);
    tests.erase(second);
  };
  for (auto next = references.begin(); next != references.end();) {
    const auto first = next++;
    if (const auto second = tests.find(first->first); second != tests.end()) take(first, second);
  }
  const std::map<std::string, Stem> other_stems = stems_of(tests);
  for (const auto& [stem, one] : stems_of(references)) {
    const auto other = other_stems.find(stem);
    if (one.count == 1 && other != other_stems.end() && other->second.count == 1)
      take(references.find(one.name), tests.find(other->second.name));
  }
  for (const auto& [name, file] : references) pairs.push_back({name, file, {}});
  for (const auto& [name, file] : tests) pairs.push_back({name, {}, file});
  if (pairs.empty())
    throw Error(reference.string(), {}, "contains no images", "images in at least one of the folders");
  std::ranges::stable_sort(pairs, {}, &ImagePair::name);
  return pairs;
}

std::vector<ImagePair> read_pairs(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw Error({.file = file.string(), .problem = "cannot read the file"});
  return read_pairs(stream, file);
}

std::vector<ImagePair> read_pairs(std::istream& stream, const fs::path& file) {
  std::vector<ImagePair> pairs;
  std::size_t columns = 0;
  std::string line;
  for (std::size_t number = 1; std::getline(stream, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (number == 1 && line.starts_with(k_byte_order_mark)) line.erase(0, k_byte_order_mark.size());
    if (line.empty()) continue;
    const std::vector<std::string> fields = fields_of(line, file, number);
    if (columns == 0) {
      const bool is_header = fields == std::vector<std::string>{"reference", "test"} ||
                             fields == std::vector<std::string>{"reference", "test", "name"};
      if (!is_header)
        throw Error(file.string(), fmt::format("line {}", number), "missing header",
                    "reference,test or reference,test,name", "'" + line.substr(0, 80) + "'");
      columns = fields.size();
      continue;
    }
    if (fields.size() != columns || fields[0].empty() || fields[1].empty())
      throw Error(file.string(), fmt::format("line {}", number), "invalid pair of images",
                  fmt::format("{} fields with nonempty paths", columns), "'" + line.substr(0, 80) + "'");
    const bool has_name = columns == 3 && !fields[2].empty();
    pairs.push_back(
        {has_name ? fields[2] : fields[1], file.parent_path() / fields[0], file.parent_path() / fields[1]});
  }
  if (stream.bad()) throw Error({.file = file.string(), .problem = "cannot read the file to its end"});
  if (pairs.empty()) throw Error({.file = file.string(), .problem = "contains no pairs of images"});
  return pairs;
}

}  // namespace alidade::compare
