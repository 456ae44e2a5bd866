// SPDX-License-Identifier: MIT
// The SQL types: their input and output as text and bytes, the functions that make their values, and those of
// distances and limits. Errors are PostgreSQL's.
#include <array>
#include <span>
#include <string_view>

#include "extensions/postgres/alidade_pg/cloud_limit.h"
#include "extensions/postgres/alidade_pg/postgres_api.h"

extern "C" {
#include <lib/stringinfo.h>
#include <libpq/pqformat.h>
#include <utils/builtins.h>
#include <utils/float.h>

PG_MODULE_MAGIC;
}

namespace alidade::database {
namespace {

const char* skip_spaces(const char* text) {
  return text + std::strspn(text, " \t\n\r\v\f");
}

/// Ends with the error that a text is not of the type.
[[noreturn]] void reject_text(const char* all, const char* type) {
  ereport(ERROR, (errcode(ERRCODE_INVALID_TEXT_REPRESENTATION),
                  errmsg("invalid input syntax for type %s: \"%s\"", type, all)));
}

/// Reads "(1,2,3)", with optional spaces, up to the end of the text. `text`: the part of `all` to read;
/// error messages have the type and all of the text.
void read_numbers(const char* text, const char* all, const char* type, std::span<double> numbers) {
  const char* cursor = skip_spaces(text);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (*cursor != (i == 0 ? '(' : ',')) reject_text(all, type);
    // PostgreSQL's own parser has a parameter of type char*, but only reads.
    char* end = nullptr;
    numbers[i] = float8in_internal(const_cast<char*>(cursor + 1), &end, type, all);
    cursor = skip_spaces(end);
  }
  if (*cursor != ')' || *skip_spaces(cursor + 1) != '\0') reject_text(all, type);
}

using Six = std::array<double, 6>;

Six numbers_of(const CloudLine& line) {
  return {line.position.x,  line.position.y,  line.position.z,
          line.direction.x, line.direction.y, line.direction.z};
}

/// The first six numbers.
template <class Numbers>
CloudLine line_of(DistanceKind kind, const Numbers& n) {
  return guarded([&] { return make_line(kind, {n[0], n[1], n[2]}, {n[3], n[4], n[5]}); });
}

Six numbers_of(const Bounds& box) {
  return {box.min.x, box.min.y, box.min.z, box.max.x, box.max.y, box.max.z};
}

Bounds box_of_numbers(const Six& n) {
  const Bounds box{{n[0], n[1], n[2]}, {n[3], n[4], n[5]}};
  if (box.empty())
    ereport(ERROR, (errcode(ERRCODE_INVALID_PARAMETER_VALUE),
                    errmsg("the minimum of a box must not exceed its maximum")));
  return box;
}

std::array<double, 3> numbers_of(const glm::dvec3& point) {
  return {point.x, point.y, point.z};
}

std::array<double, 8> numbers_of(const CloudLimit& limit) {
  const Six n = numbers_of(limit.line);
  return {n[0], n[1], n[2], n[3], n[4], n[5], limit.least, limit.largest};
}

CloudLimit limit_of(DistanceKind kind, const std::array<double, 8>& n) {
  return {.line = line_of(kind, n), .least = n[6], .largest = n[7], .kind = kind};
}

/// Numbers with the precision of the setting extra_float_digits, by default exact.
template <class Numbers>
Datum text_of(const char* prefix, const Numbers& numbers) {
  StringInfoData written;
  initStringInfo(&written);
  appendStringInfoString(&written, prefix);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    appendStringInfoChar(&written, i == 0 ? '(' : ',');
    appendStringInfoString(&written, float8out_internal(numbers[i]));
  }
  appendStringInfoChar(&written, ')');
  return CStringGetDatum(written.data);
}

template <class Numbers>
Datum message_of(const Numbers& numbers, const DistanceKind* kind = nullptr) {
  StringInfoData message;
  pq_begintypsend(&message);
  if (kind != nullptr) pq_sendbyte(&message, static_cast<std::uint8_t>(*kind));
  for (const double number : numbers) pq_sendfloat8(&message, number);
  return PointerGetDatum(pq_endtypsend(&message));
}

