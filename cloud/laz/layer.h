// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/bytes.h"
#include "cloud/laz/entropy_coder.h"
#include "cloud/laz/laz_layout.h"
#include "cloud/laz/shared_models.h"

/// Byte offsets of the fields of the item POINT14, with which all records of formats 6-10 begin.
namespace alidade::point14 {

inline constexpr std::size_t k_x = 0;
inline constexpr std::size_t k_y = 4;
inline constexpr std::size_t k_z = 8;
inline constexpr std::size_t k_intensity = 12;
inline constexpr std::size_t k_returns = 14;  ///< return number in bits 0-3, number of returns in bits 4-7
inline constexpr std::size_t k_flags = 15;    ///< bits 0-3, 6 and 7; scanner channel in bits 4-5
inline constexpr std::size_t k_classification = 16;
inline constexpr std::size_t k_user_data = 17;
inline constexpr std::size_t k_scan_angle = 18;
inline constexpr std::size_t k_point_source = 20;
inline constexpr std::size_t k_gps_time = 22;
inline constexpr std::size_t k_size = 30;

inline constexpr unsigned k_channel_bits = 0x30;  ///< of the byte of flags

inline unsigned channel(const std::byte* record) {
  return (load<std::uint8_t>(record + k_flags) & k_channel_bits) >> 4;
}

inline void put_channel(std::byte* record, unsigned channel) {
  const unsigned flags = load<std::uint8_t>(record + k_flags) & ~k_channel_bits;
  store(record + k_flags, static_cast<std::uint8_t>(flags | channel << 4));
}

}  // namespace alidade::point14

namespace alidade {

/// Bytes of the items RGB14 and of what RGBNIR14 adds.
inline constexpr std::size_t k_color_size = 6, k_near_infrared_size = 2;

/// What the other layers of a layered LAZ chunk use of a point's first layer, that of returns and positions.
struct LayeredPoint {
  enum Change : std::uint8_t {
    k_number_of_returns = 4,
    k_scan_angle = 8,
    k_gps_time = 16,
    k_point_source = 32,
    k_channel = 64  ///< the scanner channel is not that of the point before
  };

  std::uint8_t channel;     ///< scanner channel, 0 to 3
  std::uint8_t changes;     ///< Change bits, against the last point of the channel; bits 0-1: return number
  std::uint8_t z_context;   ///< how many bits x and y differed by
  std::uint8_t level;       ///< distance of the return from the last one, at most 7
  std::uint8_t return_end;  ///< 2 if it is the first return, plus 1 if it is the last

  bool has(Change change) const { return (changes & change) != 0; }
};

/// The state of a layer of POINT14, separately for each of the four scanner channels. A channel is opened by
/// its first point and inherits the last value of the channel before. State has `open(value)`, which resets
/// it to a first value, and the value `last`. Memory for a channel is taken by the first chunk that has it.
template <class State>
class ChannelStates {
 public:
  /// Begins a chunk whose first point has this channel and value.
  template <class Value>
  void start(unsigned channel, const Value& value) {
    opened_ = 0;
    open(channel, value);
    current_ = states_[channel].get();
    channel_ = channel;
  }

  /// The state for a point, whose channel the first layer has decoded.
  State& select(const LayeredPoint& point) {
    if (point.has(LayeredPoint::k_channel)) [[unlikely]]
      change(point.channel);
    return *current_;
  }

  /// Makes another channel current and opens it if no point had it.
  void change(unsigned channel) {
    if (!opened(channel)) open(channel, current_->last);
    current_ = states_[channel].get();
    channel_ = channel;
  }

  bool opened(unsigned channel) const { return (opened_ >> channel & 1) != 0; }
  unsigned channel() const { return channel_; }
  State& current() { return *current_; }
  /// Requires opened(channel).
  const State& of(unsigned channel) const { return *states_[channel]; }

 private:
  template <class Value>
  void open(unsigned channel, const Value& value) {
    opened_ |= 1u << channel;
    if (!states_[channel]) states_[channel] = std::make_unique<State>();
    states_[channel]->open(value);
  }

  std::array<std::unique_ptr<State>, 4> states_;
  State* current_ = nullptr;
  unsigned channel_ = 0;
  unsigned opened_ = 0;  // bit c: channel c
};

/// The state of a layer of RGB14, RGBNIR14, WAVEPACKET14 or BYTE14, separately for each scanner channel:
/// models (with `reset()`) and the last value. Items of version 3 have two historical faults that all files
/// share and that are kept here: a point whose channel is that of the point before counts as one of channel
/// 0, and where a channel is met again its models are right but the value predicted from is that of the
/// channel before. Version 4 is free of both. Memory for a channel is taken by the first chunk that has it.
template <class Models, class Value>
class ItemChannels {
 public:
  /// Requires version 2 to 4; 2 is decoded as 3.
  explicit ItemChannels(int version) : by_channel_(version >= 4) {}

