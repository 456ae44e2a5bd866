// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "cloud/laz/color_models.h"
#include "cloud/laz/item_channels.h"
#include "cloud/laz/layer.h"
#include "cloud/laz/wave_packet_models.h"

// Layers of RGB14, RGBNIR14, WAVEPACKET14 and BYTE14.

namespace alidade {

/// `Models` codes values of `size` bytes, as they stand in the record, by the value before.
template <class Models, std::size_t size>
class ItemLayer : public LayerOfPoints<ItemLayer<Models, size>> {
 public:
  /// `offset`: of the value in the record. Requires an item version of 2 to 4.
  ItemLayer(const char* name, std::size_t offset, int version)
      : LayerOfPoints<ItemLayer>({name, offset, size}), channels_(version) {}

  void start(const std::byte* first_record, unsigned channel) override {
    channels_.start(channel, load<Value>(first_record + this->field().offset));
  }

  template <class Byte>
  void code(LayerDecoding& coder, const LayeredPoint& point, Byte* field) {
    channels_.select(point);
    Value& last = channels_.last_value();
    channels_.models().decode(coder.stream(), last.data());
    std::memcpy(field, last.data(), size);
  }

  void code(LayerEncoding& coder, const LayeredPoint& point, const std::byte* field) {
    channels_.select(point);
    Value& last = channels_.last_value();
    channels_.models().encode(coder.stream(), last.data(), field);
    std::memcpy(last.data(), field, size);
  }

 private:
  using Value = std::array<std::byte, size>;

  ItemChannels<Models, Value> channels_;
};

class NearInfraredModels {
 public:
  void reset() {
    used_.reset();
    for (SymbolModel& model : bytes_) model.reset();
  }

  void decode(ArithmeticDecoder& decoder, std::byte* value) {
    const unsigned used = decoder.symbol(used_);
    for (std::size_t byte = 0; byte < 2; ++byte)
      if ((used >> byte & 1) != 0)
        value[byte] =
            static_cast<std::byte>(std::to_integer<unsigned>(value[byte]) + decoder.symbol(bytes_[byte]));
  }

  void encode(ArithmeticEncoder& encoder, const std::byte* previous, const std::byte* value) {
    const auto change = [&](std::size_t byte) {
      return (std::to_integer<unsigned>(value[byte]) - std::to_integer<unsigned>(previous[byte])) & 255;
    };
    encoder.symbol(used_, (change(0) != 0 ? 1u : 0u) | (change(1) != 0 ? 2u : 0u));
    for (std::size_t byte = 0; byte < 2; ++byte)
      if (change(byte) != 0) encoder.symbol(bytes_[byte], change(byte));
  }

 private:
  SymbolModel used_{4};
  std::array<SymbolModel, 2> bytes_{SymbolModel(256), SymbolModel(256)};
};

class ExtraByteModels {
 public:
  void reset() { changes_.reset(); }

  void decode(ArithmeticDecoder& decoder, std::byte* value) {
    *value = static_cast<std::byte>(std::to_integer<unsigned>(*value) + decoder.symbol(changes_));
  }

  void encode(ArithmeticEncoder& encoder, const std::byte* previous, const std::byte* value) {
    encoder.symbol(changes_,
                   (std::to_integer<unsigned>(*value) - std::to_integer<unsigned>(*previous)) & 255);
  }

 private:
  SymbolModel changes_{256};
};

inline constexpr std::size_t k_color_size = 6, k_near_infrared_size = 2;

class ColorLayer final : public ItemLayer<ColorModels, k_color_size> {
 public:
  using ItemLayer::ItemLayer;

  /// Colours that differ from grey are written even where they never change, as other writers do.
  bool needed(std::span<const std::byte> records, std::size_t record_size) const override {
    if (records.size() == record_size) return false;
    const auto color = load<std::array<std::uint16_t, 3>>(records.data() + field().offset);
    return color[0] != color[1] || color[0] != color[2] || ItemLayer::needed(records, record_size);
  }
};

using NearInfraredLayer = ItemLayer<NearInfraredModels, k_near_infrared_size>;
using WavePacketLayer = ItemLayer<WavePacketModels, WavePacketModels::k_size>;
using ExtraByteLayer = ItemLayer<ExtraByteModels, 1>;

}  // namespace alidade
