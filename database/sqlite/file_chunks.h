// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cloud/cloud_inputs.h"
#include "cloud/read_cloud.h"
#include "database/sqlite/chunk_source.h"
#include "database/sqlite/cloud_schema.h"

namespace alidade::database {

/// A cloud in files as a source of scans. For one thread at a time.
struct FileChunks {
  CloudSchema schema{};  ///< without reference system
  std::vector<std::string> warnings{};
  std::unique_ptr<ChunkSource> source{};
};

/// Clouds with their octree: an index file is mapped, and only the requested points and attributes are read;
/// other files are read into memory and indexed. A chunk consists of the leaves of one node, up to 512
/// points; its id is the node's number. Errors: those of load_indexed_cloud(). Memory: of files that are not
/// indexed, 11 B per point and the attributes; 24 B per node.
FileChunks octree_chunks(const CloudInputs& inputs, const ReadOptions& reading);

/// A COPC file that is not loaded: nodes of its hierarchy are read if a scan may find points in their cubes,
/// attributes of a node when those of one of its points are requested. A chunk is 128 points of a node. A
/// scan that may find points in more nodes than the cache holds tests all points of these. The first
/// statement that uses colours reads those of the nodes until one exceeds 255, which decides about
/// ColorDepth::automatic. `is_given_up` is called after each node; if it returns true, the scan ends with
/// Cancelled. Errors: those of CopcFile; of scans, of CopcCache. Requires a file with points. Memory: 512 MB
/// of positions (20 B per point) and 256 MB of attributes at most, or one node.
FileChunks copc_chunks(const CloudInput& input, std::function<bool()> is_given_up);

}  // namespace alidade::database
