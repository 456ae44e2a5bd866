// SPDX-License-Identifier: MIT
#include "database/sqlite/scan.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "database/sqlite/functions.h"

namespace alidade::database {

namespace {

// A plan's text has two characters for each value that the scan gets: what it limits, and how.
constexpr char k_first_argument = 'A';  // to 'F'
constexpr char k_axes[] = "xyz";
constexpr char k_distance = 'd', k_t = 't', k_limit = 'w', k_chunk = 'c', k_row = 'r';
constexpr char k_most = '<', k_least = '>', k_equal = '=';

using ColumnKind = TableColumns::Kind;

char comparison(unsigned char op) {
  if (op == SQLITE_INDEX_CONSTRAINT_LT || op == SQLITE_INDEX_CONSTRAINT_LE) return k_most;
  if (op == SQLITE_INDEX_CONSTRAINT_GT || op == SQLITE_INDEX_CONSTRAINT_GE) return k_least;
  return op == SQLITE_INDEX_CONSTRAINT_EQ ? k_equal : '\0';
}

/// The sign of a limited column in a plan; 0 if a limit on it is of no use.
char sign_of(const TableColumns& columns, int column, bool has_ray) {
  if (column < 0) return 0;
  const ColumnKind kind = columns.kind(column);
  if (kind == ColumnKind::axis) return k_axes[columns.axis(column)];
  if (!has_ray) return 0;
  return kind == ColumnKind::distance ? k_distance : kind == ColumnKind::t ? k_t : '\0';
}

RowOrder order_of(const TableColumns& columns, const sqlite3_index_info& info, bool has_ray) {
  if (!has_ray || info.nOrderBy != 1 || info.aOrderBy[0].desc || info.aOrderBy[0].iColumn < 0)
    return RowOrder::stored;
  const ColumnKind kind = columns.kind(info.aOrderBy[0].iColumn);
  return kind == ColumnKind::distance ? RowOrder::distance
         : kind == ColumnKind::t      ? RowOrder::t
                                      : RowOrder::stored;
}

/// Narrows an interval by a comparison. False if no number fulfils it.
bool narrow(Interval& limits, char how, sqlite3_value* value) {
  const int type = sqlite3_value_type(value);
  if (type == SQLITE_NULL) return false;
  // Comparisons with text are left to SQLite, and so are those with integers that no double holds.
  if (type != SQLITE_INTEGER && type != SQLITE_FLOAT) return true;
  constexpr sqlite3_int64 k_exact = sqlite3_int64{1} << 53;
  if (type == SQLITE_INTEGER) {
    const sqlite3_int64 whole = sqlite3_value_int64(value);
    if (whole > k_exact || whole < -k_exact) return true;
  }
  const double number = sqlite3_value_double(value);
  if (how != k_most) limits.low = std::max(limits.low, number);
  if (how != k_least) limits.high = std::min(limits.high, number);
  return true;
}

/// Narrows the chunks to the one of a row id or with a number. False if there can be none.
bool narrow(std::optional<std::uint64_t>& only, char what, sqlite3_value* value) {
  const int type = sqlite3_value_type(value);
  if (type == SQLITE_NULL) return false;
  if (type != SQLITE_INTEGER && type != SQLITE_FLOAT) return true;  // left to SQLite
  constexpr double k_end = 9223372036854775808.0;
  const double about = sqlite3_value_double(value);
  if (!(about >= 0.0)) return false;
  if (type == SQLITE_FLOAT && about >= k_end) return false;
  const sqlite3_int64 number =
      type == SQLITE_INTEGER ? sqlite3_value_int64(value) : static_cast<sqlite3_int64>(about);
  const auto chunk = static_cast<std::uint64_t>(number) >> (what == k_row ? k_row_bits : 0);
  if (only && *only != chunk) return false;
  only = chunk;
  return true;
}

std::optional<ScanFilter> none() {
  return std::nullopt;
}

/// The constraints of the six arguments.
struct GivenArguments {
  std::array<int, 6> constraints;  ///< their indices; -1 for those that are not given
  bool is_complete = true, are_usable = true;

