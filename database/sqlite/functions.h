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

// Values between SQLite and the functions and tables of the module.

namespace alidade::database {

/// Runs `work`, which returns SQLite's code or nothing, for a callback of SQLite, through which no exception
/// may pass; calls `fail` with the message as line_text() (base/shown_text.h).
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

/// Sets the result of a function of SQL to the value of a column.
void answer(sqlite3_context* context, const ColumnValue& value);

/// The numbers of some arguments; empty if one of them is NULL. Errors: one is neither number nor NULL, named
/// with `function` and counted from 1.
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

/// A limit on dist_ray or dist_plane as one SQL value, the result of ray_limit() and plane_limit() and
/// the argument of in_chunk().
struct DistanceLimit {
  enum class Kind : unsigned char { none, ray, plane };
  Kind kind = Kind::none;
  /// Origin and direction or normal, as they were given; least and largest distance, inclusive.
  std::array<double, 8> numbers{};
};

std::vector<std::byte> encode(const DistanceLimit& limit);

/// Errors: the bytes are not a result of encode().
DistanceLimit decode_distance_limit(std::span<const std::byte> bytes);

/// Adds the limit to the conditions of a filter; Kind::none adds nothing. Errors: as
/// make_ray() and make_plane().
void add(const DistanceLimit& limit, PointFilter& filter);

/// Registers with a connection the functions
///   dist_ray(ox,oy,oz, dx,dy,dz, x,y,z)    distance of a point to the line through o along d (eq. 1)
///   dist_plane(px,py,pz, nx,ny,nz, x,y,z)  signed distance to the plane through p across n (eq. 2)
///   ray_limit(ox,..,dz, least, largest), plane_limit(px,..,nz, least, largest), in_chunk(_chunk, limit):
///     in_chunk is 1 for every point; as a condition on a table of the module it may leave out points whose
///     distance is not within the limit, and skips chunks without others. Which points it leaves out depends
///     on the plan: it must be used together with the condition on the distance from which it is made.
/// Lengths are in the unit of the coordinates; directions and normals of any length but zero. The result is
/// NULL if an argument is NULL. Errors, in SQL: text or blobs for numbers, directions that are zero or not
/// finite, positions of the ray or plane that are not finite; the distance to a point that is not finite is
/// NULL or infinite. Returns SQLite's code.
int add_functions(sqlite3* database);

/// The implementation of in_chunk() for SQLite.
void in_chunk(sqlite3_context* context, int count, sqlite3_value** values);

/// Registers with a connection the virtual table module pointcloud: CREATE VIRTUAL TABLE name
/// USING pointcloud gives access to the points in the tables name_*
/// (database/sqlite/cloud_schema.h), with the columns
///   id, x, y, z and those of NAME_column
/// and hidden ones: the arguments ox, oy, oz, dx, dy, dz of the form name(ox, oy, oz, dx, dy, dz), dist and t
/// of that ray, and _chunk for in_chunk(). With conditions on x, y, z, dist, t and in_chunk(), also between
/// tables of a join, chunks without such points are not read; ORDER BY t or dist reads only the chunks of the
/// rows that are fetched. The tables are read-only. They can be renamed and dropped; one whose stored tables
/// cannot be read can only be replaced (StoreOptions::replace). Scans add their counts to `reads` when they
/// end, if it is given; it must outlive the connection. Returns SQLite's code.
int add_cloud_table(sqlite3* database, ScanReads* reads = nullptr);

/// Registers with a connection the virtual table module alidade, for cloud files that are not loaded:
///   CREATE VIRTUAL TABLE temp.name USING alidade('site.laz')
/// with one or more names of files, folders and patterns (FileCloud, database/sqlite/file_cloud.h) as SQL
/// text, which are one cloud. Columns, and the conditions that skip chunks, are those of a pointcloud table
/// into which the files are loaded, and so are rows except for their order and rowid. Files are opened when
/// the table is made, and remain open until it is dropped or the connection is closed; a file that has
/// changed since then is an error of the next statement.
///
/// Such tables belong to one connection: they are in `temp`, or in a database in memory. They cannot be
/// made in a database file, and one in the schema of a file is not opened; one in a database in memory
/// is connected again only while its schema is trusted (SQLITE_DBCONFIG_TRUSTED_SCHEMA). Views and
/// triggers cannot use them, except temporary ones (SQLITE_VTAB_DIRECTONLY). So only files are read that
/// a user's own statement names. Null `tables`: the default options; otherwise it must outlive the
/// connection. Returns SQLite's code.
int add_file_tables(sqlite3* database, const FileTables* tables = nullptr);

}  // namespace alidade::database
