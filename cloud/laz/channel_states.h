// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <memory>

#include "cloud/laz/layered_point.h"

namespace alidade {

/// What a layer of POINT14 has learnt, separately for each of the four scanner channels. A channel is opened
/// by its first point and inherits the last value of the channel before. State has `open(value)`, which
/// forgets all but a first value, and `last_value()`. Memory for a channel is taken when a chunk first has
/// it.
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
    if (!opened(channel)) open(channel, current_->last_value());
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

}  // namespace alidade
