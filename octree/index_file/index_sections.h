// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "base/progress.h"
#include "octree/index_file/index_header.h"

namespace alidade {

/// The sections of an index file, and the checking of their sums. Each block of a section has a checksum in
/// the last section, and the header has one of each section's run of these.
class IndexSections {
 public:
  /// Reads the header, and maps the file unless it is remote. Errors: as read_index_header(); those of
  /// InputFile.
  explicit IndexSections(const InputFile& file);

  const std::string& name() const { return file_.name(); }
  const IndexHeader& header() const { return header_; }

  /// A section with its checksums compared; of a remote file, only its bytes are fetched. Empty if there is
  /// no such section. Thread safe. Errors: as check(); it does not fit into memory.
  std::vector<std::byte> read(IndexSection kind) const;

  bool is_mapped() const { return map_.storage != nullptr; }
  /// Maps the file, unless it is: fetches a remote one whole. Not thread safe. Errors: InputFile::map().
  void map(const Progress& progress);

  /// A section in the map; empty if there is no such section.
  std::span<const std::byte> bytes(IndexSection kind) const;
  /// bytes() as values; they are aligned because sections are.
  template <class T>
  std::span<const T> values(IndexSection kind) const {
    const std::span<const std::byte> all = bytes(kind);
    return {reinterpret_cast<const T*>(all.data()), all.size() / sizeof(T)};
  }

  /// What else to do with a block of a section while it is at hand: the bytes [begin, end) of the section.
  using LookAtBlock = std::function<void(std::uint64_t begin, std::uint64_t end)>;

  /// Compares a section with its checksums, in parallel. Nothing is done for one that is not there.
  /// `progress` is in bytes. Errors: name section and byte of the first bad block; those that `look` throws.
  void check(IndexSection kind, const Progress& progress = {}, const LookAtBlock& look = {}) const;

  /// Errors: the gaps between the sections are not zero.
  void check_gaps() const;

  /// The Error for something wrong at a byte of a section.
  [[noreturn]] void fail(IndexSection kind, std::uint64_t byte, const std::string& problem) const;

 private:
  void check_blocks(IndexSection kind, std::span<const std::byte> all, const Progress& progress,
                    const LookAtBlock& look) const;
  const SectionEntry& entry(IndexSection kind) const { return *header_.find(kind); }
  /// Errors: they differ from their sum in the header.
  std::vector<std::uint64_t> stored_checksums(IndexSection kind) const;

  MappedBytes map_;
  mutable std::mutex reading_;
  mutable InputFile file_;  ///< the map as a file, unless it is remote
  IndexHeader header_;
};

}  // namespace alidade
