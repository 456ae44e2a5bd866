// SPDX-License-Identifier: MIT
// Support for the planner. It rewrites the paper's SQL into conditions and orders that indexes support:
//   dist_ray(A, x,y,z)       becomes  cloud_point(x,y,z) <-> cloud_ray(A)
//   dist_ray(A, x,y,z) <= r  becomes  cloud_point(x,y,z) <@ cloud_limit(cloud_ray(A), '<=', r)
// with the same result, to the last bit; an index on cloud_point(x,y,z) supports both. And it estimates the
// number of rows that keep a limit: the histogram that ANALYZE keeps for such an index is a sample of the
// table's points, about a hundred of them, evenly spaced in Morton order.
#include <algorithm>
#include <string_view>

#include "database/postgres/cloud_limit.h"
#include "database/postgres/postgres_api.h"

extern "C" {
#include <access/htup_details.h>
#include <catalog/pg_collation.h>
#include <catalog/pg_namespace.h>
#include <catalog/pg_operator.h>
#include <catalog/pg_proc.h>
#include <catalog/pg_statistic.h>
#include <catalog/pg_type.h>
#include <miscadmin.h>
#include <nodes/makefuncs.h>
#include <nodes/nodeFuncs.h>
#include <nodes/supportnodes.h>
#include <optimizer/optimizer.h>
#include <utils/acl.h>
#include <utils/builtins.h>
#include <utils/fmgrprotos.h>
#include <utils/lsyscache.h>
#include <utils/selfuncs.h>
#include <utils/syscache.h>
}

namespace alidade::database {
namespace {

// Rewriting.

bool may_execute(Oid function) {
  return pg_proc_aclcheck(function, GetUserId(), ACL_EXECUTE) == ACLCHECK_OK;
}

Oid operator_in(Oid schema, const char* name, Oid left, Oid right) {
  return GetSysCacheOid4(OPERNAMENSP, Anum_pg_operator_oid, CStringGetDatum(name), ObjectIdGetDatum(left),
                         ObjectIdGetDatum(right), ObjectIdGetDatum(schema));
}

/// The functions, types and operators of the extension, in its current schema. If they were renamed, or the
/// user has no right to execute them, they are not found, and statements are not changed. The USAGE right on
/// the schema is not checked: views and CHECK constraints that use its functions do not require it.
class OwnParts {
 public:
  /// `function`: one of the extension's, whose schema is searched.
  explicit OwnParts(Oid function) : schema_(get_func_namespace(function)) {}

  template <class... Types>
  Oid function(const char* name, Types... types) const {
    const Oid given[] = {static_cast<Oid>(types)...};
    const Oid found =
        GetSysCacheOid3(PROCNAMEARGSNSP, Anum_pg_proc_oid, CStringGetDatum(name),
                        PointerGetDatum(buildoidvector(given, sizeof...(types))), ObjectIdGetDatum(schema_));
    return OidIsValid(found) && may_execute(found) ? found : InvalidOid;
  }
  Oid symbol(const char* name, Oid left, Oid right) const {
    const Oid found = operator_in(schema_, name, left, right);
    return OidIsValid(found) && may_execute(get_opcode(found)) ? found : InvalidOid;
  }

