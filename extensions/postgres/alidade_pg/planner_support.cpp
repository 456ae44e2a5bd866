// SPDX-License-Identifier: MIT
// Planner support. It rewrites the paper's SQL into conditions and orders that indexes support:
//   dist_ray(A, x,y,z)       becomes  cloud_point(x,y,z) <-> cloud_ray(A)
//   dist_ray(A, x,y,z) <= r  becomes  cloud_point(x,y,z) <@ cloud_limit(cloud_ray(A), '<=', r)
// with the same result, to the last bit; an index on cloud_point(x,y,z) supports both. It also estimates how
// many rows are within a limit: the histogram that ANALYZE stores for such an index is a sample of about a
// hundred of the table's points, evenly spaced in Morton order.
#include <algorithm>
#include <string_view>

#include "extensions/postgres/alidade_pg/cloud_limit.h"
#include "extensions/postgres/alidade_pg/postgres_api.h"

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

/// Finds functions and operators of the extension in its current schema. InvalidOid if they were renamed or
/// the user has no right to execute them: statements are not changed then. The USAGE right on the schema is
/// not checked: views and CHECK constraints that use its functions do not require it.
class ExtensionObjects {
 public:
  /// `function`: one of the extension's, whose schema is searched.
  explicit ExtensionObjects(Oid function) : schema_(get_func_namespace(function)) {}

