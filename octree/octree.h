// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

#include "octree/bounds.h"
#include "octree/cloud/lattice.h"

namespace alidade {

/// The index over a cloud's points; made by build() (octree/build.h), asked by the functions of octree/query.h.
/// Immutable, cheap to move, safe to query from many threads.
class Octree {
 public:
  std::size_t size() const;
  const Lattice& lattice() const;
  const Bounds& bounds() const;
};

}  // namespace alidade
