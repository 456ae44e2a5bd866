// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cloud/read_cloud.h"
#include "jobs/cloud_formats.h"
#include "jobs/cloud_request.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/plan.h"

namespace alidade::jobs {

/// A cloud that is stored in databases. `memory` sorts points, by default 1 GB; it need not hold the cloud.
struct StoreRequest : CloudRequest {
  std::string table = "points";  ///< name of the cloud in SQL
  ColorDepth color_depth = ColorDepth::automatic;
};

/// A cloud for a database, the `output`: an SQLite file, or what an extension adds. `overwrite`: an existing
/// cloud of that name.
struct LoadRequest : StoreRequest {
  CloudStores stores = make_stores();
  std::optional<std::uint32_t> chunk_points;  ///< of SQLite, 1 to 65536; empty: 1024
};

/// Declares all fields.
void add_load_fields(const Fields& fields, LoadRequest& request);

/// Declare those of a StoreRequest: the table's name, and what reading and sorting take.
void add_table(const Fields& fields, StoreRequest& request);
void add_storing(const Fields& fields, StoreRequest& request);

using LoadPlan = Plan<LoadRequest>;

/// Checks all that can be checked before a point is read. Errors: a database with the name of a cloud, or
/// that is one of the files or cannot be written; a chunk size for another database than SQLite; those of
/// CloudStore::check().
LoadPlan plan(const LoadRequest& request);

/// Stores the cloud as a table, and notes where. Errors: those of database::store_cloud() and of the
/// extension's output; Cancelled. Memory: theirs.
database::StoredFiles run(const LoadPlan& plan, Listener& listener);

/// Reads the cloud of such a request, and stores it by `output`: store_in_stages().
database::StoredFiles store_in_stages(const StoreRequest& request, const std::string& storing,
                                      const OpenStore& output, Listener& listener);

}  // namespace alidade::jobs
