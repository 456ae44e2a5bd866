// SPDX-License-Identifier: MIT
#include "cloud/laz/wave_packet_models.h"

#include "base/bytes.h"

namespace alidade {
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
