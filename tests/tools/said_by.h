// SPDX-License-Identifier: MIT
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>

namespace alidade::test {

/// What another program prints to stdout, started by a shell in a folder; empty if it fails or is not there.
inline std::string said_by(const std::string& command, const std::filesystem::path& folder) {
  const std::string line = "cd '" + folder.string() + "' && " + command + " 2> /dev/null";
  std::FILE* const pipe = ::popen(line.c_str(), "r");
  if (pipe == nullptr) return "";
  std::string said;
  char bytes[4096];
  for (std::size_t count = 0; (count = std::fread(bytes, 1, sizeof bytes, pipe)) > 0;)
    said.append(bytes, count);
  return ::pclose(pipe) == 0 ? said : "";
}

}  // namespace alidade::test
