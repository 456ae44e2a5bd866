// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/input_file.h"

namespace alidade::geo {

/// A remote file in the folder, complete or begun.
struct KeptCopy {
  FileDescriptor file;        ///< begins with the bytes of the remote file; locked while any are missing
  std::uint64_t fetched = 0;  ///< bytes that are there
};

/// Blocks of remote files, and whole ones, in a folder, which several programs may use at once. Thread safe.
///
/// A key names a block of one version of a file. Each block is a file of its own with a checksum, written
/// under another name and renamed: one that is damaged counts as missing. The names of remote files, which
/// may hold passwords, are not stored. Whatever fails while a block is kept only means that it is not kept.
class BlockFolder {
 public:
  /// Makes the folder unless it is there, for this user only, and marks it. The blocks take at most
  /// `most_bytes`, or somewhat more while several programs write; those that were not used for longest are
  /// removed, and nothing else is. Errors: the folder cannot be made or written to; other users may write to
  /// it; it holds something and is not marked.
  BlockFolder(std::filesystem::path folder, std::uint64_t most_bytes);

  /// Whether so many bytes, in blocks of `block` bytes, would all stay when they are kept one after the
  /// other, whatever else is there.
  bool has_room(std::uint64_t bytes, std::uint64_t block) const;
  /// Whether there is a block, which may still be damaged.
  bool contains(const std::string& key) const;
  /// The block, of so many bytes; empty if it is missing or damaged.
  std::optional<std::vector<std::byte>> find(const std::string& key, std::size_t count);
  void keep(const std::string& key, std::span<const std::byte> block);

  /// How many of the bytes of a whole file are there. `key` names the file and its version.
  std::uint64_t fetched_of(const std::string& key, std::uint64_t bytes) const;
  /// Opens the copy of that file, or begins one. Empty if the copy would not fit, cannot be written, or is
  /// being fetched by another process.
  std::optional<KeptCopy> copy_of(const std::string& key, std::uint64_t bytes);
  /// Adds the next bytes to a copy, on the disk. Errors: they cannot be written.
  void extend(KeptCopy& copy, const std::string& key, std::uint64_t bytes, std::span<const std::byte> next);

 private:
  std::filesystem::path path_of(const std::string& key, std::string_view extension) const;
  /// Sums up the folder, and removes what has not been used for longest if it is too much.
  void make_room();
  /// The size to which make_room() cuts: less than allowed, so that this is rare.
  std::uint64_t cut_bytes() const { return most_bytes_ / 5 * 4; }

  std::filesystem::path folder_;
  std::uint64_t most_bytes_;
  /// Of the blocks, without what other programs wrote since make_room().
  std::atomic<std::uint64_t> bytes_ = 0;
  std::atomic<int> temporaries_ = 0;
};

}  // namespace alidade::geo
