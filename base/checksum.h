// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace alidade {

/// XXH3, 64 bits, seed 0, through the xxHash library: as fast as memory delivers on any machine, without
/// instructions of its own to choose, and its bytes are fixed since version 0.8.0. It finds damage; it does
/// not withstand forgers. Source: https://github.com/Cyan4973/xxHash, doc/xxhash_spec.md.
std::uint64_t checksum(std::span<const std::byte> bytes);

/// Sections of a file are summed in blocks, so that threads can share the work and damage has a place.
inline constexpr std::size_t k_checksum_block = std::size_t{1} << 20;

/// Number of blocks in so many bytes; the last one may be short.
constexpr std::uint64_t checksum_blocks(std::uint64_t bytes) {
  return bytes / k_checksum_block + (bytes % k_checksum_block != 0);
}

/// The block with this number.
inline std::span<const std::byte> checksum_block(std::span<const std::byte> bytes, std::size_t block) {
  const std::span<const std::byte> rest = bytes.subspan(block * k_checksum_block);
  return rest.first(rest.size() < k_checksum_block ? rest.size() : k_checksum_block);
}

}  // namespace alidade
