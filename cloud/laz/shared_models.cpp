// SPDX-License-Identifier: MIT
#include "cloud/laz/shared_models.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/bytes.h"

namespace alidade {

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
  // Single precision, as in all writers: another quotient would decode to the same times but give other
  // bytes.
  const float quotient = std::round(static_cast<float>(change) / static_cast<float>(difference));
  const int factor = static_cast<int>(std::clamp(quotient, -10.0f, 500.0f));
  return static_cast<unsigned>(factor >= 0 ? factor : 500 - factor);
}

namespace {

using Bytes = std::array<int, 6>;  // red low, red high, green low, ...

constexpr unsigned k_not_grey = 1 << 6;  // the bits below say which bytes differ

Bytes bytes_of(const std::byte* color) {
  Bytes bytes;
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = std::to_integer<int>(color[i]);
  return bytes;
}

bool differs(unsigned used, std::size_t byte) {
  return (used >> byte & 1) != 0;
}

// What the low (half 0) or high (1) byte of green and blue probably are, given those before them.
int predicted_green(const Bytes& previous, const Bytes& color, std::size_t half) {
  return std::clamp(previous[2 + half] + color[half] - previous[half], 0, 255);
}
int predicted_blue(const Bytes& previous, const Bytes& color, std::size_t half) {
  const int change = color[half] - previous[half] + color[2 + half] - previous[2 + half];
  return std::clamp(previous[4 + half] + change / 2, 0, 255);
}

}  // namespace

ColorModels::ColorModels() : used_(128) {
  for (int i = 0; i < 6; ++i) bytes_.emplace_back(256);
}

void ColorModels::reset() {
  used_.reset();
  for (SymbolModel& model : bytes_) model.reset();
}

void ColorModels::decode(ArithmeticDecoder& decoder, std::byte* color) {
  const Bytes previous = bytes_of(color);
  Bytes next = previous;
  const unsigned used = decoder.symbol(used_);
  const auto read = [&](std::size_t byte, int prediction) {
    next[byte] = (prediction + static_cast<int>(decoder.symbol(bytes_[byte]))) & 255;
  };
  for (std::size_t half = 0; half < 2; ++half)
    if (differs(used, half)) read(half, previous[half]);
  if ((used & k_not_grey) != 0) {
    for (std::size_t half = 0; half < 2; ++half) {
      if (differs(used, 2 + half)) read(2 + half, predicted_green(previous, next, half));
      if (differs(used, 4 + half)) read(4 + half, predicted_blue(previous, next, half));
    }
  } else {
    next = {next[0], next[1], next[0], next[1], next[0], next[1]};
  }
  for (std::size_t i = 0; i < next.size(); ++i) color[i] = static_cast<std::byte>(next[i]);
}

bool ColorModels::encode(ArithmeticEncoder& encoder, const std::byte* previous_color,
                         const std::byte* color) {
  const Bytes previous = bytes_of(previous_color);
  const Bytes next = bytes_of(color);
  unsigned used = 0;
  for (std::size_t i = 0; i < next.size(); ++i) used |= (next[i] != previous[i] ? 1u : 0u) << i;
  const bool grey = next[0] == next[2] && next[0] == next[4] && next[1] == next[3] && next[1] == next[5];
  if (!grey) used |= k_not_grey;
  encoder.symbol(used_, used);
  const auto write = [&](std::size_t byte, int prediction) {
    encoder.symbol(bytes_[byte], static_cast<unsigned>(next[byte] - prediction) & 255);
  };
  for (std::size_t half = 0; half < 2; ++half)
    if (differs(used, half)) write(half, previous[half]);
  if (!grey) {
    for (std::size_t half = 0; half < 2; ++half) {
      if (differs(used, 2 + half)) write(2 + half, predicted_green(previous, next, half));
      if (differs(used, 4 + half)) write(4 + half, predicted_blue(previous, next, half));
    }
  }
  return used != 0;
}

namespace {

// Where the fields stand in the record, in bytes.
constexpr std::size_t k_place = 1;          // u64
constexpr std::size_t k_packet_size = 9;    // u32
constexpr std::size_t k_return_point = 13;  // f32
constexpr std::size_t k_direction = 17;     // 3 f32

enum Move : unsigned {
  unchanged = 0,
  by_packet_size = 1,
  by_difference = 2,
  anywhere = 3,
};

std::uint64_t widened(std::int32_t difference) {
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(difference));
}

}  // namespace

WavePacketModels::WavePacketModels()
    : descriptor_index_(256), place_(32, 1), size_(32, 1), return_point_(32, 1), direction_(32, 3) {
  for (int i = 0; i < 4; ++i) moves_.emplace_back(4);
}

void WavePacketModels::reset() {
  descriptor_index_.reset();
  for (SymbolModel& model : moves_) model.reset();
  place_.reset();
  size_.reset();
  return_point_.reset();
  direction_.reset();
  last_move_ = 0;
  last_difference_ = 0;
}

void WavePacketModels::decode(ArithmeticDecoder& decoder, std::byte* packet) {
  packet[0] = static_cast<std::byte>(decoder.symbol(descriptor_index_));
  std::uint64_t place = load<std::uint64_t>(packet + k_place);
  last_move_ = decoder.symbol(moves_[last_move_]);
  switch (last_move_) {
    case Move::unchanged:
      break;
    case Move::by_packet_size:
      place += load<std::uint32_t>(packet + k_packet_size);
      break;
    case Move::by_difference:
      last_difference_ = place_.decode(decoder, last_difference_);
      place += widened(last_difference_);
      break;
    default:
      place = decoder.raw64();
  }
  store(packet + k_place, place);
  const auto read = [&](std::size_t at, IntegerCompressor& compressor, int context) {
    store(packet + at, compressor.decode(decoder, load<std::int32_t>(packet + at), context));
  };
  read(k_packet_size, size_, 0);
  read(k_return_point, return_point_, 0);
  for (int axis = 0; axis < 3; ++axis)
    read(k_direction + 4 * static_cast<std::size_t>(axis), direction_, axis);
}

void WavePacketModels::encode(ArithmeticEncoder& encoder, const std::byte* previous,
                              const std::byte* packet) {
  encoder.symbol(descriptor_index_, std::to_integer<unsigned>(packet[0]));
  const std::uint64_t place = load<std::uint64_t>(packet + k_place);
  const std::uint64_t wide = place - load<std::uint64_t>(previous + k_place);
  const std::int32_t difference = static_cast<std::int32_t>(wide);
  Move move = Move::by_difference;
  if (widened(difference) != wide) {
    move = Move::anywhere;
  } else if (difference == 0) {
    move = Move::unchanged;
  } else if (wide == load<std::uint32_t>(previous + k_packet_size)) {
    move = Move::by_packet_size;
  }
  encoder.symbol(moves_[last_move_], move);
  last_move_ = move;
  if (move == Move::by_difference) {
    place_.encode(encoder, last_difference_, difference);
    last_difference_ = difference;
  } else if (move == Move::anywhere) {
    encoder.raw64(place);
  }
  const auto write = [&](std::size_t at, IntegerCompressor& compressor, int context) {
    compressor.encode(encoder, load<std::int32_t>(previous + at), load<std::int32_t>(packet + at), context);
  };
  write(k_packet_size, size_, 0);
  write(k_return_point, return_point_, 0);
  for (int axis = 0; axis < 3; ++axis)
    write(k_direction + 4 * static_cast<std::size_t>(axis), direction_, axis);
}

}  // namespace alidade
