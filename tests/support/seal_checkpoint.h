// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "tests/support/seal_index.h"

// Gives checkpoints that were tampered with right checksums, for the reason in seal_index.h. Offsets are
// those of renderer/checkpoint.h.

namespace alidade::test {

/// Gives head and rest the checksums of their bytes, as far as there is a head.
inline void seal_checkpoint(std::span<std::byte> file) {
  constexpr std::size_t k_fixed = 80;
  if (file.size() < k_fixed) return;
  const std::size_t head =
      k_fixed + std::min<std::size_t>(get<std::uint32_t>(file, 72), file.size() - k_fixed);
  const std::span<const std::byte> rest = file.subspan(head);
  std::vector<std::uint64_t> sums;
  for (std::size_t block = 0; block < checksum_blocks(rest.size()); ++block)
    sums.push_back(checksum(checksum_block(rest, block)));
  put(file, 32, checksum(std::as_bytes(std::span(sums))));
  put<std::uint64_t>(file, 24, 0);
  put(file, 24, checksum(file.first(head)));
}

}  // namespace alidade::test
