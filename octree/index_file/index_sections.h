// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "base/progress.h"
#include "base/remote_map.h"
#include "octree/index_file/index_header.h"

namespace alidade {

/// The sections of an index file in the map, and the checking of their sums. Each block of a section has a
/// checksum in the last section, and the header has one of each section's run of these.
class IndexSections {
 public:
  /// The blocks of a remote file are checked when they arrive, and so are ids (find_bad_id()).
  /// RemoteMap::check() throws what fails then. Errors: as read_index_header(); those of MappedFile.
  explicit IndexSections(const InputFile& file);

  const std::string& name() const { return map_.name(); }
  const IndexHeader& header() const { return header_; }
  const std::shared_ptr<const void>& storage() const { return map_.storage(); }
  /// Whether all that is read has been checked: the file is remote.
  bool are_checked_on_arrival() const { return are_checked_on_arrival_; }

  /// Empty if there is no such section.
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
  void check_on_arrival(RemoteMap& map);
  const SectionEntry& entry(IndexSection kind) const { return *header_.find(kind); }
  /// Errors: they differ from their sum in the header.
  std::vector<std::uint64_t> stored_checksums(IndexSection kind) const;

  IndexHeader header_;
  MappedFile map_;
  bool are_checked_on_arrival_ = false;
};

}  // namespace alidade
