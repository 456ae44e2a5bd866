// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

#include "cloud/point_cloud.h"

namespace alidade {

/// Takes the points out of a cloud whose mark is 0; the others close up in the order they had, with all their
/// attributes; CloudFile::point_count follows. One mark per point. Memory: none. Cost: one pass over every
/// column.
void keep_rows(PointCloud& cloud, std::span<const std::uint8_t> marks);

/// Keeps the first point and every `step`-th from there on: rows 0, step, 2 * step ... As keep_rows(); `step`
/// is at least 1.
void keep_every(PointCloud& cloud, std::uint64_t step);

}  // namespace alidade
