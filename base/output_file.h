// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace alidade {

/// A file that appears completely or not at all: bytes go to a temporary file in the same folder, and
/// commit() renames it to its final name. Without commit() the destructor removes the temporary file, and an
/// earlier file stays as it was. Through a symbolic link its target is written, whether or not it exists; a
/// link in a folder that others can write requires `overwrite`. Temporary files that killed processes left of
/// this output are removed.
class OutputFile {
 public:
  /// Errors: those of check_output(); the folder is not writable.
  OutputFile(const std::filesystem::path& path, bool overwrite);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Appends bytes, through a buffer: many small pieces cost little. Errors: no space left and other write
  /// failures.
  void write(std::span<const std::byte> bytes);
  void write(std::string_view text) { write(std::as_bytes(std::span(text))); }
  /// Overwrites bytes at an offset already written (headers completed at the end).
  void write_at(std::uint64_t offset, std::span<const std::byte> bytes);
  /// Bytes written so far.
  std::uint64_t size() const { return size_; }
  /// Flushes, checks, renames. Call once, last. Errors: a failed write; a file that has appeared under the
  /// final name in the meantime and may not be replaced.
  void commit();

 private:
  void flush();

  std::string name_;  ///< the path as the caller gave it, for messages
  std::filesystem::path path_, temporary_;
  bool overwrite_ = false;
  int descriptor_ = -1;
  std::vector<std::byte> buffer_;  ///< appended, not yet in the file
  std::uint64_t size_ = 0;
  bool committed_ = false;
};

/// Writes a text as an OutputFile. Errors: those of OutputFile.
void write_text_file(const std::filesystem::path& path, std::string_view text, bool overwrite);

/// The name of this process's temporary file for an output, in its folder: ".yard.part-4711-0.las". It is
/// short enough for file systems even if the output's own name has 255 bytes, with room for 8 more.
std::filesystem::path temporary_beside(const std::filesystem::path& path, int attempt);

/// Creates the temporary file that becomes an output, in its folder (temporary_beside()): empty, and locked
/// until its descriptor is closed, which must not be before it has the output's name. First removes what
/// killed processes left of this output: files that no process has locked, even if a process has the number
/// in their names. `name` is the output's in messages. Returns the descriptor. Errors: the folder is missing
/// or not writable.
int create_temporary(const std::filesystem::path& output, const std::string& name,
                     std::filesystem::path& temporary);

/// Waits until the bytes are on the disk. False if the system could not write them.
bool sync_temporary(int descriptor);

/// Writes all bytes at an offset of an open file. Errors, which name `name`: no space left and other
/// failures.
void write_fully(const std::string& name, int descriptor, std::uint64_t offset,
                 std::span<const std::byte> bytes);

/// Lets a long task fail before it starts. Errors: `path` is not a regular file, or its folder is
/// missing; unless `overwrite`, it exists, or is a symbolic link, also a dangling one, in a folder that
/// others can write.
void check_output(const std::filesystem::path& path, bool overwrite);

/// Errors: `path` leads through a symbolic link in a folder that others can write, or through too many. For
/// files that may exist: databases, checkpoints.
void check_links(const std::filesystem::path& path);

}  // namespace alidade
