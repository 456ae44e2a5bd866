// SPDX-License-Identifier: MIT
#include "cloud/laz/entropy_coder.h"

#include <utility>

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

SymbolModel::SymbolModel(int symbols)
    // Enough starts for find() that its loop rarely runs more than once.
    : shift_(k_precision - std::min(8u, static_cast<std::uint32_t>(std::bit_width(symbols - 1u)) + 1)),
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

void SymbolModelSet::prepare(Slot& slot) {
  if (slot.model == nullptr) {
    slot.model = std::make_unique<SymbolModel>(symbols_);
  } else {
    slot.model->reset();
  }
  slot.generation = generation_;
}

void ArithmeticEncoder::carry() {
  // The numbers written so far are less than 1, so there is a byte that takes the carry.
  std::size_t at = bytes_.size() - 1;
  for (; bytes_[at] == std::byte{0xff}; --at) bytes_[at] = std::byte{0};
  bytes_[at] = static_cast<std::byte>(std::to_integer<unsigned>(bytes_[at]) + 1);
}

std::vector<std::byte> ArithmeticEncoder::finish() {
  // A number of the interval that needs few bytes; the zeros behind it make a decoder, which reads four bytes
  // ahead, end exactly at the end.
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

}  // namespace alidade
