// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>

#include "base/input_file.h"

namespace alidade {

/// Where points are kept that memory need not hold.
struct ScratchSpace {
  std::filesystem::path folder;  ///< of scratch files
  std::uint64_t memory = 0;      ///< bytes to work in
};

/// The folder for temporary files of commands without an output: TMPDIR, or /tmp. Errors: it is not a folder.
std::filesystem::path temporary_folder();

/// A file without a name for data that memory does not hold: removed with the object, also if the program is
/// killed.
class ScratchFile {
 public:
  /// A file in this folder, made when the first bytes come.
  explicit ScratchFile(std::filesystem::path folder) : folder_(std::move(folder)) {}
  ~ScratchFile();
  ScratchFile(ScratchFile&& other) noexcept;
  ScratchFile& operator=(ScratchFile&& other) noexcept;

  /// Adds bytes at the end. Errors: the folder cannot be written to; no space left.
  void append(std::span<const std::byte> bytes);
  /// Adds zeros at the end. Errors: as append().
  void append_zeros(std::uint64_t count);
  /// Bytes written so far.
  std::uint64_t size() const { return size_; }
  /// Copies bytes that were written. Errors: reading failed.
  void read(std::uint64_t offset, std::span<std::byte> into) const;

  /// Cuts the file to its first `kept` bytes, which it must have. Errors: the system cannot.
  void cut(std::uint64_t kept);

  /// All bytes written so far, mapped into memory. Changes go to the file. The map stays until the object is
  /// gone; nothing may be appended any more. On file systems that write changed pages elsewhere (Btrfs, ZFS),
  /// a full disk then ends the program (SIGBUS). Errors: the system cannot map them.
  std::span<std::byte> map();

 protected:
  std::span<std::byte> map(int protection, int flags);
  [[noreturn]] void fail(const char* problem) const;
  [[noreturn]] void fail_to_write() const;

  std::filesystem::path folder_;
  FileDescriptor descriptor_;
  std::uint64_t size_ = 0;

 private:
  void open();

  std::byte* mapped_ = nullptr;
};

/// Memory of a scratch file of its own in this folder, for which disk space is reserved: zeros. `byte_count`:
/// more than 0. munmap() returns it, and its space on the disk. Errors: as ScratchFile::append().
void* map_scratch_pages(std::size_t byte_count, const std::filesystem::path& folder);

/// Advises the system that bytes of a mapped scratch file will be read at random: it then reads single pages,
/// and none ahead that would displace those needed next. For files that are larger than memory.
void expect_random_reads(std::span<const std::byte> bytes) noexcept;

/// Removes bytes of a mapped scratch file from memory, and from the disk if the map can be written to, as far
/// as they fill whole pages and the file system supports it (ext4, XFS, Btrfs, tmpfs).
void discard_scratch_pages(std::span<const std::byte> bytes) noexcept;

}  // namespace alidade
