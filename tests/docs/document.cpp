// SPDX-License-Identifier: MIT
#include "tests/docs/document.h"

#include <algorithm>
#include <fstream>

namespace alidade::test {
namespace {

void add_links(const std::string& line, std::vector<std::string>& links) {
  for (std::size_t begin = line.find("]("); begin != std::string::npos; begin = line.find("](", begin + 2)) {
    const std::size_t end = line.find_first_of("#) ", begin + 2);
    if (end == std::string::npos) return;
    const std::string target = line.substr(begin + 2, end - begin - 2);
    if (!target.empty() && target.find("://") == std::string::npos) links.push_back(target);
  }
}

}  // namespace

Document read_document(const std::filesystem::path& repository, const std::string& name) {
  Document document{.name = name, .blocks = {}, .links = {}};
  std::ifstream stream(repository / name);
  bool in_block = false;
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    if (line.starts_with("```")) {
      in_block = !in_block;
      if (!in_block) continue;
      const std::size_t space = std::min(line.find(' '), line.size());
      document.blocks.push_back({.language = line.substr(3, space - 3),
                                 .remark = space < line.size() ? line.substr(space + 1) : "",
                                 .text = "",
                                 .line = number});
    } else if (in_block) {
      document.blocks.back().text += line + "\n";
    } else {
      add_links(line, document.links);
    }
  }
  return document;
}

std::vector<std::string> document_names(const std::filesystem::path& repository) {
  std::vector<std::string> names = {"README.md", "CONTRIBUTING.md", "CHANGELOG.md"};
  for (const char* const folder : {"docs", "extensions"}) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(repository / folder)) {
      if (entry.path().extension() == ".md")
        names.push_back(entry.path().lexically_relative(repository).string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace alidade::test
