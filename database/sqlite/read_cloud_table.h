// SPDX-License-Identifier: MIT
#pragma once

#include "cloud/cloud_inputs.h"

namespace alidade {

/// Clouds that store_cloud() wrote, for add_cloud_database(): points come back in the rows they had, with all
/// attributes. Names: SqliteCloudName. Errors when opened: StoredCloud's. When read: ChunkStore's; ids that
/// are no rows.
CloudDatabase sqlite_clouds();

}  // namespace alidade
