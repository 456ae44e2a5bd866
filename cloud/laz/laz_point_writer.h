// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>

#include "base/output_file.h"
#include "cloud/laz/laz_layout.h"

namespace alidade {

/// Writes the points of a LAZ file: the offset of the chunk table, the chunks, which are packed in parallel,
/// and the table. The bytes do not depend on the number of threads, nor on the pieces that records come in.
///
/// Memory: the records of two chunks per thread and what they are packed into, but no more than 64 MB of
/// records beside the first chunk.
class LazPointWriter {
 public:
  /// Points begin at the end of what is written to `file` so far. Requires the layout of the file's laszip
  /// record, as standard_laz_layout() makes it: chunks of one size. `file` must outlive this object.
  LazPointWriter(OutputFile& file, const LazLayout& layout);
  ~LazPointWriter();
  LazPointWriter(const LazPointWriter&) = delete;
  LazPointWriter& operator=(const LazPointWriter&) = delete;

  /// Appends a whole number of point data records. Errors: as OutputFile.
  void write(std::span<const std::byte> records);

  /// Packs what is left, and writes the table and its offset. Call once, last.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Takes the points of a file as LazPointWriter does: packed if there is a layout to pack them by, else as they
/// are.
class RecordOutput {
 public:
  RecordOutput(OutputFile& file, const std::optional<LazLayout>& packing) : file_(file) {
    if (packing) packed_.emplace(file, *packing);
  }
  void write(std::span<const std::byte> records) {
    if (packed_) {
      packed_->write(records);
    } else {
      file_.write(records);
    }
  }
  void finish() {
    if (packed_) packed_->finish();
  }

 private:
  OutputFile& file_;
  std::optional<LazPointWriter> packed_;
};

}  // namespace alidade
