// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "cloud/laz/entropy_coder.h"

namespace alidade {

/// Codes integers of LAZ streams as differences to a prediction: first the number k of bits the difference
/// needs, by a model of the caller's context, then the difference by a model of k, whose upper eight bits are
/// modelled and whose lower bits are raw.
class IntegerCompressor {
 public:
  /// Requires 1 <= bits <= 32, contexts >= 1. Begins as after reset(). Memory: up to 40 KB.
  IntegerCompressor(int bits, int contexts);

  /// The next value: any with 32 bits, otherwise 0 to 2^bits - 1. The prediction can be any number; sums wrap
  /// at 2^bits. Requires 0 <= context < contexts.
  std::int32_t decode(ArithmeticDecoder& decoder, std::int32_t prediction, int context = 0) {
    const unsigned k = decoder.symbol(length_models_[static_cast<std::size_t>(context)]);
    last_k_ = static_cast<int>(k);
    const std::uint32_t sum =
        static_cast<std::uint32_t>(prediction) + static_cast<std::uint32_t>(decode_difference(decoder, k));
    return static_cast<std::int32_t>(sum & mask_);
  }

  /// Writes the lower `bits` bits of a value.
  void encode(ArithmeticEncoder& encoder, std::int32_t prediction, std::int32_t value, int context = 0);

  /// The k of the last value decoded or encoded, 0 to bits.
  int last_k() const { return last_k_; }

  /// Resets all models.
  void reset();

 private:
  static constexpr unsigned k_modelled_bits = 8;

  // Differences of k bits are -(2^k - 1) to -2^(k-1) and 2^(k-1) + 1 to 2^k; k = 0 has 0 and 1.
  std::int32_t decode_difference(ArithmeticDecoder& decoder, unsigned k) {
    if (k == 0) return static_cast<std::int32_t>(decoder.bit(zero_or_one_));
    if (k == 32) return INT32_MIN;
    SymbolModel& model = difference_model(k);
    std::uint32_t number = decoder.symbol(model);
    if (k > k_modelled_bits) {
      const unsigned raw_bits = k - k_modelled_bits;
      number = number << raw_bits | decoder.raw(static_cast<int>(raw_bits));
    }
    number += number >> (k - 1) != 0 ? 1 : 1 - (1u << k);
    return static_cast<std::int32_t>(number);
  }

  // Most of these models are never used in a chunk: each is reset on first use.
  SymbolModel& difference_model(unsigned k) {
    SymbolModel& model = difference_models_[k - 1];
    if ((stale_ >> k & 1) != 0) {
      stale_ &= ~(std::uint64_t{1} << k);
      model.reset();
    }
    return model;
  }

  int bits_;
  std::uint32_t mask_;
  int last_k_ = 0;
  std::uint64_t stale_ = 0;  // bit k: the model of k has to be reset
  BitModel zero_or_one_;
  std::vector<SymbolModel> length_models_;      // by context
  std::vector<SymbolModel> difference_models_;  // of k = 1, 2 ...
};

/// A byte that is one symbol.
template <class Coder>
std::uint8_t code_byte(Coder& coder, SymbolModel& model, std::uint8_t value) {
  return static_cast<std::uint8_t>(coder.symbol(model, value));
}

/// a + b and a - b modulo 2^32 or 2^64, as coordinates and times of LAZ wrap.
template <class Whole>
constexpr Whole wrapped_sum(Whole a, Whole b) {
  using Unsigned = std::make_unsigned_t<Whole>;
  return static_cast<Whole>(static_cast<Unsigned>(a) + static_cast<Unsigned>(b));
}
template <class Whole>
constexpr Whole wrapped_difference(Whole a, Whole b) {
  using Unsigned = std::make_unsigned_t<Whole>;
  return static_cast<Whole>(static_cast<Unsigned>(a) - static_cast<Unsigned>(b));
}

/// The context for a number of bits: two neighbours share one, and so do all from `most` on.
constexpr int bits_context(int bits, int most) {
  return bits < most ? bits & ~1 : most;
}

/// Predicts coordinate differences of LAZ points by about the median of the last five: a new difference
/// replaces the largest of the five until one is not below the median, then the smallest until one is not
/// above it, and so on.
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

/// Codes GPS times of LAZ points, version 2 and later: times are the bits of doubles as integers, and belong
/// to one of four sequences. In each sequence a multiple of the last difference predicts the next time.
class GpsTimeModel {
 public:
  enum class Unchanged : unsigned {
    never_coded = 0,  ///< POINT14: the first layer has whether a time changes
    has_code = 1      ///< GPSTIME11
  };

