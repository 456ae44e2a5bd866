// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <numeric>
#include <vector>

namespace alidade::bench {

/// Draws an index with given weights in constant time: Walker's alias method (1977).
class AliasTable {
 public:
  explicit AliasTable(const std::vector<double>& weights) : slots_(weights.size()) {
    const double mean =
        std::accumulate(weights.begin(), weights.end(), 0.0) / static_cast<double>(weights.size());
    std::vector<std::uint32_t> small, large;
    std::vector<double> share(weights.size());
    for (std::uint32_t i = 0; i < weights.size(); ++i) {
      share[i] = weights[i] / mean;
      (share[i] < 1.0 ? small : large).push_back(i);
    }
    for (std::uint32_t i = 0; i < weights.size(); ++i) slots_[i] = {1.0f, i};
    while (!small.empty() && !large.empty()) {
      const std::uint32_t low = small.back(), high = large.back();
      small.pop_back();
      slots_[low] = {static_cast<float>(share[low]), high};
      share[high] -= 1.0 - share[low];
      if (share[high] < 1.0) {
        large.pop_back();
        small.push_back(high);
      }
    }
  }

  std::uint32_t draw(std::uint64_t bits) const {
    const auto slot = static_cast<std::uint32_t>((bits >> 32) * slots_.size() >> 32);
    const float fraction = static_cast<float>(static_cast<std::uint32_t>(bits) >> 8) * 0x1p-24f;
    return fraction < slots_[slot].share ? slot : slots_[slot].other;
  }

 private:
  struct Slot {
    float share;
    std::uint32_t other;
  };
  std::vector<Slot> slots_;
};

}  // namespace alidade::bench
