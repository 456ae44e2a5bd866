// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <memory>

#include "cloud/laz/layered_point.h"

namespace alidade {

/// What a layer of RGB14, RGBNIR14, WAVEPACKET14 or BYTE14 has learnt, separately for each scanner channel:
/// models (with `reset()`) and the last value. Items of version 3 have two historical faults that all files
/// share and that are kept here: a point whose channel is that of the point before counts as one of channel
/// 0, and where a channel is met again its models are right but the value predicted from is that of the
/// channel before. Version 4 is free of both. Memory for a channel is taken when a chunk first has it.
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
  /// What the value is predicted from; whoever decodes or encodes it puts the new one here.
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

}  // namespace alidade
