// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>

#include "cloud/laz/bit_model.h"
#include "cloud/laz/symbol_model.h"

namespace alidade {

/// Reads one stream of LAZ's arithmetic coder: numbers in an interval of 32 bits, which is narrowed by the
/// probability of each symbol and widened by a byte whenever it falls below 2^24.
///
/// Takes any bytes. Behind the end it reads zeros; that, and values no encoder writes, are remembered in
/// failed(), which callers ask once per point. Every value it returns lies in its range all the same.
/// Cost: constant for bits and raw values; symbols() see SymbolModel. The bytes must outlive the decoder.
///
/// Source: A. Said, "Introduction to Arithmetic Coding: Theory and Practice", HP Labs report HPL-2004-76.
class ArithmeticDecoder {
 public:
  static constexpr std::uint32_t k_least_length = 1u << 24;

  /// A decoder of nothing: it has failed.
  ArithmeticDecoder() = default;

  /// Reads the first four bytes at once. The stream may end before `bytes` does: see consumed().
  explicit ArithmeticDecoder(std::span<const std::byte> bytes)
      : begin_(bytes.data()),
        next_(begin_),
        end_(begin_ + bytes.size()),
        length_(UINT32_MAX),
        failed_(false) {
    for (int i = 0; i < 4; ++i) value_ = value_ << 8 | next_byte();
    if (value_ == length_) {
      failed_ = true;
      value_ = 0;
    }
  }

  /// The next bit, 0 or 1, which the model learns.
  unsigned bit(BitModel& model) {
    const std::uint32_t split = model.probability * (length_ >> BitModel::k_precision);
    const unsigned bit = value_ >= split;
    if (bit != 0) {
      value_ -= split;
      length_ -= split;
    } else {
      length_ = split;
    }
    renormalise();
    model.count(bit);
    return bit;
  }

  /// The next symbol, less than the number of symbols of the model, which learns it.
  unsigned symbol(SymbolModel& model) {
    const std::uint32_t unit = length_ >> SymbolModel::k_precision;
    // The quotient of value_ and unit, rounded down: a division would take half of the time of a symbol.
    const int shift = std::countl_zero(length_);
    const std::uint64_t reciprocal = k_reciprocals[(length_ << shift) >> k_reciprocal_shift];
    const SymbolModel::Interval found =
        model.find(static_cast<std::uint32_t>((value_ << shift) * reciprocal >> 32), unit, value_);
    const unsigned symbol = found.symbol;
    value_ -= found.begin;
    // The last symbol owns the rest of the interval that `unit` rounds away.
    length_ = static_cast<std::uint32_t>(std::min<std::uint64_t>(found.end, length_)) - found.begin;
    renormalise();
    model.count(symbol);
    return symbol;
  }

  /// The next `width` bits without model, 1 to 32.
  std::uint32_t raw(int width) {
    assert(width >= 1 && width <= 32);
    if (width <= k_widest_raw) return narrow_raw(width);
    const std::uint32_t low = narrow_raw(16);
    return narrow_raw(width - 16) << 16 | low;
  }

  /// The next 64 bits without model.
  std::uint64_t raw64() {
    const std::uint64_t low = raw(32);
    return static_cast<std::uint64_t>(raw(32)) << 32 | low;
  }

  /// Whether anything was read from behind the end or was no value that an encoder writes. Stays true.
  bool failed() const { return failed_; }

  /// Remembers that a value was impossible for reasons the caller knows.
  void fail() { failed_ = true; }

  /// Bytes read so far. When the last value of a stream is read, this is exactly the stream's length.
  std::size_t consumed() const { return static_cast<std::size_t>(next_ - begin_); }

 private:
  static constexpr int k_widest_raw = 19;  // more bits are written in two parts

  // Of lengths from 2^31 on, by their upper bits: 2^47 divided by the length or a little less, so that
  // value * reciprocal / 2^32 is at most value * 2^15 / length.
  static constexpr int k_reciprocal_shift = 22;
  static constexpr std::array<std::uint32_t, 1 << (32 - k_reciprocal_shift)> k_reciprocals = [] {
    std::array<std::uint32_t, 1 << (32 - k_reciprocal_shift)> reciprocals{};
    for (std::uint64_t i = reciprocals.size() / 2; i < reciprocals.size(); ++i)
      reciprocals[i] = static_cast<std::uint32_t>((std::uint64_t{1} << 47) / ((i + 1) << k_reciprocal_shift));
    return reciprocals;
  }();

  std::uint32_t narrow_raw(int width) {
    length_ >>= width;
    std::uint32_t value = value_ / length_;
    value_ -= value * length_;
    if (value >> width != 0) {
      failed_ = true;
      value = 0;
    }
    renormalise();
    return value;
  }

  std::uint32_t next_byte() {
    if (next_ == end_) {
      failed_ = true;
      return 0;
    }
    return std::to_integer<std::uint32_t>(*next_++);
  }

  // value_ < length_ holds from the start and after every step, whatever the bytes are: SymbolModel::find()
  // needs it.
  void renormalise() {
    while (length_ < k_least_length) {
      value_ = value_ << 8 | next_byte();
      length_ <<= 8;
    }
  }

  const std::byte* begin_ = nullptr;
  const std::byte* next_ = nullptr;
  const std::byte* end_ = nullptr;
  std::uint32_t value_ = 0;
  std::uint32_t length_ = UINT32_MAX;
  bool failed_ = true;
};

}  // namespace alidade
