// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "cloud/laz/entropy_coder.h"
#include "cloud/laz/laz_layout.h"

namespace alidade {

/// Rules of one item of point data records in pointwise LAZ streams, with their models.
class PointwiseItem {
 public:
  virtual ~PointwiseItem() = default;

  /// Begins a chunk with the item of its first record, and resets all models.
  virtual void start(const std::byte* first) = 0;

  /// Writes the item of the next record to `item`, which need not be adjacent to the last one.
  virtual void decode(ArithmeticDecoder& stream, std::byte* item) = 0;

  virtual void encode(ArithmeticEncoder& stream, const std::byte* item) = 0;
};

struct PlacedItem {
  std::size_t offset;  ///< in the record, bytes
  std::unique_ptr<PointwiseItem> rules;
};

// Point data records of formats 0 to 5 in LAZ files (compressors 1 and 2): a chunk is its first record as it
// is, then one stream of the arithmetic coder in which every further record is coded item by item. Records
// are those of LAS.

/// Decodes chunks one after another. Memory is taken on the first use of an attribute's value, then kept. For
/// one thread at a time.
///
///     PointwiseDecoder decoder(layout);
///     decoder.start(chunk);
///     decoder.decode(records);  // some of the chunk's points, or all
class PointwiseDecoder {
 public:
  /// Errors: CorruptChunk, if the layout has items that pointwise streams do not have.
  explicit PointwiseDecoder(const LazLayout& layout);

  /// Begins a chunk, whose bytes must outlive its decoding and may be followed by others. Errors:
  /// CorruptChunk, if it is too short for one point.
  void start(std::span<const std::byte> chunk);

  /// Decodes the next records of the chunk. Requires a whole number of them, and at most as many as the chunk
  /// has; beyond these the decoder returns arbitrary points or throws. Errors: CorruptChunk with the point's
  /// number in the chunk, if the chunk ends early or holds values that no encoder writes; the records from
  /// there on are then undefined. Cost: linear in the records.
  void decode(std::span<std::byte> records);

  /// Bytes of the chunk read so far: all of them once its last point is decoded.
  std::size_t consumed() const { return point_ == 0 ? 0 : record_size_ + stream_.consumed(); }

 private:
  [[noreturn]] void throw_corrupt() const;

  std::size_t record_size_;
  std::vector<PlacedItem> items_;
  std::span<const std::byte> chunk_;
  ArithmeticDecoder stream_;
  std::uint64_t point_ = 0;  // the next to be decoded
};

/// Encodes chunks, byte for byte as other writers do. For one thread at a time.
class PointwiseEncoder {
 public:
  /// Errors: as PointwiseDecoder.
  explicit PointwiseEncoder(const LazLayout& layout);

  /// The chunk of these records. Requires a whole number of them, at least one.
  std::vector<std::byte> encode(std::span<const std::byte> records);

 private:
  std::size_t record_size_;
  std::vector<PlacedItem> items_;
};

}  // namespace alidade
