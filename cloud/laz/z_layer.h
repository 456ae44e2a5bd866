// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include "cloud/laz/channel_states.h"
#include "cloud/laz/integer_compressor.h"
#include "cloud/laz/layer.h"
#include "cloud/laz/point14_fields.h"

namespace alidade {

/// z of POINT14: predicted by the last point of the channel that was as far from the last return.
class ZLayer final : public LayerOfPoints<ZLayer> {
 public:
  ZLayer() : LayerOfPoints({"z", point14::k_z, 4}) {}

  void start(const std::byte* first_record, unsigned channel) override {
    channels_.start(channel, load<std::int32_t>(first_record + point14::k_z));
  }

  /// Written even where z never changes, as other writers do.
  bool needed(std::span<const std::byte>, std::size_t) const override { return true; }

  template <class Coder, class Byte>
  void code(Coder& coder, const LayeredPoint& point, Byte* field) {
    Channel& channel = channels_.select(point);
    std::int32_t& last = channel.by_level[point.level];
    last = coder.integer(channel.dz, last, coder.template value<std::int32_t>(field), point.z_context);
    channel.last = last;
    coder.put(field, last);
  }

 private:
  struct Channel {
    void open(std::int32_t value) {
      dz.reset();
      by_level.fill(value);
      last = value;
    }
    std::int32_t last_value() const { return last; }

    IntegerCompressor dz{32, 20};
    std::array<std::int32_t, 8> by_level{};
    std::int32_t last = 0;
  };

  ChannelStates<Channel> channels_;
};

}  // namespace alidade
