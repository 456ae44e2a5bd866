// SPDX-License-Identifier: MIT
#include "octree/cloud/laz/layered_chunk.h"

#include <fmt/format.h>

#include <cassert>

#include "octree/cloud/byte_order.h"
#include "octree/cloud/laz/corrupt_chunk.h"

namespace alidade {
namespace {

std::size_t layers_of(const LazItem& item) {
  switch (item.kind) {
    case LazItemKind::point14:
      return 9;
    case LazItemKind::rgb_nir14:
      return 2;
    case LazItemKind::byte14:
      return item.size;
    default:
      return 1;
  }
}

}  // namespace

LayeredChunkHead::LayeredChunkHead(const LazLayout& layout) : record_size_(layout.record_size()) {
  assert(layout.compressor == LazCompressor::layered);
  std::size_t layers = 0;
  for (const LazItem& item : layout.items) layers += layers_of(item);
  layer_sizes_.resize(layers);
}

void LayeredChunkHead::read(std::span<const std::byte> bytes) {
  constexpr std::uint32_t k_smallest_layer = 4;  // what an arithmetic coder writes of nothing
  if (bytes.size() < size())
    throw CorruptChunk(fmt::format("the chunk ends before its layers; expected {} bytes or more, found {}",
                                   size(), bytes.size()));
  const std::byte* at = bytes.data() + record_size_;
  point_count_ = load<std::uint32_t>(at);
  if (point_count_ == 0) throw CorruptChunk("the chunk has no points; expected 1 or more, found 0");
  chunk_size_ = size();
  for (std::size_t layer = 0; layer < layer_sizes_.size(); ++layer) {
    at += 4;
    const std::uint32_t layer_size = layer_sizes_[layer] = load<std::uint32_t>(at);
    const bool may_be_empty = layer > 0 || point_count_ == 1;
    if (layer_size < k_smallest_layer && !(layer_size == 0 && may_be_empty))
      throw CorruptChunk(fmt::format("layer {} is too small; expected {}{} bytes or more, found {}", layer,
                                     may_be_empty ? "0, or " : "", k_smallest_layer, layer_size));
    chunk_size_ += layer_size;
  }
}

}  // namespace alidade
