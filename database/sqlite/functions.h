// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <array>
#include <cstddef>
#include <exception>
#include <new>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "base/shown_text.h"
#include "database/point_filter.h"
#include "database/sqlite/connection.h"
#include "database/stored_column.h"

// The functions of SQL, and what they share with the virtual tables.

namespace alidade::database {

/// Runs `work`, which returns SQLite's code or nothing, in a callback of SQLite, through which no exception
/// may pass: its message goes to `fail` as line_text() (base/shown_text.h). Returns SQLite's code.
template <class Work, class Fail>
int guarded(const Work& work, const Fail& fail) {
  try {
    if constexpr (std::is_void_v<decltype(work())>) {
      work();
      return SQLITE_OK;
    } else {
      return work();
    }
  } catch (const std::bad_alloc&) {
    return SQLITE_NOMEM;
  } catch (const SqliteError& error) {
    fail(line_text(error.what()).c_str());
    return error.code();
  } catch (const std::exception& error) {
    fail(line_text(error.what()).c_str());
    return SQLITE_ERROR;
  }
}

/// Sets the result of a function of SQL, or the value of a virtual table's column.
void set_result(sqlite3_context* context, const ColumnValue& value);

/// The values of arguments that are numbers; empty if one of them is NULL. Errors: an argument is neither a
/// number nor NULL; the message has `function` and its number, from 1.
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
      throw Error({.problem = fmt::format("{}: invalid argument {}", function, i + 1),
                   .expected = "a number or NULL",
                   .found = type == SQLITE_TEXT ? "text" : "a blob"});
    }
  }
  if (is_null) return std::nullopt;
  return result;
}

/// A limit on dist_ray or dist_plane as one value of SQL: the result of ray_limit() and plane_limit(), and
/// the argument of in_chunk().
struct DistanceLimit {
  std::optional<DistanceKind> kind{};  ///< empty: no limit
  /// Origin and direction or normal, as they were given; least and largest distance, inclusive.
  std::array<double, 8> numbers{};
};

std::vector<std::byte> encode(const DistanceLimit& limit);

/// Errors: the bytes are not a result of encode().
DistanceLimit decode_distance_limit(std::span<const std::byte> bytes);

/// Adds the limit to the conditions of a filter. Errors: those of make_line().
void add(const DistanceLimit& limit, PointFilter& filter);

/// Registers with a connection the functions
///   dist_ray(ox,oy,oz, dx,dy,dz, x,y,z)    distance of a point to the line through o along d (eq. 1)
///   dist_plane(px,py,pz, nx,ny,nz, x,y,z)  signed distance to the plane through p across n (eq. 2)
///   ray_limit(ox,..,dz, least, largest), plane_limit(px,..,nz, least, largest), in_chunk(_chunk, limit):
///     in_chunk is 1 for every point. As a condition on a table of the module it skips chunks without points
///     within the limit, and may also skip other points beyond it. Which ones depends on the plan, so it must
///     be used together with the condition on the distance that it repeats.
/// Lengths are in the unit of the coordinates; directions and normals have any length but zero. The result is
/// NULL if an argument is NULL. Errors of SQL: text or a blob in place of a number; a direction that is zero
/// or not finite; a position of the ray or plane that is not finite. The distance of a point that is not
/// finite is NULL or infinite. Returns SQLite's code.
int add_functions(sqlite3* database);

/// in_chunk() as SQLite calls it.
void in_chunk(sqlite3_context* context, int count, sqlite3_value** values);

}  // namespace alidade::database
