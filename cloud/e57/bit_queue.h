// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

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

}  // namespace alidade
