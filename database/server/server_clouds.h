// SPDX-License-Identifier: MIT
#pragma once

#include "cloud/cloud_inputs.h"
#include "database/point_filter.h"
#include "database/point_stream.h"
#include "database/server/server_name.h"

namespace alidade::database {

/// Reads the points of a table on a server (ServerName) for which one of the filters holds, and possibly
/// others. The server finds them by its index. With more than 64 filters, which take the server longer than
/// sending the points, all points are read. Requires a table with its NAME_cloud. `progress` is in points of
/// the whole cloud. Errors: those of k_server_format; duplicate ids.
CloudPart read_server_part(const std::string& name, std::span<const PointFilter> any_of,
                           AttributeSet attributes, const Progress& progress = {});

/// Whether a table has its NAME_cloud, as read_server_part() requires. Errors: those of opening it.
bool has_server_parts(const std::string& name);

/// Tables of PostgreSQL servers (ServerName). Any table, view or foreign table with numeric columns x, y and
/// z is a cloud, in its state when it was opened:
/// - Columns with the names that `alidade sql load` gives to attributes are these attributes. Other numeric
///   columns become extra dimensions; the rest is skipped with a warning. For NULL see CloudValues.
/// - Rows with a coordinate that is not finite are skipped with a warning.
/// - If the values of `id` are the integers from 0 to one less than the number of rows, each once, rows are
///   in their order, and `id` is not a dimension. Otherwise rows are in the order of the server.
/// - Lattice, reference system and the kind of GPS times are those of the table NAME_cloud
///   (database/server/server_sql.h). Without it, a lattice is chosen as for files of free coordinates.
///
/// Errors when opened: ServerName's, ServerConnection's, find_server_table()'s. When read: values out of an
/// attribute's range; a table that does not match its NAME_cloud. Cost: a pass over the table, and one more
/// without NAME_cloud; on the server, points that memory does not hold are sorted by their ids.
extern const CloudFormat k_server_format;

struct ServerStoreOptions {
  bool replace = false;  ///< a table of that name that has its NAME_cloud; otherwise it is an Error
  /// Bytes for points; those of a larger cloud are kept in a temporary file without a name.
  std::uint64_t memory = std::uint64_t{1} << 30;
  Progress progress{};  ///< in points, after all are read
};

/// Stores cloud files as a table of a PostgreSQL server that has the extension alidade_pg, in one
/// transaction. Columns are those of server_columns(). Rows follow a Morton curve, so that the boxes of the
/// BRIN index on cloud_point(x, y, z) are small. A second table is NAME_cloud (database/server/server_sql.h).
///
/// Errors: those of check_server_table(); no server; no right to make tables; the table exists; the extension
/// is not installed; those of reading. Cancelled. Memory: as store_files().
StoredFiles store_on_server(const ServerName& name, const CloudInputs& inputs, const ReadOptions& reading,
                            const ServerStoreOptions& options = {});

}  // namespace alidade::database
