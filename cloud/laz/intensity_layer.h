// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include "cloud/laz/channel_states.h"
#include "cloud/laz/integer_compressor.h"
#include "cloud/laz/layer.h"
#include "cloud/laz/point14_fields.h"

namespace alidade {

/// Intensity of POINT14: predicted by the last point of the channel that was like it first or last return and
/// like it had a new time or not.
class IntensityLayer final : public LayerOfPoints<IntensityLayer> {
 public:
  IntensityLayer() : LayerOfPoints({"intensity", point14::k_intensity, 2}) {}

  void start(const std::byte* first_record, unsigned channel) override {
    channels_.start(channel, load<std::uint16_t>(first_record + point14::k_intensity));
  }

  template <class Coder, class Byte>
  void code(Coder& coder, const LayeredPoint& point, Byte* field) {
    Channel& channel = channels_.select(point);
    std::uint16_t& last = channel.by_return[2u * point.return_end + point.has(LayeredPoint::k_gps_time)];
    last = static_cast<std::uint16_t>(
        coder.integer(channel.intensity, last, coder.template value<std::uint16_t>(field), point.return_end));
    channel.last = last;
    coder.put(field, last);
  }

 private:
  struct Channel {
    void open(std::uint16_t value) {
      intensity.reset();
      by_return.fill(value);
      last = value;
    }
    std::uint16_t last_value() const { return last; }

    IntegerCompressor intensity{16, 4};
    std::array<std::uint16_t, 8> by_return{};
    std::uint16_t last = 0;
  };

  ChannelStates<Channel> channels_;
};

}  // namespace alidade
