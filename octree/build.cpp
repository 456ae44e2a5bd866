// SPDX-License-Identifier: MIT
#include "octree/build.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "octree/cloud/reorder_attributes.h"
#include "octree/sorted_points.h"
#include "octree/tree_walk.h"

namespace alidade {
namespace {

// Above this many points the subtrees of a node are built side by side.
constexpr std::uint32_t k_parallel_points = 1u << 15;

using Steps = std::array<std::uint32_t, 3>;

/// Box in lattice steps from the root's corner, inclusive.
struct StepBox {
  Steps low{0xffffffffu, 0xffffffffu, 0xffffffffu};
  Steps high{0, 0, 0};

  void grow(const Steps& steps) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], steps[axis]);
      high[axis] = std::max(high[axis], steps[axis]);
    }
  }
  void grow(const StepBox& box) {
    grow(box.low);
    grow(box.high);
  }
};

/// A range of the sorted points that becomes one child.
struct Slot {
  std::uint32_t begin = 0, end = 0;
  int level = 0;  ///< of the smallest cell around the range; the key shift if all keys are equal
  std::uint32_t count() const { return end - begin; }
};

/// The children of a node in the making.
struct SlotList {
  std::array<Slot, k_node_width> items{};
  int count = 0;

  void add(const Slot& slot) { items[count++] = slot; }
  Slot& operator[](int s) { return items[s]; }
  const Slot& operator[](int s) const { return items[s]; }
  auto begin() { return items.begin(); }
  auto end() { return items.begin() + count; }
};

/// Which slots are inner nodes, and from which place on their points stand.
struct InnerSlots {
  std::array<int, k_node_width> slot{};
  std::array<std::uint32_t, k_node_width> place{};
  int count = 0;

  void add(int s, std::uint32_t first_place) {
    slot[count] = s;
    place[count++] = first_place;
  }
};

struct Storage {
  std::vector<Node> nodes;
  std::unique_ptr<std::uint16_t[]> coordinates;
  std::unique_ptr<std::uint32_t[]> ids;
  std::unique_ptr<LatticePosition[]> positions;
};

class Builder {
 public:
  Builder(SortedPoints& sorted, const std::vector<LatticePosition>& cloud_positions, int leaf_size,
          Storage& storage)
      : sorted_(sorted), cloud_positions_(cloud_positions), leaf_size_(leaf_size), storage_(storage) {}

  StepBox build_root(int level) {
    storage_.nodes.resize(1);
    return build_node({0, static_cast<std::uint32_t>(sorted_.size()), 0}, level, storage_.nodes, 0, 0);
  }

 private:
  /// Builds the node for a range into nodes[index]; its points take the places from first_place on.
  StepBox build_node(Slot range, int level, std::vector<Node>& nodes, std::size_t index,
                     std::uint32_t first_place) {
    const SlotList slots = collapse(range, level);
    const Steps corner = frame_corner(range.begin, level);

    std::array<StepBox, k_node_width> boxes;
    InnerSlots inner;
    std::uint32_t place = first_place;
    for (int s = 0; s < slots.count; ++s) {
      if (!becomes_leaf(slots[s], level)) continue;
      boxes[s] = emit_leaf(slots[s], level, corner, place);
      place += slots[s].count();
    }
    for (int s = 0; s < slots.count; ++s) {
      if (becomes_leaf(slots[s], level)) continue;
      inner.add(s, place);
      place += slots[s].count();
    }

    const std::size_t first_child = nodes.size();
    nodes.resize(first_child + inner.count);
    if (range.count() > k_parallel_points) {
      build_subtrees(slots, inner, level, boxes, nodes, first_child);
    } else {
      for (int i = 0; i < inner.count; ++i) {
        const Slot& slot = slots[inner.slot[i]];
        boxes[inner.slot[i]] =
            build_node(slot, child_level(slot, level), nodes, first_child + i, inner.place[i]);
      }
    }

    Node node{};
    node.first_child = static_cast<std::uint32_t>(first_child);
    node.first_point = first_place;
    StepBox all;
    for (int s = 0; s < slots.count; ++s) {
      for (int axis = 0; axis < 3; ++axis) {
        node.low[axis][s] = grid_step(boxes[s].low[axis], corner[axis], level);
        node.high[axis][s] = grid_step(boxes[s].high[axis], corner[axis], level);
      }
      node.kind[s] = becomes_leaf(slots[s], level)
                         ? static_cast<std::uint8_t>(slots[s].count())
                         : static_cast<std::uint8_t>(k_inner_kind + level - child_level(slots[s], level));
      all.grow(boxes[s]);
    }
    nodes[index] = node;
    return all;
  }

