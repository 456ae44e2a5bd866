// SPDX-License-Identifier: MIT
#include "cloud/pcd/lzf.h"

#include <cstring>

namespace alidade {

bool decode_lzf(std::span<const std::byte> input, std::span<std::byte> output) {
  const std::byte* from = input.data();
  const std::byte* const from_end = from + input.size();
  std::byte* to = output.data();
  std::byte* const to_end = to + output.size();
  const auto next = [&] { return std::to_integer<std::size_t>(*from++); };

  while (from != from_end) {
    const std::size_t control = next();
    if (control < 32) {
      const std::size_t length = control + 1;
      if (length > static_cast<std::size_t>(from_end - from) ||
          length > static_cast<std::size_t>(to_end - to))
        return false;
      std::memcpy(to, from, length);
      from += length;
      to += length;
      continue;
    }
    std::size_t length = control >> 5;
    if (from_end - from < (length == 7 ? 2 : 1)) return false;
    if (length == 7) length += next();
    length += 2;
    const std::size_t distance = ((control & 31) << 8 | next()) + 1;
    if (distance > static_cast<std::size_t>(to - output.data()) ||
        length > static_cast<std::size_t>(to_end - to))
      return false;
    // The two ranges may overlap: a short pattern is repeated by copying what has just been written.
    for (const std::byte* source = to - distance; length > 0; --length) *to++ = *source++;
  }
  return to == to_end;
}

}  // namespace alidade
