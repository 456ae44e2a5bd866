// SPDX-License-Identifier: MIT
#include "database/sqlite/functions.h"

#include <algorithm>
#include <cstring>

#include "base/error.h"

namespace alidade::database {
namespace {

constexpr std::size_t k_head = 4;
constexpr std::byte k_mark[k_head - 1] = {std::byte{'a'}, std::byte{'l'}, std::byte{'d'}};

using Values = std::span<sqlite3_value* const>;

/// A function of SQL; its errors begin with `name`.
struct SqlFunction {
  const char* name;
  int arguments;
  void (*set_result)(sqlite3_context*, Values, const char* name);
};

/// Calls the SqlFunction that is the user data of the context.
void call(sqlite3_context* context, int count, sqlite3_value** values) {
  const auto& function = *static_cast<const SqlFunction*>(sqlite3_user_data(context));
  const int result = guarded(
      [&] { function.set_result(context, Values(values, static_cast<std::size_t>(count)), function.name); },
      [&](const std::string& message) {
        const std::string name = function.name;
        const std::string text = message.starts_with(name) ? message : name + ": " + message;
        sqlite3_result_error(context, text.c_str(), -1);
      });
  if (result == SQLITE_NOMEM) sqlite3_result_error_nomem(context);
}

template <DistanceKind kind>
void dist(sqlite3_context* context, Values values, const char* name) {
  const auto n = numbers<9>(values, name);
  if (!n) return;
  const auto& [px, py, pz, dx, dy, dz, x, y, z] = *n;
  sqlite3_result_double(context,
                        distance(kind, make_line(kind, {px, py, pz}, {dx, dy, dz}), glm::dvec3(x, y, z)));
}

void set_limit(sqlite3_context* context, const DistanceLimit& limit) {
  const std::vector<std::byte> bytes = encode(limit);
  sqlite3_result_blob64(context, bytes.data(), bytes.size(), SQLITE_TRANSIENT);
}

template <DistanceKind kind>
void limit(sqlite3_context* context, Values values, const char* name) {
  const auto given = numbers<8>(values, name);
  DistanceLimit limit{.kind = kind};
  if (given) {
    limit.numbers = *given;
  } else {
    // An invalid ray is an error also if a limit is NULL.
    const auto ray = numbers<6>(values.first(6), name);
    if (!ray) return;
    std::ranges::copy(*ray, limit.numbers.begin());
  }
  PointFilter filter;
  add(limit, filter);
  if (given) set_limit(context, limit);
}

template <DistanceKind kind>
void try_limit(sqlite3_context* context, Values values, const char* name) {
  try {
    limit<kind>(context, values, name);
  } catch (const Error&) {
    set_limit(context, DistanceLimit{});
  }
}

constexpr SqlFunction k_functions[] = {
    {"dist_ray", 9, dist<DistanceKind::ray>},
    {"dist_plane", 9, dist<DistanceKind::plane>},
    {"ray_limit", 8, limit<DistanceKind::ray>},
    {"plane_limit", 8, limit<DistanceKind::plane>},
    {"try_ray_limit", 8, try_limit<DistanceKind::ray>},
    {"try_plane_limit", 8, try_limit<DistanceKind::plane>},
};

struct SetResult {
  sqlite3_context* context;
  void operator()(std::monostate) const {}
  void operator()(std::int64_t whole) const { sqlite3_result_int64(context, whole); }
  void operator()(std::uint64_t whole) const { (*this)(static_cast<double>(whole)); }
  void operator()(double number) const { sqlite3_result_double(context, number); }
  void operator()(std::span<const std::byte> bytes) const {
    sqlite3_result_blob64(context, bytes.data(), bytes.size(), SQLITE_TRANSIENT);
  }
};

}  // namespace

void set_result(sqlite3_context* context, const ColumnValue& value) {
  std::visit(SetResult{context}, value);
}

std::vector<std::byte> encode(const DistanceLimit& limit) {
  std::vector<std::byte> bytes(k_head + sizeof limit.numbers);
  std::memcpy(bytes.data(), k_mark, sizeof k_mark);
  if (limit.kind) bytes[k_head - 1] = static_cast<std::byte>(*limit.kind);
  std::memcpy(bytes.data() + k_head, limit.numbers.data(), sizeof limit.numbers);
  return bytes;
}

DistanceLimit decode_distance_limit(std::span<const std::byte> bytes) {
  DistanceLimit limit;
  const bool is_one = bytes.size() == k_head + sizeof limit.numbers &&
                      std::memcmp(bytes.data(), k_mark, sizeof k_mark) == 0 &&
                      bytes[k_head - 1] <= static_cast<std::byte>(DistanceKind::plane);
  check_that(is_one, "in_chunk: argument 2 is not a limit", "ray_limit(...) or plane_limit(...)");
  if (bytes[k_head - 1] != std::byte{0}) limit.kind = static_cast<DistanceKind>(bytes[k_head - 1]);
  std::memcpy(limit.numbers.data(), bytes.data() + k_head, sizeof limit.numbers);
  return limit;
}

void add(const DistanceLimit& limit, PointFilter& filter) {
  const auto& [px, py, pz, dx, dy, dz, least, largest] = limit.numbers;
  if (limit.kind)
    filter.add(*limit.kind, make_line(*limit.kind, {px, py, pz}, {dx, dy, dz}), {least, largest});
}

void in_chunk(sqlite3_context* context, int, sqlite3_value** values) {
  if (sqlite3_value_type(values[1]) != SQLITE_NULL) sqlite3_result_int(context, 1);
}

int add_functions(sqlite3* database) {
  const auto add = [&](const char* name, int count, const SqlFunction* data, auto function) {
    constexpr int k_flags = SQLITE_UTF8 | SQLITE_DETERMINISTIC | SQLITE_INNOCUOUS;
    return sqlite3_create_function_v2(database, name, count, k_flags, const_cast<SqlFunction*>(data),
                                      function, nullptr, nullptr, nullptr);
  };
  int result = add("in_chunk", 2, nullptr, in_chunk);
  for (const SqlFunction& function : k_functions) {
    if (result == SQLITE_OK) result = add(function.name, function.arguments, &function, call);
  }
  return result;
}

}  // namespace alidade::database
