// SPDX-License-Identifier: MIT
#include "cloud/laz/layer.h"

#include <cassert>
#include <cstring>

#include "cloud/laz/entropy_coder.h"
#include "cloud/laz/layered_codec.h"
#include "cloud/laz/shared_models.h"

namespace alidade {

/// Layers of POINT14 whose values are predicted by the last point of the channel that was of a kind. Rules
/// says which of eight kinds a point is, and which of its contexts codes the difference.
template <class Rules>
class PredictedLayer final : public LayerOfPoints<PredictedLayer<Rules>> {
  using Value = typename Rules::Value;

 public:
  PredictedLayer() : LayerOfPoints<PredictedLayer<Rules>>(Rules::k_field) {}

  void start(const std::byte* first_record, unsigned channel) override {
    channels_.start(channel, load<Value>(first_record + Rules::k_field.offset));
  }

  bool needed(std::span<const std::byte> records, std::size_t record_size) const override {
    return Rules::k_is_always_written || Layer::needed(records, record_size);
  }

  template <class Coder, class Byte>
  void code(Coder& coder, const LayeredPoint& point, Byte* field) {
    Channel& channel = channels_.select(point);
    Value& last = channel.by_kind[Rules::kind(point)];
    last = static_cast<Value>(
        coder.integer(channel.differences, last, coder.template value<Value>(field), Rules::context(point)));
    channel.last = last;
    coder.put(field, last);
  }

 private:
  struct Channel {
    void open(Value value) {
      differences.reset();
      by_kind.fill(value);
      last = value;
    }
    Value last_value() const { return last; }

    IntegerCompressor differences{8 * sizeof(Value), Rules::k_contexts};
    std::array<Value, 8> by_kind{};
    Value last = 0;
  };

  ChannelStates<Channel> channels_;
};

struct ZRules {
  using Value = std::int32_t;
  static constexpr Layer::Field k_field = {"z", point14::k_z, sizeof(Value)};
  static constexpr int k_contexts = 20;
  static constexpr bool k_is_always_written = true;  // also where z never changes, as other writers do
  static unsigned kind(const LayeredPoint& point) { return point.level; }
  static int context(const LayeredPoint& point) { return point.z_context; }
};

/// Points are alike that are both first or last returns or neither, and both have a new time or not.
struct IntensityRules {
  using Value = std::uint16_t;
  static constexpr Layer::Field k_field = {"intensity", point14::k_intensity, sizeof(Value)};
  static constexpr int k_contexts = 4;
  static constexpr bool k_is_always_written = false;
  static unsigned kind(const LayeredPoint& point) {
    return 2u * point.return_end + point.has(LayeredPoint::k_gps_time);
  }
  static int context(const LayeredPoint& point) { return point.return_end; }
};

using ZLayer = PredictedLayer<ZRules>;
using IntensityLayer = PredictedLayer<IntensityRules>;

// Layers of POINT14 whose values are few: each is one symbol, whose model the last value of the channel
// chooses.

/// Rules says what a value is in the byte of the record, and which model codes it.
template <class Rules>
class ByteLayer final : public LayerOfPoints<ByteLayer<Rules>> {
 public:
  ByteLayer() : LayerOfPoints<ByteLayer<Rules>>(Rules::k_field) {}

  void start(const std::byte* first_record, unsigned channel) override {
    channels_.start(channel, Rules::value(load<std::uint8_t>(first_record + Rules::k_field.offset)));
  }

  bool needed(std::span<const std::byte> records, std::size_t record_size) const override {
    const std::byte* at = records.data() + Rules::k_field.offset;
    const unsigned first = Rules::value(load<std::uint8_t>(at));
    for (std::size_t i = 0; i < records.size(); i += record_size)
      if (Rules::value(load<std::uint8_t>(at + i)) != first) return true;
    return false;
  }

  template <class Coder, class Byte>
  void code(Coder& coder, const LayeredPoint& point, Byte* field) {
    Channel& channel = channels_.select(point);
    const unsigned value = Rules::value(coder.template value<std::uint8_t>(field));
    channel.last = coder.symbol(channel.models[Rules::model(channel.last, point)], value);
    coder.put(field, Rules::byte(channel.last, point));
  }

