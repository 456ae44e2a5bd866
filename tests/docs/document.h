// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace alidade::test {

/// A fenced block of a Markdown document.
struct Block {
  std::string language;  ///< first word behind the fence
  std::string remark;    ///< what follows it: "no-run", or the path of the file the block is a copy of
  std::string text;      ///< with the newline of its last line
  int line = 0;          ///< of the opening fence, from 1
};

/// A page of the documentation.
struct Document {
  std::string name;  ///< path below the repository
  std::vector<Block> blocks;
  std::vector<std::string>
      links;  ///< targets of links and images that are no addresses, without their #anchor
};

Document read_document(const std::filesystem::path& repository, const std::string& name);

/// README, CONTRIBUTING, CHANGELOG and all pages of docs/ and extensions/ and their folders.
std::vector<std::string> document_names(const std::filesystem::path& repository);

}  // namespace alidade::test
