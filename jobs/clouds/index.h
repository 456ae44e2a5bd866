// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "cloud/read_cloud.h"
#include "jobs/cloud_request.h"
#include "jobs/fields.h"
#include "jobs/large_clouds.h"
#include "jobs/listener.h"
#include "jobs/long_run.h"
#include "jobs/plan.h"
#include "octree/build.h"

namespace alidade::jobs {

/// The contents of an index file beside points and attributes.
struct IndexContents {
  Organisation organisation = Organisation::adaptive;
  double cell_size = 0.0;                   ///< of fixed organisation, see BuildOptions
  bool stored_order = false;                ///< points are numbered as the octree stores them
  std::optional<int> spacing_neighbours{};  ///< distances to this neighbour are measured and stored
  bool surfaces = false;                    ///< so are the surfaces that points lie on, and their spacings
};

/// An index file of a cloud. With `memory`, the points lie in scratch files (jobs/large_clouds.h).
struct IndexRequest : CloudRequest {
  IndexContents contents;
  ColorDepth color_depth = ColorDepth::automatic;
  AttributeSet attributes = AttributeSet::all();  ///< to keep
  CheckpointRequest checkpoint;                   ///< of LargeClouds, a folder; requires `memory`
};

/// Declares all fields.
void add_index_fields(const Fields& fields, IndexRequest& request);

/// A checked request.
using IndexPlan = Plan<IndexRequest>;

/// Errors: settings that exclude each other; an output that is an input, of another format, or that cannot be
/// replaced or written; a checkpoint that is or holds the output, holds an input, exists and may neither be
/// resumed from nor replaced, or is another folder; a checkpoint of a table of a database, whose changes
/// would not be detected.
IndexPlan plan(const IndexRequest& request);

/// What was written.
struct IndexResult {
  std::uint64_t point_count = 0;
  std::uint64_t bytes = 0, octree_bytes = 0;
};

/// Reads the cloud, and does write_index(). With a checkpoint, points of an earlier run are not read again:
/// it is valid for the same files, by name, size and time of the last change (remote ones: the server's
/// version), the same version of the program, and the same fields but for threads, memory, and names of
/// outputs. Errors: those of reading; no room for temporary files; those of the checkpoint. Cancelled.
IndexResult run(const IndexPlan& plan, Listener& listener);

/// Builds the octree over a cloud, measures what is requested, writes the index file, and notes its size. The
/// positions of a cloud in memory are moved into the octree; a large cloud requires contents without stored
/// order. Errors: as build() and save_index().
IndexResult write_index(const std::filesystem::path& path, HeldCloud& cloud, const IndexContents& contents,
                        bool overwrite, Listener& listener);

}  // namespace alidade::jobs
