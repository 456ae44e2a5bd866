// SPDX-License-Identifier: MIT
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "cloud/laz/bit_model.h"
#include "cloud/laz/symbol_model.h"

namespace alidade {

/// Writes one stream of LAZ's arithmetic coder, byte for byte as other writers do; the inverse of
/// ArithmeticDecoder, with the same models. The whole stream stays in memory, as a carry may run back through
/// any number of bytes.
class ArithmeticEncoder {
 public:
  /// Requires bit to be 0 or 1.
  void bit(BitModel& model, unsigned bit) {
    assert(bit <= 1);
    const std::uint32_t split = model.probability * (length_ >> BitModel::k_precision);
    if (bit != 0) {
      add(split);
      length_ -= split;
    } else {
      length_ = split;
    }
    renormalise();
    model.count(bit);
  }

  /// Requires a symbol of the model.
  void symbol(SymbolModel& model, unsigned symbol) {
    const std::uint32_t unit = length_ >> SymbolModel::k_precision;
    const std::uint32_t low = model.cumulative(symbol) * unit;
    const std::uint32_t high = symbol == model.last_symbol() ? length_ : model.cumulative(symbol + 1) * unit;
    add(low);
    length_ = high - low;
    renormalise();
    model.count(symbol);
  }

  /// Requires 1 <= width <= 32 and value < 2^width.
  void raw(int width, std::uint32_t value) {
    assert(width >= 1 && width <= 32 && (width == 32 || value >> width == 0));
    if (width <= k_widest_raw) return narrow_raw(width, value);
    narrow_raw(16, value & 0xffff);
    narrow_raw(width - 16, value >> 16);
  }

  void raw64(std::uint64_t value) {
    raw(32, static_cast<std::uint32_t>(value));
    raw(32, static_cast<std::uint32_t>(value >> 32));
  }

  /// The stream, complete; the encoder is then new. A stream of nothing is 01 00 00 00.
  std::vector<std::byte> finish();

 private:
  static constexpr int k_widest_raw = 19;  // more bits are written in two parts
  static constexpr std::uint32_t k_least_length = 1u << 24;

  void narrow_raw(int width, std::uint32_t value) {
    length_ >>= width;
    add(value * length_);
    renormalise();
  }

  void add(std::uint32_t amount) {
    base_ += amount;
    if (base_ < amount) carry();
  }

  void renormalise() {
    while (length_ < k_least_length) {
      bytes_.push_back(static_cast<std::byte>(base_ >> 24));
      base_ <<= 8;
      length_ <<= 8;
    }
  }

  void carry();

  std::vector<std::byte> bytes_;
  std::uint32_t base_ = 0;
  std::uint32_t length_ = UINT32_MAX;
};

}  // namespace alidade