  /// Subtrees in parallel, each into nodes of its own, appended in slot order so that the result is always
  /// the same.
  void build_subtrees(const SlotList& slots, const InnerSlots& inner, int level,
                      std::array<StepBox, k_node_width>& boxes, std::vector<Node>& nodes,
                      std::size_t first_child) {
    std::array<std::vector<Node>, k_node_width> subtrees;
    tbb::parallel_for(0, inner.count, [&](int i) {
      const Slot& slot = slots[inner.slot[i]];
      subtrees[i].resize(1);
      boxes[inner.slot[i]] = build_node(slot, child_level(slot, level), subtrees[i], 0, inner.place[i]);
      // The points now stand in their leaves; giving the entries back keeps the peak at what the cloud itself
      // took.
      if (slot.count() <= k_parallel_points) sorted_.discard(slot.begin, slot.end);
    });
    for (int i = 0; i < inner.count; ++i) {
      // Node 1 of the subtree comes to stand at the end of `nodes`; its root goes to the place kept for it.
      const auto shift = static_cast<std::uint32_t>(nodes.size() - 1);
      for (Node& node : subtrees[i]) node.first_child += shift;
      nodes[first_child + i] = subtrees[i][0];
      nodes.insert(nodes.end(), subtrees[i].begin() + 1, subtrees[i].end());
      std::vector<Node>().swap(subtrees[i]);
    }
  }

  /// Up to eight children for a range: octree levels are opened, largest cell first, until the slots are
  /// used.
  SlotList collapse(Slot range, int level) const {
    SlotList slots;
    slots.add(with_level(range));
    std::array<SlotList, k_node_width> octants;  // of slots[s]; empty = not asked yet
    for (;;) {
      int chosen = -1;
      for (int s = 0; s < slots.count; ++s) {
        const bool splits = slots[s].level > sorted_.space().key_shift && !becomes_leaf(slots[s], level);
        if (!splits || (chosen >= 0 && !larger(slots[s], slots[chosen]))) continue;
        if (octants[s].count == 0) octants[s] = split(slots[s]);
        if (slots.count - 1 + octants[s].count <= k_node_width) chosen = s;
      }
      if (chosen < 0) break;
      const SlotList opened = std::exchange(octants[chosen], {});
      slots[chosen] = opened[0];
      for (int o = 1; o < opened.count; ++o) slots.add(opened[o]);
    }
    if (slots.count == 1 && slots[0].count() > static_cast<std::uint32_t>(leaf_size_))
      return split_by_number(slots[0]);
    std::sort(slots.begin(), slots.end(), [](const Slot& a, const Slot& b) { return a.begin < b.begin; });
    return slots;
  }

  static bool larger(const Slot& a, const Slot& b) {
    return a.level != b.level ? a.level > b.level : a.count() > b.count();
  }

  /// The non-empty octants of the smallest cell around a range.
  SlotList split(const Slot& slot) const {
    const int digit_shift = 3 * (slot.level - sorted_.space().key_shift - 1);
    const auto digit = [&](std::uint32_t i) { return sorted_[i].key() >> digit_shift & 7; };
    SlotList octants;
    for (std::uint32_t begin = slot.begin; begin < slot.end;) {
      const std::uint64_t here = digit(begin);
      std::uint32_t low = begin, high = slot.end;  // digit(low) == here; digit(high) > here or past the end
      while (high - low > 1) {
        const std::uint32_t middle = low + (high - low) / 2;
        (digit(middle) == here ? low : high) = middle;
      }
      octants.add(with_level({begin, high, 0}));
      begin = high;
    }
    return octants;
  }

