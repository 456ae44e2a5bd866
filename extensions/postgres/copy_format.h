// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "cloud/read_in_pieces.h"
#include "database/point_stream.h"
#include "extensions/postgres/server_sql.h"

namespace alidade::database {

/// A value of a row, highest byte first; without bytes: NULL.
using CopyField = std::span<const std::byte>;

/// Decodes the data of COPY ... TO STDOUT (FORMAT binary), in pieces of any size, into rows. Only for
/// values of at most 8 bytes. Errors: other data, or another number of fields. Source: PostgreSQL 15
/// documentation, COPY, "Binary Format".
class CopyDecoder {
 public:
  using TakeRow = std::function<void(std::span<const CopyField>)>;

  CopyDecoder(std::size_t fields, TakeRow take) : fields_(fields), take_(std::move(take)) {}

  void add(std::span<const std::byte> bytes);

  /// Errors: the end is missing.
  void finish() const;

 private:
  std::size_t take_head(std::span<const std::byte> bytes);
  std::size_t take_row(std::span<const std::byte> bytes);

  enum class Part { head, rows, end };

  std::vector<CopyField> fields_;
  TakeRow take_;
  Part part_ = Part::head;
  std::vector<std::byte> left_;  ///< of an incomplete row
};

/// Encodes rows for COPY ... FROM STDIN (FORMAT binary), with the columns of server_columns().
/// Source: PostgreSQL 15 documentation, COPY, "Binary Format".
class CopyRows {
 public:
  /// Requires at most 32,764 columns.
  CopyRows(std::vector<StoredColumn> columns, const Lattice& lattice);

  const std::vector<StoredColumn>& columns() const { return columns_; }

  /// The bytes before the first row and after the last.
  static std::vector<std::byte> head();
  static std::vector<std::byte> tail();

  /// Adds a row for the i-th of the points to `bytes`.
  void append(const EncodedChunks& points, std::size_t i, std::vector<std::byte>& bytes) const;

  /// Writes the next `count` points of a cloud with `write` as a complete COPY, piece by piece. Returns their
  /// box.
  Bounds copy(OrderedCloud& cloud, std::uint64_t count,
              const std::function<void(std::span<const std::byte> bytes, std::size_t points)>& write) const;

 private:
  std::vector<StoredColumn> columns_;
  std::vector<ServerType> types_;
  Lattice lattice_;
};

}  // namespace alidade::database
