// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "cloud/laz/arithmetic_encoder.h"
#include "cloud/laz/entropy_coder.h"
#include "cloud/laz/laz_layout.h"

namespace alidade {

/// Rules of one item of point data records in pointwise LAZ streams, with the models they have learnt.
class PointwiseItem {
 public:
  virtual ~PointwiseItem() = default;

  /// Begins a chunk with the item of its first record: all models are fresh.
  virtual void start(const std::byte* first) = 0;

  /// Writes the item of the next record to `item`, which need not be behind the last.
  virtual void decode(ArithmeticDecoder& stream, std::byte* item) = 0;

  virtual void encode(ArithmeticEncoder& stream, const std::byte* item) = 0;
};

struct PlacedItem {
  std::size_t place;  ///< in the record, bytes
  std::unique_ptr<PointwiseItem> rules;
};

/// The items of a layout in their order. Errors: CorruptChunk, if pointwise streams have no such items.
std::vector<PlacedItem> make_pointwise_items(const LazLayout& layout);

}  // namespace alidade
