// SPDX-License-Identifier: MIT
// BRIN: the box of the points of each range of pages. These are the paper's chunk statistics (section 4.2).
#include "database/postgres/index_conditions.h"

extern "C" {
#include <access/brin_internal.h>
#include <access/brin_tuple.h>
#include <access/skey.h>
#include <catalog/pg_type.h>
#include <utils/typcache.h>
}

namespace alidade {
namespace {

/// Least x, y and z, then largest: each is a column of the index.
constexpr int k_faces = 6;

Bounds box_in(const BrinValues& range) {
  const auto vector = [&](int first) {
    return glm::dvec3(DatumGetFloat8(range.bv_values[first]), DatumGetFloat8(range.bv_values[first + 1]),
                      DatumGetFloat8(range.bv_values[first + 2]));
  };
  return {vector(0), vector(3)};
}

/// Grows the range's box; answers whether that changed it.
bool grow(BrinValues& range, const Bounds& by) {
  const bool is_first = range.bv_allnulls;
  Bounds box = is_first ? Bounds{} : box_in(range);
  const Bounds before = box;
  box.grow(by);
  if (!is_first && box.min == before.min && box.max == before.max) return false;
  for (int axis = 0; axis < 3; ++axis) {
    range.bv_values[axis] = Float8GetDatum(box.min[axis]);
    range.bv_values[3 + axis] = Float8GetDatum(box.max[axis]);
  }
  range.bv_allnulls = false;
  return true;
}

BrinValues& range_in(FunctionCallInfo fcinfo, int argument) {
  return *reinterpret_cast<BrinValues*>(PG_GETARG_POINTER(argument));
}

}  // namespace
}  // namespace alidade

using namespace alidade;

ALIDADE_SQL_FUNCTION(alidade_brin_columns) {
  auto* const info = static_cast<BrinOpcInfo*>(palloc0(MAXALIGN(SizeofBrinOpcInfo(k_faces))));
  info->oi_nstored = k_faces;
  info->oi_regular_nulls = true;
  for (int i = 0; i < k_faces; ++i) info->oi_typcache[i] = lookup_type_cache(FLOAT8OID, 0);
  PG_RETURN_POINTER(info);
}
ALIDADE_SQL_FUNCTION(alidade_brin_add) {
  PG_RETURN_BOOL(grow(range_in(fcinfo, 1), box_of(value_of<glm::dvec3>(PG_GETARG_DATUM(2)))));
}
ALIDADE_SQL_FUNCTION(alidade_brin_union) {
  grow(range_in(fcinfo, 1), box_in(range_in(fcinfo, 2)));
  PG_RETURN_VOID();
}
ALIDADE_SQL_FUNCTION(alidade_brin_consistent) {
  const Bounds box = box_in(range_in(fcinfo, 1));
  auto* const* const keys = reinterpret_cast<ScanKey*>(PG_GETARG_POINTER(2));
  const int count = PG_GETARG_INT32(3);
  for (int i = 0; i < count; ++i)
    if (!may_match(keys[i]->sk_strategy, keys[i]->sk_argument, box)) PG_RETURN_BOOL(false);
  PG_RETURN_BOOL(true);
}
