// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <iterator>
#include <string>

#include "cloud/las/write_las.h"
#include "jobs/load_cloud.h"
#include "tests/jobs/heard.h"
#include "tests/support/garden.h"
#include "visibility/observers.h"

namespace alidade::test {

/// What jobs on the points of a garden return if nothing is to be written.
class GardenJobTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = std::filesystem::temp_directory_path() / ("alidade_garden_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder);
    write_las(folder / "garden.las", garden(k_metres));
  }
  void TearDown() override { std::filesystem::remove_all(folder); }

  template <class Request>
  Request request() const {
    Request made;
    const std::filesystem::path name = folder / "garden.las";
    made.files = resolve_clouds({&name, 1}, jobs::cloud_formats());
    return made;
  }

  std::size_t file_count() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
  }

  std::filesystem::path folder;
  Heard heard;
};

inline const auto k_before = visibility::parse_observer("690005,5325010,601.7");
inline const auto k_behind = visibility::parse_observer("690015,5325010,601.7");

}  // namespace alidade::test
