// SPDX-License-Identifier: MIT
#include "visibility/points/thin_points.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_map>

#include "base/error.h"
#include "cloud/lattice.h"
#include "geo/raster.h"
#include "octree/distance.h"
#include "octree/tree_walk.h"

namespace alidade {
namespace {

constexpr int k_cell_bits = 21;
/// While the points are chosen: a node of the map with its share of the table, and a copy.
constexpr std::uint64_t k_bytes_per_cell = 140;

/// The point that stands for a cell so far.
struct Best {
  PlacementTarget target;
  double distance = 0.0;    ///< to the cell's middle
  std::uint64_t place = 0;  ///< in the octree
};

void check_spacing(const Octree& octree, double spacing) {
  const glm::dvec3 size = octree.bounds().size();
  const double longest = std::max({size.x, size.y, size.z});
  if (!(spacing > 0.0 && std::isfinite(spacing))) {
    throw Error({.problem = "bad spacing of targets",
                 .expected = "a length above 0",
                 .found = std::to_string(spacing)});
  }
  if (longest / spacing >= static_cast<double>((1 << k_cell_bits) - 1)) {
    throw Error({.problem = "spacing of targets is too fine for a cloud of this size",
                 .expected = "at least " + std::to_string(longest / ((1 << k_cell_bits) - 2)),
                 .found = std::to_string(spacing)});
  }
}

}  // namespace

std::vector<PlacementTarget> thin_points(const Octree& octree, double spacing,
                                         const std::function<bool(std::uint64_t point_id)>& counts) {
  check_spacing(octree, spacing);
  const TreeView& tree = octree.view();
  const glm::dvec3 corner = octree.bounds().min;
  std::unordered_map<std::uint64_t, Best> cells;
  // There are as many again when it is looked next.
  std::size_t next_check = 1 << 20;
  for_each_leaf(tree, [&](const Leaf& leaf) {
    for (std::uint32_t i = 0; i < leaf.count; ++i) {
      const std::uint64_t id = point_id(tree, leaf.place + i);
      if (counts && !counts(id)) continue;
      const glm::dvec3 position = to_world(tree.lattice, position_of(tree, leaf, i));
      std::uint64_t key = 0;
      glm::dvec3 middle{0.0};
      for (int axis = 0; axis < 3; ++axis) {
        const double cell = std::floor((position[axis] - corner[axis]) / spacing);
        key = key << k_cell_bits | static_cast<std::uint64_t>(cell);
        middle[axis] = corner[axis] + (cell + 0.5) * spacing;
      }
      const Best here{{id, position}, distance(middle, position), leaf.place + i};
      const auto [found, is_new] = cells.try_emplace(key, here);
      Best& best = found->second;
      const bool is_nearer =
          here.distance < best.distance || (here.distance == best.distance && id < best.target.point_id);
      if (!is_new && is_nearer) best = here;
    }
    if (cells.size() < next_check) return;
    check_memory(k_bytes_per_cell * cells.size(), "targets so near each other");
    next_check *= 2;
  });
  std::vector<Best> chosen;
  chosen.reserve(cells.size());
  for (const auto& [key, best] : cells) chosen.push_back(best);
  cells = {};
  std::ranges::sort(chosen, {}, &Best::place);
  std::vector<PlacementTarget> targets;
  targets.reserve(chosen.size());
  for (const Best& best : chosen) targets.push_back(best.target);
  return targets;
}

}  // namespace alidade
