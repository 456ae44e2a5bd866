// SPDX-License-Identifier: MIT
#pragma once

#include <cassert>
#include <cstdint>
#include <memory>

namespace alidade {

/// Adaptive probabilities of n symbols 0 to n - 1 in LAZ streams (shared by arithmetic_decoder.h and
/// arithmetic_encoder.h): symbols are counted, and from time to time, first often, then seldom, the counts
/// become new probabilities. Memory, about 5 bytes per symbol, is taken by the constructor only.
class SymbolModel {
 public:
  static constexpr int k_precision = 15;  ///< bits of probabilities

  /// Requires 2 <= symbols <= 2048. The model is fresh.
  explicit SymbolModel(int symbols);

  /// Forgets all symbols: each is as probable as any other, but for rounding.
  void reset();

  unsigned last_symbol() const { return last_symbol_; }

  /// Probability of all symbols less than this one, in units of 2^-15. What remains above that of the last
  /// symbol is its own; there is no entry behind it.
  std::uint32_t cumulative(unsigned symbol) const {
    assert(symbol <= last_symbol_);
    return cumulative_[symbol];
  }

  /// A symbol and the part of the coder's interval that is its own.
  struct Interval {
    unsigned symbol;
    std::uint32_t begin;  ///< included
    std::uint64_t end;    ///< excluded; of the last symbol something above all values
  };

  /// The symbol that `value` belongs to in an interval where each unit of probability is `unit` long.
  /// `guess`: at most value / unit, the nearer the faster. Requires guess < 2^15 and value < 65535 * unit.
  Interval find(std::uint32_t guess, std::uint64_t unit, std::uint32_t value) const {
    assert(guess * unit <= value && guess >> k_precision == 0 &&
           value < cumulative_[last_symbol_ + 1] * unit);
    unsigned symbol = first_symbols_[guess >> shift_];
    std::uint64_t end = cumulative_[symbol + 1] * unit;
    while (end <= value) end = cumulative_[++symbol + 1] * unit;
    return {.symbol = symbol, .begin = static_cast<std::uint32_t>(cumulative_[symbol] * unit), .end = end};
  }

  /// Learns one symbol.
  void count(unsigned symbol) {
    assert(symbol <= last_symbol_);
    ++counts_[symbol];
    if (--left_ == 0) adapt();
  }

  /// Symbols before the next adaptation.
  std::uint32_t left() const { return left_; }

 private:
  void adapt();

  std::unique_ptr<std::uint16_t[]> memory_;  // what the three pointers point into
  std::uint16_t* cumulative_;                // n entries, and one above all values that stops find()
  std::uint16_t* first_symbols_;             // by the upper bits of the guess: where find() starts
  std::uint16_t* counts_;
  std::uint32_t shift_;
  std::uint32_t last_symbol_;
  std::uint32_t sum_;    // of the counts at the last adaptation
  std::uint32_t cycle_;  // symbols from one adaptation to the next
  std::uint32_t left_;
};

}  // namespace alidade
