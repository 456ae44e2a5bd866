// SPDX-License-Identifier: MIT
#include "cloud/laz/color_models.h"

#include <algorithm>
#include <array>

namespace alidade {
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

}  // namespace alidade
