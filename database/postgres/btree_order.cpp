// SPDX-License-Identifier: MIT
// Points in Morton order, for btree and ORDER BY.
#include "database/postgres/point_order.h"
#include "database/postgres/postgres_api.h"

extern "C" {
#include <utils/sortsupport.h>
}

namespace alidade {
namespace {

int order(Datum a, Datum b) {
  return compare_morton(value_of<glm::dvec3>(a), value_of<glm::dvec3>(b));
}

int order(FunctionCallInfo fcinfo) {
  return order(PG_GETARG_DATUM(0), PG_GETARG_DATUM(1));
}

}  // namespace
}  // namespace alidade

using namespace alidade;

ALIDADE_SQL_FUNCTION(alidade_point_order) {
  PG_RETURN_INT32(order(fcinfo));
}
ALIDADE_SQL_FUNCTION(alidade_point_before) {
  PG_RETURN_BOOL(order(fcinfo) < 0);
}
ALIDADE_SQL_FUNCTION(alidade_point_not_after) {
  PG_RETURN_BOOL(order(fcinfo) <= 0);
}
ALIDADE_SQL_FUNCTION(alidade_point_equal) {
  PG_RETURN_BOOL(order(fcinfo) == 0);
}
ALIDADE_SQL_FUNCTION(alidade_point_not_before) {
  PG_RETURN_BOOL(order(fcinfo) >= 0);
}
ALIDADE_SQL_FUNCTION(alidade_point_after) {
  PG_RETURN_BOOL(order(fcinfo) > 0);
}
ALIDADE_SQL_FUNCTION(alidade_point_sort_support) {
  reinterpret_cast<SortSupport>(PG_GETARG_POINTER(0))->comparator = [](Datum a, Datum b, SortSupport) {
    return order(a, b);
  };
  PG_RETURN_VOID();
}
