// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cloud/cloud_inputs.h"
#include "cloud/read_cloud.h"
#include "database/point_stream.h"
#include "database/sqlite/chunk_source.h"
#include "database/sqlite/cloud_schema.h"
#include "octree/index_file/index_file.h"
#include "octree/tree_walk.h"

namespace alidade::database {

/// Cloud files as what scans of a table read, with their octree: an index file is mapped, and only the points
/// and attributes that are asked for are read; anything else is read into memory and indexed. A chunk is what
/// lies in the leaves of one node, up to 512 points; its id is the node's number. The id of a point is its row
/// in the files. Safe to use from many threads.
class FileCloud final : public ChunkSource {
 public:
  /// Names of files, folders and patterns (resolve_clouds()), taken together as one cloud. Errors: those of
  /// resolve_clouds() and load_indexed_cloud(); a file changes while it is read. Cancelled. Memory: of files
  /// that are not indexed, 11 B per point and the attributes; 24 B per node.
  FileCloud(std::span<const std::filesystem::path> names, const ReadOptions& reading);

  const CloudSchema& schema() const { return schema_; }
  const std::vector<std::string>& warnings() const { return cloud_.cloud.warnings; }

  /// Error if a file is not the one that was opened, by its size, modification time and number in the file
  /// system. Remote files are not looked at. Cost: a system call per file.
  void check_unchanged() const;

  std::vector<ChunkLocation> chunks(const PointFilter& filter, std::optional<std::uint64_t> only) override;
  std::shared_ptr<StoredChunk> read(const ChunkLocation& location) override;
  const std::byte* bytes(StoredChunk& chunk, const StoredColumn& column, std::size_t row) override;

 private:
  /// What tells a file from another one of its name.
  struct FileState {
    std::filesystem::path name;
    std::uint64_t device = 0, number = 0, size = 0;
    std::int64_t seconds = 0, nanoseconds = 0;
    bool operator==(const FileState&) const = default;
  };

  static std::vector<FileState> states_of(const CloudInputs& inputs);
  void note_frames();

  std::vector<FileState> files_;
  IndexedCloud cloud_;
  AttributeColumns columns_;
  std::vector<ValueBlob> blobs_;
  std::vector<Frame> frames_;  ///< of the nodes, by their numbers
  CloudSchema schema_;
};

}  // namespace alidade::database
