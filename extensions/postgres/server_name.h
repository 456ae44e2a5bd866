// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace alidade::database {

/// A table of a PostgreSQL server, named as
///   postgresql://[USER@][HOST][:PORT]/DATABASE?table=NAME[&schema=NAME][&KEYWORD=VALUE]...
/// or postgres://... Every part may be percent-encoded. Keywords other than table and schema are parameters
/// of libpq ("host" may be a folder with a socket). Omitted parts have libpq's defaults (PGHOST and so on).
struct ServerName {
  /// Keywords and values for libpq, as given. If a keyword is repeated, the last value is used.
  std::vector<std::pair<std::string, std::string>> parameters;
  std::string schema;  ///< empty: the first one of the search path that has the table
  std::string table;   ///< may be empty

  /// Errors: not of this form; a password, since all users of the machine can see it in the list of
  /// processes. Messages contain only host, port, database and table.
  explicit ServerName(std::string_view text);

  /// "postgresql://HOST:PORT/DATABASE?table=NAME", as far as they are given, for messages.
  std::string shown() const;

  /// A parameter's value; empty if it is not given.
  std::string parameter(std::string_view keyword) const;
};

/// The parts of "HOST", "HOST:PORT" or "[ADDRESS]:PORT".
struct HostAndPort {
  std::string_view host;
  std::optional<std::string_view> port{};
  bool is_address = true;  ///< false: invalid, with something else after the bracket
};
HostAndPort split_host(std::string_view text);

/// Empty unless the text is a whole number from 1 to 65535.
std::optional<int> parse_port(std::string_view text);

/// Whether a name begins as that of a table of a server, valid or not.
bool is_server_name(std::string_view text);

}  // namespace alidade::database
