// SPDX-License-Identifier: MIT
#include "cloud/laz/layered_chunk.h"

#include <fmt/format.h>

#include "base/bytes.h"
#include "cloud/laz/corrupt_chunk.h"
#include "cloud/laz/field_layers.h"
#include "cloud/laz/point14_fields.h"

namespace alidade {
namespace {

std::size_t count_layers(const LazItem& item) {
  if (item.version >= 2 && item.version <= 4) {
    switch (item.kind) {
      case LazItemKind::point14:
        if (item.size == point14::k_size) return 9;
        break;
      case LazItemKind::rgb14:
        if (item.size == k_color_size) return 1;
        break;
      case LazItemKind::rgb_nir14:
        if (item.size == k_color_size + k_near_infrared_size) return 2;
        break;
      case LazItemKind::wave_packet14:
        if (item.size == WavePacketModels::k_size) return 1;
        break;
      case LazItemKind::byte14:
        if (item.size > 0) return item.size;
        break;
      default:
        break;
    }
  }
  throw CorruptChunk(fmt::format(
      "unknown part of point records; expected kinds 10 to 14 in versions 2 to 4, found kind {} of "
      "{} bytes in version {}",
      static_cast<unsigned>(item.kind), item.size, item.version));
}

}  // namespace

std::size_t count_layers(const LazLayout& layout) {
  std::size_t layers = 0;
  for (std::size_t i = 0; i < layout.items.size(); ++i) {
    layers += count_layers(layout.items[i]);
    const bool is_point = layout.items[i].kind == LazItemKind::point14;
    if (is_point != (i == 0))
      throw CorruptChunk(
          fmt::format("the parts of point records are in no order; expected one of kind 10, the "
                      "first, found kind {} as number {}",
                      static_cast<unsigned>(layout.items[i].kind), i));
  }
  if (layers == 0) throw CorruptChunk("point records have no parts; expected one of kind 10, found none");
  return layers;
}

LayeredChunkHead::LayeredChunkHead(const LazLayout& layout)
    : record_size_(layout.record_size()), layer_sizes_(count_layers(layout)) {}

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
