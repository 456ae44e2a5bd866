// SPDX-License-Identifier: MIT
// The SQL functions of distances, and of whether a point keeps a limit.
#include "database/postgres/postgres_api.h"

#include "database/postgres/cloud_limit.h"

extern "C" {
PG_MODULE_MAGIC;
}

namespace alidade::database {
namespace {

Datum distance_of_numbers(FunctionCallInfo fcinfo, DistanceKind kind) {
  const auto vector = [&](int first) {
    return glm::dvec3(PG_GETARG_FLOAT8(first), PG_GETARG_FLOAT8(first + 1), PG_GETARG_FLOAT8(first + 2));
  };
  const CloudLine line = guarded([&] { return make_line(kind, vector(0), vector(3)); });
  PG_RETURN_FLOAT8(distance(kind, line, vector(6)));
}

Datum distance_of_values(FunctionCallInfo fcinfo, DistanceKind kind) {
  PG_RETURN_FLOAT8(distance(kind, argument<CloudLine>(fcinfo, 1), argument<glm::dvec3>(fcinfo, 0)));
}

bool keeps_limit(FunctionCallInfo fcinfo) {
  return holds(argument<CloudLimit>(fcinfo, 1), argument<glm::dvec3>(fcinfo, 0));
}

}  // namespace
}  // namespace alidade::database

using namespace alidade;
using namespace alidade::database;

ALIDADE_SQL_ANSWER(alidade_dist_ray, distance_of_numbers(fcinfo, DistanceKind::ray));
ALIDADE_SQL_ANSWER(alidade_dist_plane, distance_of_numbers(fcinfo, DistanceKind::plane));
ALIDADE_SQL_ANSWER(alidade_distance_to_ray, distance_of_values(fcinfo, DistanceKind::ray));
ALIDADE_SQL_ANSWER(alidade_distance_to_plane, distance_of_values(fcinfo, DistanceKind::plane));
ALIDADE_SQL_ANSWER(alidade_keeps_limit, BoolGetDatum(keeps_limit(fcinfo)));
ALIDADE_SQL_ANSWER(alidade_breaks_limit, BoolGetDatum(!keeps_limit(fcinfo)));
