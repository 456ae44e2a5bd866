// SPDX-License-Identifier: MIT
// The distances, and whether a point keeps a limit.
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
  const auto& point = value_of<glm::dvec3>(PG_GETARG_DATUM(0));
  PG_RETURN_FLOAT8(distance(kind, value_of<CloudLine>(PG_GETARG_DATUM(1)), point));
}

bool keeps_limit(FunctionCallInfo fcinfo) {
  return holds(value_of<CloudLimit>(PG_GETARG_DATUM(1)), value_of<glm::dvec3>(PG_GETARG_DATUM(0)));
}

}  // namespace
}  // namespace alidade::database

using namespace alidade;
using namespace alidade::database;

ALIDADE_SQL_FUNCTION(alidade_dist_ray) {
  return distance_of_numbers(fcinfo, DistanceKind::ray);
}
ALIDADE_SQL_FUNCTION(alidade_dist_plane) {
  return distance_of_numbers(fcinfo, DistanceKind::plane);
}
ALIDADE_SQL_FUNCTION(alidade_distance_to_ray) {
  return distance_of_values(fcinfo, DistanceKind::ray);
}
ALIDADE_SQL_FUNCTION(alidade_distance_to_plane) {
  return distance_of_values(fcinfo, DistanceKind::plane);
}
ALIDADE_SQL_FUNCTION(alidade_keeps_limit) {
  PG_RETURN_BOOL(keeps_limit(fcinfo));
}
ALIDADE_SQL_FUNCTION(alidade_breaks_limit) {
  PG_RETURN_BOOL(!keeps_limit(fcinfo));
}
