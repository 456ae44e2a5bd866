// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include "cloud/lattice.h"
#include "octree/morton.h"

namespace alidade {

/// Lattice steps from the lowest position of a cloud, per axis.
using Steps = std::array<std::uint32_t, 3>;

/// A point under way into the octree: Morton key, which holds its position without loss, and row. As large as
/// the position it takes the place of; for clouds of at most 2^21 steps per axis.
struct NarrowEntry {
  using Key = std::uint64_t;

  std::uint32_t key_low;
  std::uint32_t key_high;
  std::uint32_t id;

  static NarrowEntry make(const Steps& steps, std::uint32_t id) {
    const Key key = morton_key(steps[0], steps[1], steps[2]);
    return {static_cast<std::uint32_t>(key), static_cast<std::uint32_t>(key >> 32), id};
  }
  Key key() const { return Key{key_high} << 32 | key_low; }
};
static_assert(sizeof(NarrowEntry) == sizeof(LatticePosition));

/// The same for any cloud.
struct WideEntry {
  using Key = WideMortonKey;

  std::uint64_t key_high;
  std::uint32_t key_low;
  std::uint32_t id;

  static WideEntry make(const Steps& steps, std::uint32_t id) {
    const Key key = wide_morton_key(steps[0], steps[1], steps[2]);
    return {static_cast<std::uint64_t>(key >> 32), static_cast<std::uint32_t>(key), id};
  }
  Key key() const { return Key{key_high} << 32 | key_low; }
};
static_assert(sizeof(WideEntry) == 16);

template <class Entry>
Steps steps_of(const Entry& entry) {
  const typename Entry::Key key = entry.key();
  return {morton_coordinate(key, 0), morton_coordinate(key, 1), morton_coordinate(key, 2)};
}

}  // namespace alidade
