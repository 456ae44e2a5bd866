// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "cloud/laz/channel_states.h"
#include "cloud/laz/layer.h"
#include "cloud/laz/point14_fields.h"
#include "cloud/laz/symbol_model_set.h"

// Layers of POINT14 whose values are few: each is one symbol, whose model the last value of the channel
// chooses.

namespace alidade {

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

/// Flags share their byte with the scanner channel, which stands in its middle.
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

}  // namespace alidade
