// SPDX-License-Identifier: MIT
#include "cloud/laz/layer.h"

#include <cassert>
#include <cstring>

#include "cloud/laz/layered_codec.h"

namespace alidade {

bool Layer::needed(std::span<const std::byte> records, std::size_t record_size) const {
  const std::byte* const first = records.data() + field_.offset;
  for (std::size_t at = record_size; at < records.size(); at += record_size)
    if (std::memcmp(first, first + at, field_.size) != 0) return true;
  return false;
}

namespace {

/// A layer of POINT14. Channel is its state of a scanner channel: beside what ChannelStates requires, it has
/// the field of the record, and `code(coder, point, value)`, which returns a point's value in the record.
template <class Channel>
class PointLayer : public LayerOfPoints<PointLayer<Channel>> {
  using Value = typename Channel::Value;

 public:
  PointLayer() : LayerOfPoints<PointLayer<Channel>>(Channel::k_field) {}

  void start(const std::byte* first_record, unsigned channel) override {
    channels_.start(channel, load<Value>(first_record + Channel::k_field.offset));
  }

  template <class Coder, class Byte>
  void code(Coder& coder, const LayeredPoint& point, Byte* field) {
    coder.put(field, channels_.select(point).code(coder, point, coder.template value<Value>(field)));
  }

 private:
  ChannelStates<Channel> channels_;
};

/// Values that are predicted by the last point of the same kind in the channel. Rules defines which points
/// have a code (the others have the last value of their channel), which of eight kinds a point is, and which
/// of its contexts codes the difference.
template <class Rules>
struct PredictedChannel : Rules {
  using Value = typename Rules::Value;

  void open(Value value) {
    differences.reset();
    by_kind.fill(value);
    last = value;
  }
  template <class Coder>
  [[gnu::always_inline]] Value code(Coder& coder, const LayeredPoint& point, Value value) {
    if (!Rules::has_code(point)) return last;
    Value& before = by_kind[Rules::kind(point)];
    before = static_cast<Value>(coder.integer(differences, before, value, Rules::context(point)));
    return last = before;
  }

  IntegerCompressor differences{8 * sizeof(Value), Rules::k_contexts};
  std::array<Value, 8> by_kind{};
  Value last = 0;
};

struct ZRules {
  using Value = std::int32_t;
  static constexpr Layer::Field k_field = {"z", point14::k_z, sizeof(Value)};
  static constexpr int k_contexts = 20;
  static bool has_code(const LayeredPoint&) { return true; }
  static unsigned kind(const LayeredPoint& point) { return point.level; }
  static int context(const LayeredPoint& point) { return point.z_context; }
};

/// Written also where z never changes, as other writers do.
class ZLayer final : public PointLayer<PredictedChannel<ZRules>> {
  bool needed(std::span<const std::byte>, std::size_t) const override { return true; }
};

/// Points are alike that are both first or last returns or neither, and both have a new time or not.
struct IntensityRules {
  using Value = std::uint16_t;
  static constexpr Layer::Field k_field = {"intensity", point14::k_intensity, sizeof(Value)};
  static constexpr int k_contexts = 4;
  static bool has_code(const LayeredPoint&) { return true; }
  static unsigned kind(const LayeredPoint& point) {
    return 2u * point.return_end + point.has(LayeredPoint::k_gps_time);
  }
  static int context(const LayeredPoint& point) { return point.return_end; }
};

struct ScanAngleRules {
  using Value = std::int16_t;
  static constexpr Layer::Field k_field = {"scan angle", point14::k_scan_angle, sizeof(Value)};
  static constexpr int k_contexts = 2;
  static bool has_code(const LayeredPoint& point) { return point.has(LayeredPoint::k_scan_angle); }
  static unsigned kind(const LayeredPoint&) { return 0; }
  static int context(const LayeredPoint& point) { return point.has(LayeredPoint::k_gps_time); }
};

struct PointSourceRules {
  using Value = std::uint16_t;
  static constexpr Layer::Field k_field = {"point source", point14::k_point_source, sizeof(Value)};
  static constexpr int k_contexts = 1;
  static bool has_code(const LayeredPoint& point) { return point.has(LayeredPoint::k_point_source); }
  static unsigned kind(const LayeredPoint&) { return 0; }
  static int context(const LayeredPoint&) { return 0; }
};

struct GpsTimeChannel {
  using Value = std::int64_t;  // the bits of a double
  static constexpr Layer::Field k_field = {"GPS time", point14::k_gps_time, sizeof(Value)};

