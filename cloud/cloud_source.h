// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cloud/cloud_reader.h"

namespace alidade {

/// A file of a cloud that waits to be read.
struct CloudSource {
  std::unique_ptr<CloudReader> reader;
  std::uint64_t bytes = 0;  ///< of the file
  std::uint64_t work = 0;   ///< of a pass: the bytes, or CloudReader::work()
  bool has_lattice = false;
  FileFacts facts{};
  CoordinateSurvey survey{};  ///< of files without a lattice
  bool is_skipped = false;    ///< lies outside ReadOptions::region

  const std::filesystem::path& path() const { return reader->file().path; }
  std::uint64_t point_count() const {
    return has_lattice ? reader->point_count().value_or(0) : survey.finite_count;
  }
};

/// The lattice of the joined cloud, by the rules at read_cloud(). Errors: a file does not share it, or lies
/// too far away for it. If most files differ from the first, it is the first that is named as the odd one.
Lattice common_lattice(const std::vector<CloudSource>& sources);

/// The coordinate reference system of the joined cloud: that of the first file that states one. Error: a file
/// with points states a different one (compare_crs()); the one that most files do not share is named.
Crs common_crs(const std::vector<CloudSource>& sources);

}  // namespace alidade
