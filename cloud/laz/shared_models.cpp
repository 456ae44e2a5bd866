// SPDX-License-Identifier: MIT
#include "cloud/laz/shared_models.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

#include "base/bytes.h"

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
  if (k <= k_modelled_bits) {
    encoder.symbol(model, number);
    return;
  }
  const unsigned raw_bits = k - k_modelled_bits;
  encoder.symbol(model, number >> raw_bits);
  encoder.raw(static_cast<int>(raw_bits), number & ((1u << raw_bits) - 1));
}

GpsTimeModel::GpsTimeModel(Unchanged unchanged)
    : unchanged_(unchanged),
      without_difference_(5 + static_cast<int>(unchanged)),
      with_difference_(515 + static_cast<int>(unchanged)) {}

void GpsTimeModel::start(std::int64_t first) {
  without_difference_.reset();
  with_difference_.reset();
  integers_.reset();
  sequences_.fill({});
  sequences_[0].time = first;
  current_ = newest_ = 0;
}

unsigned GpsTimeModel::symbol_of(std::int32_t change, std::int32_t difference) {
  // Single precision, as in all writers: other quotients would decode to the same times, but their bytes
  // would differ.
  const float quotient = std::round(static_cast<float>(change) / static_cast<float>(difference));
  const int factor = static_cast<int>(std::clamp(quotient, -10.0f, 500.0f));
  return static_cast<unsigned>(factor >= 0 ? factor : 500 - factor);
}

namespace {

using Bytes = std::array<int, 6>;  // red low, red high, green low, ...

constexpr unsigned k_not_grey = 1 << 6;  // the bits below it are those of bytes that differ

Bytes bytes_of(const std::byte* color) {
  Bytes bytes;
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = std::to_integer<int>(color[i]);
  return bytes;
}

// Predictions of the low (half 0) or high (1) byte of green and blue, given those before them.
int predicted_green(const Bytes& previous, const Bytes& color, std::size_t half) {
  return std::clamp(previous[2 + half] + color[half] - previous[half], 0, 255);
}
int predicted_blue(const Bytes& previous, const Bytes& color, std::size_t half) {
  const int change = color[half] - previous[half] + color[2 + half] - previous[2 + half];
  return std::clamp(previous[4 + half] + change / 2, 0, 255);
}

// Offsets of the fields in the record, in bytes.
constexpr std::size_t k_offset = 1;         // u64
constexpr std::size_t k_packet_size = 9;    // u32
constexpr std::size_t k_return_point = 13;  // f32
constexpr std::size_t k_direction = 17;     // 3 f32

enum Move : unsigned { unchanged, by_packet_size, by_difference, anywhere };

std::uint64_t widened(std::int32_t difference) {
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(difference));
}

}  // namespace

void ColorModels::reset() {
  used_.reset();
  for (SymbolModel& model : bytes_) model.reset();
}

template <class Coder>
bool ColorModels::code(Coder& coder, std::byte* color, const std::byte* record) {
  const Bytes previous = bytes_of(color);
  Bytes next = bytes_of(Coder::k_decodes ? color : record);
  unsigned used = 0;
  if constexpr (!Coder::k_decodes) {
    for (std::size_t i = 0; i < next.size(); ++i) used |= (next[i] != previous[i] ? 1u : 0u) << i;
    const bool grey = next[0] == next[2] && next[0] == next[4] && next[1] == next[3] && next[1] == next[5];
    if (!grey) used |= k_not_grey;
  }
  used = coder.symbol(used_, used);
  const auto differs = [&](std::size_t byte) { return (used >> byte & 1) != 0; };
  const auto code_change = [&](std::size_t byte, int prediction) {
    const unsigned change = static_cast<unsigned>(next[byte] - prediction) & 255;
    next[byte] = (prediction + static_cast<int>(coder.symbol(bytes_[byte], change))) & 255;
  };
  for (std::size_t half = 0; half < 2; ++half)
    if (differs(half)) code_change(half, previous[half]);
  if ((used & k_not_grey) == 0) {
    next = {next[0], next[1], next[0], next[1], next[0], next[1]};
  } else {
    for (std::size_t half = 0; half < 2; ++half) {
      if (differs(2 + half)) code_change(2 + half, predicted_green(previous, next, half));
      if (differs(4 + half)) code_change(4 + half, predicted_blue(previous, next, half));
    }
  }
  for (std::size_t i = 0; i < next.size(); ++i) color[i] = static_cast<std::byte>(next[i]);
  return used != 0;
}

template bool ColorModels::code(ArithmeticDecoder&, std::byte*, const std::byte*);
template bool ColorModels::code(ArithmeticEncoder&, std::byte*, const std::byte*);

void WavePacketModels::reset() {
  descriptor_index_.reset();
  moves_.reset();
  offset_.reset();
  size_.reset();
  return_point_.reset();
  direction_.reset();
  last_move_ = 0;
  last_difference_ = 0;
}

template <class Coder>
void WavePacketModels::code(Coder& coder, std::byte* last, const std::byte* packet) {
  last[0] = static_cast<std::byte>(
      code_byte(coder, descriptor_index_, Coder::template value<std::uint8_t>(packet)));
  std::uint64_t offset = load<std::uint64_t>(last + k_offset);
  const std::uint64_t next_offset = Coder::template value<std::uint64_t>(packet + k_offset);
  const std::uint64_t wide = next_offset - offset;
  const std::int32_t difference = static_cast<std::int32_t>(wide);
  const std::uint32_t last_size = load<std::uint32_t>(last + k_packet_size);
  const Move move = widened(difference) != wide ? Move::anywhere
                    : difference == 0           ? Move::unchanged
                    : wide == last_size         ? Move::by_packet_size
                                                : Move::by_difference;
  last_move_ = coder.symbol(moves_[last_move_], move);
  if (last_move_ == Move::by_packet_size) offset += last_size;
  if (last_move_ == Move::by_difference) {
    last_difference_ = coder.integer(offset_, last_difference_, difference);
    offset += widened(last_difference_);
  }
  if (last_move_ == Move::anywhere) offset = coder.raw64(next_offset);
  store(last + k_offset, offset);
  const auto code_integer = [&](std::size_t at, IntegerCompressor& compressor, int context) {
    const std::int32_t next = Coder::template value<std::int32_t>(packet + at);
    store(last + at, coder.integer(compressor, load<std::int32_t>(last + at), next, context));
  };
  code_integer(k_packet_size, size_, 0);
  code_integer(k_return_point, return_point_, 0);
  for (int axis = 0; axis < 3; ++axis)
    code_integer(k_direction + 4 * static_cast<std::size_t>(axis), direction_, axis);
}

template void WavePacketModels::code(ArithmeticDecoder&, std::byte*, const std::byte*);
template void WavePacketModels::code(ArithmeticEncoder&, std::byte*, const std::byte*);

}  // namespace alidade