  void open(Value value) {
    model.start(value);
    last = value;
  }
  template <class Coder>
  [[gnu::always_inline]] Value code(Coder& coder, const LayeredPoint& point, Value value) {
    if (point.has(LayeredPoint::k_gps_time)) last = model.code(coder, value);
    return last;
  }

  GpsTimeModel model{GpsTimeModel::Unchanged::never_coded};
  Value last = 0;
};

/// Values of a small set: each is one symbol, whose model the last value of the channel selects. Rules
/// defines the value in the byte of the record, and the model that codes it.
template <class Rules>
struct ByteChannel : Rules {
  using Value = std::uint8_t;  // the byte

  void open(Value byte) {
    models.reset();
    last = byte;
  }
  template <class Coder>
  [[gnu::always_inline]] Value code(Coder& coder, const LayeredPoint& point, Value byte) {
    SymbolModel& model = models[Rules::model(Rules::value(last), point)];
    return last = Rules::byte(coder.symbol(model, Rules::value(byte)), point);
  }

  SymbolModelSet models{64, Rules::k_values};
  Value last = 0;
};

struct WholeByteRules {
  static constexpr int k_values = 256;
  static unsigned value(std::uint8_t byte) { return byte; }
  static std::uint8_t byte(unsigned value, const LayeredPoint&) { return static_cast<std::uint8_t>(value); }
};

struct ClassificationRules : WholeByteRules {
  static constexpr Layer::Field k_field = {"classification", point14::k_classification, 1};
  static unsigned model(unsigned last, const LayeredPoint& point) {
    constexpr std::uint8_t k_only_return = 3;
    return 2 * (last & 31) + (point.return_end == k_only_return);
  }
};

struct UserDataRules : WholeByteRules {
  static constexpr Layer::Field k_field = {"user data", point14::k_user_data, 1};
  static unsigned model(unsigned last, const LayeredPoint&) { return last / 4; }
};

/// Flags share their byte with the scanner channel, which has the bits in the middle.
struct FlagsRules {
  static constexpr Layer::Field k_field = {"flags", point14::k_flags, 1};
  static constexpr int k_values = 64;
  static unsigned value(std::uint8_t byte) { return (byte & 0x0fu) | (byte & 0xc0u) >> 2; }
  static std::uint8_t byte(unsigned value, const LayeredPoint& point) {
    return static_cast<std::uint8_t>((value & 0x0f) | unsigned{point.channel} << 4 | (value & 0x30) << 2);
  }
  static unsigned model(unsigned last, const LayeredPoint&) { return last; }
};

class FlagsLayer final : public PointLayer<ByteChannel<FlagsRules>> {
  bool needed(std::span<const std::byte> records, std::size_t record_size) const override {
    const auto flags_at = [at = records.data() + field().offset](std::size_t record) {
      return FlagsRules::value(load<std::uint8_t>(at + record));
    };
    for (std::size_t record = record_size; record < records.size(); record += record_size)
      if (flags_at(record) != flags_at(0)) return true;
    return false;
  }
};

// Layers of RGB14, RGBNIR14, WAVEPACKET14 and BYTE14.

/// `Models` codes values of `size` bytes, as in the record, by their previous value.
template <class Models, std::size_t size>
class ItemLayer : public LayerOfPoints<ItemLayer<Models, size>> {
 public:
  /// `offset`: of the value in the record. Requires an item version of 2 to 4.
  ItemLayer(const char* name, std::size_t offset, int version)
      : LayerOfPoints<ItemLayer>({name, offset, size}), channels_(version) {}

  void start(const std::byte* first_record, unsigned channel) override {
    channels_.start(channel, load<Value>(first_record + this->field().offset));
  }

