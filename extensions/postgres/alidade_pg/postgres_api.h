// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <string>
#include <type_traits>

// PostgreSQL's headers redefine names of the standard library (snprintf), so those it uses come first.

// PostgreSQL 15 marks exported symbols only on Windows.
#define PGDLLEXPORT __attribute__((visibility("default")))
extern "C" {
#include <postgres.h>
//
#include <fmgr.h>
}

/// Starts the definition of a function that SQL calls: ALIDADE_SQL_FUNCTION(name) { ... PG_RETURN_...; }
/// Errors of PostgreSQL leave it by longjmp, so no object in its frame may need a destructor while
/// PostgreSQL is called.
#define ALIDADE_SQL_FUNCTION(name)          \
  extern "C" {                              \
  PGDLLEXPORT Datum name(PG_FUNCTION_ARGS); \
  PG_FUNCTION_INFO_V1(name);                \
  }                                         \
  Datum name([[maybe_unused]] FunctionCallInfo fcinfo)

/// Defines one that returns the value of an expression: ALIDADE_SQL_ANSWER(name, BoolGetDatum(...));
#define ALIDADE_SQL_ANSWER(name, ...) \
  ALIDADE_SQL_FUNCTION(name) {        \
    return __VA_ARGS__;               \
  }                                   \
  extern "C" Datum name(PG_FUNCTION_ARGS)

namespace alidade::database {

/// Runs work that may throw and does not call PostgreSQL. An exception becomes an error of SQL after
/// all C++ objects have been destroyed.
template <class Work>
auto guarded(const Work& work) -> decltype(work()) {
  static_assert(std::is_trivially_destructible_v<decltype(work())>);
  char message[256];
  try {
    return work();
  } catch (const std::exception& error) {
    strlcpy(message, error.what(), sizeof message);
  }
  ereport(ERROR, (errcode(ERRCODE_INVALID_PARAMETER_VALUE), errmsg("%s", message)));
}

/// The C function of a function of SQL.
inline PGFunction address_of(Oid function) {
  FmgrInfo info;
  fmgr_info(function, &info);
  return info.fn_addr;
}

/// An argument of one of the extension's types, which PostgreSQL passes by reference.
template <class Value>
const Value& value_of(Datum datum) {
  return *reinterpret_cast<const Value*>(DatumGetPointer(datum));
}

/// The argument of this number of a function of SQL.
template <class Value>
const Value& argument(FunctionCallInfo fcinfo, int number) {
  return value_of<Value>(PG_GETARG_DATUM(number));
}

/// A value of one of the extension's types for PostgreSQL, in the current memory context.
template <class Value>
Datum datum_of(const Value& value) {
  static_assert(std::is_trivially_copyable_v<Value>);
  void* const copy = palloc(sizeof value);
  std::memcpy(copy, &value, sizeof value);
  return PointerGetDatum(copy);
}

}  // namespace alidade::database

// Functions of SQL that the planner's support recognises in expressions.
extern "C" {
Datum alidade_distance_to_ray(PG_FUNCTION_ARGS);
Datum alidade_distance_to_plane(PG_FUNCTION_ARGS);
Datum alidade_keeps_limit(PG_FUNCTION_ARGS);
Datum alidade_breaks_limit(PG_FUNCTION_ARGS);
Datum alidade_limit_by_plane(PG_FUNCTION_ARGS);
}
