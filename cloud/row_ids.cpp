// SPDX-License-Identifier: MIT
#include "cloud/rows.h"

#include <algorithm>

namespace alidade {

RowIds::RowIds(std::span<const CloudFile> files) {
  std::uint64_t row = 0, before = 0;
  for (const CloudFile& file : files) {
    row += file.point_count;
    if (file.skipped_count == 0) continue;
    before += file.skipped_count;
    ++skipped_files_;
    if (!skips_.empty() && skips_.back().row == row) {
      skips_.back().before = before;
    } else {
      skips_.push_back({row, before});
    }
  }
}

std::uint64_t RowIds::operator()(std::uint64_t row) const {
  const auto next =
      std::upper_bound(skips_.begin(), skips_.end(), row,
                       [](std::uint64_t wanted, const Skip& skip) { return wanted < skip.row; });
  return next == skips_.begin() ? row : row + std::prev(next)->before;
}

}  // namespace alidade
