// SPDX-License-Identifier: MIT
#pragma once

#include "octree/query.h"

namespace alidade {

/// Types of a family of queries.
template <class Target>
struct Family {
  using Query = PointQuery;
  using Answer = PointHit;
};
template <>
struct Family<Ray> {
  using Query = RayQuery;
  using Answer = Hit;
};
template <>
struct Family<Cone> {
  using Query = ConeQuery;
  using Answer = Hit;
};
template <>
struct Family<Path> {
  using Query = PathQuery;
  using Answer = PathHit;
};

}  // namespace alidade
