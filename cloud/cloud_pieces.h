// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "cloud/point_cloud.h"

namespace alidade {

/// How points are handed over while a cloud is read that memory does not hold, fewer than 2^32 at a time. As
/// it stands: not at all, they all stay in the cloud.
struct CloudPieces {
  std::uint64_t most_bytes = UINT64_MAX;  ///< of the points of a piece, and of what they need beside
  std::uint64_t bytes_beside = 0;         ///< per point, for what `take` makes of them
  /// Takes the points of a cloud, all or some of a file's or of several; it must leave none, and the extra
  /// dimensions without values. Nothing else of the cloud may change.
  std::function<void(PointCloud&)> take{};
};

/// For how many of `wanted` further points, with these attributes beside those of the cloud, a piece has
/// room, which is handed over first if it has none; 1 or more, unless `wanted` is 0.
std::size_t room_in_piece(PointCloud& cloud, AttributeSet coming, std::uint64_t wanted,
                          const CloudPieces& pieces);

}  // namespace alidade
