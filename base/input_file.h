// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace alidade {

/// A file to read from anywhere in it, checked: whoever asks for bytes beyond its end gets an Error that
/// names the byte. Works alike on bytes in memory, which is how fuzz tests feed the readers. Not thread safe.
class InputFile {
 public:
  /// Opens a file. Errors: it is missing, unreadable or not a regular file.
  explicit InputFile(const std::filesystem::path& path);
  /// Takes bytes in memory for a file called `name`. The bytes must outlive the object.
  InputFile(std::span<const std::byte> bytes, std::string name);
  ~InputFile();
  InputFile(InputFile&& other) noexcept;
  InputFile& operator=(InputFile&& other) noexcept;

  /// Path as the caller gave it; what error messages call the file.
  const std::string& name() const { return name_; }
  /// Bytes in the file when it was opened.
  std::uint64_t size() const { return size_; }
  /// The bytes of a file in memory; empty for one on disk.
  std::optional<std::span<const std::byte>> memory() const {
    return in_memory_ ? std::optional(memory_) : std::nullopt;
  }

  /// Copies into.size() bytes from `place` on. Errors: they are not all there ("file ends early"), reading
  /// failed.
  void read_at(std::uint64_t place, std::span<std::byte> into);

  /// The bytes [place, place + count), without a copy where possible. Valid until the next call of any
  /// function but size() and name(). Errors as read_at(). Memory: the largest `count` asked for; ask for a
  /// mebibyte or so at a time.
  std::span<const std::byte> view(std::uint64_t place, std::size_t count);

  /// As view(), but at the file's end the bytes that are left, maybe none.
  std::span<const std::byte> view_up_to(std::uint64_t place, std::size_t count);

  /// Gives back the file handle and the buffer until the next call that needs them, so that thousands of
  /// files can wait for their turn.
  void rest();

 private:
  void open();
  void fill(std::uint64_t place, std::span<std::byte> into);
  void check_range(std::uint64_t place, std::uint64_t count) const;

  std::string name_;
  std::uint64_t size_ = 0;
  int descriptor_ = -1;  ///< -1 while resting and for bytes in memory
  std::span<const std::byte> memory_;
  bool in_memory_ = false;
  std::vector<std::byte>
      window_;  ///< bytes of the file from window_place_ on; window_size_ of them are valid
  std::uint64_t window_place_ = 0;
  std::size_t window_size_ = 0;
};

}  // namespace alidade
