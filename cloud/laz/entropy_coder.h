// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/bytes.h"

namespace alidade {

/// Adaptive probability of a bit in LAZ streams, for decoder and encoder alike: bits are counted, and at
/// growing intervals the counts become the new probability.
struct BitModel {
  static constexpr int k_precision = 13;  ///< bits of `probability`

  std::uint32_t zeros, total;  ///< counts; `total` is that of the last adaptation
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

/// Adaptive probabilities of n symbols 0 to n - 1 in LAZ streams, for decoder and encoder alike: symbols are
/// counted, and at growing intervals the counts become new probabilities. Memory: about 5 bytes per symbol,
/// taken by the constructor only.
class SymbolModel {
 public:
  static constexpr int k_precision = 15;  ///< bits of probabilities

  /// Requires 2 <= symbols <= 2048. The model begins as after reset().
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
  /// `guess` is a lower bound of value / unit; close bounds are faster. Requires guess < 2^15 and
  /// value < 65535 * unit.
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

/// One SymbolModel per context. Files use few contexts: each model is made on first use, and kept.
class SymbolModelSet {
 public:
  /// Requires what SymbolModel requires of `symbols`.
  SymbolModelSet(std::size_t contexts, int symbols) : symbols_(symbols), slots_(contexts) {}

  /// The model of a context. Requires context < contexts.
  SymbolModel& operator[](std::size_t context) {
    Slot& slot = slots_[context];
    if (slot.generation != generation_) [[unlikely]]
      prepare(slot);
    return *slot.model;
  }

  /// Resets all models.
  void reset() { ++generation_; }

 private:
  struct Slot {
    std::unique_ptr<SymbolModel> model;
    std::uint64_t generation = 0;  // in which the model was last reset
  };

  void prepare(Slot& slot);

  int symbols_;
  std::uint64_t generation_ = 1;
  std::vector<Slot> slots_;
};

/// Reads one stream of LAZ's arithmetic coder: numbers in an interval of 32 bits, which is narrowed by the
/// probability of each symbol and widened by a byte whenever it falls below 2^24.
///
/// Takes any bytes. Behind the end it reads zeros; after that, or after a value that no encoder writes,
/// failed() returns true. Callers test it once per point; every value lies in its range all the same. Cost:
/// constant for bits and raw values; for symbols see SymbolModel. The bytes must outlive the decoder.
///
/// The rules of an attribute are written once, as a template on this class or ArithmeticEncoder: both take a
/// value and return it, but the decoder ignores its argument and returns the value of the stream.
///
/// Source: A. Said, "Introduction to Arithmetic Coding: Theory and Practice", HP Labs report HPL-2004-76.
class ArithmeticDecoder {
 public:
  static constexpr bool k_decodes = true;
  static constexpr std::uint32_t k_least_length = 1u << 24;
  static constexpr int k_widest_raw = 19;  ///< wider values are written in two parts

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
  unsigned symbol(SymbolModel& model, unsigned = 0) {
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
  std::uint32_t raw(int width, std::uint32_t = 0) {
    assert(width >= 1 && width <= 32);
    if (width <= k_widest_raw) return narrow_raw(width);
    const std::uint32_t low = narrow_raw(16);
    return narrow_raw(width - 16) << 16 | low;
  }

  /// The next 64 bits without model.
  std::uint64_t raw64(std::uint64_t = 0) {
    const std::uint64_t low = raw(32);
    return static_cast<std::uint64_t>(raw(32)) << 32 | low;
  }

  /// The next value of an IntegerCompressor.
  template <class Compressor>
  std::int32_t integer(Compressor& compressor, std::int32_t prediction, std::int32_t, int context = 0) {
    return compressor.decode(*this, prediction, context);
  }

  /// The value in a record; a placeholder, as it is unknown before it is decoded.
  template <class T>
  static T value(const std::byte*) {
    return T{};
  }
  template <class T>
  static void put(std::byte* at, const T& value) {
    store(at, value);
  }

  /// Whether something was read from behind the end, or a value that no encoder writes. Stays true.
  bool failed() const { return failed_; }

  /// Marks the stream as failed: the caller has found a value that no encoder writes.
  void fail() { failed_ = true; }

  /// Bytes read so far. When the last value of a stream is read, this is exactly the stream's length.
  std::size_t consumed() const { return static_cast<std::size_t>(next_ - begin_); }

 private:
  // For lengths of 2^31 and more, by their upper bits: 2^47 divided by the length, or slightly less, so that
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

/// Writes one stream of LAZ's arithmetic coder, byte for byte as other writers do; the inverse of
/// ArithmeticDecoder, with the same models. The whole stream stays in memory, as a carry may run back through
/// any number of bytes.
class ArithmeticEncoder {
 public:
  static constexpr bool k_decodes = false;

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
  unsigned symbol(SymbolModel& model, unsigned symbol) {
    const std::uint32_t unit = length_ >> SymbolModel::k_precision;
    const std::uint32_t low = model.cumulative(symbol) * unit;
    const std::uint32_t high = symbol == model.last_symbol() ? length_ : model.cumulative(symbol + 1) * unit;
    add(low);
    length_ = high - low;
    renormalise();
    model.count(symbol);
    return symbol;
  }

  /// Requires 1 <= width <= 32 and value < 2^width.
  std::uint32_t raw(int width, std::uint32_t value) {
    assert(width >= 1 && width <= 32 && (width == 32 || value >> width == 0));
    if (width <= ArithmeticDecoder::k_widest_raw) return narrow_raw(width, value);
    narrow_raw(16, value & 0xffff);
    narrow_raw(width - 16, value >> 16);
    return value;
  }
  std::uint64_t raw64(std::uint64_t value) {
    raw(32, static_cast<std::uint32_t>(value));
    raw(32, static_cast<std::uint32_t>(value >> 32));
    return value;
  }
  template <class Compressor>
  std::int32_t integer(Compressor& compressor, std::int32_t prediction, std::int32_t value, int context = 0) {
    compressor.encode(*this, prediction, value, context);
    return value;
  }

  template <class T>
  static T value(const std::byte* at) {
    return load<T>(at);
  }

  /// Does nothing: encoding does not change records.
  template <class T>
  static void put(const std::byte*, const T&) {}
  /// The complete stream; the encoder can then be used for another one. An empty stream is 01 00 00 00.
  std::vector<std::byte> finish();

 private:
  static constexpr std::uint32_t k_least_length = ArithmeticDecoder::k_least_length;

  std::uint32_t narrow_raw(int width, std::uint32_t value) {
    length_ >>= width;
    add(value * length_);
    renormalise();
    return value;
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
