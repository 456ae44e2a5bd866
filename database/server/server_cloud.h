// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "database/server/cloud_values.h"
#include "database/server/server_connection.h"
#include "database/server/server_table.h"

namespace alidade {

/// Which rows of a table are wanted, and what of them.
struct RowChoice {
  std::vector<ValueColumn> columns{};
  bool has_ids = false;     ///< the table has whole numbers id
  bool is_sorted = false;   ///< by them
  std::string condition{};  ///< beside ServerTable::has_place(); empty for none
};

/// A row, while it is shown.
struct ServerRow {
  std::uint64_t number = 0;  ///< of those that were shown
  std::int64_t id = 0;       ///< 0 without RowChoice::has_ids
  glm::dvec3 world{0.0};
  std::span<const CopyField> values{};  ///< of RowChoice::columns
};

/// A table of a server, open as a cloud: all that is read of it is of one moment.
class ServerCloud {
 public:
  /// Errors: ServerConnection's and find_server_table()'s.
  explicit ServerCloud(const ServerName& name);

  ServerConnection& connection() { return connection_; }
  const ServerConnection& connection() const { return connection_; }
  const ServerTable& table() const { return table_; }

  /// Shows rows. Errors: the server's; what it sends is no rows.
  void read(const RowChoice& choice, const std::function<void(const ServerRow&)>& take,
            const ServerWait& wait);

 private:
  static ServerTable begin(ServerConnection& connection, const ServerName& name);

  ServerConnection connection_;
  ServerTable table_;
};

}  // namespace alidade
