// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "database/point_stream.h"
#include "database/stored_column.h"
#include "extensions/parquet/column_chunk.h"
#include "extensions/parquet/thrift_writer.h"

namespace alidade::database {

/// A column of a Parquet file, and the values of a cloud in it.
struct FileColumn {
  enum class Content { id, coordinate, attribute, geometry };

  std::string name;
  Content content = Content::attribute;
  PhysicalType type = PhysicalType::float64;
  int axis = 0;           ///< of a coordinate
  StoredColumn stored{};  ///< of an attribute
  int fixed_size = 0;     ///< of strings of bytes that all have one length
  int integer_bits = 0;   ///< 8 to 64 of whole numbers that are not plain int32 or int64; 0 otherwise
  bool is_signed = true;
  bool may_be_null = false;
};

/// The columns of the tables that `alidade sql load` makes, under their names: id, x, y, z, then the
/// others of `stored`. A number with scale or offset becomes its value, as double; a mark for missing
/// values becomes null. `geometry`: adds a last column of WKB points, called geometry, or geometry_ if
/// an attribute has that name.
std::vector<FileColumn> file_columns(const std::vector<StoredColumn>& stored, bool geometry);

/// Writes the column's element of the schema.
void write_schema_element(const FileColumn& column, ThriftWriter& writer);

/// The values of some rows, encoded.
ColumnChunk encode_column(const FileColumn& column, const EncodedChunks& rows, const Lattice& lattice);

}  // namespace alidade::database
