// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "octree/build.h"
#include "octree/tree_walk.h"

namespace alidade::test {

struct NamedOctree {
  std::string name;
  Octree octree;
};

/// A cloud in every organisation, with large and small leaves.
inline std::vector<NamedOctree> octrees_of(const PointCloud& cloud,
                                           InstructionSet instruction_set = InstructionSet::best) {
  std::vector<NamedOctree> octrees;
  const auto add = [&](const std::string& name, Organisation organisation, int leaf_size) {
    BuildOptions options;
    options.organisation = organisation;
    options.leaf_size = leaf_size;
    options.instruction_set = instruction_set;
    octrees.push_back({name + " with leaves of " + std::to_string(leaf_size), build(cloud, options)});
  };
  add("adaptive", Organisation::adaptive, 32);
  add("adaptive", Organisation::adaptive, 3);
  add("fixed", Organisation::fixed, 32);
  add("layered", Organisation::layered, 32);
  add("layered", Organisation::layered, 4);
  return octrees;
}

/// Level of every point by its id.
inline std::vector<int> levels_by_id(const Octree& octree) {
  std::vector<int> levels(octree.size());
  for_each_leaf(octree.view(), [&](const Leaf& leaf) {
    for (std::uint32_t i = 0; i < leaf.count; ++i)
      levels[point_id(octree.view(), leaf.first + i)] = leaf.depth;
  });
  return levels;
}

}  // namespace alidade::test
