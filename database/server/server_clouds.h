// SPDX-License-Identifier: MIT
#pragma once

#include "cloud/cloud_inputs.h"
#include "database/point_filter.h"
#include "database/point_stream.h"
#include "database/server/server_name.h"

namespace alidade::database {

/// Reads those points of a table on a server (ServerName) for which one of the filters may hold: at least all
/// for which one does. The server finds them by its index; with more than 64 filters, which it would evaluate
/// on too many points, all points are read. Requires a table with its NAME_cloud. `progress` is in points, of
/// all. Errors: those of k_server_format; duplicate ids.
CloudPart read_server_part(const std::string& name, std::span<const PointFilter> any_of,
                           AttributeSet attributes, const Progress& progress = {});

/// Whether read_server_part() can read the table: it has its NAME_cloud. Errors: those of opening it.
bool has_server_parts(const std::string& name);

/// Tables of PostgreSQL servers (ServerName). Any table, view or foreign table with numbers x, y, z is a
/// cloud, as it was when it was opened:
/// - Columns with the names that `alidade sql load` gives to attributes are these attributes; other numbers
///   become extra dimensions, anything else is left out with a warning. NULL: see CloudValues.
/// - Rows with a coordinate that is not finite are left out with a warning.
/// - Rows are in the order of `id` if that is an integer from 0 to one less than their count, each once; then
///   it is not a dimension. Otherwise rows are in the order of the server.
/// - Lattice, reference system and the kind of GPS times are those of the table NAME_cloud
///   (database/server/server_sql.h). Without it, a lattice is chosen as for files of free coordinates.
///
/// Errors when opened: ServerName's, ServerConnection's, find_server_table()'s. When read: values out of an
/// attribute's range; a table that does not match its NAME_cloud. Cost: a pass over the table, and one more
/// without NAME_cloud; on the server, points that memory does not hold are sorted by their ids.
extern const CloudFormat k_server_format;

struct ServerStoreOptions {
  bool replace = false;  ///< a table of that name that has its NAME_cloud; otherwise it is an Error
  /// Bytes for points; those of a larger cloud are kept in a file without a name in
  /// the folder for such files.
  std::uint64_t memory = std::uint64_t{1} << 30;
  Progress progress{};  ///< in points, after all are read
};

/// Stores cloud files as a table of a PostgreSQL server that has the extension alidade_pg.
/// Columns are those of server_columns(), rows follow a Morton curve, so that the boxes of the BRIN index on
/// cloud_point(x, y, z) are small; a second table is NAME_cloud (database/server/server_sql.h). Everything
/// is stored in one transaction.
///
/// Errors: check_server_table()'s; no server; no right to make tables; the table exists; the
/// extension is not installed; those of reading. Cancelled. Memory: as store_files().
StoredFiles store_on_server(const ServerName& name, const CloudInputs& inputs, const ReadOptions& reading,
                            const ServerStoreOptions& options = {});

}  // namespace alidade::database
