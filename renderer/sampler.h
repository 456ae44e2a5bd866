// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>

// Numbers for Monte Carlo that are a pure function of (seed, pixel, sample, dimension): any thread may call
// for any of them in any order. Each dimension (one number or one pair) is its own randomised (0,2)-sequence
// over the samples of a pixel: the first 2^m samples have exactly one in every elementary box of area 2^-m,
// so 50 samples spread better than random ones do.
//
// Sources: Sobol's sequence; Owen scrambling by hashing, Laine and Karras 2011, with the constants of Vegdahl
// 2021; shuffling and padding of dimensions: Burley, Practical Hash-based Owen Scrambling, JCGT 2020; mixing:
// splitmix64's finaliser (Stafford 13).

namespace alidade::renderer {

inline std::uint32_t reverse_bits(std::uint32_t x) {
  x = (x >> 16) | (x << 16);
  x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
  x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
  x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
  return ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
}

inline std::uint64_t mix_bits(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

/// Owen scrambling for a number whose bits are in reverse order: bit k of the result is bit k of x, flipped
/// or not depending on the bits below k and the seed.
inline std::uint32_t scramble_reversed(std::uint32_t x, std::uint32_t seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

/// Second dimension of Sobol's sequence, bits in reverse order. Its matrix is Pascal's triangle modulo 2: bit
/// j of the result is the parity of the index bits k whose number contains j's ones, which five folds give at
/// once.
inline std::uint32_t sobol_second_reversed(std::uint32_t index) {
  index ^= (index >> 1) & 0x55555555u;
  index ^= (index >> 2) & 0x33333333u;
  index ^= (index >> 4) & 0x0f0f0f0fu;
  index ^= (index >> 8) & 0x00ff00ffu;
  return index ^ (index >> 16);
}

/// The numbers of one sample of one pixel. Values lie in [0, 1), on steps of 2^-32.
class Sampler {
 public:
  Sampler(std::uint64_t seed, std::uint32_t x, std::uint32_t y, std::uint32_t sample)
      : key_(mix_bits(mix_bits(seed + k_step) ^ (std::uint64_t{y} << 32 | x))),
        reversed_sample_(reverse_bits(sample)) {}

  /// Continues at this dimension, so that each use in a path always meets the same sequence.
  void start_at(std::uint32_t dimension) { dimension_ = dimension; }

  double next_1d() {
    const std::uint64_t bits = next_bits();
    return to_unit(scramble_reversed(shuffled_index(bits), static_cast<std::uint32_t>(bits >> 32)));
  }

  glm::dvec2 next_2d() {
    const std::uint64_t bits = next_bits();
    const std::uint32_t index = shuffled_index(bits);
    const std::uint64_t further = mix_bits(bits + k_step);
    return {to_unit(scramble_reversed(index, static_cast<std::uint32_t>(bits >> 32))),
            to_unit(scramble_reversed(sobol_second_reversed(index), static_cast<std::uint32_t>(further)))};
  }

 private:
  static constexpr std::uint64_t k_step = 0x9e3779b97f4a7c15u;

  std::uint64_t next_bits() { return mix_bits(key_ + k_step * ++dimension_); }
  std::uint32_t shuffled_index(std::uint64_t bits) const {
    return reverse_bits(scramble_reversed(reversed_sample_, static_cast<std::uint32_t>(bits)));
  }
  static double to_unit(std::uint32_t reversed) { return reverse_bits(reversed) * 0x1p-32; }

  std::uint64_t key_;
  std::uint32_t reversed_sample_;
  std::uint64_t dimension_ = 0;
};

}  // namespace alidade::renderer
