// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace alidade {

/// A database of a PostgreSQL server that holds a part of a cloud.
struct Shard {
  std::string host;  ///< name or address
  int port = 5432;
  std::string database;

  bool operator==(const Shard&) const = default;
};

/// Reads "HOST/DATABASE" or "HOST:PORT/DATABASE"; addresses of IPv6 stand in brackets: "[::1]:5433/site".
/// Errors: anything else, also a user or a password, which have no place on a command line.
Shard parse_shard(std::string_view text);

}  // namespace alidade
