// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <string_view>

#include "cloud/laz/corrupt_chunk.h"
#include "cloud/laz/layered_block.h"
#include "cloud/laz/layered_chunk.h"
#include "cloud/laz/layered_codec.h"
#include "cloud/laz/make_layers.h"
#include "cloud/laz/point14_fields.h"
#include "cloud/laz/position_layer.h"

namespace alidade {
namespace {

constexpr const char* k_positions = "returns and positions";

/// Somewhere in a block a stream has failed.
struct FailedBlock {};

}  // namespace

struct LayeredDecoder::State {
  State(const LazLayout& layout, const LazLayers& wanted)
      : record_size(layout.record_size()),
        head(layout),
        layers(make_layers(layout, wanted)),
        streams(layers.size()) {}

  void start(std::span<const std::byte> chunk, std::size_t point_count);
  void decode_points(std::span<const std::byte> chunk, std::span<std::byte> records,
                     std::size_t block_points);
  void decode_block(std::byte* records, std::size_t first_point, std::size_t count);
  void check_stream(const ArithmeticDecoder& stream, std::size_t layer, std::size_t first_point,
                    std::size_t count) const;
  const char* name(std::size_t layer) const { return layer == 0 ? k_positions : layers[layer - 1]->name(); }
  void check_changes(std::span<const LayeredPoint> block, std::size_t first_point) const;
  void check_end() const;

  std::size_t record_size;
  LayeredChunkHead head;
  PositionLayer positions;
  ArithmeticDecoder position_stream;
  std::vector<std::unique_ptr<Layer>> layers;  // null where not wanted
  std::vector<ArithmeticDecoder> streams;      // of the layers
  std::vector<std::size_t> active;             // layers that are wanted and have bytes
  std::array<LayeredPoint, k_layered_block> points;
};

LayeredDecoder::LayeredDecoder(const LazLayout& layout, const LazLayers& wanted)
    : state_(std::make_unique<State>(layout, wanted)) {}
LayeredDecoder::LayeredDecoder(LayeredDecoder&&) noexcept = default;
LayeredDecoder& LayeredDecoder::operator=(LayeredDecoder&&) noexcept = default;
LayeredDecoder::~LayeredDecoder() = default;

/// Finds the streams of all layers and begins with the first record.
void LayeredDecoder::State::start(std::span<const std::byte> chunk, std::size_t point_count) {
  head.read(chunk);
  if (head.point_count() != point_count)
    throw CorruptChunk(fmt::format("the chunk has another number of points; expected {}, found {}",
                                   point_count, head.point_count()));
  if (head.chunk_size() != chunk.size())
    throw CorruptChunk(fmt::format("the layers do not fill the chunk; expected {} bytes in all, found {}",
                                   chunk.size(), head.chunk_size()));
  const unsigned channel = point14::channel(chunk.data());
  std::span<const std::byte> bytes = chunk.subspan(head.size());
  const auto take = [&](std::size_t layer) {
    const std::size_t size = head.layer_sizes()[layer];
    const std::span<const std::byte> taken = bytes.first(size);
    bytes = bytes.subspan(size);
    return taken;
  };
  // With one point the stream may be missing; it is never read then.
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

/// An attribute that changes must have a layer, whether it is wanted or not.
void LayeredDecoder::State::check_changes(std::span<const LayeredPoint> block,
                                          std::size_t first_point) const {
  struct Attribute {
    LayeredPoint::Change change;
    std::size_t layer;
    std::string_view name;
  };
  constexpr std::array<Attribute, 3> k_attributes = {{{LayeredPoint::k_scan_angle, 5, "scan angle"},
                                                      {LayeredPoint::k_point_source, 7, "point source"},
                                                      {LayeredPoint::k_gps_time, 8, "GPS time"}}};
  for (const Attribute& attribute : k_attributes) {
    if (head.layer_sizes()[attribute.layer] != 0) continue;
    const auto changed = std::find_if(block.begin(), block.end(),
                                      [&](const LayeredPoint& point) { return point.has(attribute.change); });
    if (changed != block.end())
      throw CorruptChunk(
          fmt::format("the {} changes, but its layer is empty; expected 4 bytes or more, found 0",
                      attribute.name),
          first_point + static_cast<std::size_t>(changed - block.begin()));
  }
}

/// Streams remember only that something was wrong: which point it was, is known of a block of one.
void LayeredDecoder::State::check_stream(const ArithmeticDecoder& stream, std::size_t layer,
                                         std::size_t first_point, std::size_t count) const {
  if (!stream.failed()) return;
  if (count > 1) throw FailedBlock();
  const std::size_t size = head.layer_sizes()[layer];
  if (stream.consumed() == size)
    throw CorruptChunk(
        fmt::format("the layer of {} ends before the last point; expected all within {} bytes, found more",
                    name(layer), size),
        first_point);
  throw CorruptChunk(
      fmt::format("the layer of {} is damaged; expected values that encoders write, found others",
                  name(layer)),
      first_point);
}

void LayeredDecoder::State::decode_block(std::byte* records, std::size_t first_point, std::size_t count) {
  const std::span<LayeredPoint> block(points.data(), count);
  positions.decode(position_stream, block, records, record_size);
  check_stream(position_stream, 0, first_point, count);
  check_changes(block, first_point);
  for (const std::size_t i : active) {
    layers[i]->decode(streams[i], {.points = block, .records = records, .record_size = record_size});
    check_stream(streams[i], i + 1, first_point, count);
  }
}

void LayeredDecoder::State::decode_points(std::span<const std::byte> chunk, std::span<std::byte> records,
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

/// A sound layer ends exactly behind the last point.
void LayeredDecoder::State::check_end() const {
  const auto check = [&](const ArithmeticDecoder& stream, std::size_t layer) {
    // One point reads nothing of a stream but its start.
    check_stream(stream, layer, 0, 1);
    const std::size_t size = head.layer_sizes()[layer];
    if (stream.consumed() != size)
      throw CorruptChunk(
          fmt::format("the layer of {} goes on behind the last point; expected {} bytes, found {}",
                      name(layer), stream.consumed(), size));
  };
  if (head.layer_sizes()[0] != 0) check(position_stream, 0);
  for (const std::size_t i : active) check(streams[i], i + 1);
}

void LayeredDecoder::decode(std::span<const std::byte> chunk, std::span<std::byte> records) {
  assert(!records.empty() && records.size() % state_->record_size == 0);
  try {
    state_->decode_points(chunk, records, k_layered_block);
  } catch (const FailedBlock&) {
    state_->decode_points(chunk, records, 1);
  }
}

}  // namespace alidade
