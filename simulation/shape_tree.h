// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "octree/bounds.h"
#include "octree/ray.h"

namespace alidade {

/// A bounding-volume hierarchy over boxes: finds those that a ray may meet, nearest first. Knows nothing of shapes.
/// Built by the surface area heuristic; immutable.
class ShapeTree {
 public:
  ShapeTree() = default;
  /// One finite, non-empty box per item.
  explicit ShapeTree(std::span<const Bounds> boxes);

  /// Calls visit(item, t_max) for items whose box the ray meets within [t_min, t_max], roughly nearest first; visit returns the
  /// new, not larger t_max. A negative infinity ends the walk. Boxes are tested conservatively.
  template <typename Visit>
  void walk(const Ray& ray, Visit&& visit) const;

 private:
  /// Either two children, at first and first + 1, or `count` > 0 entries of items_ from `first`. Box faces are rounded outwards.
  struct Node {
    float min[3], max[3];
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> items_;
};

}  // namespace alidade
