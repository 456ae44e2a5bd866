// SPDX-License-Identifier: MIT
#include "cloud/laz/arithmetic_encoder.h"

#include <utility>

namespace alidade {

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

}  // namespace alidade