 private:
  struct Channel {
    void open(unsigned value) {
      models.reset();
      last = value;
    }
    unsigned last_value() const { return last; }

    SymbolModelSet models{64, Rules::k_values};
    unsigned last = 0;
  };

  ChannelStates<Channel> channels_;
};

struct ClassificationRules {
  static constexpr Layer::Field k_field = {"classification", point14::k_classification, 1};
  static constexpr int k_values = 256;
  static unsigned value(std::uint8_t byte) { return byte; }
  static std::uint8_t byte(unsigned value, const LayeredPoint&) { return static_cast<std::uint8_t>(value); }
  static unsigned model(unsigned last, const LayeredPoint& point) {
    constexpr std::uint8_t k_only_return = 3;
    return 2 * (last & 31) + (point.return_end == k_only_return);
  }
};

struct UserDataRules {
  static constexpr Layer::Field k_field = {"user data", point14::k_user_data, 1};
  static constexpr int k_values = 256;
  static unsigned value(std::uint8_t byte) { return byte; }
  static std::uint8_t byte(unsigned value, const LayeredPoint&) { return static_cast<std::uint8_t>(value); }
  static unsigned model(unsigned last, const LayeredPoint&) { return last / 4; }
};

/// Flags share their byte with the scanner channel, which is in its middle.
struct FlagsRules {
  static constexpr Layer::Field k_field = {"flags", point14::k_flags, 1};
  static constexpr int k_values = 64;
  static unsigned value(std::uint8_t byte) { return (byte & 0x0fu) | (byte & 0xc0u) >> 2; }
  static std::uint8_t byte(unsigned value, const LayeredPoint& point) {
    return static_cast<std::uint8_t>((value & 0x0f) | unsigned{point.channel} << 4 | (value & 0x30) << 2);
  }
  static unsigned model(unsigned last, const LayeredPoint&) { return last; }
};

using ClassificationLayer = ByteLayer<ClassificationRules>;
using UserDataLayer = ByteLayer<UserDataRules>;
using FlagsLayer = ByteLayer<FlagsRules>;

// Layers of POINT14 that hold a value only for points where the first layer says it has changed; all others
// have the last one of their channel.

/// Rules: the type of the values, the bit that says they change, and `Models` with `code`.
template <class Rules>
class ChangedLayer final : public LayerOfPoints<ChangedLayer<Rules>> {
  using Value = typename Rules::Value;

 public:
  ChangedLayer() : LayerOfPoints<ChangedLayer<Rules>>(Rules::k_field) {}

  void start(const std::byte* first_record, unsigned channel) override {
    channels_.start(channel, load<Value>(first_record + Rules::k_field.offset));
  }

  template <class Coder, class Byte>
  void code(Coder& coder, const LayeredPoint& point, Byte* field) {
    Channel& channel = channels_.select(point);
    if (point.has(Rules::k_change))
      channel.last = channel.models.code(coder, channel.last, coder.template value<Value>(field), point);
    coder.put(field, channel.last);
  }

 private:
  struct Channel {
    void open(Value value) {
      models.reset(value);
      last = value;
    }
    Value last_value() const { return last; }

    typename Rules::Models models;
    Value last{};
  };

  ChannelStates<Channel> channels_;
};

struct ScanAngleRules {
  using Value = std::int16_t;
  static constexpr Layer::Field k_field = {"scan angle", point14::k_scan_angle, sizeof(Value)};
  static constexpr LayeredPoint::Change k_change = LayeredPoint::k_scan_angle;

  struct Models {
    void reset(Value) { compressor.reset(); }
    template <class Coder>
    Value code(Coder& coder, Value last, Value value, const LayeredPoint& point) {
      return static_cast<Value>(coder.integer(compressor, last, value, point.has(LayeredPoint::k_gps_time)));
    }
    IntegerCompressor compressor{16, 2};
  };
};

struct PointSourceRules {
  using Value = std::uint16_t;
  static constexpr Layer::Field k_field = {"point source", point14::k_point_source, sizeof(Value)};
  static constexpr LayeredPoint::Change k_change = LayeredPoint::k_point_source;

