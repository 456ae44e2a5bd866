// SPDX-License-Identifier: MIT
// Indexes: the order of points for btree, and boxes of points for GiST and for BRIN (the paper's chunk
// statistics, section 4.2).
#include <algorithm>
#include <limits>

#include "extensions/postgres/alidade_pg/cloud_limit.h"
#include "extensions/postgres/alidade_pg/postgres_api.h"

extern "C" {
#include <access/brin_internal.h>
#include <access/brin_tuple.h>
#include <access/gist.h>
#include <access/skey.h>
#include <catalog/pg_type.h>
#include <utils/sortsupport.h>
#include <utils/typcache.h>
}

namespace alidade::database {
namespace {

// Numbers of the operators in the operator classes of the install script.
constexpr int k_keeps = 1;   ///< cloud_point <@ cloud_limit
constexpr int k_breaks = 2;  ///< cloud_point !<@ cloud_limit
constexpr int k_to_ray = 15;
constexpr int k_to_plane = 16;

/// False only if the condition of an index scan holds for no point of the box.
bool may_match(int symbol, Datum argument, const Bounds& box) {
  const auto& limit = value_of<CloudLimit>(argument);
  return guarded([&] { return symbol == k_keeps ? may_hold(limit, box) : may_break(limit, box); });
}

// Points in Morton order, for btree and ORDER BY.

int order(Datum a, Datum b) {
  return compare_morton(value_of<glm::dvec3>(a), value_of<glm::dvec3>(b));
}

int order(FunctionCallInfo fcinfo) {
  return order(PG_GETARG_DATUM(0), PG_GETARG_DATUM(1));
}

// BRIN: the box of the points of each range of pages. These are the paper's chunk statistics (section 4.2).

/// Least x, y and z, then largest: each is a column of the index.
constexpr int k_faces = 6;

Bounds box_in(const BrinValues& range) {
  const auto vector = [&](int first) {
    return glm::dvec3(DatumGetFloat8(range.bv_values[first]), DatumGetFloat8(range.bv_values[first + 1]),
                      DatumGetFloat8(range.bv_values[first + 2]));
  };
  return {vector(0), vector(3)};
}

/// Grows the range's box; returns whether that changed it.
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

// GiST: a tree of boxes; in its leaves those of single points.

const Bounds& box_in(const GISTENTRY& entry) {
  return value_of<Bounds>(entry.key);
}

GISTENTRY& entry_in(FunctionCallInfo fcinfo, int argument) {
  return *reinterpret_cast<GISTENTRY*>(PG_GETARG_POINTER(argument));
}

/// Half the sum of the sides. Not the volume, which is 0 for boxes around walls and ground.
double size_of(const Bounds& box) {
  const glm::dvec3 sides = box.size();
  return sides.x + sides.y + sides.z;
}

/// Doubled centre along an axis; zero if the box is unbounded.
double center_of(const Bounds& box, int axis) {
  const double center = box.min[axis] + box.max[axis];
  return std::isnan(center) ? 0.0 : center;
}

int longest_axis_of_centers(const GistEntryVector& entries) {
  Bounds centers;
  for (int i = FirstOffsetNumber; i < entries.n; ++i) {
    const Bounds& box = box_in(entries.vector[i]);
    centers.grow(glm::dvec3(center_of(box, 0), center_of(box, 1), center_of(box, 2)));
  }
  const glm::dvec3 sides = centers.size();
  return sides.x >= sides.y && sides.x >= sides.z ? 0 : sides.y >= sides.z ? 1 : 2;
}

/// A lower bound of the distances of all points of a box.
double least_distance(DistanceKind kind, const CloudLine& line, const Bounds& box) {
  constexpr double k_anything = -std::numeric_limits<double>::infinity();
  if (!is_finite(box)) return k_anything;
  const double low = distance(kind, line, box).low;
  return std::isnan(low) ? k_anything : low;
}

}  // namespace
}  // namespace alidade::database

using namespace alidade;
using namespace alidade::database;

ALIDADE_SQL_ANSWER(alidade_point_order, Int32GetDatum(order(fcinfo)));
ALIDADE_SQL_ANSWER(alidade_point_before, BoolGetDatum(order(fcinfo) < 0));
ALIDADE_SQL_ANSWER(alidade_point_not_after, BoolGetDatum(order(fcinfo) <= 0));
ALIDADE_SQL_ANSWER(alidade_point_equal, BoolGetDatum(order(fcinfo) == 0));
ALIDADE_SQL_ANSWER(alidade_point_not_before, BoolGetDatum(order(fcinfo) >= 0));
ALIDADE_SQL_ANSWER(alidade_point_after, BoolGetDatum(order(fcinfo) > 0));
ALIDADE_SQL_FUNCTION(alidade_point_sort_support) {
  reinterpret_cast<SortSupport>(PG_GETARG_POINTER(0))->comparator = [](Datum a, Datum b, SortSupport) {
    return order(a, b);
  };
  PG_RETURN_VOID();
}

