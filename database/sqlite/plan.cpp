// SPDX-License-Identifier: MIT
#include "database/sqlite/plan.h"

#include <algorithm>
#include <cmath>

#include "database/sqlite/distance_limit.h"
#include "database/sqlite/point_cursor.h"
#include "database/sqlite/sql_values.h"
#include "database/sqlite/statement.h"

namespace alidade {
namespace {

// A plan's text is two letters for each value that the scan gets: what it limits, and how.
constexpr char k_first_argument = 'A';  // to 'F'
constexpr char k_axes[] = "xyz";
constexpr char k_distance = 'd', k_t = 't', k_limit = 'w';
constexpr char k_most = '<', k_least = '>', k_equal = '=';

char comparison(unsigned char op) {
  switch (op) {
    case SQLITE_INDEX_CONSTRAINT_EQ:
      return k_equal;
    case SQLITE_INDEX_CONSTRAINT_LT:
    case SQLITE_INDEX_CONSTRAINT_LE:
      return k_most;
    case SQLITE_INDEX_CONSTRAINT_GT:
    case SQLITE_INDEX_CONSTRAINT_GE:
      return k_least;
    default:
      return 0;
  }
}

/// What a limited column is called in a plan; 0 if a limit on it is of no use.
char letter(const TableColumns& columns, int column, bool has_ray) {
  if (column < 0) return 0;
  switch (columns.kind(column)) {
    case TableColumns::Kind::axis:
      return k_axes[columns.axis(column)];
    case TableColumns::Kind::distance:
      return has_ray ? k_distance : '\0';
    case TableColumns::Kind::t:
      return has_ray ? k_t : '\0';
    default:
      return 0;
  }
}

RowOrder order_of(const TableColumns& columns, const sqlite3_index_info& info, bool has_ray) {
  if (!has_ray || info.nOrderBy != 1 || info.aOrderBy[0].desc || info.aOrderBy[0].iColumn < 0)
    return RowOrder::stored;
  switch (columns.kind(info.aOrderBy[0].iColumn)) {
    case TableColumns::Kind::distance:
      return RowOrder::distance;
    case TableColumns::Kind::t:
      return RowOrder::t;
    default:
      return RowOrder::stored;
  }
}

/// Narrows an interval by a comparison. False if no number fulfils it.
bool narrow(Interval& limits, char how, sqlite3_value* value) {
  const int type = sqlite3_value_type(value);
  if (type == SQLITE_NULL) return false;
  // Comparing with text is SQLite's affair, and so is an integer that no double holds.
  if (type != SQLITE_INTEGER && type != SQLITE_FLOAT) return true;
  constexpr sqlite3_int64 k_exact = sqlite3_int64{1} << 53;
  if (type == SQLITE_INTEGER && std::abs(sqlite3_value_int64(value)) > k_exact) return true;
  const double number = sqlite3_value_double(value);
  if (how != k_most) limits.low = std::max(limits.low, number);
  if (how != k_least) limits.high = std::min(limits.high, number);
  return true;
}

std::optional<PointFilter> none() {
  return std::nullopt;
}

}  // namespace

TableColumns::Kind TableColumns::kind(int column) const {
  if (column >= 1 && column <= 3) return Kind::axis;
  const int hidden = column - first_hidden();
  if (hidden < 0) return Kind::stored;
  if (hidden < 6) return Kind::argument;
  return hidden == 6 ? Kind::chunk : hidden == 7 ? Kind::distance : Kind::t;
}

std::string TableColumns::declaration() const {
  const auto stored_text = [](const StoredColumn& column) {
    const bool is_whole = column.type != ScalarType::float32 && column.type != ScalarType::float64 &&
                          column.scale == 1.0 && column.offset == 0.0;
    return sql_name(column.name) + (column.type == ScalarType::bytes ? " BLOB"
                                    : is_whole                       ? " INTEGER"
                                                                     : " REAL");
  };
  std::string text = "CREATE TABLE cloud(" + stored_text(stored_.front()) + ", x REAL, y REAL, z REAL";
  for (std::size_t i = 1; i < stored_.size(); ++i) text += ", " + stored_text(stored_[i]);
  for (const char* const name : {"ox", "oy", "oz", "dx", "dy", "dz", "_chunk", "dist", "t"})
    text += std::string(", ") + name + " HIDDEN";
  return text + ")";
}

int choose_plan(const TableColumns& columns, std::uint64_t point_count, sqlite3_index_info& info) {
  int arguments[6];
  std::ranges::fill(arguments, -1);
  for (int i = 0; i < info.nConstraint; ++i) {
    const auto& constraint = info.aConstraint[i];
    if (constraint.iColumn < 0 || columns.kind(constraint.iColumn) != TableColumns::Kind::argument) continue;
    if (constraint.op != SQLITE_INDEX_CONSTRAINT_EQ) continue;
    if (!constraint.usable) return SQLITE_CONSTRAINT;
    arguments[columns.argument(constraint.iColumn)] = i;
  }
  const auto given = std::ranges::count_if(arguments, [](int place) { return place >= 0; });
  if (given != 0 && given != 6) {
    throw Error({.problem = "a cloud takes a ray's six numbers or none",
                 .expected = "cloud(ox, oy, oz, dx, dy, dz)",
                 .found = std::to_string(given) + " of them"});
  }
  std::string plan;
  int used = 0;
  const auto use = [&](int constraint, char what, char how, bool is_settled) {
    info.aConstraintUsage[constraint].argvIndex = ++used;
    info.aConstraintUsage[constraint].omit = is_settled ? 1 : 0;
    plan += what;
    plan += how;
  };
  const bool has_ray = given == 6;
  for (std::size_t i = 0; has_ray && i < 6; ++i)
    use(arguments[i], static_cast<char>(k_first_argument + static_cast<char>(i)), k_equal, true);
  double share = 1.0;
  for (int i = 0; i < info.nConstraint; ++i) {
    const auto& constraint = info.aConstraint[i];
    if (!constraint.usable) continue;
    if (constraint.op == SQLITE_INDEX_CONSTRAINT_FUNCTION &&
        columns.kind(constraint.iColumn) == TableColumns::Kind::chunk) {
      use(i, k_limit, k_equal, false);
      share *= 0.01;
      continue;
    }
    const char what = letter(columns, constraint.iColumn, has_ray), how = comparison(constraint.op);
    if (what == 0 || how == 0) continue;
    use(i, what, how, false);
    share *= what == k_distance && how != k_least ? 0.01 : 0.5;
  }
  const RowOrder order = order_of(columns, info, has_ray);
  info.orderByConsumed = order == RowOrder::stored ? 0 : 1;
  info.idxNum = static_cast<int>(order);
  info.idxStr = sqlite3_mprintf("%s", plan.c_str());
  if (info.idxStr == nullptr) return SQLITE_NOMEM;
  info.needToFreeIdxStr = 1;
  const double rows = std::max(1.0, share * static_cast<double>(point_count));
  info.estimatedRows = static_cast<sqlite3_int64>(rows);
  info.estimatedCost = 100.0 + rows;
  return SQLITE_OK;
}

std::optional<PointFilter> plan_filter(const char* plan, std::span<sqlite3_value* const> values,
                                       Arguments& arguments) {
  PointFilter filter;
  std::vector<DistanceLimit> limits;
  arguments.reset();
  std::size_t next = 0;
  if (plan[0] == k_first_argument) {
    const auto six = numbers<6>(values.first(6), "the ray of a cloud");
    if (!six) return none();
    const auto& [ox, oy, oz, dx, dy, dz] = *six;
    filter.lines.push_back({.ray = make_ray({ox, oy, oz}, {dx, dy, dz})});
    arguments = *six;
    next = 6;
  }
  for (; next < values.size(); ++next) {
    const char what = plan[2 * next], how = plan[2 * next + 1];
    sqlite3_value* const value = values[next];
    if (what == k_limit) {
      if (sqlite3_value_type(value) == SQLITE_NULL) return none();
      const auto* const bytes = static_cast<const std::byte*>(sqlite3_value_blob(value));
      limits.push_back(decode_distance_limit({bytes, static_cast<std::size_t>(sqlite3_value_bytes(value))}));
    } else if (what == k_distance || what == k_t) {
      LineCondition& line = filter.lines.front();
      if (!narrow(what == k_t ? line.t : line.distance, how, value)) return none();
    } else {
      const int axis = what - k_axes[0];
      Interval side{filter.box.min[axis], filter.box.max[axis]};
      if (!narrow(side, how, value)) return none();
      filter.box.min[axis] = side.low;
      filter.box.max[axis] = side.high;
    }
  }
  // Where one of them is an error, the rows for which it is one must be met.
  if (std::ranges::none_of(limits,
                           [](const auto& limit) { return limit.kind == DistanceLimit::Kind::none; })) {
    for (const DistanceLimit& limit : limits) add(limit, filter);
  }
  return filter;
}

}  // namespace alidade
