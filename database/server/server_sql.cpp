// SPDX-License-Identifier: MIT
#include "database/server/server_column.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "base/words.h"
#include "database/sql_name.h"

namespace alidade {
namespace {

const char* type_name(ServerType type) {
  switch (type) {
    case ServerType::smallint:
      return "smallint";
    case ServerType::integer:
      return "integer";
    case ServerType::bigint:
      return "bigint";
    case ServerType::real:
      return "real";
    case ServerType::double_precision:
      return "double precision";
    case ServerType::numeric:
      return "numeric(20)";
    case ServerType::bytea:
      break;
  }
  return "bytea";
}

}  // namespace

ServerType server_type(const StoredColumn& column) {
  constexpr int k_id_blob = 0;
  if (column.blob == k_id_blob) return ServerType::bigint;
  if (column.scale != 1.0 || column.offset != 0.0) return ServerType::double_precision;
  switch (column.type) {
    case ScalarType::uint8:
    case ScalarType::int8:
    case ScalarType::int16:
      return ServerType::smallint;
    case ScalarType::uint16:
    case ScalarType::int32:
      return ServerType::integer;
    case ScalarType::uint32:
    case ScalarType::int64:
      return ServerType::bigint;
    case ScalarType::uint64:
      return ServerType::numeric;
    case ScalarType::float32:
      return ServerType::real;
    case ScalarType::float64:
      return ServerType::double_precision;
    case ScalarType::bytes:
      break;
  }
  return ServerType::bytea;
}

std::string server_index(const std::string& quoted_name) {
  return "CREATE INDEX ON " + quoted_name +
         " USING brin (cloud_point(x, y, z)) WITH (pages_per_range = 8, autosummarize = on)";
}

void check_server_table(const std::string& name) {
  constexpr std::size_t k_longest = 40;
  const auto is_control = [](char letter) {
    return static_cast<unsigned char>(letter) < 0x20 || letter == 0x7f;
  };
  if (name.empty() || name.size() > k_longest || std::ranges::any_of(name, is_control) || !is_utf8(name)) {
    throw Error({.problem = "this cannot be the name of a table on a server",
                 .expected = fmt::format("1 to {} bytes of UTF-8 without control characters", k_longest),
                 .found = fmt::format("{} bytes", name.size())});
  }
}

void check_column_count(const std::vector<StoredColumn>& columns) {
  constexpr std::size_t k_most = 1600, k_axes = 3;
  if (columns.size() + k_axes <= k_most) return;
  throw Error({.problem = "the cloud has too many attributes for a table of PostgreSQL",
               .expected = fmt::format("at most {} columns", k_most),
               .found = std::to_string(columns.size() + k_axes)});
}

std::string server_columns(const std::vector<StoredColumn>& columns) {
  std::string text =
      "id bigint NOT NULL, x double precision NOT NULL, y double precision NOT NULL, "
      "z double precision NOT NULL";
  for (std::size_t i = 1; i < columns.size(); ++i)
    text += ", " + sql_name(columns[i].name) + " " + type_name(server_type(columns[i]));
  return text;
}

}  // namespace alidade
