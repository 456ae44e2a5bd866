// SPDX-License-Identifier: MIT
#include "cloud/laz/layered_codec.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <string_view>

#include "base/bytes.h"
#include "cloud/laz/layer.h"
#include "cloud/laz/position_layer.h"

namespace alidade {
namespace {

std::size_t count_layers(const LazItem& item) {
  struct LayeredItem {
    LazItemKind kind;
    std::size_t size, layers;
  };
  constexpr std::array<LayeredItem, 4> k_items = {
      {{LazItemKind::point14, point14::k_size, 9},
       {LazItemKind::rgb14, k_color_size, 1},
       {LazItemKind::rgb_nir14, k_color_size + k_near_infrared_size, 2},
       {LazItemKind::wave_packet14, WavePacketModels::k_size, 1}}};
  if (item.version >= 2 && item.version <= 4) {
    if (item.kind == LazItemKind::byte14 && item.size > 0) return item.size;
    for (const LayeredItem& known : k_items)
      if (item.kind == known.kind && item.size == known.size) return known.layers;
  }
  throw CorruptChunk(
      fmt::format("unsupported item; expected kinds 10 to 14 in versions 2 to 4, found kind {} of "
                  "{} bytes in version {}",
                  static_cast<unsigned>(item.kind), item.size, item.version));
}

/// Points that a layered codec passes through one layer before the next: enough that a layer stays in
/// registers, few enough that the records stay in the cache.
constexpr std::size_t k_layered_block = 512;

/// Thrown when a stream fails at an unknown point of a block.
struct FailedBlock {};

}  // namespace

std::size_t count_layers(const LazLayout& layout) {
  std::size_t layers = 0;
  for (std::size_t i = 0; i < layout.items.size(); ++i) {
    layers += count_layers(layout.items[i]);
    const bool is_point = layout.items[i].kind == LazItemKind::point14;
    if (is_point != (i == 0))
      throw CorruptChunk(
          fmt::format("items out of order; expected kind 10 "
                      "first, found kind {} as number {}",
                      static_cast<unsigned>(layout.items[i].kind), i));
  }
  if (layers == 0) throw CorruptChunk("missing items; expected one of kind 10, found none");
  return layers;
}

LayeredChunkHead::LayeredChunkHead(const LazLayout& layout)
    : record_size_(layout.record_size()), layer_sizes_(count_layers(layout)) {}

void LayeredChunkHead::read(std::span<const std::byte> bytes) {
  constexpr std::uint32_t k_smallest_layer = 4;  // an empty stream of the arithmetic coder
  if (bytes.size() < size())
    throw CorruptChunk(
        fmt::format("truncated chunk: it ends before its layers; expected at least {} bytes, found {}",
                    size(), bytes.size()));
  const std::byte* at = bytes.data() + record_size_;
  point_count_ = load<std::uint32_t>(at);
  if (point_count_ == 0) throw CorruptChunk("the chunk has no points");
  chunk_size_ = size();
  for (std::size_t layer = 0; layer < layer_sizes_.size(); ++layer) {
    at += 4;
    const std::uint32_t layer_size = layer_sizes_[layer] = load<std::uint32_t>(at);
    const bool may_be_empty = layer > 0 || point_count_ == 1;
    if (layer_size < k_smallest_layer && !(layer_size == 0 && may_be_empty))
      throw CorruptChunk(fmt::format("layer {} is too small; expected {}at least {} bytes, found {}", layer,
                                     may_be_empty ? "0, or " : "", k_smallest_layer, layer_size));
    chunk_size_ += layer_size;
  }
}

/// What decoder and encoder of chunks share.
template <class Coder>
struct LayeredState {
  LayeredState(const LazLayout& layout, const LazLayers& wanted)
      : record_size(layout.record_size()), layers(make_layers(layout, wanted)), streams(layers.size()) {}

