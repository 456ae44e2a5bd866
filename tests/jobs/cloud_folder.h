// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "jobs/clouds/generate.h"
#include "jobs/load_cloud.h"
#include "tests/jobs/heard.h"

namespace alidade::test {

/// A folder with cloud files, for jobs on them.
class CloudFolderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = std::filesystem::temp_directory_path() / ("alidade_clouds_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder);
  }
  void TearDown() override { std::filesystem::remove_all(folder); }

  CloudInputs files(const std::vector<std::string>& names) const {
    std::vector<std::filesystem::path> paths;
    for (const std::string& name : names) paths.push_back(folder / name);
    return resolve_clouds(paths, jobs::cloud_formats());
  }

  /// A request on these files.
  template <class Request>
  Request request(const std::vector<std::string>& names, const std::string& output = {}) const {
    Request made;
    made.files = files(names);
    if constexpr (requires { made.output; })
      if (!output.empty()) made.output = folder / output;
    return made;
  }

  void scan(const std::string& name, std::uint64_t points) {
    jobs::GenerateRequest wanted;
    wanted.point_count = points;
    wanted.output = folder / name;
    run(plan(wanted), heard);
  }

  void write(const std::string& name, const std::string& text) const { std::ofstream(folder / name) << text; }

  std::string read(const std::string& name) const {
    std::ifstream file(folder / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  std::filesystem::path folder;
  Heard heard;
};

}  // namespace alidade::test
