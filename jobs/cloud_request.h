// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "cloud/cloud_inputs.h"

namespace alidade::jobs {

/// What all jobs on one cloud are requested with.
struct CloudRequest {
  CloudInputs files;
  bool partial = false;        ///< damaged files are read in part: ReadOptions::partial
  std::optional<int> threads;  ///< empty: as many as the machine has
  std::string command;         ///< the request in words, for the metadata of outputs

  /// The files of the cloud, and other files that are read.
  std::vector<std::filesystem::path> inputs(std::initializer_list<std::filesystem::path> more = {}) const {
    std::vector<std::filesystem::path> all = files.names();
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
};

}  // namespace alidade::jobs
