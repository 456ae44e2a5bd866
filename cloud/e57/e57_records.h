// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "cloud/e57/e57_file.h"
#include "cloud/e57/e57_pages.h"

namespace alidade {

/// Numbers of one width that arrive as bytes in pieces, cut anywhere: the i-th takes bits i * width and up,
/// bit k of the stream is bit k mod 8 of byte k / 8. Memory: what was added and not yet taken.
class BitQueue {
 public:
  /// Width is 0 to 64 bits. Of width 0 there are always any number of zeros.
  explicit BitQueue(int width) : width_(width) {}

  void add(std::span<const std::byte> piece);
  /// What is added next begins with a new number, in a byte of its own: bits left over from the last one are
  /// forgotten, and of numbers narrower than a byte all that is left of the last byte. False if more waits
  /// before such bits, so that they cannot be.
  bool restart();
  /// Whole numbers to be taken, `most` at most.
  std::size_t available(std::size_t most) const;
  /// Takes the next ones. Requires: as many are available.
  void take(std::span<std::uint64_t> numbers);

 private:
  std::uint64_t bit_count() const { return 8 * std::uint64_t{bytes_.size()} - next_bit_; }

  int width_;
  std::vector<std::byte> bytes_;
  std::uint64_t next_bit_ = 0;  ///< of bytes_
};

/// Reads the records of a scan, some thousand at a time. Streams of fields that are not requested are not
/// decoded. Memory: a block; where streams of one scan run apart, what one is ahead of another.
class E57Records {
 public:
  /// Takes columns of values: columns[i] belongs to the i-th field asked for.
  using Visitor = std::function<void(std::span<const std::vector<double>> columns, std::size_t count)>;

  /// `wanted` are fields of the scan, ascending, none of them text; `where` is what messages call the scan.
  /// The scan is one of an E57File over `pages`.
  E57Records(E57Pages& pages, const E57Scan& scan, std::string where, std::span<const std::size_t> wanted);

  /// Passes on all records in order. Errors, with scan and packet, counted from 1: an invalid packet or one
  /// that leaves the section, another number of streams than the scan has fields, a section that ends before
  /// all records were read; a damaged page.
  void visit(const Visitor& visitor);

 private:
  struct Stream {
    std::size_t field;
    BitQueue queue;
  };

  bool next_packet();
  void take_pieces(std::span<const std::byte> packet);
  void decode(const Stream& stream, std::span<const std::uint64_t> numbers, std::span<double> values) const;
  [[noreturn]] void fail(std::string problem, std::string expected = {}, std::string found = {}) const;

  E57Pages& pages_;
  const E57Scan& scan_;
  std::string where_;
  std::vector<Stream> streams_;
  std::uint64_t offset_;      ///< of the next packet
  std::uint64_t packet_ = 0;  ///< number of the one last read
};

}  // namespace alidade
