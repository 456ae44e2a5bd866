// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/bounds.h"
#include "database/server/server_sql.h"
#include "database/server/shard.h"
#include "database/stored_column.h"

// What write_shard_plan() has servers do. Scripts are for psql, and run as a whole or not at all.

namespace alidade {

/// "shard_1" for shard 0: the name of its files, without ending.
std::string shard_name(std::size_t shard);

/// Makes the table of a shard whose points are in a box, from the file of its rows.
std::string shard_script(const std::string& table, const std::vector<StoredColumn>& columns,
                         std::size_t shard, const Bounds& box);

/// Makes the table over all shards, whose points are in these boxes, and what says of them all what rows
/// cannot.
std::string coordinator_script(const std::string& table, const std::vector<StoredColumn>& columns,
                               std::span<const Shard> shards, std::span<const Bounds> boxes,
                               const CloudRow& cloud);

/// What to type.
std::string plan_readme(const std::string& table, std::span<const Shard> shards,
                        std::span<const Bounds> boxes);

}  // namespace alidade
