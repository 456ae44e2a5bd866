// SPDX-License-Identifier: MIT

#include <utility>

#include "cloud/laz/entropy_coder.h"
#include "cloud/laz/value_coders.h"

namespace alidade {

void BitModel::adapt() {
  total += cycle;
  if (total > 1u << k_precision) {
    total = (total + 1) >> 1;
    zeros = (zeros + 1) >> 1;
    if (zeros == total) ++total;
  }
  probability = (zeros * ((1u << 31) / total)) >> (31 - k_precision);
  cycle = std::min((5 * cycle) >> 2, 64u);
  left = cycle;
}

namespace {

/// Bits of the table where find() starts, so that its loop seldom runs more than once.
std::uint32_t start_bits(std::uint32_t symbols) {
  return std::min(8u, static_cast<std::uint32_t>(std::bit_width(symbols - 1)) + 1);
}

}  // namespace

SymbolModel::SymbolModel(int symbols)
    : shift_(k_precision - start_bits(static_cast<std::uint32_t>(symbols))),
      last_symbol_(static_cast<std::uint32_t>(symbols) - 1) {
  assert(symbols >= 2 && symbols <= 2048);
  const std::size_t count = static_cast<std::size_t>(symbols);
  const std::size_t starts = std::size_t{1} << (k_precision - shift_);
  memory_ = std::make_unique<std::uint16_t[]>(count + 1 + starts + count);
  cumulative_ = memory_.get();
  first_symbols_ = cumulative_ + count + 1;
  counts_ = first_symbols_ + starts;
  cumulative_[count] = UINT16_MAX;
  reset();
}

void SymbolModel::reset() {
  const std::uint32_t symbols = last_symbol_ + 1;
  std::fill_n(counts_, symbols, std::uint16_t{1});
  sum_ = 0;
  cycle_ = symbols;
  adapt();
  cycle_ = left_ = (symbols + 6) >> 1;
}

void SymbolModel::adapt() {
  const std::uint32_t symbols = last_symbol_ + 1;
  sum_ += cycle_;
  if (sum_ > 1u << k_precision) {
    sum_ = 0;
    for (std::uint32_t s = 0; s < symbols; ++s) {
      counts_[s] = static_cast<std::uint16_t>((counts_[s] + 1) >> 1);
      sum_ += counts_[s];
    }
  }
  const std::uint32_t scale = (1u << 31) / sum_;
  std::uint32_t below = 0;
  std::uint32_t slot = 0;
  for (std::uint32_t s = 0; s < symbols; ++s) {
    const std::uint32_t cumulative = (scale * below) >> (31 - k_precision);
    cumulative_[s] = static_cast<std::uint16_t>(cumulative);
    below += counts_[s];
    // Slots that begin before this symbol does start with the one below.
    for (; slot << shift_ < cumulative; ++slot) first_symbols_[slot] = static_cast<std::uint16_t>(s - 1);
  }
  for (; slot << shift_ < 1u << k_precision; ++slot)
    first_symbols_[slot] = static_cast<std::uint16_t>(last_symbol_);
  cycle_ = std::min((5 * cycle_) >> 2, (symbols + 6) * 8);
  left_ = cycle_;
}

void SymbolModelSet::prepare(Offset& offset) {
  if (offset.model == nullptr) {
    offset.model = std::make_unique<SymbolModel>(symbols_);
  } else {
    offset.model->reset();
  }
  offset.generation = generation_;
}

void ArithmeticEncoder::carry() {
  // The numbers written so far are less than 1, so there is a byte that takes the carry.
  std::size_t at = bytes_.size() - 1;
  for (; bytes_[at] == std::byte{0xff}; --at) bytes_[at] = std::byte{0};
  bytes_[at] = static_cast<std::byte>(std::to_integer<unsigned>(bytes_[at]) + 1);
}

std::vector<std::byte> ArithmeticEncoder::finish() {
  // Some number of the interval that needs few bytes; with the zeros behind, a decoder, which reads four
  // bytes ahead, ends exactly at the end.
  int zeros = 2;
  if (length_ > 2 * k_least_length) {
    add(k_least_length);
    length_ = k_least_length >> 1;
    zeros = 3;
  } else {
    add(k_least_length >> 1);
    length_ = k_least_length >> 9;
  }
  renormalise();
  bytes_.resize(bytes_.size() + static_cast<std::size_t>(zeros));
  base_ = 0;
  length_ = UINT32_MAX;
  return std::exchange(bytes_, {});
}

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
