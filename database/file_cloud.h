// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "cloud/cloud_inputs.h"
#include "cloud/read_cloud.h"
#include "database/chunk_source.h"
#include "database/point_cursor.h"

namespace alidade::database {

/// Options of tables of cloud files.
struct FileTables {
  ReadOptions reading{};
  std::function<bool()> is_given_up{};                          ///< if it returns true, scans end
  std::function<void(const std::vector<std::string>&)> warn{};  ///< called with PointCloud::warnings
  ScanReads* reads = nullptr;                                   ///< to which scans add their counts
};

/// A cloud in files as a source of scans.
struct FileChunks {
  CloudSchema schema{};  ///< without reference system
  std::vector<std::string> warnings{};
  std::unique_ptr<ChunkSource> source{};
};

/// The cloud of a table over files. For one thread at a time.
class FileCloud {
 public:
  /// Opens files, folders and patterns (resolve_clouds()) as one cloud:
  /// - A single COPC file with points, unless with ReadOptions::partial, is not loaded: scans read the nodes
  ///   in whose cubes they may find points. Memory: 512 MB of positions (20 B per point) and 256 MB of
  ///   attributes at most, or one node.
  /// - Everything else by its octree, which is mapped from an index file or made of points that are read into
  ///   memory. Memory: 24 B per node; of files that are not indexed, also 11 B per point and the attributes.
  ///
  /// Heights are in the unit of x and y (in_one_unit()). Errors: those of load_indexed_cloud() and CopcFile;
  /// a file changes while it is read. Cancelled.
  FileCloud(std::span<const std::filesystem::path> names, const FileTables& how);

  const CloudSchema& schema() const { return chunks_.schema; }
  const std::vector<std::string>& warnings() const { return chunks_.warnings; }
  ChunkSource& source() const { return *chunks_.source; }

  /// Error if a file is not the one that was opened, by its size, modification time and inode number. Remote
  /// files are not checked. Cost: a system call per file.
  void check_unchanged() const;

 private:
  /// Identifies a file and its version.
  struct FileState {
    std::filesystem::path name;
    std::uint64_t device = 0, number = 0, size = 0;
    std::int64_t seconds = 0, nanoseconds = 0;
    bool operator==(const FileState&) const = default;
  };

  static FileState state_of(const std::filesystem::path& file);

  std::vector<FileState> files_;
  FileChunks chunks_;
};

}  // namespace alidade::database
