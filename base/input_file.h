// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/progress.h"

namespace alidade {

/// A file descriptor, closed with the object; -1: none.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  /// Takes over one that is open, or -1.
  explicit FileDescriptor(int number) : number_(number) {}
  /// Opens `path` with the flags of open(2). Errors: it cannot be opened.
  FileDescriptor(const std::string& path, int flags);
  ~FileDescriptor() { close(); }
  FileDescriptor(FileDescriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }

  int number() const { return number_; }
  bool is_open() const { return number_ >= 0; }
  void close();
  /// Bytes of the file. Errors, which name `path`: it is not a regular file.
  std::uint64_t size_of_regular(const std::string& path) const;
  /// Reads bytes at an offset. Returns how many; if they are fewer, errno is 0 where the file ends, else the
  /// reason.
  std::size_t read_at(std::uint64_t offset, std::span<std::byte> into) const noexcept;
  /// Locks a checkpoint, file or folder, until this is closed: two runs that write to one would damage it.
  /// Errors, which name `path`: another run has locked it; it cannot be locked.
  void lock_checkpoint(const std::string& path) const;

 private:
  int number_ = -1;
};

/// Bytes in memory, and what keeps them there.
struct MappedBytes {
  std::span<const std::byte> bytes;
  std::shared_ptr<const void> storage;
};

/// A file that the system cannot open itself.
class RemoteFile {
 public:
  virtual ~RemoteFile() = default;
  virtual std::uint64_t size() const = 0;
  /// Differs between different contents under one name, as far as the server reports it.
  virtual std::string version() const = 0;
  /// Copies bytes, all of them within the file. Errors: reading failed.
  virtual void read(std::uint64_t offset, std::span<std::byte> into) = 0;
  /// Fetches the whole file to this machine and maps it into memory. `progress` is in bytes. Errors: the user
  /// does not permit it; the disk has no room; those of read(). Cancelled.
  virtual MappedBytes map(const Progress& progress) = 0;
};

/// Whether a name is that of a remote file: it begins with "https://", "http://", "s3://", "gs://", "az://",
/// or as the virtual files of GDAL do ("/vsizip/tiles.zip/a.laz").
bool is_remote_name(std::string_view name);

using OpenRemoteFile = std::unique_ptr<RemoteFile> (*)(const std::string& name);
/// How InputFile opens files of such names; before, it rejects them. Not while others open files.
void set_remote_files(OpenRemoteFile open);
/// Opens a file of such a name. Errors: those of the function given to set_remote_files(); none was given.
std::unique_ptr<RemoteFile> open_remote_file(const std::string& name);

/// A file with checked random access: reading beyond its end throws an Error that names the byte. Works alike
/// on bytes in memory, which is how fuzz tests feed the readers. Not thread safe.
class InputFile {
 public:
  /// Opens a file, also a remote one. Errors: it is missing, unreadable or not a regular file; those of the
  /// function given to set_remote_files().
  explicit InputFile(const std::filesystem::path& path);
  /// Takes bytes in memory for a file called `name`. The bytes must outlive the object.
  InputFile(std::span<const std::byte> bytes, std::string name);

  /// Name in messages and stored metadata: public_name() of its path.
  const std::string& name() const { return name_; }
  /// Path as the caller gave it, which opens the file again. It may hold a password.
  const std::string& address() const { return address_; }
  /// Bytes in the file when it was opened.
  std::uint64_t size() const { return size_; }
  bool is_remote() const { return is_remote_name(name_) && !memory_; }
  /// The bytes of a file in memory; empty for one on disk.
  const std::optional<std::span<const std::byte>>& memory() const { return memory_; }

  /// Copies into.size() bytes from `offset` on. Errors: they are not all there ("file ends early"), reading
  /// failed.
  void read_at(std::uint64_t offset, std::span<std::byte> into);

  /// The bytes [offset, offset + count), without a copy where possible. Valid until the next call of any
  /// function but size() and name(). Errors as read_at(). Memory: the largest `count` so far; keep to a
  /// mebibyte or so.
  std::span<const std::byte> view(std::uint64_t offset, std::size_t count);

  /// As view(), but at the file's end the bytes that are left, maybe none.
  std::span<const std::byte> view_up_to(std::uint64_t offset, std::size_t count);

  /// All bytes in memory, from a multiple of 4096 on: a file on this machine is mapped (base/local_map.h),
  /// one in memory copied, a remote one fetched whole (RemoteFile::map()), which `progress` is for. Cost:
  /// constant for a file on this machine. Errors: those of opening it again, map_file() and
  /// RemoteFile::map(); a remote file has changed.
  MappedBytes map(const Progress& progress = {}) const;

  /// Gives back the file handle and the buffer until the next call that needs them, so that thousands of
  /// files can wait for their turn.
  void rest();

 private:
  /// Opens the remote file again. Errors: it has changed.
  std::unique_ptr<RemoteFile> open_again() const;
  void fill(std::uint64_t offset, std::span<std::byte> into);
  void check_range(std::uint64_t offset, std::uint64_t count) const;

  std::string address_, name_;
  std::uint64_t size_ = 0;
  FileDescriptor descriptor_;  ///< closed while resting, for bytes in memory and remote files
  std::unique_ptr<RemoteFile> remote_;
  std::string version_;  ///< of the remote file
  std::optional<std::span<const std::byte>> memory_;
  std::vector<std::byte> window_;  ///< the file from window_offset_ on; window_size_ bytes are valid
  std::uint64_t window_offset_ = 0;
  std::size_t window_size_ = 0;
};

/// Most bytes of scene files and our camera files.
inline constexpr std::uintmax_t k_largest_scene_file = 4u << 20;

/// A text file of at most so many bytes. Errors: missing, not a regular file, too large, unreadable.
std::string read_text_file(const std::filesystem::path& file, std::uintmax_t largest = k_largest_scene_file);

/// Walks forward through the bytes of a file. Errors: those of InputFile, when the file ends early.
class ByteCursor {
 public:
  ByteCursor(InputFile& file, std::uint64_t offset) : file_(file), window_offset_(offset) {}

  /// Byte that comes next.
  std::uint64_t offset() const { return window_offset_ + used_; }

  /// The next `count` bytes, valid until the next call.
  const std::byte* take(std::size_t count) {
    if (count > window_.size() - used_) refill(count);
    const std::byte* const bytes = window_.data() + used_;
    used_ += count;
    return bytes;
  }

  /// Leaves out `count` bytes. Cost: constant.
  void skip(std::uint64_t count) {
    if (count <= window_.size() - used_) {
      used_ += static_cast<std::size_t>(count);
      return;
    }
    const std::uint64_t from = offset();
    if (count > file_.size() - std::min(from, file_.size())) file_.view(from, count);
    window_ = {};
    used_ = 0;
    window_offset_ = from + count;
  }

 private:
  void refill(std::size_t count) {
    constexpr std::size_t k_window = 1 << 20;
    window_offset_ += used_;
    used_ = 0;
    window_ = {};
    const auto bytes = file_.view_up_to(window_offset_, std::max(count, k_window));
    window_ = bytes.size() < count ? file_.view(window_offset_, count) : bytes;
  }

  InputFile& file_;
  std::uint64_t window_offset_;
  std::span<const std::byte> window_;
  std::size_t used_ = 0;
};

}  // namespace alidade
