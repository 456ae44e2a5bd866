// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>
#include <vector>

namespace alidade::test {

/// SHA-256 of some bytes as 64 digits: the checksum that lists of reference data give. Source: FIPS 180-4.
/// The constants there are the first 32 bits of the fractions of roots of primes: square roots for the state,
/// cube roots for the rounds; they are computed in whole numbers here.
inline std::string sha256(std::span<const std::byte> bytes) {
  // The first 32 bits behind the point of the power-th root of a prime.
  const auto root_bits = [](unsigned prime, int power) {
    using Wide = unsigned __int128;
    // The largest r with r^power <= prime * 2^(32 * power), whose lower 32 bits are wanted.
    std::uint64_t root = 0;
    for (int bit = 36; bit >= 0; --bit) {
      const std::uint64_t tried = root | std::uint64_t{1} << bit;
      const Wide square = Wide{tried} * tried;
      const bool fits = power == 2 ? square <= Wide{prime} << 64 : square <= (Wide{prime} << 96) / tried;
      if (fits) root = tried;
    }
    return static_cast<std::uint32_t>(root);
  };
  std::vector<unsigned> primes;
  for (unsigned number = 2; primes.size() < 64; ++number) {
    bool is_prime = true;
    for (const unsigned prime : primes) is_prime = is_prime && number % prime != 0;
    if (is_prime) primes.push_back(number);
  }
  std::array<std::uint32_t, 64> round_constants{};
  for (std::size_t i = 0; i < 64; ++i) round_constants[i] = root_bits(primes[i], 3);
  std::array<std::uint32_t, 8> state{};
  for (std::size_t i = 0; i < 8; ++i) state[i] = root_bits(primes[i], 2);

  const auto add_block = [&](const std::byte* block) {
    std::array<std::uint32_t, 64> words{};
    for (std::size_t i = 0; i < 64; ++i)
      words[i / 4] = words[i / 4] << 8 | std::to_integer<std::uint32_t>(block[i]);
    for (std::size_t i = 16; i < 64; ++i) {
      const std::uint32_t a = words[i - 15], b = words[i - 2];
      words[i] = words[i - 16] + words[i - 7] + (std::rotr(a, 7) ^ std::rotr(a, 18) ^ a >> 3) +
                 (std::rotr(b, 17) ^ std::rotr(b, 19) ^ b >> 10);
    }
    auto [a, b, c, d, e, f, g, h] = state;
    for (std::size_t i = 0; i < 64; ++i) {
      const std::uint32_t sum = h + (std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25)) +
                                ((e & f) ^ (~e & g)) + round_constants[i] + words[i];
      const std::uint32_t other =
          (std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22)) + ((a & b) ^ (a & c) ^ (b & c));
      h = g, g = f, f = e, e = d + sum, d = c, c = b, b = a, a = sum + other;
    }
    const std::array<std::uint32_t, 8> added = {a, b, c, d, e, f, g, h};
    for (std::size_t i = 0; i < 8; ++i) state[i] += added[i];
  };
  std::size_t offset = 0;
  for (; offset + 64 <= bytes.size(); offset += 64) add_block(bytes.data() + offset);
  std::vector<std::byte> end(bytes.begin() + static_cast<std::ptrdiff_t>(offset), bytes.end());
  end.push_back(std::byte{0x80});
  while (end.size() % 64 != 56) end.push_back(std::byte{0});
  for (int shift = 56; shift >= 0; shift -= 8)
    end.push_back(static_cast<std::byte>(std::uint64_t{bytes.size()} * 8 >> shift));
  for (offset = 0; offset < end.size(); offset += 64) add_block(end.data() + offset);

  std::string text;
  for (const std::uint32_t word : state) {
    char digits[9];
    std::snprintf(digits, sizeof digits, "%08x", word);
    text += digits;
  }
  return text;
}

}  // namespace alidade::test
