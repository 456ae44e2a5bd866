// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "database/server/server_column.h"
#include "database/value_blobs.h"

namespace alidade {

/// Rows of a cloud as COPY ... (FORMAT binary) of PostgreSQL takes them, in the columns of server_columns().
/// Source: PostgreSQL 15 documentation, COPY, "Binary Format".
class CopyRows {
 public:
  /// The cloud must outlive it. Requires at most 32,766 columns.
  explicit CopyRows(const PointCloud& cloud);

  const std::vector<StoredColumn>& columns() const { return columns_; }

  /// What stands before the first row and behind the last.
  static std::vector<std::byte> head();
  static std::vector<std::byte> tail();

  /// Adds a row, id and all, to `bytes`.
  void append(std::uint32_t row, std::vector<std::byte>& bytes) const;

 private:
  const PointCloud& cloud_;
  std::vector<StoredColumn> columns_;
  std::vector<ServerType> types_;
  AttributeColumns attributes_;
  std::vector<ValueBlob> blobs_;
};

}  // namespace alidade
