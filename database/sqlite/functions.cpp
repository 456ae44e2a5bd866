// SPDX-License-Identifier: MIT
#include "database/sqlite/functions.h"

#include <fmt/format.h>
#include <algorithm>
#include <cstring>

#include "base/error.h"
#include "octree/distance.h"

namespace alidade::database {

template <std::size_t count>
std::optional<std::array<double, count>> numbers(std::span<sqlite3_value* const> values,
                                                 const char* function) {
  std::array<double, count> result{};
  bool is_null = false;
  for (std::size_t i = 0; i < count; ++i) {
    const int type = sqlite3_value_type(values[i]);
    if (type == SQLITE_NULL) {
      is_null = true;
    } else if (type == SQLITE_INTEGER || type == SQLITE_FLOAT) {
      result[i] = sqlite3_value_double(values[i]);
    } else {
      throw Error({.problem = fmt::format("{}: argument {} is no number", function, i + 1),
                   .expected = "a number or NULL",
                   .found = type == SQLITE_TEXT ? "text" : "a blob"});
    }
  }
  if (is_null) return std::nullopt;
  return result;
}

template std::optional<std::array<double, 6>> numbers<6>(std::span<sqlite3_value* const>, const char*);
template std::optional<std::array<double, 8>> numbers<8>(std::span<sqlite3_value* const>, const char*);
template std::optional<std::array<double, 9>> numbers<9>(std::span<sqlite3_value* const>, const char*);

namespace {

constexpr std::size_t k_head = 4;
constexpr std::byte k_mark[k_head - 1] = {std::byte{'a'}, std::byte{'l'}, std::byte{'d'}};

}  // namespace

std::vector<std::byte> encode(const DistanceLimit& limit) {
  std::vector<std::byte> bytes(k_head + sizeof limit.numbers);
  std::memcpy(bytes.data(), k_mark, sizeof k_mark);
  bytes[k_head - 1] = static_cast<std::byte>(limit.kind);
  std::memcpy(bytes.data() + k_head, limit.numbers.data(), sizeof limit.numbers);
  return bytes;
}

DistanceLimit decode_distance_limit(std::span<const std::byte> bytes) {
  DistanceLimit limit;
  const bool is_one = bytes.size() == k_head + sizeof limit.numbers &&
                      std::memcmp(bytes.data(), k_mark, sizeof k_mark) == 0 &&
                      bytes[k_head - 1] <= static_cast<std::byte>(DistanceLimit::Kind::plane);
  if (!is_one)
    throw Error(
        {.problem = "in_chunk: argument 2 is no limit", .expected = "ray_limit(...) or plane_limit(...)"});
  limit.kind = static_cast<DistanceLimit::Kind>(bytes[k_head - 1]);
  std::memcpy(limit.numbers.data(), bytes.data() + k_head, sizeof limit.numbers);
  return limit;
}

void add(const DistanceLimit& limit, PointFilter& filter) {
  const auto& n = limit.numbers;
  const glm::dvec3 place(n[0], n[1], n[2]), direction(n[3], n[4], n[5]);
  const Interval distance{n[6], n[7]};
  if (limit.kind == DistanceLimit::Kind::ray)
    filter.lines.push_back({.ray = make_ray(place, direction), .distance = distance});
  else if (limit.kind == DistanceLimit::Kind::plane)
    filter.planes.push_back({.plane = make_plane(place, direction), .distance = distance});
}

namespace {

// As template arguments they need a place of their own.
constexpr char k_dist_ray[] = "dist_ray";
constexpr char k_dist_plane[] = "dist_plane";
constexpr char k_ray_limit[] = "ray_limit";
constexpr char k_plane_limit[] = "plane_limit";
constexpr char k_try_ray_limit[] = "try_ray_limit";
constexpr char k_try_plane_limit[] = "try_plane_limit";

/// Wraps what computes an answer as a function of SQL, whose name its errors begin with.
template <void (*answer)(sqlite3_context*, std::span<sqlite3_value* const>), const char* name>
void call(sqlite3_context* context, int count, sqlite3_value** values) {
  const int result = guarded(
      [&] {
        answer(context, std::span(values, static_cast<std::size_t>(count)));
        return SQLITE_OK;
      },
      [&](const std::string& message) {
        const std::string text = message.starts_with(name) ? message : std::string(name) + ": " + message;
        sqlite3_result_error(context, text.c_str(), -1);
      });
  if (result == SQLITE_NOMEM) sqlite3_result_error_nomem(context);
}

using Values = std::span<sqlite3_value* const>;

void dist_ray(sqlite3_context* context, Values values) {
  const auto n = numbers<9>(values, k_dist_ray);
  if (!n) return;
  const auto& [ox, oy, oz, dx, dy, dz, x, y, z] = *n;
  const Ray ray = make_ray({ox, oy, oz}, {dx, dy, dz});
  sqlite3_result_double(context, project(ray, glm::dvec3(x, y, z)).distance);
}

void dist_plane(sqlite3_context* context, Values values) {
  const auto n = numbers<9>(values, k_dist_plane);
  if (!n) return;
  const auto& [px, py, pz, nx, ny, nz, x, y, z] = *n;
  const Plane plane = make_plane({px, py, pz}, {nx, ny, nz});
  sqlite3_result_double(context, signed_distance(plane, glm::dvec3(x, y, z)));
}

void answer(sqlite3_context* context, const DistanceLimit& limit) {
  const std::vector<std::byte> bytes = encode(limit);
  sqlite3_result_blob64(context, bytes.data(), bytes.size(), SQLITE_TRANSIENT);
}

void limit(sqlite3_context* context, Values values, DistanceLimit::Kind kind, const char* function) {
  const auto given = numbers<8>(values, function);
  DistanceLimit limit{.kind = kind};
  if (given) {
    limit.numbers = *given;
  } else {
    // What a ray is compared with does not make one of it.
    const auto ray = numbers<6>(values.first(6), function);
    if (!ray) return;
    std::ranges::copy(*ray, limit.numbers.begin());
  }
  PointFilter filter;
  add(limit, filter);
  if (given) answer(context, limit);
}

void ray_limit(sqlite3_context* context, Values values) {
  limit(context, values, DistanceLimit::Kind::ray, k_ray_limit);
}

void plane_limit(sqlite3_context* context, Values values) {
  limit(context, values, DistanceLimit::Kind::plane, k_plane_limit);
}

void try_limit(sqlite3_context* context, Values values, DistanceLimit::Kind kind) {
  try {
    limit(context, values, kind, "");
  } catch (const Error&) {
    answer(context, DistanceLimit{});
  }
}

void try_ray_limit(sqlite3_context* context, Values values) {
  try_limit(context, values, DistanceLimit::Kind::ray);
}

void try_plane_limit(sqlite3_context* context, Values values) {
  try_limit(context, values, DistanceLimit::Kind::plane);
}

}  // namespace

void in_chunk(sqlite3_context* context, int, sqlite3_value** values) {
  if (sqlite3_value_type(values[1]) != SQLITE_NULL) sqlite3_result_int(context, 1);
}

int add_functions(sqlite3* database) {
  constexpr int k_flags = SQLITE_UTF8 | SQLITE_DETERMINISTIC | SQLITE_INNOCUOUS;
  const auto add = [&](const char* name, int count, auto function) {
    return sqlite3_create_function_v2(database, name, count, k_flags, nullptr, function, nullptr, nullptr,
                                      nullptr);
  };
  int result = add(k_dist_ray, 9, call<dist_ray, k_dist_ray>);
  if (result == SQLITE_OK) result = add(k_dist_plane, 9, call<dist_plane, k_dist_plane>);
  if (result == SQLITE_OK) result = add(k_ray_limit, 8, call<ray_limit, k_ray_limit>);
  if (result == SQLITE_OK) result = add(k_plane_limit, 8, call<plane_limit, k_plane_limit>);
  if (result == SQLITE_OK) result = add(k_try_ray_limit, 8, call<try_ray_limit, k_try_ray_limit>);
  if (result == SQLITE_OK) result = add(k_try_plane_limit, 8, call<try_plane_limit, k_try_plane_limit>);
  if (result == SQLITE_OK) result = add("in_chunk", 2, in_chunk);
  return result;
}

}  // namespace alidade::database
