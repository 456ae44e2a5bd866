// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "cloud/cloud_inputs.h"

namespace alidade::jobs {

/// What jobs that read clouds are requested with.
struct JobRequest {
  bool partial = false;               ///< damaged files are read in part: ReadOptions::partial
  std::filesystem::path output;       ///< empty: none
  std::optional<std::size_t> memory;  ///< of scratch_beside() the output
  bool overwrite = false;
  std::string command;  ///< the request in words, for the metadata of outputs
};

/// What jobs on one cloud are requested with.
struct CloudRequest : JobRequest {
  CloudInputs files;

  /// The files of the cloud, and other files that are read.
  std::vector<std::filesystem::path> inputs(std::initializer_list<std::filesystem::path> more = {}) const {
    std::vector<std::filesystem::path> all = files.names();
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
};

}  // namespace alidade::jobs
