// SPDX-License-Identifier: MIT
#pragma once

#include "cloud/point_cloud.h"

namespace alidade {

/// Appends the points of `piece`, its records, scanner positions and warnings: the cloud is then as if the
/// reader that filled the piece had appended to it (CloudReader::read). Requires equal lattices. What the
/// cloud says of itself and its files stay. Memory: columns with room reserved are not moved.
void append_cloud(PointCloud& cloud, PointCloud&& piece);

}  // namespace alidade