ALIDADE_SQL_FUNCTION(alidade_brin_columns) {
  auto* const info = static_cast<BrinOpcInfo*>(palloc0(MAXALIGN(SizeofBrinOpcInfo(k_faces))));
  info->oi_nstored = k_faces;
  info->oi_regular_nulls = true;
  for (int i = 0; i < k_faces; ++i) info->oi_typcache[i] = lookup_type_cache(FLOAT8OID, 0);
  PG_RETURN_POINTER(info);
}
ALIDADE_SQL_FUNCTION(alidade_brin_add) {
  PG_RETURN_BOOL(grow(range_in(fcinfo, 1), box_of(argument<glm::dvec3>(fcinfo, 2))));
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

ALIDADE_SQL_FUNCTION(alidade_gist_compress) {
  GISTENTRY& entry = entry_in(fcinfo, 0);
  if (!entry.leafkey) PG_RETURN_POINTER(&entry);
  auto* const compressed = static_cast<GISTENTRY*>(palloc(sizeof(GISTENTRY)));
  gistentryinit(*compressed, datum_of(box_of(value_of<glm::dvec3>(entry.key))), entry.rel, entry.page,
                entry.offset, false);
  PG_RETURN_POINTER(compressed);
}
ALIDADE_SQL_FUNCTION(alidade_gist_consistent) {
  const GISTENTRY& entry = entry_in(fcinfo, 0);
  const int symbol = PG_GETARG_UINT16(2);
  bool& must_recheck = *reinterpret_cast<bool*>(PG_GETARG_POINTER(4));
  const Bounds& box = box_in(entry);
  const bool is_point = GIST_LEAF(&entry) && is_finite(box);
  must_recheck = !is_point;
  if (is_point) PG_RETURN_BOOL(holds(argument<CloudLimit>(fcinfo, 1), box.min) == (symbol == k_keeps));
  PG_RETURN_BOOL(may_match(symbol, PG_GETARG_DATUM(1), box));
}
ALIDADE_SQL_FUNCTION(alidade_gist_distance) {
  const GISTENTRY& entry = entry_in(fcinfo, 0);
  const auto& line = argument<CloudLine>(fcinfo, 1);
  const DistanceKind kind = PG_GETARG_UINT16(2) == k_to_ray ? DistanceKind::ray : DistanceKind::plane;
  bool& must_recheck = *reinterpret_cast<bool*>(PG_GETARG_POINTER(4));
  const Bounds& box = box_in(entry);
  const bool is_point = GIST_LEAF(&entry) && is_finite(box);
  must_recheck = !is_point;
  PG_RETURN_FLOAT8(is_point ? distance(kind, line, box.min) : least_distance(kind, line, box));
}
ALIDADE_SQL_FUNCTION(alidade_gist_union) {
  const auto& entries = *reinterpret_cast<GistEntryVector*>(PG_GETARG_POINTER(0));
  Bounds box = box_in(entries.vector[0]);
  for (int i = 1; i < entries.n; ++i) box.grow(box_in(entries.vector[i]));
  *reinterpret_cast<int*>(PG_GETARG_POINTER(1)) = sizeof box;
  return datum_of(box);
}
ALIDADE_SQL_FUNCTION(alidade_gist_penalty) {
  const Bounds &box = box_in(entry_in(fcinfo, 0)), &added = box_in(entry_in(fcinfo, 1));
  const double growth = size_of(joined(box, added)) - size_of(box);
  constexpr double k_most = std::numeric_limits<float>::max();
  *reinterpret_cast<float*>(PG_GETARG_POINTER(2)) =
      std::isnan(growth) ? 0.0F : static_cast<float>(std::min(growth, k_most));
  PG_RETURN_POINTER(PG_GETARG_POINTER(2));
}

/// Halves the entries by their centres along the axis of the largest spread.
ALIDADE_SQL_FUNCTION(alidade_gist_split) {
  const auto& entries = *reinterpret_cast<GistEntryVector*>(PG_GETARG_POINTER(0));
  auto& split = *reinterpret_cast<GIST_SPLITVEC*>(PG_GETARG_POINTER(1));
  const int axis = longest_axis_of_centers(entries), count = entries.n - FirstOffsetNumber;
  // In indexes of several columns PostgreSQL moves entries from one side to the other, so each side has room
  // for all.
  const std::size_t bytes = sizeof(OffsetNumber) * static_cast<std::size_t>(count + 1);
  auto* const order = static_cast<OffsetNumber*>(palloc(bytes));
  for (int i = 0; i < count; ++i) order[i] = static_cast<OffsetNumber>(FirstOffsetNumber + i);
  const int half = count / 2;
  std::nth_element(order, order + half, order + count, [&](OffsetNumber a, OffsetNumber b) {
    return center_of(box_in(entries.vector[a]), axis) < center_of(box_in(entries.vector[b]), axis);
  });
  const auto box_from = [&](int first, int last) {
    Bounds box;
    for (int i = first; i < last; ++i) box.grow(box_in(entries.vector[order[i]]));
    return datum_of(box);
  };
  split.spl_left = order;
  split.spl_nleft = half;
  split.spl_ldatum = box_from(0, half);
  split.spl_right = static_cast<OffsetNumber*>(palloc(bytes));
  std::copy(order + half, order + count, split.spl_right);
  split.spl_nright = count - half;
  split.spl_rdatum = box_from(half, count);
  PG_RETURN_POINTER(&split);
}
ALIDADE_SQL_FUNCTION(alidade_gist_same) {
  const auto &a = argument<Bounds>(fcinfo, 0), &b = argument<Bounds>(fcinfo, 1);
  *reinterpret_cast<bool*>(PG_GETARG_POINTER(2)) = a.min == b.min && a.max == b.max;
  PG_RETURN_POINTER(PG_GETARG_POINTER(2));
}

/// Indexes are built bottom up, from points in Morton order.
ALIDADE_SQL_FUNCTION(alidade_gist_sort_support) {
  reinterpret_cast<SortSupport>(PG_GETARG_POINTER(0))->comparator = [](Datum a, Datum b, SortSupport) {
    return compare_morton(value_of<Bounds>(a).min, value_of<Bounds>(b).min);
  };
  PG_RETURN_VOID();
}
