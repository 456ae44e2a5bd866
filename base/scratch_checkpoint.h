// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>

#include "base/checkpoint.h"
#include "base/fingerprint.h"
#include "base/input_file.h"
#include "base/scratch_file.h"

namespace alidade {

/// Scratch files with names, so that a run that was interrupted or killed can go on with the rows in them. They lie in
/// a folder of their own, beside a file "manifest" that has the fingerprint of the run, the number of rows, and the
/// bytes of each file that belong to these; what a file has beyond them is cut off. Rows are only ever appended. To be
/// used by one thread at a time.
class ScratchCheckpoint {
 public:
  /// `options.file` is the folder, made if it is missing. Without `options.resume` what is in it is replaced.
  /// `fingerprint`: all that the rows depend on. Errors: the folder has other files than these, cannot be written, or
  /// is in use by another process; the manifest is damaged, or of another version or run.
  ScratchCheckpoint(PartsOptions options, Fingerprint fingerprint);

  const std::filesystem::path& folder() const { return options_.file; }
  /// Rows that are in the files: those of an earlier run, then those of the last keep().
  std::uint64_t rows() const { return rows_; }
  /// A file, with the bytes that an earlier run kept of it. Errors: it has fewer; those of opening it.
  ScratchFile file(const std::string& name) const;

  struct Kept {
    std::string name;
    const ScratchFile* file;
    std::uint64_t bytes;  ///< that belong to the rows
  };
  /// Whether the interval of the options has passed since the last keep().
  bool is_due() const;
  /// From now on the run can go on behind these rows, also when the system fails. If the disk takes no more, it can
  /// from those kept before, and `options.failed` is called.
  void keep(std::uint64_t rows, std::span<const Kept> files);
  /// Removes files and folder once they are not needed any more.
  void remove();

 private:
  void read();
  void begin();
  void write(std::uint64_t rows, std::span<const Kept> files);

  PartsOptions options_;
  Fingerprint fingerprint_;
  FileDescriptor lock_;  ///< of the folder
  std::uint64_t rows_ = 0;
  std::map<std::string, std::uint64_t> bytes_;  ///< kept, by name of the file
  std::chrono::steady_clock::time_point kept_;
};

/// Whether a folder has nothing but such files, or nothing at all.
bool is_scratch_checkpoint(const std::filesystem::path& folder);

}  // namespace alidade
