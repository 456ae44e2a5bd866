// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace alidade {

/// Adaptive probability of a bit in LAZ streams (shared by arithmetic_decoder.h and arithmetic_encoder.h):
/// bits are counted, and from time to time, first often, then seldom, the counts become the new probability.
struct BitModel {
  static constexpr int k_precision = 13;  ///< bits of `probability`

  std::uint32_t zeros, total;  ///< counts, `total` up to the last adaptation only
  std::uint32_t probability;   ///< of a 0 in units of 2^-13, at least 1, less than 2^13
  std::uint32_t cycle;         ///< bits from one adaptation to the next
  std::uint32_t left;          ///< bits before the next adaptation, at least 1

  BitModel() { reset(); }

  /// Forgets all bits: 0 and 1 are equally probable.
  void reset() {
    zeros = 1;
    total = 2;
    probability = 1 << (k_precision - 1);
    cycle = left = 4;
  }

  /// Learns one bit, 0 or 1.
  void count(unsigned bit) {
    zeros += 1 - bit;
    if (--left == 0) adapt();
  }

 private:
  void adapt();
};

}  // namespace alidade