  explicit GpsTimeModel(Unchanged unchanged);

  /// Resets all models; the time before the next one is `first`.
  void start(std::int64_t first);

  /// The next time. A time that changes the sequence as often as there are sequences marks the stream as
  /// failed, as any value that no encoder writes does.
  template <class Coder>
  std::int64_t code(Coder& coder, std::int64_t time) {
    if constexpr (Coder::k_decodes) {
      for (int changes = 1; !decode_step(coder); ++changes) {
        if (changes == k_sequences) {
          coder.fail();
          break;
        }
      }
    } else {
      while (!encode_step(coder, time)) {
      }
    }
    return current().time;
  }

 private:
  static constexpr int k_sequences = 4;

  struct Sequence {
    std::int64_t time = 0;
    std::int32_t difference = 0;  // of the last two times; 0 if only one is known
    int extremes = 0;             // times in a row that were not near multiples of it
  };

  // How a symbol for a multiple of the difference is coded.
  struct Multiple {
    std::int32_t factor;
    int context;
    bool extreme;  // many in a row replace the difference
  };
  static Multiple multiple(unsigned symbol) {
    const std::int32_t factor = static_cast<std::int32_t>(symbol);
    if (symbol == 1) return {.factor = 1, .context = 1, .extreme = false};
    if (symbol == 0) return {.factor = 0, .context = 7, .extreme = true};
    if (symbol < 10) return {.factor = factor, .context = 2, .extreme = false};
    if (symbol < 500) return {.factor = factor, .context = 3, .extreme = false};
    if (symbol == 500) return {.factor = 500, .context = 4, .extreme = true};
    if (symbol < 510) return {.factor = 500 - factor, .context = 5, .extreme = false};
    return {.factor = -10, .context = 6, .extreme = true};
  }
  // The symbol for a change of the time, given the last difference.
  static unsigned symbol_of(std::int32_t change, std::int32_t difference);

  static constexpr unsigned k_multiples = 511;

  Sequence& current() { return sequences_[current_]; }
  unsigned unchanged() const { return static_cast<unsigned>(unchanged_); }

  // Both return false if they only made another sequence current, in which the time is still to be coded.
  template <class Coder>
  bool decode_step(Coder& coder);
  template <class Coder>
  bool encode_step(Coder& coder, std::int64_t time);

  template <class Coder>
  void code_first_difference(Coder& coder, std::int32_t change);
  template <class Coder>
  void code_multiple(Coder& coder, unsigned symbol, std::int32_t change);
  template <class Coder>
  void code_new_sequence(Coder& coder, std::int64_t time);

