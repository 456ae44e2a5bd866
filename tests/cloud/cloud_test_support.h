// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "cloud/cloud_reader.h"
#include "cloud/read_cloud.h"
#include "cloud/read_in_pieces.h"
#include "tests/support/absent_data.h"

namespace alidade::test {

/// A fresh, empty folder for the running test.
inline std::filesystem::path test_folder() {
  const ::testing::TestInfo* const info = ::testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / "alidade" / info->test_suite_name() / info->name();
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

inline void write_bytes(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  std::ofstream stream(path, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

inline void write_text(const std::filesystem::path& path, const std::string& text) {
  write_bytes(path, std::as_bytes(std::span(text)));
}

inline std::vector<std::byte> read_bytes(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

/// Reads a cloud file in memory like a file named "memory".
inline PointCloud read_memory(std::span<const std::byte> bytes, const ReadOptions& options = {}) {
  return read_cloud(CloudInputs{{cloud_in_memory(bytes, "memory")}}, options);
}

/// The message of the Error that `task` throws; empty (and a failed test) if it throws none.
template <class Task>
std::string error_of(Task task) {
  try {
    task();
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "no Error was thrown";
  return {};
}

/// Whether some warning contains a text.
inline bool warns(const PointCloud& cloud, const std::string& text) {
  for (const std::string& warning : cloud.warnings) {
    if (warning.find(text) != std::string::npos) return true;
  }
  return false;
}

/// Equal bit for bit, NaNs included.
template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

/// The message of a skipped test of one case.
inline const std::string k_no_shared_data = absent("../shared/data");

/// A file of ../shared/data beside the repository. Empty if it is not there: skip the test then with
/// k_no_shared_data, or with absent() and the number of cases.
inline std::filesystem::path shared_data(const std::string& name) {
  const std::filesystem::path path = std::filesystem::path(ALIDADE_SHARED_DATA) / name;
  return std::filesystem::exists(path) ? path : std::filesystem::path();
}

}  // namespace alidade::test