  std::size_t record_size;
  PositionLayer positions;
  Coder position_stream;
  std::vector<std::unique_ptr<Layer>> layers;  // null where not wanted
  std::vector<Coder> streams;                  // of the layers
  std::vector<std::size_t> active;             // layers that the chunk has, of those that are wanted
  std::array<LayeredPoint, k_layered_block> points;
};

struct LayeredDecoder::State : LayeredState<ArithmeticDecoder> {
  State(const LazLayout& layout, const LazLayers& wanted) : LayeredState(layout, wanted), head(layout) {}

  /// Finds the streams of all layers and begins with the first record.
  void start(std::span<const std::byte> chunk, std::size_t point_count) {
    head.read(chunk);
    if (head.point_count() != point_count)
      throw CorruptChunk(fmt::format("wrong number of points in the chunk; expected {}, found {}",
                                     point_count, head.point_count()));
    if (head.chunk_size() != chunk.size())
      throw CorruptChunk(fmt::format("the layers do not fill the chunk; expected {} bytes, found {}",
                                     chunk.size(), head.chunk_size()));
    const unsigned channel = point14::channel(chunk.data());
    std::span<const std::byte> bytes = chunk.subspan(head.size());
    const auto take = [&](std::size_t layer) {
      const std::size_t size = head.layer_sizes()[layer];
      const std::span<const std::byte> taken = bytes.first(size);
      bytes = bytes.subspan(size);
      return taken;
    };
    // A chunk of one point may lack the stream, which is then never read.
    const std::span<const std::byte> position_bytes = take(0);
    if (!position_bytes.empty()) position_stream = ArithmeticDecoder(position_bytes);
    positions.start(chunk.data());
    active.clear();
    for (std::size_t i = 0; i < layers.size(); ++i) {
      const std::span<const std::byte> layer_bytes = take(i + 1);
      if (layers[i] == nullptr || layer_bytes.empty()) continue;
      streams[i] = ArithmeticDecoder(layer_bytes);
      layers[i]->start(chunk.data(), channel);
      active.push_back(i);
    }
  }

  void decode_points(std::span<const std::byte> chunk, std::span<std::byte> records,
                     std::size_t block_points) {
    const std::size_t count = records.size() / record_size;
    start(chunk, count);
    std::memcpy(records.data(), chunk.data(), record_size);
    for (std::size_t point = 1; point < count; point += block_points) {
      const std::size_t block = std::min(block_points, count - point);
      std::byte* const at = records.data() + point * record_size;
      for (std::size_t i = 0; i < block; ++i) std::memcpy(at + i * record_size, chunk.data(), record_size);
      decode_block(at, point, block);
    }
    check_end();
  }

  void decode_block(std::byte* records, std::size_t first_point, std::size_t count) {
    const std::span<LayeredPoint> block(points.data(), count);
    positions.decode(position_stream, block, records, record_size);
    check_stream(position_stream, 0, first_point, count);
    check_changes(block, first_point);
    for (const std::size_t i : active) {
      layers[i]->decode(streams[i], {.points = block, .records = records, .record_size = record_size});
      check_stream(streams[i], i + 1, first_point, count);
    }
  }

  /// Streams record only that they failed: the point is known in a block of one.
  void check_stream(const ArithmeticDecoder& stream, std::size_t layer, std::size_t first_point,
                    std::size_t count) const {
    if (!stream.failed()) return;
    if (count > 1) throw FailedBlock();
    const std::size_t size = head.layer_sizes()[layer];
    if (stream.consumed() == size)
      throw CorruptChunk(fmt::format("truncated layer of {}: it ends before the last point; expected all "
                                     "within {} bytes, found more",
                                     name(layer), size),
                         first_point);
    throw CorruptChunk(fmt::format("corrupt layer of {}; expected valid arithmetic codes", name(layer)),
                       first_point);
  }

  const char* name(std::size_t layer) const {
    return layer == 0 ? "returns and positions" : layers[layer - 1]->name();
  }

