// SPDX-License-Identifier: MIT
#include "cloud/e57/crc32c.h"

#include <array>

#include "base/bytes.h"

namespace alidade {
namespace {

using Tables = std::array<std::array<std::uint32_t, 256>, 8>;

/// tables[k][b]: what byte b does to the sum when k more bytes follow it.
constexpr Tables make_tables() {
  constexpr std::uint32_t k_reflected_polynomial = 0x82F63B78;
  Tables tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t sum = byte;
    for (int bit = 0; bit < 8; ++bit) sum = (sum >> 1) ^ ((sum & 1) != 0 ? k_reflected_polynomial : 0);
    tables[0][byte] = sum;
  }
  for (std::size_t k = 1; k < 8; ++k) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint32_t sum = tables[k - 1][byte];
      tables[k][byte] = (sum >> 8) ^ tables[0][sum & 255];
    }
  }
  return tables;
}

constexpr Tables k_tables = make_tables();

}  // namespace

std::uint32_t crc32c(std::span<const std::byte> bytes) {
  std::uint32_t sum = 0xFFFFFFFF;
  while (bytes.size() >= 8) {
    const std::uint64_t word = load<std::uint64_t>(bytes.data()) ^ sum;
    sum = 0;
    for (std::size_t k = 0; k < 8; ++k) sum ^= k_tables[7 - k][word >> (8 * k) & 255];
    bytes = bytes.subspan(8);
  }
  for (const std::byte byte : bytes)
    sum = (sum >> 8) ^ k_tables[0][(sum ^ std::to_integer<std::uint32_t>(byte)) & 255];
  return ~sum;
}

}  // namespace alidade
