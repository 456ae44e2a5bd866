// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "cloud/read_in_pieces.h"
#include "database/encode_points.h"
#include "database/server/server_column.h"

namespace alidade {

/// Makes rows as COPY ... (FORMAT binary) of PostgreSQL takes them, with the columns of server_columns().
/// Source: PostgreSQL 15 documentation, COPY, "Binary Format".
class CopyRows {
 public:
  /// Requires at most 32,764 columns.
  CopyRows(std::vector<StoredColumn> columns, const Lattice& lattice);

  const std::vector<StoredColumn>& columns() const { return columns_; }

  /// What stands before the first row and behind the last.
  static std::vector<std::byte> head();
  static std::vector<std::byte> tail();

  /// Adds a row for the i-th of the points to `bytes`.
  void append(const EncodedChunks& points, std::size_t i, std::vector<std::byte>& bytes) const;

  /// Gives the next `count` points of a stream, those of `whole`, to `write` as a whole COPY, piece by piece;
  /// answers their box.
  Bounds copy(PointStream& points, const PiecewiseCloud& whole, std::uint64_t count,
              const std::function<void(std::span<const std::byte> bytes, std::size_t points)>& write) const;

 private:
  std::vector<StoredColumn> columns_;
  std::vector<ServerType> types_;
  Lattice lattice_;
};

}  // namespace alidade