template <std::size_t count>
std::array<double, count> numbers_in(FunctionCallInfo fcinfo, const char* type) {
  std::array<double, count> numbers;
  const char* const all = PG_GETARG_CSTRING(0);
  read_numbers(all, all, type, numbers);
  return numbers;
}

template <std::size_t count>
std::array<double, count> numbers_received(StringInfo message) {
  std::array<double, count> numbers;
  for (double& number : numbers) number = pq_getmsgfloat8(message);
  return numbers;
}

template <std::size_t count>
std::array<double, count> numbers_given(FunctionCallInfo fcinfo) {
  std::array<double, count> numbers;
  for (std::size_t i = 0; i < count; ++i) numbers[i] = PG_GETARG_FLOAT8(i);
  return numbers;
}

StringInfo message_in(FunctionCallInfo fcinfo) {
  return reinterpret_cast<StringInfo>(PG_GETARG_POINTER(0));
}

glm::dvec3 point_of(const std::array<double, 3>& n) {
  return {n[0], n[1], n[2]};
}

Comparison comparison_of(const text* word) {
  const std::string_view written(VARDATA_ANY(word), VARSIZE_ANY_EXHDR(word));
  constexpr std::array<std::string_view, 5> k_words = {"<", "<=", "=", ">=", ">"};
  for (std::size_t i = 0; i < k_words.size(); ++i)
    if (written == k_words[i]) return static_cast<Comparison>(i);
  ereport(ERROR, (errcode(ERRCODE_INVALID_PARAMETER_VALUE),
                  errmsg("cloud_limit: unknown comparison \"%s\"", text_to_cstring(word)),
                  errhint("Expected <, <=, =, >= or >.")));
}

Datum limit_by_comparison(FunctionCallInfo fcinfo, DistanceKind kind) {
  const auto& line = argument<CloudLine>(fcinfo, 0);
  return datum_of(make_limit(kind, line, comparison_of(PG_GETARG_TEXT_PP(1)), PG_GETARG_FLOAT8(2)));
}

Datum distance_of_numbers(FunctionCallInfo fcinfo, DistanceKind kind) {
  const auto vector = [&](int first) {
    return glm::dvec3(PG_GETARG_FLOAT8(first), PG_GETARG_FLOAT8(first + 1), PG_GETARG_FLOAT8(first + 2));
  };
  const CloudLine line = guarded([&] { return make_line(kind, vector(0), vector(3)); });
  PG_RETURN_FLOAT8(distance(kind, line, vector(6)));
}

Datum distance_of_values(FunctionCallInfo fcinfo, DistanceKind kind) {
  PG_RETURN_FLOAT8(distance(kind, argument<CloudLine>(fcinfo, 1), argument<glm::dvec3>(fcinfo, 0)));
}

bool keeps_limit(FunctionCallInfo fcinfo) {
  return holds(argument<CloudLimit>(fcinfo, 1), argument<glm::dvec3>(fcinfo, 0));
}

}  // namespace
}  // namespace alidade::database

using namespace alidade;
using namespace alidade::database;

ALIDADE_SQL_ANSWER(alidade_point_in, datum_of(point_of(numbers_in<3>(fcinfo, "cloud_point"))));
ALIDADE_SQL_ANSWER(alidade_point_out, text_of("", numbers_of(argument<glm::dvec3>(fcinfo, 0))));
ALIDADE_SQL_ANSWER(alidade_point_receive, datum_of(point_of(numbers_received<3>(message_in(fcinfo)))));
ALIDADE_SQL_ANSWER(alidade_point_send, message_of(numbers_of(argument<glm::dvec3>(fcinfo, 0))));
ALIDADE_SQL_ANSWER(alidade_point, datum_of(point_of(numbers_given<3>(fcinfo))));

ALIDADE_SQL_ANSWER(alidade_box_in, datum_of(box_of_numbers(numbers_in<6>(fcinfo, "cloud_box"))));
ALIDADE_SQL_ANSWER(alidade_box_out, text_of("", numbers_of(argument<Bounds>(fcinfo, 0))));

ALIDADE_SQL_ANSWER(alidade_ray_in, datum_of(line_of(DistanceKind::ray, numbers_in<6>(fcinfo, "cloud_ray"))));
ALIDADE_SQL_ANSWER(alidade_plane_in,
                   datum_of(line_of(DistanceKind::plane, numbers_in<6>(fcinfo, "cloud_plane"))));
