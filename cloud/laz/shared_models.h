// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include "cloud/laz/integer_compressor.h"
#include "cloud/laz/symbol_model.h"
#include "cloud/laz/value_coders.h"

namespace alidade {

/// Codes GPS times of LAZ points, version 2 and later: times are the bits of doubles, taken as integers, and
/// belong to one of four sequences, in each of which a time is predicted by a multiple of the last
/// difference.
class GpsTimeModel {
 public:
  enum class Unchanged : unsigned {
    never_coded = 0,  ///< POINT14: the first layer says whether a time changes
    has_code = 1      ///< GPSTIME11
  };

  explicit GpsTimeModel(Unchanged unchanged);

  /// All models are fresh; the time before the next is `first`.
  void start(std::int64_t first);

  /// The next time, with a coder of layer_coders.h. A time that changes the sequence as often as there are
  /// sequences makes the stream a failed one, like any value that no encoder writes.
  template <class Coder>
  std::int64_t code(Coder& coder, std::int64_t time) {
    if constexpr (Coder::k_decodes) {
      for (int changes = 1; !decode_step(coder); ++changes) {
        if (changes == k_sequences) {
          coder.stream().fail();
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
    int extremes = 0;             // times in a row that were no near multiple of it
  };

  // What follows the symbol that says by which multiple of the difference the time has changed.
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
  // The symbol for times that differ so much.
  static unsigned symbol_of(std::int32_t change, std::int32_t difference);

  static constexpr unsigned k_multiples = 511;

  Sequence& current() { return sequences_[current_]; }
  unsigned unchanged() const { return static_cast<unsigned>(unchanged_); }

  // Both return false if another sequence has become current, from which the time is still to be coded.
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
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(time) -
                                     static_cast<std::uint64_t>(sequences_[sequence].time));
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
  sequence.time = static_cast<std::int64_t>(static_cast<std::uint64_t>(sequence.time) +
                                            static_cast<std::uint64_t>(std::int64_t{sequence.difference}));
  sequence.extremes = 0;
}

template <class Coder>
void GpsTimeModel::code_multiple(Coder& coder, unsigned symbol, std::int32_t change) {
  Sequence& sequence = current();
  const Multiple rule = multiple(symbol);
  const std::int32_t prediction = static_cast<std::int32_t>(static_cast<std::uint32_t>(rule.factor) *
                                                            static_cast<std::uint32_t>(sequence.difference));
  const std::int32_t coded = coder.integer(integers_, prediction, change, rule.context);
  sequence.time = static_cast<std::int64_t>(static_cast<std::uint64_t>(sequence.time) +
                                            static_cast<std::uint64_t>(std::int64_t{coded}));
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
  const std::uint32_t low = coder.raw32(static_cast<std::uint32_t>(time));
  current_ = newest_;
  current() = {.time = static_cast<std::int64_t>(
                   static_cast<std::uint64_t>(static_cast<std::uint32_t>(high)) << 32 | low)};
}

}  // namespace alidade
