// SPDX-License-Identifier: MIT
#include "base/checksum.h"

// The library's code is compiled in, so that nobody who links Alidade has to link xxHash.
#define XXH_INLINE_ALL
#include <xxhash.h>

namespace alidade {

std::uint64_t checksum(std::span<const std::byte> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

}  // namespace alidade
