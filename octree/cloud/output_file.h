// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace alidade {

/// A file that appears whole or not at all: bytes go to a temporary file in the same folder, commit() renames it to
/// its final name. Destroyed without commit(), the temporary file is removed and an earlier file stays as it was.
class OutputFile {
 public:
  /// Errors: `path` exists and `overwrite` is false; the folder is missing or not writable.
  OutputFile(const std::filesystem::path& path, bool overwrite);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Appends bytes. Errors: no space left and other write failures.
  void write(std::span<const std::byte> bytes);
  /// Overwrites bytes at a place already written (headers completed at the end).
  void write_at(std::uint64_t place, std::span<const std::byte> bytes);
  /// Bytes written so far.
  std::uint64_t size() const { return size_; }
  /// Name of the temporary file, for libraries that write by path (images). It exists and is empty at first.
  const std::filesystem::path& temporary_path() const { return temporary_; }
  /// Flushes, checks, renames. Call once, last.
  void commit();

 private:
  std::filesystem::path path_, temporary_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  bool committed_ = false;
};

/// Throws the Error for an output that exists already, unless `overwrite`; lets a long task fail before it starts.
void check_output(const std::filesystem::path& path, bool overwrite);

}  // namespace alidade