  /// An attribute that changes must have a layer, whether it is wanted or not.
  void check_changes(std::span<const LayeredPoint> block, std::size_t first_point) const {
    struct ChangedAttribute {
      LayeredPoint::Change change;
      std::size_t layer;
      std::string_view name;
    };
    constexpr std::array<ChangedAttribute, 3> k_attributes = {
        {{LayeredPoint::k_scan_angle, 5, "scan angle"},
         {LayeredPoint::k_point_source, 7, "point source"},
         {LayeredPoint::k_gps_time, 8, "GPS time"}}};
    for (const ChangedAttribute& attribute : k_attributes) {
      if (head.layer_sizes()[attribute.layer] != 0) continue;
      const auto changed = std::find_if(
          block.begin(), block.end(), [&](const LayeredPoint& point) { return point.has(attribute.change); });
      if (changed != block.end())
        throw CorruptChunk(
            fmt::format("the {} changes, but its layer is empty; expected at least 4 bytes, found 0",
                        attribute.name),
            first_point + static_cast<std::size_t>(changed - block.begin()));
    }
  }

  /// An intact layer ends exactly behind the last point.
  void check_end() const {
    const auto check = [&](const ArithmeticDecoder& stream, std::size_t layer) {
      // A chunk of one point reads only the start of a stream.
      check_stream(stream, layer, 0, 1);
      const std::size_t size = head.layer_sizes()[layer];
      if (stream.consumed() != size)
        throw CorruptChunk(
            fmt::format("extra bytes after the last point in the layer of {}; expected {} bytes, found {}",
                        name(layer), stream.consumed(), size));
    };
    if (head.layer_sizes()[0] != 0) check(position_stream, 0);
    for (const std::size_t i : active) check(streams[i], i + 1);
  }

  LayeredChunkHead head;
};

LayeredDecoder::LayeredDecoder(const LazLayout& layout, const LazLayers& wanted)
    : state_(std::make_unique<State>(layout, wanted)) {}
LayeredDecoder::~LayeredDecoder() = default;

void LayeredDecoder::decode(std::span<const std::byte> chunk, std::span<std::byte> records) {
  assert(!records.empty() && records.size() % state_->record_size == 0);
  try {
    state_->decode_points(chunk, records, k_layered_block);
  } catch (const FailedBlock&) {
    state_->decode_points(chunk, records, 1);
  }
}

struct LayeredEncoder::State : LayeredState<ArithmeticEncoder> {
  using LayeredState::LayeredState;
};

LayeredEncoder::LayeredEncoder(const LazLayout& layout)
    : state_(std::make_unique<State>(layout, LazLayers{})) {}
LayeredEncoder::~LayeredEncoder() = default;

std::vector<std::byte> LayeredEncoder::encode(std::span<const std::byte> records) {
  State& state = *state_;
  const std::size_t size = state.record_size;
  const std::size_t count = records.size() / size;
  assert(count > 0 && records.size() % size == 0);
  state.positions.start(records.data());
  state.active.clear();
  for (std::size_t i = 0; i < state.layers.size(); ++i) {
    if (!state.layers[i]->needed(records, size)) continue;
    state.layers[i]->start(records.data(), point14::channel(records.data()));
    state.active.push_back(i);
  }
  for (std::size_t point = 1; point < count; point += k_layered_block) {
    const std::span<LayeredPoint> block(state.points.data(), std::min(k_layered_block, count - point));
    const std::byte* const at = records.data() + point * size;
    state.positions.encode(state.position_stream, block, at, size);
    for (const std::size_t i : state.active)
      state.layers[i]->encode(state.streams[i], {.points = block, .records = at, .record_size = size});
  }
  std::vector<std::byte> chunk(records.begin(), records.begin() + static_cast<std::ptrdiff_t>(size));
  const auto append_u32 = [&](std::size_t value) {
    chunk.resize(chunk.size() + 4);
    store(chunk.data() + chunk.size() - 4, static_cast<std::uint32_t>(value));
  };
  append_u32(count);
  std::vector<std::vector<std::byte>> finished(1 + state.layers.size());
  finished[0] = state.position_stream.finish();
  for (const std::size_t i : state.active) finished[1 + i] = state.streams[i].finish();
  for (const std::vector<std::byte>& layer : finished) append_u32(layer.size());
  for (const std::vector<std::byte>& layer : finished) chunk.insert(chunk.end(), layer.begin(), layer.end());
  return chunk;
}

}  // namespace alidade