  template <class... Types>
  Oid find_function(const char* name, Types... types) const {
    const Oid parameters[] = {static_cast<Oid>(types)...};
    const Oid found = GetSysCacheOid3(PROCNAMEARGSNSP, Anum_pg_proc_oid, CStringGetDatum(name),
                                      PointerGetDatum(buildoidvector(parameters, sizeof...(types))),
                                      ObjectIdGetDatum(schema_));
    return OidIsValid(found) && may_execute(found) ? found : InvalidOid;
  }
  Oid find_operator(const char* name, Oid left, Oid right) const {
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

Node* operation(Oid op, Oid result_type, Node* left, Node* right) {
  auto* const made =
      reinterpret_cast<OpExpr*>(make_opclause(op, result_type, false, reinterpret_cast<Expr*>(left),
                                              reinterpret_cast<Expr*>(right), InvalidOid, InvalidOid));
  set_opfuncid(made);
  return reinterpret_cast<Node*>(made);
}

/// The call of dist_ray or dist_plane, with nine numbers, as an operation on a point and a ray or plane
/// (`line`); null if it cannot be changed. `line_function` makes the line of the first six numbers.
Node* simplify_distance(const SupportRequestSimplify& request, const char* line_function) {
  const FuncExpr& original = *request.fcall;
  const ExtensionObjects objects(original.funcid);
  constexpr Oid n = FLOAT8OID;
  const Oid line = objects.find_function(line_function, n, n, n, n, n, n),
            point = objects.find_function("cloud_point", n, n, n);
  if (list_length(original.args) != 9 || !OidIsValid(line) || !OidIsValid(point)) return nullptr;
  const Oid op = objects.find_operator("<->", get_func_rettype(point), get_func_rettype(line));
  if (!OidIsValid(op)) return nullptr;
  List* const point_numbers = list_copy_tail(original.args, 6);
  List* const line_numbers = list_truncate(list_copy(original.args), 6);
  Node* const folded = eval_const_expressions(request.root, call(line, line_numbers));
  Node* const distance = operation(op, FLOAT8OID, call(point, point_numbers), folded);
  return reinterpret_cast<Node*>(makeRelabelType(reinterpret_cast<Expr*>(distance), original.funcresulttype,
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

/// A function of PostgreSQL that compares doubles.
struct DoubleComparison {
  PGFunction function;
  const char* name;      ///< of its operator
  const char* commuted;  ///< with the operands exchanged
};

/// Null if the function does not compare doubles.
const DoubleComparison* comparison_of(Oid function) {
  static constexpr DoubleComparison k_comparisons[] = {{float8lt, "<", ">"},
                                                       {float8le, "<=", ">="},
                                                       {float8eq, "=", "="},
                                                       {float8ge, ">=", "<="},
                                                       {float8gt, ">", "<"}};
  const PGFunction address = address_of(function);
  for (const DoubleComparison& comparison : k_comparisons)
    if (comparison.function == address) return &comparison;
  return nullptr;
}

Node* as_double(Node* node) {
  return applyRelabelType(node, FLOAT8OID, -1, InvalidOid, COERCE_IMPLICIT_CAST, -1, true);
}

/// The comparison with PostgreSQL's own operator of doubles, which is in operator families: indexes on stored
/// distances, merge joins and hash joins support it.
Node* compare_doubles(const DoubleComparison& comparison, Node* left, Node* right) {
  const Oid op = operator_in(PG_CATALOG_NAMESPACE, comparison.name, FLOAT8OID, FLOAT8OID);
  return operation(op, BOOLOID, as_double(left), as_double(right));
}

/// A comparison with a distance as the test of a point against a limit; null if it cannot be changed.
Node* simplify_comparison(const SupportRequestSimplify& request) {
  const FuncExpr& original = *request.fcall;
  const DoubleComparison* const comparison = comparison_of(original.funcid);
  if (comparison == nullptr || list_length(original.args) != 2) return nullptr;
  auto* const left = static_cast<Node*>(linitial(original.args));
  auto* const right = static_cast<Node*>(lsecond(original.args));
  const OpExpr *const on_left = as_distance(left), *const on_right = as_distance(right);
  if ((on_left == nullptr) == (on_right == nullptr)) return compare_doubles(*comparison, left, right);
  const OpExpr& distance = on_left != nullptr ? *on_left : *on_right;
  Node* const bound = as_double(on_left != nullptr ? right : left);

  auto* const point = static_cast<Node*>(linitial(distance.args));
  auto* const line = static_cast<Node*>(lsecond(distance.args));
  const ExtensionObjects objects(original.funcid);
  const Oid limit = objects.find_function("cloud_limit", exprType(line), TEXTOID, FLOAT8OID);
  if (!OidIsValid(limit)) return nullptr;
  const Oid keeps = objects.find_operator("<@", exprType(point), get_func_rettype(limit));
  if (!OidIsValid(keeps)) return nullptr;
  const char* const name = on_left != nullptr ? comparison->name : comparison->commuted;
  Const* const name_text =
      makeConst(TEXTOID, -1, DEFAULT_COLLATION_OID, -1, CStringGetTextDatum(name), false, false);
  Node* const folded = eval_const_expressions(request.root, call(limit, list_make3(line, name_text, bound)));
  return operation(keeps, BOOLOID, point, folded);
}

/// Answers a request of the planner by simplify(request); by null if it is of another kind, or for a function
/// that the user has no right to execute.
template <class Simplify>
Datum answer(FunctionCallInfo fcinfo, const Simplify& simplify) {
  auto* const request = reinterpret_cast<Node*>(PG_GETARG_POINTER(0));
  if (!IsA(request, SupportRequestSimplify)) PG_RETURN_POINTER(nullptr);
  const auto& simplifiable = *reinterpret_cast<SupportRequestSimplify*>(request);
  PG_RETURN_POINTER(may_execute(simplifiable.fcall->funcid) ? simplify(simplifiable) : nullptr);
}

// Estimates.

// A share is the fraction of a table's rows, in [0, 1].

/// Share of a thin cylinder or slab: without statistics, and for limits that are unknown at planning time.
constexpr double k_unknown_share = 0.001;

/// Share of a limit that is unknown at planning time. That of one side of a plane is PostgreSQL's default for
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

/// Estimates the share of a limit from a sample of points.
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

/// Shares of the rows that are within the limit and of those without a position.
struct Shares {
  double within, null;
};

/// Requires an operator `op` on a point and a limit.
Shares shares_of(VariableStatData* column, Oid op, const CloudLimit& limit) {
  if (!HeapTupleIsValid(column->statsTuple)) return {k_unknown_share, 0.0};
  const double null = reinterpret_cast<Form_pg_statistic>(GETSTRUCT(column->statsTuple))->stanullfrac;
  double share = k_unknown_share;
  AttStatsSlot sample;
  if (statistic_proc_security_check(column, get_opcode(op)) &&
      get_attstatsslot(&sample, column->statsTuple, STATISTIC_KIND_HISTOGRAM, InvalidOid,
                       ATTSTATSSLOT_VALUES)) {
    if (sample.nvalues > 0 && sample.valuetype == column->atttype) share = share_of_sample(limit, sample);
    free_attstatsslot(&sample);
  }
  return {share * (1.0 - null), null};
}

/// Estimates the share of rows that are within a limit, or, if not `keeps`, beyond it.
Datum selectivity(FunctionCallInfo fcinfo, bool keeps) {
  auto* const root = reinterpret_cast<PlannerInfo*>(PG_GETARG_POINTER(0));
  auto* const arguments = reinterpret_cast<List*>(PG_GETARG_POINTER(2));
  Shares shares{k_unknown_share, 0.0};
  VariableStatData column;
  Node* other = nullptr;
  const Oid op = PG_GETARG_OID(1);
  const PGFunction test = address_of(get_opcode(op));
  const bool is_own = test == alidade_keeps_limit || test == alidade_breaks_limit;
  // Superusers can attach this estimate to any operator.
  if (!is_own) PG_RETURN_FLOAT8(k_unknown_share);
  bool is_left = false;
  if (get_restriction_variable(root, arguments, PG_GETARG_INT32(3), &column, &other, &is_left)) {
    if (IsA(other, Const)) {
      const Const& limit = *reinterpret_cast<Const*>(other);
      if (limit.constisnull) {
        ReleaseVariableStats(column);
        PG_RETURN_FLOAT8(0.0);
      }
      if (is_left) shares = shares_of(&column, op, value_of<CloudLimit>(limit.constvalue));
    } else {
      shares.within = unknown_share(other);
    }
    ReleaseVariableStats(column);
  }
  PG_RETURN_FLOAT8(std::clamp(keeps ? shares.within : 1.0 - shares.null - shares.within, 0.0, 1.0));
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