  /// Begins a chunk whose first point has this channel and value.
  void start(unsigned channel, const Value& value) {
    opened_ = 0;
    open(channel);
    values_[channel] = value;
    selected_ = channel;
  }

  /// Makes models() and last_value() those for a point.
  void select(const LayeredPoint& point) {
    const unsigned channel = by_channel_ || point.has(LayeredPoint::k_channel) ? point.channel : 0u;
    last_value_ = &values_[selected_];
    if (channel != selected_) [[unlikely]]
      change(channel);
  }

  Models& models() { return *models_[selected_]; }
  /// The value that predicts the next one. The caller writes each decoded or encoded value here.
  Value& last_value() { return *last_value_; }

 private:
  void change(unsigned channel) {
    selected_ = channel;
    const bool opens = (opened_ >> channel & 1) == 0;
    if (opens) {
      open(channel);
      values_[channel] = *last_value_;
    }
    if (opens || by_channel_) last_value_ = &values_[channel];
  }

  void open(unsigned channel) {
    opened_ |= 1u << channel;
    if (models_[channel])
      models_[channel]->reset();
    else
      models_[channel] = std::make_unique<Models>();
  }

  bool by_channel_;
  std::array<std::unique_ptr<Models>, 4> models_;
  std::array<Value, 4> values_{};
  Value* last_value_ = nullptr;
  unsigned selected_ = 0;
  unsigned opened_ = 0;  // bit c: channel c
};

/// Neighbouring points of a chunk and their records; Byte is const for encoding.
template <class Byte>
struct LayerBlock {
  std::span<const LayeredPoint> points;
  Byte* records;  ///< that of the first of the points
  std::size_t record_size;
};

/// One attribute of the points of a layered LAZ chunk, which is a stream of its own. A layer passes through a
/// chunk block by block, all points but the first, and is then reused for the next chunk.
class Layer {
 public:
  /// Part of the record that holds the attribute, and the attribute's name in messages.
  struct Field {
    const char* name;
    std::size_t offset, size;  ///< bytes
  };

  explicit Layer(const Field& field) : field_(field) {}
  Layer(const Layer&) = delete;
  Layer& operator=(const Layer&) = delete;
  virtual ~Layer() = default;

  const char* name() const { return field_.name; }

  /// Begins a chunk with its first record, which is stored as it is; `channel` is its scanner channel.
  virtual void start(const std::byte* first_record, unsigned channel) = 0;

  /// Writes the attribute into the records. Errors: reported by ArithmeticDecoder::failed().
  virtual void decode(ArithmeticDecoder& decoder, const LayerBlock<std::byte>& block) = 0;

  virtual void encode(ArithmeticEncoder& encoder, const LayerBlock<const std::byte>& block) = 0;

  /// Whether the records need this layer: without it all of them have the value of the first.
  virtual bool needed(std::span<const std::byte> records, std::size_t record_size) const;

 protected:
  const Field& field() const { return field_; }

 private:
  Field field_;
};

/// A layer whose rules for one point are the member of Derived
/// `template <class Coder, class Byte> void code(Coder&, const LayeredPoint&, Byte* field)`.
template <class Derived>
class LayerOfPoints : public Layer {
 public:
  using Layer::Layer;

  void decode(ArithmeticDecoder& decoder, const LayerBlock<std::byte>& block) final {
    // A copy that nothing else points to stays in registers.
    ArithmeticDecoder local = decoder;
    code_all(local, block);
    decoder = local;
  }

  void encode(ArithmeticEncoder& encoder, const LayerBlock<const std::byte>& block) final {
    code_all(encoder, block);
  }

 private:
  template <class Coder, class Byte>
  void code_all(Coder& coder, const LayerBlock<Byte>& block) {
    Byte* at = block.records + field().offset;
    for (const LayeredPoint& point : block.points) {
      static_cast<Derived&>(*this).code(coder, point, at);
      at += block.record_size;
    }
  }
};

/// All layers of a chunk but the first, PositionLayer, in their order; null where a layer is not wanted.
/// Errors: as count_layers().
std::vector<std::unique_ptr<Layer>> make_layers(const LazLayout& layout, const LazLayers& wanted);

}  // namespace alidade
