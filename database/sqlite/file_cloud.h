// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "cloud/cloud_inputs.h"
#include "database/sqlite/connection.h"
#include "database/sqlite/file_chunks.h"

namespace alidade::database {

/// The cloud of a table over files. For one thread at a time.
class FileCloud {
 public:
  /// Opens files, folders and patterns (resolve_clouds()) as one cloud: a single COPC file with points
  /// by copc_chunks(), unless with ReadOptions::partial; everything else by octree_chunks(). Heights
  /// are in the unit of x and y (in_one_unit()). Errors: those of these functions; a file changes
  /// while it is read. Cancelled.
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
