// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "cloud/cloud_inputs.h"
#include "database/point_filter.h"
#include "database/point_stream.h"
#include "extensions/postgres/server_name.h"

namespace alidade::database {

class ServerConnection;

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
///   (extensions/postgres/server_sql.h). Without it, a lattice is chosen as for files of free coordinates.
///
/// Errors when opened: ServerName's, ServerConnection's, find_server_table()'s. When read: values out of an
/// attribute's range; a table that does not match its NAME_cloud. Cost: a pass over the table, and one more
/// without NAME_cloud; on the server, points that memory does not hold are sorted by their ids.
extern const CloudFormat k_server_format;

/// A table of a PostgreSQL server that has the extension alidade_pg, for a cloud, whose columns are those of
/// server_columns(). Rows follow a Morton curve, so that the boxes of the BRIN index on cloud_point(x, y, z)
/// are small. A second table is NAME_cloud (extensions/postgres/server_sql.h).
class ServerStore {
 public:
  /// `replace`: a table of that name that has its NAME_cloud; otherwise it is an Error. Errors: those of
  /// check_server_table(); no server; the table exists.
  ServerStore(const ServerName& name, bool replace);
  ~ServerStore();

  /// Stores a cloud in one transaction. `progress` is in points. Errors: no right to make tables; the table
  /// exists by now; the extension is not installed. Cancelled.
  void store(OrderedCloud& cloud, const Progress& progress);

 private:
  ServerName name_;
  bool replace_;
  std::unique_ptr<ServerConnection> connection_;
};

}  // namespace alidade::database
