// SPDX-License-Identifier: MIT
#pragma once

#include "cloud/cloud_inputs.h"

namespace alidade {

/// Tables of PostgreSQL servers (ServerName), for add_cloud_database(). Any table, view or foreign table with
/// numbers x, y, z is a cloud, as it was when it was opened:
/// - Columns with the names that `alidade sql load` gives to attributes are these; other numbers become extra
///   dimensions, anything else is left out with a warning. NULL: see CloudValues.
/// - Rows with a coordinate that is not finite are left out with a warning.
/// - Rows are in the order of `id` where that is a whole number from 0 to one less than their count and each
/// is
///   there once; then it is no dimension. Otherwise they are in the order they come.
/// - Lattice, reference system and how GPS times count come from the table NAME_cloud
///   (database/server/server_sql.h). Without it, a lattice is chosen as for files of free coordinates.
///
/// Errors when opened: ServerName's, ServerConnection's, find_server_table()'s. When read: values out of an
/// attribute's range; a table that is not what its NAME_cloud says. Cost: a pass over the table, and one more
/// without NAME_cloud; on the server, points that memory does not hold are sorted by their ids.
CloudDatabase server_clouds();

}  // namespace alidade
