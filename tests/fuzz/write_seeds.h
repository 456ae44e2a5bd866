// SPDX-License-Identifier: MIT
#pragma once

#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>

namespace alidade::test {

/// Writes each text into a file of its own in `folder`. Returns the exit code for main().
inline int write_seeds(const std::filesystem::path& folder, std::span<const std::string> texts) {
  std::filesystem::create_directories(folder);
  for (std::size_t i = 0; i < texts.size(); ++i) {
    std::ofstream stream(folder / ("seed_" + std::to_string(i)), std::ios::binary);
    stream << texts[i];
    if (!stream) return 1;
  }
  return 0;
}

/// Appends the bytes of a value, little endian.
template <class Value>
void append(std::string& bytes, Value value) {
  char each[sizeof value];
  std::memcpy(each, &value, sizeof value);
  bytes.append(each, sizeof value);
}

}  // namespace alidade::test
