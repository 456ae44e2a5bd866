// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "cloud/point_cloud.h"
#include "image/color_key.h"
#include "image/point_color.h"
#include "octree/octree.h"

namespace alidade {

/// Colours worked out from other values, and what they mean.
struct ColoredPoints {
  std::vector<Color16> colors;  ///< display-referred, by point id; empty for rgb and normal
  ColorKey key;
};

/// Colours the points of a cloud. `coloring` comes from choose_color(); `columns` has what it needs, in rows
/// by point id; `facts` tells reference system, files and the kind of GPS time, and has no points. Points
/// without a value get k_no_value_color. Rgb is left as it lies, and a normal's colour is known only where
/// its surface is shaded: for both there are no colours, only the key. Memory: 6 bytes per point. Cost: up to
/// six passes over the values, in parallel; the result does not depend on the number of threads.
ColoredPoints color_points(const PointColoring& coloring, const AttributeColumns& columns,
                           const PointCloud& facts, const TreeView& tree);

}  // namespace alidade