  Unchanged unchanged_;
  SymbolModel without_difference_;
  SymbolModel with_difference_;
  IntegerCompressor integers_{32, 9};
  std::array<Sequence, k_sequences> sequences_{};
  unsigned current_ = 0;
  unsigned newest_ = 0;
};

// Symbols before the first difference of a sequence: [unchanged,] difference, new sequence, next sequence but
// 0, 1, 2. Symbols after it: multiples, [unchanged,] new sequence, next sequence but 0, 1, 2.

template <class Coder>
bool GpsTimeModel::decode_step(Coder& coder) {
  unsigned jump;  // 0: new sequence
  if (current().difference == 0) {
    const unsigned symbol = coder.symbol(without_difference_, 0);
    if (symbol < unchanged()) return true;
    if (symbol == unchanged()) {
      code_first_difference(coder, 0);
      return true;
    }
    jump = symbol - unchanged() - 1;
  } else {
    const unsigned symbol = coder.symbol(with_difference_, 0);
    if (symbol < k_multiples) {
      code_multiple(coder, symbol, 0);
      return true;
    }
    if (symbol < k_multiples + unchanged()) return true;
    jump = symbol - k_multiples - unchanged();
  }
  if (jump == 0) {
    code_new_sequence(coder, 0);
    return true;
  }
  current_ = (current_ + jump) % k_sequences;
  return false;
}

template <class Coder>
bool GpsTimeModel::encode_step(Coder& coder, std::int64_t time) {
  const auto change_in = [&](unsigned sequence) {
    return wrapped_difference(time, sequences_[sequence].time);
  };
  const auto fits = [](std::int64_t change) { return change >= INT32_MIN && change <= INT32_MAX; };
  const bool first = current().difference == 0;
  SymbolModel& model = first ? without_difference_ : with_difference_;
  const std::int64_t change = change_in(current_);
  if (change == 0 && unchanged() != 0) {
    coder.symbol(model, first ? 0 : k_multiples);
    return true;
  }
  if (fits(change)) {
    const std::int32_t narrow = static_cast<std::int32_t>(change);
    const unsigned symbol = first ? unchanged() : symbol_of(narrow, current().difference);
    coder.symbol(model, symbol);
    if (first)
      code_first_difference(coder, narrow);
    else
      code_multiple(coder, symbol, narrow);
    return true;
  }
  const unsigned new_sequence = (first ? 1 : k_multiples) + unchanged();
  for (unsigned jump = 1; jump < k_sequences; ++jump) {
    const unsigned other = (current_ + jump) % k_sequences;
    if (!fits(change_in(other))) continue;
    coder.symbol(model, new_sequence + jump);
    current_ = other;
    return false;
  }
  coder.symbol(model, new_sequence);
  code_new_sequence(coder, time);
  return true;
}

template <class Coder>
void GpsTimeModel::code_first_difference(Coder& coder, std::int32_t change) {
  Sequence& sequence = current();
  sequence.difference = coder.integer(integers_, 0, change, 0);
  sequence.time = wrapped_sum<std::int64_t>(sequence.time, sequence.difference);
  sequence.extremes = 0;
}

template <class Coder>
void GpsTimeModel::code_multiple(Coder& coder, unsigned symbol, std::int32_t change) {
  Sequence& sequence = current();
  const Multiple rule = multiple(symbol);
  const std::int32_t prediction = static_cast<std::int32_t>(static_cast<std::uint32_t>(rule.factor) *
                                                            static_cast<std::uint32_t>(sequence.difference));
  const std::int32_t coded = coder.integer(integers_, prediction, change, rule.context);
  sequence.time = wrapped_sum<std::int64_t>(sequence.time, coded);
  if (symbol == 1) {
    sequence.extremes = 0;
  } else if (rule.extreme && ++sequence.extremes > 3) {
    sequence.difference = coded;
    sequence.extremes = 0;
  }
}

template <class Coder>
void GpsTimeModel::code_new_sequence(Coder& coder, std::int64_t time) {
  const std::int32_t last_high = static_cast<std::int32_t>(current().time >> 32);
  newest_ = (newest_ + 1) % k_sequences;
  const std::int32_t high = coder.integer(integers_, last_high, static_cast<std::int32_t>(time >> 32), 8);
  const std::uint32_t low = coder.raw(32, static_cast<std::uint32_t>(time));
  current_ = newest_;
  current() = {.time = static_cast<std::int64_t>(
                   static_cast<std::uint64_t>(static_cast<std::uint32_t>(high)) << 32 | low)};
}

/// Codes colours of LAZ streams, version 2 of the old and all versions of the new formats: which of the six
/// bytes differ from the previous colour's, then these bytes; green and blue are expected to change as red
/// did. A colour is the six bytes of a point data record: red, green, blue as u16.
class ColorModels {
 public:
  /// Resets all models.
  void reset();

  /// Replaces the previous colour `color` by the next one, which the encoder reads from `record`. Returns
  /// false if its code could be left out: no byte differs, and the colour is grey. Does not allocate.
  template <class Coder>
  bool code(Coder& coder, std::byte* color, const std::byte* record);

 private:
  SymbolModel used_{128};
  std::array<SymbolModel, 6> bytes_{SymbolModel(256), SymbolModel(256), SymbolModel(256),
                                    SymbolModel(256), SymbolModel(256), SymbolModel(256)};
};

/// Codes wave packets of LAZ streams, in the old and the new formats alike: descriptor index, offset of the
/// waveform, which often follows the previous one, its size, and four floats as the integers of their bits.
/// A wave packet is the 29 bytes of a point data record.
class WavePacketModels {
 public:
  static constexpr std::size_t k_size = 29;

  /// Resets all models.
  void reset();

  /// Replaces the last wave packet by the next one, which the encoder reads from `packet`. The decoder does
  /// not read it, but requires k_size bytes there, too. The first use of a context allocates its models.
  template <class Coder>
  void code(Coder& coder, std::byte* last, const std::byte* packet);

 private:
  SymbolModel descriptor_index_{256};
  SymbolModelSet moves_{4, 4};  // by the last move: how the offset changes
  IntegerCompressor offset_{32, 1};
  IntegerCompressor size_{32, 1};
  IntegerCompressor return_point_{32, 1};
  IntegerCompressor direction_{32, 3};  // context: x, y, z
  unsigned last_move_ = 0;
  std::int32_t last_difference_ = 0;  // of offsets, when it was last written
};

}  // namespace alidade
