// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "cloud/laz/channel_states.h"
#include "cloud/laz/integer_compressor.h"
#include "cloud/laz/layer.h"
#include "cloud/laz/point14_fields.h"
#include "cloud/laz/shared_models.h"

// Layers of POINT14 that hold a value only for points where the first layer says it has changed; all others
// have the last one of their channel.

namespace alidade {

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

}  // namespace alidade
