// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace alidade {

/// XXH3, 64 bits, seed 0, through the xxHash library: as fast as memory delivers on any machine, without
/// instructions of its own to choose, and its bytes are fixed since version 0.8.0. It finds damage; it does
/// not withstand forgers. Source: https://github.com/Cyan4973/xxHash, doc/xxhash_spec.md.
std::uint64_t checksum(std::span<const std::byte> bytes);

/// Appends the checksum of each array; 0 for a null one.
void append_checksums(std::initializer_list<std::span<const std::byte>> arrays,
                      std::vector<std::uint64_t>& sums);

/// Sections of a file are summed in blocks, so that threads can share the work and damage can be located.
inline constexpr std::size_t k_checksum_block = std::size_t{1} << 20;

/// Number of blocks in so many bytes; the last one may be short.
constexpr std::uint64_t checksum_blocks(std::uint64_t bytes) {
  return bytes / k_checksum_block + (bytes % k_checksum_block != 0);
}

/// The block with this number.
inline std::span<const std::byte> checksum_block(std::span<const std::byte> bytes, std::size_t block) {
  const std::span<const std::byte> rest = bytes.subspan(block * k_checksum_block);
  return rest.first(rest.size() < k_checksum_block ? rest.size() : k_checksum_block);
}

/// Cuts bytes that come in pieces into such blocks.
class ChecksumBlocks {
 public:
  /// Calls `put` with every block once it is complete, and in the end with the last one.
  explicit ChecksumBlocks(std::function<void(std::span<const std::byte>)> put) : put_(std::move(put)) {}

  /// Blocks that lie whole in `bytes` are not copied.
  void add(std::span<const std::byte> bytes);
  /// Ends the last block; bytes added next begin another.
  void end();
  /// Of all blocks so far.
  const std::vector<std::uint64_t>& sums() const { return sums_; }

 private:
  void put(std::span<const std::byte> block);

  std::function<void(std::span<const std::byte>)> put_;
  std::vector<std::byte> block_;
  std::vector<std::uint64_t> sums_;
};

// What the results of a long task depend on, as text: a run resumes from a checkpoint only where the result
// stays the same.

/// One thing that results depend on.
struct FingerprintEntry {
  std::string name;   ///< in messages: "seed", "sky"
  std::string value;  ///< exact: equal texts are equal things

  bool operator==(const FingerprintEntry&) const = default;
};

/// All that results depend on, in a fixed order: an entry comes before those that follow from it. Numbers are
/// written so that different ones have different texts.
using Fingerprint = std::vector<FingerprintEntry>;

/// The words of messages about a fingerprint.
struct FingerprintWords {
  std::string of = "picture";
  std::string same = "scene, cloud and options";  ///< what has to be equal
  std::string file = "checkpoint";                ///< what kind of file has the fingerprint
  std::string other = "this run";                 ///< what it is compared with
  std::string remedy = ", or no --resume";
};

/// Errors: the first entry that differs, under `file`. Long texts are shown from where they differ.
void check_fingerprint(const Fingerprint& made, const Fingerprint& asked, const std::string& file,
                       const FingerprintWords& words = {});

/// Appends the entries as bytes: of each 4 B length of the name, 4 B length of the value, name, value.
void append_fingerprint(const Fingerprint& fingerprint, std::vector<std::byte>& bytes);

/// Reads them back from bytes of `file` that begin at its byte `offset`. Errors: they do not end where an
/// entry does.
Fingerprint read_fingerprint(std::span<const std::byte> bytes, std::size_t offset, const std::string& file);

}  // namespace alidade