  GivenArguments(const TableColumns& columns, const sqlite3_index_info& info) {
    constraints.fill(-1);
    for (int i = 0; i < info.nConstraint; ++i) {
      const auto& constraint = info.aConstraint[i];
      if (constraint.iColumn < 0 || constraint.op != SQLITE_INDEX_CONSTRAINT_EQ ||
          columns.kind(constraint.iColumn) != TableColumns::Kind::argument)
        continue;
      int& index = constraints[columns.argument(constraint.iColumn)];
      if (index < 0 || constraint.usable) index = i;
    }
    for (const int index : constraints) {
      is_complete &= index >= 0;
      are_usable &= index < 0 || info.aConstraint[index].usable;
    }
  }
};

/// Whether a condition is on a column that only the form with a ray has.
bool needs_ray(const TableColumns& columns, int column) {
  if (column < 0) return false;
  const ColumnKind kind = columns.kind(column);
  return kind == ColumnKind::argument || kind == ColumnKind::distance || kind == ColumnKind::t;
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
    text += ", " + line_column(stored_, name) + " HIDDEN";
  return text + ")";
}

int choose_plan(const TableColumns& columns, std::uint64_t point_count, sqlite3_index_info& info) {
  const GivenArguments given(columns, info);
  if (given.is_complete && !given.are_usable) return SQLITE_CONSTRAINT;
  std::string plan;
  int used = 0;
  const auto use = [&](int constraint, char what, char how, bool is_settled) {
    info.aConstraintUsage[constraint].argvIndex = ++used;
    info.aConstraintUsage[constraint].omit = is_settled ? 1 : 0;
    plan += what;
    plan += how;
  };
  const bool has_ray = given.is_complete;
  for (std::size_t i = 0; has_ray && i < 6; ++i)
    use(given.constraints[i], static_cast<char>(k_first_argument + static_cast<char>(i)), k_equal, true);
  double share = 1.0, cost = 100.0;
  for (int i = 0; i < info.nConstraint; ++i) {
    const auto& constraint = info.aConstraint[i];
    // Such rows are errors: any plan without them is better.
    if (!has_ray && needs_ray(columns, constraint.iColumn)) cost = 1e30;
    if (!constraint.usable) continue;
    const bool is_row = constraint.iColumn < 0;
    const bool is_chunk = !is_row && columns.kind(constraint.iColumn) == TableColumns::Kind::chunk;
    if (constraint.op == SQLITE_INDEX_CONSTRAINT_EQ && (is_row || is_chunk)) {
      check_that(!is_chunk || !has_ray, "a ray and a chunk number exclude each other", k_ray_form);
      use(i, is_row ? k_row : k_chunk, k_equal, false);
      share = std::min(share, (is_row ? 1.0 : 1024.0) / std::max(1.0, static_cast<double>(point_count)));
      continue;
    }
    if (constraint.op == SQLITE_INDEX_CONSTRAINT_FUNCTION && is_chunk) {
      use(i, k_limit, k_equal, false);
      share *= 0.01;
      continue;
    }
    const char what = sign_of(columns, constraint.iColumn, has_ray), how = comparison(constraint.op);
    if (what == 0 || how == 0) continue;
    use(i, what, how, false);
    share *= how == k_equal ? 0.001 : what == k_distance && how == k_most ? 0.01 : 0.5;
  }
  const RowOrder order = order_of(columns, info, has_ray);
  info.orderByConsumed = order == RowOrder::stored ? 0 : 1;
  info.idxNum = static_cast<int>(order);
  info.idxStr = sqlite3_mprintf("%s", plan.c_str());
  if (info.idxStr == nullptr) return SQLITE_NOMEM;
  info.needToFreeIdxStr = 1;
  const double rows = std::max(1.0, share * static_cast<double>(point_count));
  info.estimatedRows = static_cast<sqlite3_int64>(rows);
  info.estimatedCost = cost + rows;
  return SQLITE_OK;
}

std::optional<ScanFilter> plan_filter(const char* plan, std::span<sqlite3_value* const> values,
                                      Arguments& arguments) {
  ScanFilter scan;
  PointFilter& filter = scan.points;
  std::vector<DistanceLimit> limits;
  bool has_null_limit = false;
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
    if (what == k_row || what == k_chunk) {
      if (!narrow(scan.only_chunk, what, value)) return none();
    } else if (what == k_limit) {
      if (sqlite3_value_type(value) == SQLITE_NULL) {
        has_null_limit = true;
        continue;
      }
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
  // If one of them is an error, the rows with the error must be visited.
  if (std::ranges::all_of(limits, [](const auto& limit) { return limit.kind.has_value(); })) {
    if (has_null_limit) return none();
    for (const DistanceLimit& limit : limits) add(limit, filter);
  }
  return scan;
}

}  // namespace alidade::database
