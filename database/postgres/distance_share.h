// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "database/postgres/cloud_limit.h"

namespace alidade {

/// Estimates which share of all points keeps a limit, from the distances of a sample, in ascending order (NaN
/// last): between the sample's distances the share grows linearly. Near a ray the sample is too thin to
/// count: below the distance of its eighth point the share grows as the cross-section of the cylinder does,
/// with the square. In [0, 1]. Requires a sample.
double estimated_share(const CloudLimit& limit, std::span<const double> distances);

}  // namespace alidade
