// SPDX-License-Identifier: MIT
#include "cloud/laz/value_coders.h"

#include <algorithm>
#include <bit>
#include <cassert>

namespace alidade {

IntegerCompressor::IntegerCompressor(int bits, int contexts) : bits_(bits), mask_(UINT32_MAX >> (32 - bits)) {
  assert(bits >= 1 && bits <= 32 && contexts >= 1);
  length_models_.reserve(static_cast<std::size_t>(contexts));
  for (int context = 0; context < contexts; ++context) length_models_.emplace_back(bits + 1);
  for (int k = 1; k <= std::min(bits, 31); ++k)
    difference_models_.emplace_back(1 << std::min(k, static_cast<int>(k_modelled_bits)));
}

void IntegerCompressor::reset() {
  for (SymbolModel& model : length_models_) model.reset();
  zero_or_one_.reset();
  stale_ = ~std::uint64_t{0};
  last_k_ = 0;
}

void IntegerCompressor::encode(ArithmeticEncoder& encoder, std::int32_t prediction, std::int32_t value,
                               int context) {
  const std::uint32_t wrapped = static_cast<std::uint32_t>(value) - static_cast<std::uint32_t>(prediction);
  const int unused_bits = 32 - bits_;
  const std::int32_t difference = static_cast<std::int32_t>(wrapped << unused_bits) >> unused_bits;
  std::uint32_t number = static_cast<std::uint32_t>(difference);
  const unsigned k = static_cast<unsigned>(std::bit_width(difference <= 0 ? 0 - number : number - 1));
  last_k_ = static_cast<int>(k);
  encoder.symbol(length_models_[static_cast<std::size_t>(context)], k);
  if (k == 0) return encoder.bit(zero_or_one_, number);
  if (k == 32) return;
  number = difference < 0 ? number + ((1u << k) - 1) : number - 1;
  SymbolModel& model = difference_model(k);
  if (k <= k_modelled_bits) return encoder.symbol(model, number);
  const unsigned raw_bits = k - k_modelled_bits;
  encoder.symbol(model, number >> raw_bits);
  encoder.raw(static_cast<int>(raw_bits), number & ((1u << raw_bits) - 1));
}

}  // namespace alidade