  struct Models {
    void reset(Value) { compressor.reset(); }
    template <class Coder>
    Value code(Coder& coder, Value last, Value value, const LayeredPoint&) {
      return static_cast<Value>(coder.integer(compressor, last, value));
    }
    IntegerCompressor compressor{16, 1};
  };
};

struct GpsTimeRules {
  using Value = std::int64_t;  // the bits of a double
  static constexpr Layer::Field k_field = {"GPS time", point14::k_gps_time, sizeof(Value)};
  static constexpr LayeredPoint::Change k_change = LayeredPoint::k_gps_time;

  struct Models {
    void reset(Value first) { model.start(first); }
    template <class Coder>
    Value code(Coder& coder, Value, Value value, const LayeredPoint&) {
      return model.code(coder, value);
    }
    GpsTimeModel model{GpsTimeModel::Unchanged::never_coded};
  };
};

using ScanAngleLayer = ChangedLayer<ScanAngleRules>;
using PointSourceLayer = ChangedLayer<PointSourceRules>;
using GpsTimeLayer = ChangedLayer<GpsTimeRules>;

// Layers of RGB14, RGBNIR14, WAVEPACKET14 and BYTE14.

/// `Models` codes values of `size` bytes, as in the record, by the value before.
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

bool Layer::needed(std::span<const std::byte> records, std::size_t record_size) const {
  const std::byte* const first = records.data() + field_.offset;
  for (std::size_t at = record_size; at < records.size(); at += record_size)
    if (std::memcmp(first, first + at, field_.size) != 0) return true;
  return false;
}

namespace {

class Maker {
 public:
  Maker(const LazLayers& wanted, std::size_t layers) : wanted_(wanted) { layers_.reserve(layers); }

  void add(const LazItem& item) {
    switch (item.kind) {
      case LazItemKind::point14:
        add_point();
        break;
      case LazItemKind::rgb14:
        add<ColorLayer>(wanted_.color, "colour", offset_, item.version);
        break;
      case LazItemKind::rgb_nir14:
        add<ColorLayer>(wanted_.color, "colour", offset_, item.version);
        add<NearInfraredLayer>(wanted_.near_infrared, "near infrared", offset_ + k_color_size, item.version);
        break;
      case LazItemKind::wave_packet14:
        add<WavePacketLayer>(wanted_.wave_packet, "wave packet", offset_, item.version);
        break;
      case LazItemKind::byte14:
        for (std::size_t byte = 0; byte < item.size; ++byte)
          add<ExtraByteLayer>(wanted_.extra_bytes, "extra byte", offset_ + byte, item.version);
        break;
      default:
        assert(false && "count_layers() rejects other items");
    }
    offset_ += item.size;
  }

  std::vector<std::unique_ptr<Layer>> take() { return std::move(layers_); }

 private:
  void add_point() {
    add<ZLayer>(wanted_.z);
    add<ClassificationLayer>(wanted_.classification);
    add<FlagsLayer>(wanted_.flags);
    add<IntensityLayer>(wanted_.intensity);
    add<ScanAngleLayer>(wanted_.scan_angle);
    add<UserDataLayer>(wanted_.user_data);
    add<PointSourceLayer>(wanted_.point_source);
    add<GpsTimeLayer>(wanted_.gps_time);
  }

  template <class L, class... Arguments>
  void add(bool wanted, Arguments... arguments) {
    layers_.push_back(wanted ? std::make_unique<L>(arguments...) : nullptr);
  }

  const LazLayers& wanted_;
  std::size_t offset_ = 0;  // of the item in the record
  std::vector<std::unique_ptr<Layer>> layers_;
};

}  // namespace

std::vector<std::unique_ptr<Layer>> make_layers(const LazLayout& layout, const LazLayers& wanted) {
  Maker maker(wanted, count_layers(layout) - 1);
  for (const LazItem& item : layout.items) maker.add(item);
  return maker.take();
}

}  // namespace alidade
