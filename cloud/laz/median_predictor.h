// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

namespace alidade {

/// Predicts coordinate differences of LAZ points by the median of the last five, roughly: a new difference
/// replaces the largest or the smallest of the five, by turns, until one falls into the other half.
class MedianPredictor {
 public:
  std::int32_t median() const { return values_[2]; }

  void insert(std::int32_t value) {
    const std::int32_t old_median = values_[2];
    if (replaces_largest_) {
      int at = 4;
      for (; at > 0 && values_[at - 1] > value; --at) values_[at] = values_[at - 1];
      values_[at] = value;
      if (value >= old_median) replaces_largest_ = false;
    } else {
      int at = 0;
      for (; at < 4 && values_[at + 1] < value; ++at) values_[at] = values_[at + 1];
      values_[at] = value;
      if (value <= old_median) replaces_largest_ = true;
    }
  }

  /// In ascending order.
  const std::array<std::int32_t, 5>& values() const { return values_; }
  bool replaces_largest() const { return replaces_largest_; }

 private:
  std::array<std::int32_t, 5> values_{};
  bool replaces_largest_ = true;
};

}  // namespace alidade