  template <class Coder, class Byte>
  void code(Coder& coder, const LayeredPoint& point, Byte* field) {
    channels_.select(point);
    Value& last = channels_.last_value();
    channels_.models().code(coder, last.data(), field);
    coder.put(field, last);
  }

 private:
  using Value = std::array<std::byte, size>;

  ItemChannels<Models, Value> channels_;
};

/// How much a byte differs from the last one, modulo 256; unknown while decoding.
template <class Coder>
unsigned change_of(const std::byte* last, const std::byte* next) {
  return (Coder::template value<std::uint8_t>(next) - std::to_integer<unsigned>(*last)) & 255;
}

struct ExtraByteModels {
  void reset() { changes.reset(); }

  template <class Coder>
  void code(Coder& coder, std::byte* last, const std::byte* next) {
    const unsigned change = coder.symbol(changes, change_of<Coder>(last, next));
    *last = static_cast<std::byte>(std::to_integer<unsigned>(*last) + change);
  }

  SymbolModel changes{256};
};

struct NearInfraredModels {
  void reset() {
    used.reset();
    for (ExtraByteModels& models : bytes) models.reset();
  }

  template <class Coder>
  void code(Coder& coder, std::byte* last, const std::byte* next) {
    const auto bit = [&](unsigned byte) {
      return change_of<Coder>(last + byte, next + byte) != 0 ? 1u << byte : 0u;
    };
    const unsigned changed = coder.symbol(used, bit(0) | bit(1));
    for (std::size_t byte = 0; byte < 2; ++byte)
      if ((changed >> byte & 1) != 0) bytes[byte].code(coder, last + byte, next + byte);
  }

  SymbolModel used{4};
  std::array<ExtraByteModels, 2> bytes;
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

using Layers = std::vector<std::unique_ptr<Layer>>;

template <class L, class... Arguments>
void add(Layers& layers, bool is_wanted, Arguments... arguments) {
  layers.push_back(is_wanted ? std::make_unique<L>(arguments...) : nullptr);
}

/// Adds the layers of an item that begins at this offset of the record.
void add_layers(Layers& layers, const LazItem& item, std::size_t offset, const LazLayers& wanted) {
  switch (item.kind) {
    case LazItemKind::point14:
      add<ZLayer>(layers, wanted.z);
      add<PointLayer<ByteChannel<ClassificationRules>>>(layers, wanted.classification);
      add<FlagsLayer>(layers, wanted.flags);
      add<PointLayer<PredictedChannel<IntensityRules>>>(layers, wanted.intensity);
      add<PointLayer<PredictedChannel<ScanAngleRules>>>(layers, wanted.scan_angle);
      add<PointLayer<ByteChannel<UserDataRules>>>(layers, wanted.user_data);
      add<PointLayer<PredictedChannel<PointSourceRules>>>(layers, wanted.point_source);
      add<PointLayer<GpsTimeChannel>>(layers, wanted.gps_time);
      return;
    case LazItemKind::rgb14:
    case LazItemKind::rgb_nir14:
      add<ColorLayer>(layers, wanted.color, "colour", offset, item.version);
      if (item.kind == LazItemKind::rgb14) return;
      return add<ItemLayer<NearInfraredModels, k_near_infrared_size>>(
          layers, wanted.near_infrared, "near infrared", offset + k_color_size, item.version);
    case LazItemKind::wave_packet14:
      return add<ItemLayer<WavePacketModels, WavePacketModels::k_size>>(layers, wanted.wave_packet,
                                                                        "wave packet", offset, item.version);
    case LazItemKind::byte14:
      for (std::size_t byte = 0; byte < item.size; ++byte)
        add<ItemLayer<ExtraByteModels, 1>>(layers, wanted.extra_bytes, "extra byte", offset + byte,
                                           item.version);
      return;
    default:
      assert(false && "count_layers() rejects other items");
  }
}

}  // namespace

std::vector<std::unique_ptr<Layer>> make_layers(const LazLayout& layout, const LazLayers& wanted) {
  Layers layers;
  layers.reserve(count_layers(layout) - 1);
  std::size_t offset = 0;
  for (const LazItem& item : layout.items) {
    add_layers(layers, item, offset, wanted);
    offset += item.size;
  }
  return layers;
}

}  // namespace alidade
