// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cloud/point_cloud.h"

namespace alidade {

/// Point ids of the whole cloud for the rows of one that was read without the files outside a region
/// (ReadOptions::region): what the rows would be had these been read too. Order stays.
class RowIds {
 public:
  /// `files` are PointCloud::files.
  explicit RowIds(std::span<const CloudFile> files);

  /// Cost: that of a search among the skipped files; none if there are none.
  std::uint64_t operator()(std::uint64_t row) const;

  std::size_t skipped_files() const { return skipped_files_; }

 private:
  struct Skip {
    std::uint64_t row;     ///< the first behind it
    std::uint64_t before;  ///< points skipped up to there
  };
  std::vector<Skip> skips_;
  std::size_t skipped_files_ = 0;
};

}  // namespace alidade
