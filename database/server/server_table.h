// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cloud/attributes.h"
#include "database/server/server_connection.h"
#include "database/server/server_sql.h"

namespace alidade::database {

/// A column of numbers of a table on a server, whoever made it.
struct NumberColumn {
  std::string name;
  /// int16, int32, int64, float32 or float64: what a COPY of expression() gives.
  ScalarType type = ScalarType::float64;
  bool is_decimal = false;  ///< numeric, which is read as float64
  bool can_be_null = false;

  bool is_whole() const { return type != ScalarType::float32 && type != ScalarType::float64; }

  /// What SQL calls its value.
  std::string expression() const;
};

/// A table that is a cloud: it has numbers x, y and z.
struct ServerTable {
  std::string quoted_name;            ///< "SCHEMA"."TABLE"
  std::vector<NumberColumn> columns;  ///< as the table has them
  std::vector<std::string> left_out;  ///< names of columns that are no numbers
  double row_estimate = 0.0;          ///< about how many rows; 0 if unknown
  std::optional<CloudRow> cloud{};    ///< of tables that `alidade sql load` made

  /// Null if there is none of that name.
  const NumberColumn* find(std::string_view name) const;

  /// Condition for rows with a position: x, y and z finite.
  std::string has_place() const;
};

/// Looks the table up, within the transaction that the connection is in. Errors: the name has no table; there
/// is no such table, or it lacks x, y or z; the row of NAME_cloud cannot be; the server's.
ServerTable find_server_table(ServerConnection& connection, const ServerName& name);

}  // namespace alidade::database
