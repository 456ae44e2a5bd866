// SPDX-License-Identifier: MIT
#pragma once

#include "base/progress.h"
#include "cloud/point_cloud.h"

namespace alidade {

/// Thins a cloud to one point per cube of the grid with this `edge`, world units, one of whose corners is the
/// origin of the coordinates: clouds thinned apart fit together. A cube's lower faces are its own, and what
/// lies a millionth of an edge below them; the upper faces are its neighbours'.
///
/// The point that stays is a real one, the nearest to the mean of the cube's points, the first of equals. It
/// keeps its position and attributes, but for colour, near infrared and intensity, which become the means
/// over the cube's points, rounded. Points that stay keep their order. The result does not depend on the
/// number of threads; on the order of points only where several are equally near, and in that of the result.
///
/// `progress` is in points. Memory: 17 B per point. Cost: that of sorting. Errors: an edge that is not a
/// positive number; more than 2^32 - 1 cubes along an axis; more than 2^32 - 1 points.
void thin(PointCloud& cloud, double edge, const Progress& progress = {});

}  // namespace alidade
