// SPDX-License-Identifier: MIT
#include "octree/build.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cloud/rows.h"
#include "octree/building/tree_builder.h"

namespace alidade {
namespace {

struct Built {
  TreeView view;
  std::shared_ptr<OctreeArrays> arrays;

  Octree octree(InstructionSet instruction_set) && {
    return Octree(view, std::move(arrays), instruction_set);
  }
};

void check(const BuildOptions& options, std::size_t point_count) {
  if (options.leaf_size < 1 || options.leaf_size > k_max_leaf_size) {
    throw Error({.problem = "leaf size out of range",
                 .expected = "1 to " + std::to_string(k_max_leaf_size),
                 .found = std::to_string(options.leaf_size)});
  }
  if (!(options.cell_size >= 0.0) || std::isinf(options.cell_size)) {
    throw Error({.problem = "cell size out of range",
                 .expected = "a finite length, or 0 to choose one",
                 .found = std::to_string(options.cell_size)});
  }
  if (point_count >= 0xffffffffu) {
    throw Error({.problem = "too many points for one octree",
                 .expected = "at most 4294967294",
                 .found = std::to_string(point_count)});
  }
}

/// Level of the largest cells whose sides are at most this long.
int level_of_cells(const Lattice& lattice, double cell_size) {
  const double steps = cell_size / std::max({lattice.scale.x, lattice.scale.y, lattice.scale.z});
  return steps < 2.0 ? 0 : std::min(std::ilogb(steps), 32);
}

/// Level of the largest cells that hold at most leaf_size points on average, empty ones not counted.
template <class Entry>
int level_of_filled_cells(const SortedPoints<Entry>& sorted, int leaf_size) {
  // How many points are the first in their cell of this level, not above.
  std::array<std::size_t, 33> first_of_cell{};
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    const int bit = highest_bit(sorted[i - 1].key() ^ sorted[i].key());
    if (bit >= 0) ++first_of_cell[bit / 3];
  }
  std::size_t cells = 1;
  for (int level = 32; level > 0; --level) {
    if (sorted.size() <= cells * static_cast<std::size_t>(leaf_size)) return level;
    cells += first_of_cell[level - 1];
  }
  return 0;
}

template <class Entry>
void build_tree(const KeySpace& space, SortedPoints<Entry> sorted, const BuildOptions& options,
                const ScratchFolder& scratch, Built& built) {
  const std::size_t count = sorted.size();
  TreeView& view = built.view;
  OctreeArrays& arrays = *built.arrays;
  arrays.coordinates = HugeArray<std::uint16_t>(3 * count + k_coordinate_padding, scratch);
  std::fill_n(arrays.coordinates.data() + 3 * count, k_coordinate_padding, std::uint16_t{0});
  arrays.ids = HugeArray<std::uint32_t>(count, scratch);
  if (space.extent_bits > k_exact_frame_level) arrays.positions = HugeArray<LatticePosition>(count, scratch);

  SplitRules rules{options.organisation, options.leaf_size, 0};
  if (options.organisation == Organisation::fixed) {
    rules.cell_level = options.cell_size > 0.0 ? level_of_cells(view.lattice, options.cell_size)
                                               : level_of_filled_cells(sorted, options.leaf_size);
  }
  const PointRange all = point_range(sorted, 0, static_cast<std::uint32_t>(count));
  view.root_level = std::max(rules.lowest_frame_level(all), space.extent_bits);
  const TreeSummary summary =
      TreeBuilder<Entry>(sorted, rules, space.base, arrays, scratch).build(view.root_level);

  view.base = space.base;
  view.point_count = static_cast<std::uint32_t>(count);
  view.node_count = static_cast<std::uint32_t>(arrays.nodes.size());
  view.level_count = summary.level_count;
  view.bounds.grow(to_world(view.lattice, lattice_position(space.base, summary.box.low)));
  view.bounds.grow(to_world(view.lattice, lattice_position(space.base, summary.box.high)));
  view.nodes = arrays.nodes.data();
  view.coordinates = arrays.coordinates.data();
  view.ids = arrays.ids.data();
  if (summary.first_exact < count) {
    view.positions = arrays.positions.data() + summary.first_exact;
    view.first_exact = summary.first_exact;
  } else {
    arrays.positions = {};
  }
}

/// sort(space, Entry()) gives the sorted points.
template <class Sort>
Built build_from(const Lattice& lattice, std::span<const LatticePosition> positions,
                 const BuildOptions& options, const ScratchFolder& scratch, const Sort& sort) {
  const std::size_t count = positions.size();
  check(options, count);
  Built built{{}, std::make_shared<OctreeArrays>()};
  built.view.lattice = lattice;
  built.view.organisation = options.organisation;
  if (count == 0) return built;

  report(options.progress, 0, count);
  const KeySpace space = key_space(positions);
  const auto sort_and_build = [&]<class Entry>(const Entry& entry) {
    SortedPoints<Entry> sorted = sort(space, entry);
    report(options.progress, count / 2, count);
    build_tree(space, std::move(sorted), options, scratch, built);
  };
  if (space.is_narrow()) {
    sort_and_build(NarrowEntry{});
  } else {
    sort_and_build(WideEntry{});
  }
  report(options.progress, count, count);
  return built;
}

Built build_from(PointCloud&& cloud, const BuildOptions& options) {
  return build_from(cloud.lattice, cloud.positions, options, {},
                    [&]<class Entry>(const KeySpace& space, const Entry&) {
                      return sort_points<Entry>(space, std::move(cloud.positions));
                    });
}

}  // namespace

Octree build(const PointCloud& cloud, const BuildOptions& options) {
  const InstructionSet instruction_set = usable(options.instruction_set);
  return build_from(cloud.lattice, cloud.positions, options, {},
                    [&]<class Entry>(const KeySpace& space, const Entry&) {
                      return sort_points<Entry>(space, cloud.positions);
                    })
      .octree(instruction_set);
}

Octree build(PointCloud&& cloud, const BuildOptions& options) {
  const InstructionSet instruction_set = usable(options.instruction_set);
  return build_from(std::move(cloud), options).octree(instruction_set);
}

Octree build_in_stored_order(PointCloud& cloud, const BuildOptions& options) {
  const InstructionSet instruction_set = usable(options.instruction_set);
  Built built = build_from(std::move(cloud), options);
  reorder_attributes(cloud, {built.view.ids, built.view.point_count});
  built.arrays->ids = {};
  built.view.ids = nullptr;
  return std::move(built).octree(instruction_set);
}

Octree build_in_scratch(const Lattice& lattice, std::span<LatticePosition> positions,
                        const ScratchSpace& scratch, const BuildOptions& options) {
  const InstructionSet instruction_set = usable(options.instruction_set);
  return build_from(lattice, positions, options, scratch.folder,
                    [&]<class Entry>(const KeySpace& space, const Entry&) {
                      return sort_points<Entry>(space, positions, scratch);
                    })
      .octree(instruction_set)
      .with_scratch(scratch.folder);
}

}  // namespace alidade
