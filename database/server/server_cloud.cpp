// SPDX-License-Identifier: MIT
#include "database/server/server_cloud.h"

#include "base/error.h"

namespace alidade {
namespace {

constexpr std::size_t k_axes = 3, k_first_value = 4;  // of a row's fields: x, y, z, id, values

std::string copy_statement(const ServerTable& table, const RowChoice& choice) {
  std::string sql = "COPY (SELECT ";
  for (const char* const axis : {"x", "y", "z"}) sql += table.find(axis)->expression() + "::float8, ";
  sql += choice.has_ids ? table.find("id")->expression() + "::int8" : "0::int8";
  for (const ValueColumn& column : choice.columns) sql += ", " + column.column.expression();
  sql += " FROM " + table.quoted_name + " WHERE " + table.has_place();
  if (!choice.condition.empty()) sql += " AND (" + choice.condition + ")";
  if (choice.is_sorted) sql += " ORDER BY id";
  return sql + ") TO STDOUT (FORMAT binary)";
}

}  // namespace

ServerCloud::ServerCloud(const ServerName& name) : connection_(name), table_(begin(connection_, name)) {}

ServerTable ServerCloud::begin(ServerConnection& connection, const ServerName& name) {
  connection.run("BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY");
  // Numbers in texts are those of the table to the last bit; rows come in one order; sorting leaves the disk
  // alone for longer; conditions on many rays are not compiled, which takes longer than asking them.
  connection.run(
      "SELECT set_config('extra_float_digits', '3', true), set_config('synchronize_seqscans', 'off', true),"
      " set_config('work_mem', '256MB', true), set_config('jit', 'off', true)");
  return find_server_table(connection, name);
}

void ServerCloud::read(const RowChoice& choice, const std::function<void(const ServerRow&)>& take,
                       const ServerWait& wait) {
  const NumberColumn coordinate{.name = "a coordinate", .type = ScalarType::float64};
  const NumberColumn id{.name = "id", .type = ScalarType::int64};
  ServerRow row;
  CopyDecoder decoder(k_first_value + choice.columns.size(), [&](std::span<const CopyField> fields) {
    for (int axis = 0; axis < static_cast<int>(k_axes); ++axis)
      row.world[axis] = number_of(coordinate, fields[static_cast<std::size_t>(axis)]);
    row.id = whole_of(id, fields[k_axes]);
    row.values = fields.subspan(k_first_value);
    take(row);
    ++row.number;
  });
  try {
    connection_.copy_out(
        copy_statement(table_, choice), [&](auto bytes) { decoder.add(bytes); }, wait);
    decoder.finish();
  } catch (const Error& error) {
    Error::Parts parts = error.parts();
    if (!parts.file.empty()) throw;
    parts.file = connection_.name();
    throw Error(parts);
  }
}

}  // namespace alidade
