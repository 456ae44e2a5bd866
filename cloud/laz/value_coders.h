// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/bytes.h"
#include "cloud/laz/arithmetic_encoder.h"
#include "cloud/laz/entropy_coder.h"
#include "cloud/laz/integer_compressor.h"

// The rules of an attribute stand once, as a template on one of these two coders: both take a value and
// return it, but the decoder leaves what it is given unused and returns what the stream says.

namespace alidade {

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