 private:
  Oid schema_;
};

Node* call(Oid function, List* arguments) {
  return reinterpret_cast<Node*>(makeFuncExpr(function, get_func_rettype(function), arguments, InvalidOid,
                                              InvalidOid, COERCE_EXPLICIT_CALL));
}

Node* operation(Oid symbol, Oid result, Node* left, Node* right) {
  auto* const made =
      reinterpret_cast<OpExpr*>(make_opclause(symbol, result, false, reinterpret_cast<Expr*>(left),
                                              reinterpret_cast<Expr*>(right), InvalidOid, InvalidOid));
  set_opfuncid(made);
  return reinterpret_cast<Node*>(made);
}

/// The call with nine arguments as an operation on a point and a line; null if it cannot be changed.
Node* simplify_distance(const SupportRequestSimplify& request, const char* line_name) {
  const FuncExpr& written = *request.fcall;
  const OwnParts parts(written.funcid);
  constexpr Oid n = FLOAT8OID;
  const Oid line = parts.function(line_name, n, n, n, n, n, n),
            point = parts.function("cloud_point", n, n, n);
  if (list_length(written.args) != 9 || !OidIsValid(line) || !OidIsValid(point)) return nullptr;
  const Oid symbol = parts.symbol("<->", get_func_rettype(point), get_func_rettype(line));
  if (!OidIsValid(symbol)) return nullptr;
  List* const position = list_copy_tail(written.args, 6);
  List* const given = list_truncate(list_copy(written.args), 6);
  Node* const folded = eval_const_expressions(request.root, call(line, given));
  Node* const distance = operation(symbol, FLOAT8OID, call(point, position), folded);
  return reinterpret_cast<Node*>(makeRelabelType(reinterpret_cast<Expr*>(distance), written.funcresulttype,
                                                 -1, InvalidOid, COERCE_IMPLICIT_CAST));
}

/// The operation that simplify_distance() made; null if the node is not one. Casts by functions, and to
/// domains, are not skipped: they change or check the value.
OpExpr* as_distance(Node* node) {
  while (IsA(node, RelabelType)) node = reinterpret_cast<Node*>(reinterpret_cast<RelabelType*>(node)->arg);
  if (!IsA(node, OpExpr)) return nullptr;
  auto* const found = reinterpret_cast<OpExpr*>(node);
  const PGFunction address = address_of(found->opfuncid);
  return address == alidade_distance_to_ray || address == alidade_distance_to_plane ? found : nullptr;
}

struct Symbol {
  PGFunction function;
  const char* written;
  const char* commuted;
};

/// The comparison of a function of PostgreSQL; null if it is not one.
const Symbol* symbol_of(Oid function) {
  static constexpr Symbol k_symbols[] = {{float8lt, "<", ">"},
                                         {float8le, "<=", ">="},
                                         {float8eq, "=", "="},
                                         {float8ge, ">=", "<="},
                                         {float8gt, ">", "<"}};
  const PGFunction address = address_of(function);
  for (const Symbol& symbol : k_symbols)
    if (symbol.function == address) return &symbol;
  return nullptr;
}

Node* as_double(Node* node) {
  return applyRelabelType(node, FLOAT8OID, -1, InvalidOid, COERCE_IMPLICIT_CAST, -1, true);
}

/// The comparison as one of doubles, which is in PostgreSQL's own operator families: stored distances can be
/// found by an index on them, and joined by merging or hashing.
Node* compare_doubles(const Symbol& symbol, Node* left, Node* right) {
  const Oid known = operator_in(PG_CATALOG_NAMESPACE, symbol.written, FLOAT8OID, FLOAT8OID);
  return operation(known, BOOLOID, as_double(left), as_double(right));
}

/// A comparison with a distance as a limit that a point keeps; null if it cannot be changed.
Node* simplify_comparison(const SupportRequestSimplify& request) {
  const FuncExpr& written = *request.fcall;
  const Symbol* const symbol = symbol_of(written.funcid);
  if (symbol == nullptr || list_length(written.args) != 2) return nullptr;
  auto* const left = static_cast<Node*>(linitial(written.args));
  auto* const right = static_cast<Node*>(lsecond(written.args));
  const OpExpr *const on_left = as_distance(left), *const on_right = as_distance(right);
  if ((on_left == nullptr) == (on_right == nullptr)) return compare_doubles(*symbol, left, right);
  const OpExpr& distance = on_left != nullptr ? *on_left : *on_right;
  Node* const bound = as_double(on_left != nullptr ? right : left);

  auto* const point = static_cast<Node*>(linitial(distance.args));
  auto* const line = static_cast<Node*>(lsecond(distance.args));
  const OwnParts parts(written.funcid);
  const Oid limit = parts.function("cloud_limit", exprType(line), TEXTOID, FLOAT8OID);
  if (!OidIsValid(limit)) return nullptr;
  const Oid keeps = parts.symbol("<@", exprType(point), get_func_rettype(limit));
  if (!OidIsValid(keeps)) return nullptr;
  const char* const word = on_left != nullptr ? symbol->written : symbol->commuted;
  Const* const comparison =
      makeConst(TEXTOID, -1, DEFAULT_COLLATION_OID, -1, CStringGetTextDatum(word), false, false);
  Node* const folded = eval_const_expressions(request.root, call(limit, list_make3(line, comparison, bound)));
  return operation(keeps, BOOLOID, point, folded);
}

template <class Simplify>
Datum answer(FunctionCallInfo fcinfo, const Simplify& simplify) {
  auto* const request = reinterpret_cast<Node*>(PG_GETARG_POINTER(0));
  if (!IsA(request, SupportRequestSimplify)) PG_RETURN_POINTER(nullptr);
  const auto& simplifiable = *reinterpret_cast<SupportRequestSimplify*>(request);
  PG_RETURN_POINTER(may_execute(simplifiable.fcall->funcid) ? simplify(simplifiable) : nullptr);
}

// Estimates.

/// Share without statistics, or for limits that are unknown at planning time: a thin cylinder or slab.
constexpr double k_unknown_share = 0.001;

/// Share of a limit that is unknown at planning time. One side of a plane has PostgreSQL's default for
/// inequalities.
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

ALIDADE_SQL_ANSWER(alidade_dist_ray_support, answer(fcinfo, [](const auto& request) {
                     return simplify_distance(request, "cloud_ray");
                   }));
ALIDADE_SQL_ANSWER(alidade_dist_plane_support, answer(fcinfo, [](const auto& request) {
                     return simplify_distance(request, "cloud_plane");
                   }));
ALIDADE_SQL_ANSWER(alidade_comparison_support, answer(fcinfo, simplify_comparison));
ALIDADE_SQL_ANSWER(alidade_keeping_share, selectivity(fcinfo, true));
ALIDADE_SQL_ANSWER(alidade_breaking_share, selectivity(fcinfo, false));
