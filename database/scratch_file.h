// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace alidade {

/// A file without a name for what memory does not hold: gone with the object, also if the program is killed.
class ScratchFile {
 public:
  /// Made when the first bytes come, in this folder.
  explicit ScratchFile(std::filesystem::path folder) : folder_(std::move(folder)) {}
  ~ScratchFile();
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  /// Adds bytes at the end. Errors: the folder cannot be written to; no space left.
  void append(std::span<const std::byte> bytes);
  /// Bytes written so far.
  std::uint64_t size() const { return size_; }
  /// Copies bytes that were written. Errors: reading failed.
  void read(std::uint64_t place, std::span<std::byte> into) const;

 private:
  void open();
  [[noreturn]] void fail(const char* problem) const;

  std::filesystem::path folder_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace alidade
