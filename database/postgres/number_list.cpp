// SPDX-License-Identifier: MIT
#include "database/postgres/number_list.h"

extern "C" {
#include <libpq/pqformat.h>
#include <utils/float.h>
}

namespace alidade {
namespace {

const char* skip_spaces(const char* text) {
  return text + std::strspn(text, " \t\n\r\v\f");
}

}  // namespace

void refuse_text(const char* all, const char* type) {
  ereport(ERROR, (errcode(ERRCODE_INVALID_TEXT_REPRESENTATION),
                  errmsg("invalid input syntax for type %s: \"%s\"", type, all)));
}

void read_numbers(const char* text, const char* all, const char* type, std::span<double> numbers) {
  const char* place = skip_spaces(text);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (*place != (i == 0 ? '(' : ',')) refuse_text(all, type);
    // PostgreSQL's own parser, which only reads, asks for text that may be changed.
    char* end = nullptr;
    numbers[i] = float8in_internal(const_cast<char*>(place + 1), &end, type, all);
    place = skip_spaces(end);
  }
  if (*place != ')' || *skip_spaces(place + 1) != '\0') refuse_text(all, type);
}

void append_numbers(StringInfo text, std::span<const double> numbers) {
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    appendStringInfoChar(text, i == 0 ? '(' : ',');
    appendStringInfoString(text, float8out_internal(numbers[i]));
  }
  appendStringInfoChar(text, ')');
}

void receive_numbers(StringInfo message, std::span<double> numbers) {
  for (double& number : numbers) number = pq_getmsgfloat8(message);
}

void send_numbers(StringInfo message, std::span<const double> numbers) {
  for (const double number : numbers) pq_sendfloat8(message, number);
}

}  // namespace alidade
