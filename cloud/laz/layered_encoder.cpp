// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cassert>

#include "cloud/laz/layered_block.h"
#include "cloud/laz/layered_codec.h"
#include "cloud/laz/make_layers.h"
#include "cloud/laz/point14_fields.h"
#include "cloud/laz/position_layer.h"

namespace alidade {

struct LayeredEncoder::State {
  explicit State(const LazLayout& layout)
      : record_size(layout.record_size()), layers(make_layers(layout, {})), streams(layers.size()) {}

  void start(std::span<const std::byte> records);
  void encode_block(const std::byte* records, std::size_t count);

  std::size_t record_size;
  PositionLayer positions;
  ArithmeticEncoder position_stream;
  std::vector<std::unique_ptr<Layer>> layers;
  std::vector<ArithmeticEncoder> streams;  // of the layers
  std::vector<std::size_t> active;         // layers that are needed
  std::array<LayeredPoint, k_layered_block> points;
};

LayeredEncoder::LayeredEncoder(const LazLayout& layout) : state_(std::make_unique<State>(layout)) {}
LayeredEncoder::LayeredEncoder(LayeredEncoder&&) noexcept = default;
LayeredEncoder& LayeredEncoder::operator=(LayeredEncoder&&) noexcept = default;
LayeredEncoder::~LayeredEncoder() = default;

void LayeredEncoder::State::start(std::span<const std::byte> records) {
  positions.start(records.data());
  active.clear();
  for (std::size_t i = 0; i < layers.size(); ++i) {
    if (!layers[i]->needed(records, record_size)) continue;
    layers[i]->start(records.data(), point14::channel(records.data()));
    active.push_back(i);
  }
}

void LayeredEncoder::State::encode_block(const std::byte* records, std::size_t count) {
  const std::span<LayeredPoint> block(points.data(), count);
  positions.encode(position_stream, block, records, record_size);
  for (const std::size_t i : active)
    layers[i]->encode(streams[i], {.points = block, .records = records, .record_size = record_size});
}

std::vector<std::byte> LayeredEncoder::encode(std::span<const std::byte> records) {
  State& state = *state_;
  const std::size_t size = state.record_size;
  const std::size_t count = records.size() / size;
  assert(count > 0 && records.size() % size == 0);
  state.start(records);
  for (std::size_t point = 1; point < count; point += k_layered_block)
    state.encode_block(records.data() + point * size, std::min(k_layered_block, count - point));

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
