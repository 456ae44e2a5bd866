// SPDX-License-Identifier: MIT
#pragma once

#include "database/postgres/cloud_line.h"

namespace alidade {

enum class Comparison { less, less_equal, equal, greater_equal, greater };

/// A limit on dist_ray or dist_plane: the value of the SQL type cloud_limit, byte for byte. Distances are
/// ordered as PostgreSQL orders them: NaN equals itself and is above all others.
struct CloudLimit {
  CloudLine line;
  double least, largest;  ///< inclusive; nothing keeps the limit if least is above largest
  DistanceKind kind;
};

/// The limit that distances keep of which `distance comparison value` is true, to the last bit.
CloudLimit make_limit(DistanceKind kind, const CloudLine& line, Comparison comparison, double value);

/// Whether a point keeps it.
bool holds(const CloudLimit& limit, const glm::dvec3& point);

/// False only if no point of the box keeps it. A box without limits holds points without a place, too.
bool may_hold(const CloudLimit& limit, const Bounds& box);

/// False only if all points of the box keep it.
bool may_break(const CloudLimit& limit, const Bounds& box);

/// Whether all faces are finite.
bool is_finite(const Bounds& box);

/// The box of a point; without limits if a coordinate is not finite.
Bounds box_of(const glm::dvec3& point);

}  // namespace alidade
