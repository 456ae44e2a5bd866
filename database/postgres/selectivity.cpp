// SPDX-License-Identifier: MIT
// Estimates of the number of rows for the planner: the histogram that ANALYZE keeps for an
// index on cloud_point(x,y,z) is a sample of the table's points, about a hundred of them,
// evenly spaced in Morton order.
#include <algorithm>
#include <string_view>

#include "database/postgres/cloud_limit.h"
#include "database/postgres/postgres_api.h"

extern "C" {
#include <access/htup_details.h>
#include <catalog/pg_statistic.h>
#include <utils/builtins.h>
#include <utils/lsyscache.h>
#include <utils/selfuncs.h>
}

namespace alidade::database {
namespace {

/// Share without statistics, or for limits that are unknown at planning time: a thin cylinder or slab.
constexpr double k_unknown_share = 0.001;

/// Share of a limit that is unknown at planning time. One side of a plane has PostgreSQL's
/// default for inequalities.
double unknown_share(const Node* limit) {
  if (!IsA(limit, FuncExpr)) return k_unknown_share;
  const auto& made = *reinterpret_cast<const FuncExpr*>(limit);
  if (address_of(made.funcid) != alidade_limit_by_plane) return k_unknown_share;
  const auto& comparison = *static_cast<const Const*>(lsecond(made.args));
  const bool has_sides = IsA(&comparison, Const) && !comparison.constisnull &&
                         text_to_cstring(DatumGetTextPP(comparison.constvalue)) != std::string_view("=");
  return has_sides ? DEFAULT_INEQ_SEL : k_unknown_share;
}

double share_of_sample(const CloudLimit& limit, const AttStatsSlot& sample) {
  const int count = sample.nvalues;
  auto* const distances = static_cast<double*>(palloc(sizeof(double) * static_cast<std::size_t>(count)));
  for (int i = 0; i < count; ++i)
    distances[i] = distance(limit.kind, limit.line, value_of<glm::dvec3>(sample.values[i]));
  std::sort(distances, distances + count, [](double a, double b) { return compare_numbers(a, b) < 0; });
  const double share = estimated_share(limit, {distances, static_cast<std::size_t>(count)});
  pfree(distances);
  return share;
}

/// Shares of the rows that keep the limit and of those without a position.
struct Shares {
  double keeping, null;
};

/// Requires that the symbol compares a point with a limit.
Shares shares_of(VariableStatData* column, Oid symbol, const CloudLimit& limit) {
  if (!HeapTupleIsValid(column->statsTuple)) return {k_unknown_share, 0.0};
  const double null = reinterpret_cast<Form_pg_statistic>(GETSTRUCT(column->statsTuple))->stanullfrac;
  double share = k_unknown_share;
  AttStatsSlot sample;
  if (statistic_proc_security_check(column, get_opcode(symbol)) &&
      get_attstatsslot(&sample, column->statsTuple, STATISTIC_KIND_HISTOGRAM, InvalidOid,
                       ATTSTATSSLOT_VALUES)) {
    if (sample.nvalues > 0 && sample.valuetype == column->atttype) share = share_of_sample(limit, sample);
    free_attstatsslot(&sample);
  }
  return {share * (1.0 - null), null};
}

Datum selectivity(FunctionCallInfo fcinfo, bool keeps) {
  auto* const root = reinterpret_cast<PlannerInfo*>(PG_GETARG_POINTER(0));
  auto* const arguments = reinterpret_cast<List*>(PG_GETARG_POINTER(2));
  Shares shares{k_unknown_share, 0.0};
  VariableStatData column;
  Node* other = nullptr;
  const Oid symbol = PG_GETARG_OID(1);
  const PGFunction decides = address_of(get_opcode(symbol));
  const bool is_own = decides == alidade_keeps_limit || decides == alidade_breaks_limit;
  // Superusers can use this estimate for any operator.
  if (!is_own) PG_RETURN_FLOAT8(k_unknown_share);
  bool is_left = false;
  if (get_restriction_variable(root, arguments, PG_GETARG_INT32(3), &column, &other, &is_left)) {
    if (IsA(other, Const)) {
      const Const& limit = *reinterpret_cast<Const*>(other);
      if (limit.constisnull) {
        ReleaseVariableStats(column);
        PG_RETURN_FLOAT8(0.0);
      }
      if (is_left) shares = shares_of(&column, symbol, value_of<CloudLimit>(limit.constvalue));
    } else {
      shares.keeping = unknown_share(other);
    }
    ReleaseVariableStats(column);
  }
  PG_RETURN_FLOAT8(std::clamp(keeps ? shares.keeping : 1.0 - shares.null - shares.keeping, 0.0, 1.0));
}

}  // namespace
}  // namespace alidade::database

using namespace alidade;
using namespace alidade::database;

ALIDADE_SQL_ANSWER(alidade_keeping_share, selectivity(fcinfo, true));
ALIDADE_SQL_ANSWER(alidade_breaking_share, selectivity(fcinfo, false));
