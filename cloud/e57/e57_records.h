// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "cloud/e57/bit_queue.h"
#include "cloud/e57/e57_document.h"
#include "cloud/e57/e57_pages.h"

namespace alidade {

/// Walks through the records of a scan, some thousand at a time. Streams of fields that nobody asks for are
/// not looked at. Memory: a block; where streams of one scan run apart, what one is ahead of another.
class E57Records {
 public:
  /// Takes columns of values: columns[i] belongs to the i-th field asked for.
  using Visitor = std::function<void(std::span<const std::vector<double>> columns, std::size_t count)>;

  /// `wanted` are fields of the scan, ascending, none of them text; `where` is what messages call the scan.
  /// The scan is one of an E57File over `pages`.
  E57Records(E57Pages& pages, const E57Scan& scan, std::string where, std::span<const std::size_t> wanted);

  /// Shows all records in order. Errors, with scan and packet, counted from 1: a packet that is none or
  /// leaves the section, another number of streams than the scan has fields, a section that ends before all
  /// records were read; a damaged page.
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
  std::uint64_t place_;       ///< of the next packet
  std::uint64_t packet_ = 0;  ///< number of the one last read
};

}  // namespace alidade