  /// Points at one place cannot be told apart by cells; equal parts keep nodes and leaves within their sizes.
  SlotList split_by_number(const Slot& slot) const {
    SlotList parts;
    const std::uint64_t count = slot.count();
    for (std::uint64_t part = 0; part < k_node_width; ++part) {
      const auto begin = static_cast<std::uint32_t>(slot.begin + count * part / k_node_width);
      const auto end = static_cast<std::uint32_t>(slot.begin + count * (part + 1) / k_node_width);
      if (begin < end) parts.add({begin, end, slot.level});
    }
    return parts;
  }

  Slot with_level(Slot slot) const {
    const std::uint64_t difference = sorted_[slot.begin].key() ^ sorted_[slot.end - 1].key();
    slot.level = (std::bit_width(difference) + 2) / 3 + sorted_.space().key_shift;
    return slot;
  }

  /// 16 bits hold every position under a frame of level 16 or less; above, only if exact positions stand
  /// beside.
  bool becomes_leaf(const Slot& slot, int level) const {
    return slot.count() <= static_cast<std::uint32_t>(leaf_size_) && (level <= 16 || storage_.positions);
  }

  static int child_level(const Slot& slot, int level) {
    return std::max({k_min_frame_level, slot.level, level - k_max_level_drop});
  }

  Steps steps(std::uint32_t i) const {
    const SortEntry entry = sorted_[i];
    Steps result;
    for (int axis = 0; axis < 3; ++axis) {
      result[axis] = sorted_.space().key_shift == 0
                         ? morton_coordinate(entry.key(), axis)
                         : static_cast<std::uint32_t>(cloud_positions_[entry.id][axis]) -
                               static_cast<std::uint32_t>(sorted_.space().base[axis]);
    }
    return result;
  }

  Steps frame_corner(std::uint32_t i, int level) const {
    Steps corner = steps(i);
    for (std::uint32_t& c : corner) c = level >= 32 ? 0 : c >> level << level;
    return corner;
  }

  static std::uint8_t grid_step(std::uint32_t step, std::uint32_t corner, int level) {
    return static_cast<std::uint8_t>((step - corner) >> (level - k_min_frame_level));
  }

  StepBox emit_leaf(const Slot& slot, int level, const Steps& corner, std::uint32_t place) {
    StepBox box;
    const std::uint32_t count = slot.count();
    std::uint16_t* coordinates = storage_.coordinates.get() + std::size_t{3} * place;
    for (std::uint32_t i = 0; i < count; ++i) {
      const Steps point = steps(slot.begin + i);
      for (int axis = 0; axis < 3; ++axis) {
        coordinates[axis * count + i] =
            static_cast<std::uint16_t>((point[axis] - corner[axis]) >> coordinate_shift(level));
      }
      const std::uint32_t id = sorted_[slot.begin + i].id;
      storage_.ids[place + i] = id;
      if (storage_.positions) storage_.positions[place + i] = cloud_positions_[id];
      box.grow(point);
    }
    return box;
  }

  SortedPoints& sorted_;
  const std::vector<LatticePosition>& cloud_positions_;
  const int leaf_size_;
  Storage& storage_;
};

LatticePosition lattice_position(const LatticePosition& base, const Steps& steps) {
  LatticePosition position;
  for (int axis = 0; axis < 3; ++axis) {
    position[axis] = static_cast<std::int32_t>(static_cast<std::uint32_t>(base[axis]) + steps[axis]);
  }
  return position;
}

struct Built {
  TreeView view;
  std::shared_ptr<Storage> storage;
};

