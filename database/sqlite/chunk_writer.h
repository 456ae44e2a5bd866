// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "database/encode_points.h"
#include "database/sqlite/statement.h"

namespace alidade {

/// Writes chunk after chunk into the tables of a cloud (database/sqlite/cloud_schema.h).
class ChunkWriter {
 public:
  ChunkWriter(sqlite3* database, const std::string& table, const ChunkEncoding& encoding);

  void write(const EncodedChunks& chunks);

  /// Of the chunks written so far.
  std::vector<Bounds> boxes() && { return std::move(boxes_); }

 private:
  const ChunkEncoding& encoding_;
  Statement chunk_, value_;
  std::vector<Bounds> boxes_;
};

}  // namespace alidade
