// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "cloud/laz/layered_codec.h"
#include "cloud/laz/laz_layout.h"
#include "cloud/laz/pointwise_codec.h"

namespace alidade {

/// Packs chunks by the rules of whatever compressor, one after another. Not thread safe: one per thread.
class ChunkEncoder {
 public:
  /// Requires what LayeredEncoder or PointwiseEncoder requires. Errors: as theirs.
  explicit ChunkEncoder(const LazLayout& layout) {
    if (layout.compressor == LazCompressor::layered) {
      layered_.emplace(layout);
    } else {
      pointwise_.emplace(layout);
    }
  }

  /// One chunk. Requires a whole number of records, at least one.
  std::vector<std::byte> encode(std::span<const std::byte> records) {
    return layered_ ? layered_->encode(records) : pointwise_->encode(records);
  }

 private:
  std::optional<LayeredEncoder> layered_;
  std::optional<PointwiseEncoder> pointwise_;
};

}  // namespace alidade
