// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/bytes.h"
#include "cloud/laz/entropy_coder.h"

namespace alidade {

/// Codes integers of LAZ streams as differences to a prediction: first the number k of bits the difference
/// needs, by a model of the caller's context, then the difference by a model of k, whose upper eight bits are
/// modelled and whose lower bits are raw.
class IntegerCompressor {
 public:
  /// Requires 1 <= bits <= 32, contexts >= 1. All models are fresh. Memory: up to 40 KB.
  IntegerCompressor(int bits, int contexts);

  /// The next value: with 32 bits any value, with fewer one of 0 to 2^bits - 1. The prediction may be any
  /// number; sums wrap at 2^bits. Requires 0 <= context < contexts.
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

  /// All models are fresh again.
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

  // Most of these models are never used in a chunk: each is made fresh on first use.
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
  std::uint64_t stale_ = 0;  // bit k: the model of k has to be made fresh
  BitModel zero_or_one_;
  std::vector<SymbolModel> length_models_;      // by context
  std::vector<SymbolModel> difference_models_;  // of k = 1, 2 ...
};

// The rules of an attribute stand once, as a template on one of these two coders: both take a value and
// return it, but the decoder leaves what it is given unused and returns what the stream says.

class LayerDecoding {
 public:
  static constexpr bool k_decodes = true;

  explicit LayerDecoding(ArithmeticDecoder& decoder) : decoder_(decoder) {}

  /// For models that decode by themselves.
  ArithmeticDecoder& stream() { return decoder_; }

  unsigned symbol(SymbolModel& model, unsigned) { return decoder_.symbol(model); }
  std::int32_t integer(IntegerCompressor& compressor, std::int32_t prediction, std::int32_t,
                       int context = 0) {
    return compressor.decode(decoder_, prediction, context);
  }
  std::uint32_t raw32(std::uint32_t) { return decoder_.raw(32); }
  std::uint64_t raw64(std::uint64_t) { return decoder_.raw64(); }

  /// The value in a record: not known before it is decoded.
  template <class T>
  static T value(const std::byte*) {
    return T{};
  }
  template <class T>
  static void put(std::byte* at, const T& value) {
    store(at, value);
  }

 private:
  ArithmeticDecoder& decoder_;
};

class LayerEncoding {
 public:
  static constexpr bool k_decodes = false;

  explicit LayerEncoding(ArithmeticEncoder& encoder) : encoder_(encoder) {}

  ArithmeticEncoder& stream() { return encoder_; }

  unsigned symbol(SymbolModel& model, unsigned value) {
    encoder_.symbol(model, value);
    return value;
  }
  std::int32_t integer(IntegerCompressor& compressor, std::int32_t prediction, std::int32_t value,
                       int context = 0) {
    compressor.encode(encoder_, prediction, value, context);
    return value;
  }
  std::uint32_t raw32(std::uint32_t value) {
    encoder_.raw(32, value);
    return value;
  }
  std::uint64_t raw64(std::uint64_t value) {
    encoder_.raw64(value);
    return value;
  }

  template <class T>
  static T value(const std::byte* at) {
    return load<T>(at);
  }
  /// Records are not changed by encoding them.
  template <class T>
  static void put(const std::byte*, const T&) {}

 private:
  ArithmeticEncoder& encoder_;
};

/// A byte that is one symbol.
template <class Coder>
std::uint8_t code_byte(Coder& coder, SymbolModel& model, std::uint8_t value) {
  return static_cast<std::uint8_t>(coder.symbol(model, value));
}

/// a + b and a - b modulo 2^32, as coordinates of LAZ wrap.
constexpr std::int32_t wrapped_sum(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) + static_cast<std::uint32_t>(b));
}
constexpr std::int32_t wrapped_difference(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b));
}

}  // namespace alidade