ALIDADE_SQL_ANSWER(alidade_line_out, text_of("", numbers_of(argument<CloudLine>(fcinfo, 0))));
ALIDADE_SQL_ANSWER(alidade_ray_receive,
                   datum_of(line_of(DistanceKind::ray, numbers_received<6>(message_in(fcinfo)))));
ALIDADE_SQL_ANSWER(alidade_plane_receive,
                   datum_of(line_of(DistanceKind::plane, numbers_received<6>(message_in(fcinfo)))));
ALIDADE_SQL_ANSWER(alidade_line_send, message_of(numbers_of(argument<CloudLine>(fcinfo, 0))));
ALIDADE_SQL_ANSWER(alidade_ray, datum_of(line_of(DistanceKind::ray, numbers_given<6>(fcinfo))));
ALIDADE_SQL_ANSWER(alidade_plane, datum_of(line_of(DistanceKind::plane, numbers_given<6>(fcinfo))));

ALIDADE_SQL_FUNCTION(alidade_limit_in) {
  const char* const all = PG_GETARG_CSTRING(0);
  const char* const list = std::strchr(all, '(');
  const std::size_t length = list == nullptr ? 0 : static_cast<std::size_t>(list - all);
  const bool is_ray = length == 3 && std::strncmp(all, "ray", length) == 0;
  const bool is_plane = length == 5 && std::strncmp(all, "plane", length) == 0;
  if (!is_ray && !is_plane) reject_text(all, "cloud_limit");
  std::array<double, 8> numbers;
  read_numbers(list, all, "cloud_limit", numbers);
  return datum_of(limit_of(is_ray ? DistanceKind::ray : DistanceKind::plane, numbers));
}
ALIDADE_SQL_FUNCTION(alidade_limit_out) {
  const auto& limit = argument<CloudLimit>(fcinfo, 0);
  return text_of(limit.kind == DistanceKind::ray ? "ray" : "plane", numbers_of(limit));
}
ALIDADE_SQL_FUNCTION(alidade_limit_receive) {
  StringInfoData* const message = message_in(fcinfo);
  const auto kind = static_cast<DistanceKind>(pq_getmsgbyte(message));
  if (kind != DistanceKind::ray && kind != DistanceKind::plane)
    ereport(ERROR, (errcode(ERRCODE_INVALID_BINARY_REPRESENTATION),
                    errmsg("invalid kind in external \"cloud_limit\" value")));
  return datum_of(limit_of(kind, numbers_received<8>(message)));
}
ALIDADE_SQL_FUNCTION(alidade_limit_send) {
  const auto& limit = argument<CloudLimit>(fcinfo, 0);
  return message_of(numbers_of(limit), &limit.kind);
}
ALIDADE_SQL_ANSWER(alidade_ray_limit, datum_of(limit_of(DistanceKind::ray, numbers_given<8>(fcinfo))));
ALIDADE_SQL_ANSWER(alidade_plane_limit, datum_of(limit_of(DistanceKind::plane, numbers_given<8>(fcinfo))));
ALIDADE_SQL_ANSWER(alidade_limit_by_ray, limit_by_comparison(fcinfo, DistanceKind::ray));
ALIDADE_SQL_ANSWER(alidade_limit_by_plane, limit_by_comparison(fcinfo, DistanceKind::plane));

ALIDADE_SQL_ANSWER(alidade_dist_ray, distance_of_numbers(fcinfo, DistanceKind::ray));
ALIDADE_SQL_ANSWER(alidade_dist_plane, distance_of_numbers(fcinfo, DistanceKind::plane));
ALIDADE_SQL_ANSWER(alidade_distance_to_ray, distance_of_values(fcinfo, DistanceKind::ray));
ALIDADE_SQL_ANSWER(alidade_distance_to_plane, distance_of_values(fcinfo, DistanceKind::plane));
ALIDADE_SQL_ANSWER(alidade_keeps_limit, BoolGetDatum(keeps_limit(fcinfo)));
ALIDADE_SQL_ANSWER(alidade_breaks_limit, BoolGetDatum(!keeps_limit(fcinfo)));
