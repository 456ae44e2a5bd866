// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "cloud/read_in_pieces.h"
#include "database/point_stream.h"
#include "database/stored_column.h"

namespace alidade {

/// stored_columns() of a cloud that was read piece by piece: those that some piece had.
std::vector<StoredColumn> streamed_columns(const PiecewiseCloud& whole, const PointStream& points);

}  // namespace alidade
