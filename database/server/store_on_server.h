// SPDX-License-Identifier: MIT
#pragma once

#include "database/point_stream.h"
#include "database/server/server_name.h"

namespace alidade::database {

struct ServerStoreOptions {
  bool replace = false;  ///< a table of that name that has its NAME_cloud; otherwise it is an Error
  /// Bytes for points; those of a larger cloud wait in a file without a name in the folder for such files.
  std::uint64_t memory = std::uint64_t{1} << 30;
  Progress progress{};  ///< in points, once all are read
};

/// Stores cloud files as a table of a PostgreSQL server that has the extension alidade_pg.
/// Columns are those of server_columns(), rows lie along a Morton curve, so that the BRIN index on
/// cloud_point(x, y, z) keeps small boxes; beside it stands NAME_cloud (database/server/server_sql.h). All of
/// it is there at once or not at all, whatever ends the program.
///
/// Errors: check_server_table()'s; no server; no right to make tables; the table exists; the
/// extension is not installed; those of reading. Cancelled. Memory: as store_files().
StoredFiles store_on_server(const ServerName& name, const CloudInputs& inputs, const ReadOptions& reading,
                            const ServerStoreOptions& options = {});

}  // namespace alidade::database