/// `given` is the vector behind `positions` if it is to be emptied, otherwise null.
Built build_from(const Lattice& lattice, const std::vector<LatticePosition>& positions,
                 std::vector<LatticePosition>* given, const BuildOptions& options) {
  if (options.leaf_size < 1 || options.leaf_size > k_max_leaf_size) {
    throw Error({.problem = "leaf size of the octree is out of range",
                 .expected = "1 to " + std::to_string(k_max_leaf_size),
                 .found = std::to_string(options.leaf_size)});
  }
  const std::size_t count = positions.size();
  if (count >= 0xffffffffu) {
    throw Error({.problem = "too many points for one octree",
                 .expected = "at most 4294967294",
                 .found = std::to_string(count)});
  }
  TreeView view;
  view.lattice = lattice;
  auto storage = std::make_shared<Storage>();
  if (count > 0) {
    report(options.progress, 0, count);
    const KeySpace space = key_space(positions);
    // Keys that do not hold the positions need them beside, up to the end.
    const bool lossless = space.key_shift == 0;
    SortedPoints sorted = sort_points(space, given && lossless ? std::move(*given) : positions);
    report(options.progress, count / 2, count);

    const std::size_t coordinate_count = 3 * count + k_coordinate_padding;
    storage->coordinates = std::make_unique_for_overwrite<std::uint16_t[]>(coordinate_count);
    std::fill_n(storage->coordinates.get() + 3 * count, k_coordinate_padding, std::uint16_t{0});
    storage->ids = std::make_unique_for_overwrite<std::uint32_t[]>(count);
    if (!lossless) storage->positions = std::make_unique_for_overwrite<LatticePosition[]>(count);

    view.base = space.base;
    view.root_level = std::max(k_min_frame_level, space.extent_bits);
    view.point_count = static_cast<std::uint32_t>(count);
    const StepBox box = Builder(sorted, positions, options.leaf_size, *storage).build_root(view.root_level);
    storage->nodes.shrink_to_fit();
    view.bounds.grow(to_world(lattice, lattice_position(space.base, box.low)));
    view.bounds.grow(to_world(lattice, lattice_position(space.base, box.high)));
    if (given) std::vector<LatticePosition>().swap(*given);
    report(options.progress, count, count);
  }
  view.node_count = static_cast<std::uint32_t>(storage->nodes.size());
  view.nodes = storage->nodes.data();
  view.coordinates = storage->coordinates.get();
  view.ids = storage->ids.get();
  view.positions = storage->positions.get();
  for_each_leaf(view,
                [&](const Leaf& leaf) { view.level_count = std::max(view.level_count, leaf.depth + 1); });
  return {view, std::move(storage)};
}

}  // namespace

Octree build(const PointCloud& cloud, const BuildOptions& options) {
  const InstructionSet instruction_set = usable(options.instruction_set);
  Built built = build_from(cloud.lattice, cloud.positions, nullptr, options);
  return Octree(built.view, std::move(built.storage), instruction_set);
}

Octree build(PointCloud&& cloud, const BuildOptions& options) {
  const InstructionSet instruction_set = usable(options.instruction_set);
  Built built = build_from(cloud.lattice, cloud.positions, &cloud.positions, options);
  return Octree(built.view, std::move(built.storage), instruction_set);
}

Octree build_in_stored_order(PointCloud& cloud, const BuildOptions& options) {
  const InstructionSet instruction_set = usable(options.instruction_set);
  Built built = build_from(cloud.lattice, cloud.positions, &cloud.positions, options);
  reorder_attributes(cloud, {built.view.ids, built.view.point_count});
  built.storage->ids.reset();
  built.view.ids = nullptr;
  return Octree(built.view, std::move(built.storage), instruction_set);
}

std::size_t Octree::memory() const {
  const std::size_t per_point = 3 * sizeof(std::uint16_t) + (view_.ids ? sizeof(std::uint32_t) : 0);
  return view_.node_count * sizeof(Node) + view_.point_count * per_point +
         view_.exact_count() * sizeof(LatticePosition);
}

}  // namespace alidade
