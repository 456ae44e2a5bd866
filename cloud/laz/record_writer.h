// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/output_file.h"
#include "cloud/laz/chunk_table.h"
#include "cloud/laz/laz_layout.h"

namespace alidade {

/// Writes the points of a LAS file as they are, or those of a LAZ file: the offset of the chunk table, the
/// chunks, which are packed in parallel, and the table. The bytes do not depend on the number of threads, nor
/// on the pieces in which records arrive.
///
/// Memory: to pack, the records of two chunks per thread and their packed bytes, but no more than 64 MB of
/// records beside the first chunk.
class RecordWriter {
 public:
  /// Points begin at the current end of `file`. `packing` is the layout of the file's laszip record, as
  /// standard_laz_layout() makes it: chunks of one size or, if its chunk_size is 0, of counts[0], counts[1],
  /// ... points. Without a layout, nothing is packed. `file` must outlive this object.
  RecordWriter(OutputFile& file, const std::optional<LazLayout>& packing,
               std::vector<std::uint32_t> counts = {});
  ~RecordWriter();
  RecordWriter(const RecordWriter&) = delete;
  RecordWriter& operator=(const RecordWriter&) = delete;

  /// Appends a whole number of point data records. Errors: as OutputFile.
  void write(std::span<const std::byte> records);

  /// Packs the remaining records, and writes the table and its offset. Call once, last.
  void finish();

  /// The chunks of the file, once all are written.
  std::span<const LazChunk> chunks() const;

 private:
  struct State;

  OutputFile& file_;
  std::unique_ptr<State> state_;  ///< of packing
};

}  // namespace alidade
