// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>

#include "base/checkpoint.h"
#include "base/fingerprint.h"
#include "base/input_file.h"
#include "extensions/scratch/kept_file.h"

namespace alidade {

/// Scratch files with names, so that a run that was interrupted or killed can resume with the rows in them.
/// They lie in a folder of their own, beside a file "manifest" that has the fingerprint of the run, the
/// number of rows, and of each file the bytes that belong to these and their checksum; further bytes of a
/// file are cut off. Rows are only ever appended. To be used by one thread at a time.
class ScratchCheckpoint {
 public:
  /// `options.file` is the folder, made if it is missing. Without `options.resume` its contents are replaced.
  /// `fingerprint`: all that the rows depend on. `is_interrupted`: whether to stop, called while kept bytes
  /// are compared. Errors: the folder is neither empty nor is_scratch_checkpoint(), cannot be written, or is
  /// in use by another process; the manifest is damaged, or of another version or run.
  ScratchCheckpoint(PartsOptions options, Fingerprint fingerprint, std::function<bool()> is_interrupted = {});

  const std::filesystem::path& folder() const { return options_.file; }
  /// Rows that are in the files: those of an earlier run, then those of the last keep().
  std::uint64_t rows() const { return rows_; }
  /// Whether there was a checkpoint to resume from, maybe without rows.
  bool resumes() const { return resumes_; }
  /// A file, "positions" or "attribute-N", with the bytes that an earlier run kept of it. Errors: it has
  /// fewer; their checksum is wrong; those of opening it. Cancelled. Cost: the bytes are read.
  KeptFile file(const std::string& name);
  /// Throws the error of a checkpoint that no run can resume from.
  [[noreturn]] void fail_as_corrupt(const std::string& problem, const std::string& expected,
                                    const std::string& found);
  /// Whether that error was thrown.
  bool is_corrupt() const { return is_corrupt_; }

  struct Kept {
    std::string name;
    KeptFile* file;
    std::uint64_t bytes;  ///< that belong to the rows
  };
  /// Whether the interval of the options has passed since the last keep().
  bool is_due() const;
  /// From now on the run can resume behind these rows, also when the system fails. Bytes beyond them are cut
  /// off. If the disk is full, it can resume behind those kept before, and `options.failed` is called.
  void keep(std::uint64_t rows, std::span<const Kept> files);
  /// Removes the files once they are not needed any more, and the folder if this run or the one that it
  /// resumed has made it.
  void remove();

 private:
  void read();
  void begin();
  bool remove_rows();
  void write(std::uint64_t rows, std::span<const Kept> files);

  PartsOptions options_;
  Fingerprint fingerprint_;
  std::function<bool()> is_interrupted_;
  FileDescriptor lock_;  ///< of the folder
  std::uint64_t rows_ = 0;
  bool resumes_ = false, is_corrupt_ = false;
  bool made_folder_ = false;  ///< else it is the user's
  struct Content {
    std::uint64_t bytes = 0, checksum = 0;
  };
  std::map<std::string, Content> kept_files_;  ///< by name of the file
  std::chrono::steady_clock::time_point kept_;
};

/// Whether a folder has a manifest, of whatever version, and beside it nothing but what this class writes; or
/// nothing at all, but for a manifest that was not finished.
bool is_scratch_checkpoint(const std::filesystem::path& folder);

}  // namespace alidade
