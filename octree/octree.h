// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "base/bounds.h"
#include "base/fingerprint.h"
#include "base/huge_memory.h"
#include "base/instruction_set.h"
#include "cloud/lattice.h"

namespace alidade {

/// A node: up to 16 children with their boxes, two cache lines.
///
///   byte  0      16     32     48     64     80     96     112          116          120
///         low.x  low.y  low.z  high.x high.y high.z kind   first_child  first_point  0
///         16 B   16 B   16 B   16 B   16 B   16 B   16 B   4 B          4 B          8 B
///
/// Every node has a *frame*: a cell of the octree, 2^level lattice steps wide, level >= 8, whose lower corner
/// is a multiple of its width. The children's boxes are on the frame's own grid of 256 steps per axis; one
/// grid step is 2^(level - 8) lattice steps, so boxes are exact at level 8. low and high are inclusive grid
/// steps. A node does not store its frame: the root's is the tree's, and a child's follows from its parent's
/// (child_corner).
///
/// Children are not the octants of one split: each bit of the Morton key splits a cell in two halves, and the
/// 16 slots are used for those halves of halves that a ray is expected to meet least often
/// (octree/building/collapsed_tree.h). Their cells are disjoint and in Morton order. Exceptions: points that
/// are too many for a leaf but lie in a cell that is not split further are divided by number, in Morton
/// order; and in a layered octree the first slot may be a leaf with a sample of the points of the whole cell.
/// At level 8, slots with equal boxes hold points of one position only, in any organisation; the lowest ids
/// are in the first of them.
///
/// From frames of level 16 (k_exact_frame_level) on, the points below a node are contiguous: those of its
/// leaves, then those below its inner children in slot order.
struct alignas(64) Node {
  std::uint8_t low[3][16];
  std::uint8_t high[3][16];
  /// 0: empty slot. 1..127: leaf with so many points. 128 + d: inner node whose frame is d levels smaller, d
  /// = 0..7.
  std::uint8_t kind[16];
  /// The inner children are contiguous from here, in slot order.
  std::uint32_t first_child;
  /// The points of leaf children are contiguous from here, in slot order.
  std::uint32_t first_point;
  std::uint64_t unused;  ///< 0
};
static_assert(sizeof(Node) == 128);

constexpr int k_node_width = 16;
constexpr std::uint8_t k_inner_kind = 0x80;
constexpr int k_max_level_drop = 7;
constexpr int k_min_frame_level = 8;
constexpr int k_max_leaf_size = 32;

/// Nodes on the longest possible way down: each takes at least one of the 96 bits of a position, or drops the
/// frame by seven levels (three times at most, once more down to level 8), or splits the points of one cell
/// by number (11 times).
constexpr int k_max_tree_depth = 96 + 4 + 11;

constexpr bool is_inner(std::uint8_t kind) {
  return kind >= k_inner_kind;
}
constexpr bool is_leaf(std::uint8_t kind) {
  return kind != 0 && kind < k_inner_kind;
}

/// Sixteen bytes of a node, one per slot, as two words: slot by slot, reading them would take longer than all
/// else.
struct SlotBytes {
  static constexpr std::uint64_t k_every_byte = 0x0101010101010101u;

  std::uint64_t lower, upper;  ///< of slots 0 to 7 and 8 to 15

  /// Of a row of a node.
  static SlotBytes load(const std::uint8_t (&row)[k_node_width]) { return std::bit_cast<SlotBytes>(row); }
  static constexpr SlotBytes fill(std::uint8_t byte) { return {byte * k_every_byte, byte * k_every_byte}; }

  constexpr SlotBytes operator|(SlotBytes b) const { return {lower | b.lower, upper | b.upper}; }
  constexpr SlotBytes operator^(SlotBytes b) const { return {lower ^ b.lower, upper ^ b.upper}; }

  /// Bit s: the highest bit of byte s.
  constexpr unsigned high_bits() const { return high_bits(lower) | high_bits(upper) << 8; }
  /// Bit s: byte s is not 0.
  constexpr unsigned nonzero() const { return high_bits(nonzero(lower)) | high_bits(nonzero(upper)) << 8; }
  /// Sum of the bytes of the slots before one, at most 15.
  constexpr std::uint32_t sum_before(int slot) const {
    const std::uint64_t mask = (std::uint64_t{1} << (8 * (slot & 7))) - 1;
    return slot < 8 ? sum(lower & mask) : sum(lower) + sum(upper & mask);
  }
  constexpr std::uint32_t sum() const { return sum(lower) + sum(upper); }

 private:
  static constexpr unsigned high_bits(std::uint64_t word) {
    return static_cast<unsigned>(((word >> 7 & k_every_byte) * 0x0102040810204080u) >> 56);
  }
  static constexpr std::uint64_t nonzero(std::uint64_t word) {
    constexpr std::uint64_t k_low_bits = 0x7f * k_every_byte;
    return ((word & k_low_bits) + k_low_bits) | word;
  }
  static constexpr std::uint32_t sum(std::uint64_t bytes) {
    constexpr std::uint64_t k_even_bytes = 0x00ff00ff00ff00ffu;
    return static_cast<std::uint32_t>(
        ((bytes & k_even_bytes) + (bytes >> 8 & k_even_bytes)) * 0x0001000100010001u >> 48);
  }
};

/// The slots of inner children, as bits.
inline unsigned inner_slots(const Node& node) {
  return SlotBytes::load(node.kind).high_bits();
}

/// Number of points by slot; 0 where no leaf is.
inline SlotBytes leaf_counts(const Node& node) {
  const auto without_inner = [](std::uint64_t kinds) {
    return kinds & ~((kinds >> 7 & SlotBytes::k_every_byte) * 0xff);
  };
  const SlotBytes kinds = SlotBytes::load(node.kind);
  return {without_inner(kinds.lower), without_inner(kinds.upper)};
}

/// Lattice steps from the corner of the parent's frame to the corner of the child's, along one axis.
/// low: the child's grid step in the parent; level: of the parent's frame; drop: level difference.
constexpr std::uint32_t child_corner(std::uint8_t low, int level, int drop) {
  const std::uint32_t cell_mask = ~((256u >> drop) - 1u);
  return (low & cell_mask) << (level - k_min_frame_level);
}

/// How the points of a cloud are spread over the nodes of an octree; BuildOptions (octree/build.h) chooses.
enum class Organisation : std::uint8_t {
  adaptive,  ///< cells are split until a leaf holds few enough points
  fixed,     ///< a grid: all leaves are cells of one size, or parts of one
  layered,   ///< every node holds a sample of the points in its cell, coarse to fine
};

/// Lengths of a tree that every query needs, in metres; derived from its lattice, base and bounds.
struct TreeExtent {
  // Four values each, the last being 0, so that they fill vectors.
  double corner[4] = {};             ///< of the root's frame, world
  double low[4] = {}, high[4] = {};  ///< of the bounds, world
  float scale[4] = {};               ///< of the lattice
  double widest_scale = 0.0;
  double frame_width = 0.0;  ///< of the root's frame, along the axis of the widest scale
  /// The *site*: the frame that holds all nodes but a few. Invalid points at 0 0 0, far away from the others,
  /// make the root's frame millions of metres wide, in which floats are metres apart. The root's frame if
  /// most of it is in use.
  std::array<std::uint32_t, 3> site_corner{};  ///< lattice steps from the root's corner
  int site_level = 0;                          ///< it is 2^site_level lattice steps wide
  double site_width = 0.0;                     ///< along the axis of the widest scale
  double largest_coordinate = 0.0;  ///< at least |offset of the lattice| + |coordinate| of every point
  double size = 0.0;                ///< sum of the sides of the bounds
};

/// The flat arrays of an octree, as traversals read them. A *storage index* is a point's number in the order
/// of the leaves; its id, the row in the cloud, is point_id(view, storage index).
struct TreeView {
  Lattice lattice;
  LatticePosition base{0};  ///< lattice position of the root frame's corner
  int root_level = k_min_frame_level;
  std::uint32_t point_count = 0;
  std::uint32_t node_count = 0;  ///< 0 for an empty cloud
  Organisation organisation = Organisation::adaptive;
  /// Levels of nodes; the root is level 0. The level of a point is that of the node whose leaf slot holds it.
  int level_count = 0;
  Bounds bounds;                ///< of the points, world
  TreeExtent extent;            ///< set by Octree
  const Node* nodes = nullptr;  ///< the root is nodes[0]
  /// Leaf of c points that starts at storage index p: coordinates[3p .. 3p + 3c) = c x, c y, c z: steps from
  /// the corner of its parent node's frame, divided by 2^coordinate_shift(level). Readable for
  /// k_coordinate_padding values past the end.
  const std::uint16_t* coordinates = nullptr;
  /// Row in the cloud by storage index; null if the cloud's rows are in the order of the storage indices.
  const std::uint32_t* ids = nullptr;
  /// Exact positions of the points in leaves under frames above level 16, whose coordinates are not exact;
  /// null if there are none. These points are at the storage indices from first_exact on: positions[storage
  /// index - first_exact].
  const LatticePosition* positions = nullptr;
  std::uint32_t first_exact = 0;  ///< meaningless without positions

  /// Length of `positions`.
  std::uint32_t exact_count() const { return positions ? point_count - first_exact : 0; }
};

/// Appends checksums of all that defines the points of a tree. Cost: as fast as memory delivers, about 16
/// bytes per point.
inline void append_tree_checksums(const TreeView& tree, std::vector<std::uint64_t>& sums) {
  const auto bytes_of = [](const auto* values, std::size_t count) {
    return values == nullptr ? std::span<const std::byte>() : std::as_bytes(std::span(values, count));
  };
  append_checksums(
      {bytes_of(tree.nodes, tree.node_count), bytes_of(tree.coordinates, 3 * std::size_t{tree.point_count}),
       bytes_of(tree.ids, tree.point_count), bytes_of(tree.positions, tree.exact_count())},
      sums);
}

/// Everything of a tree's extent. Cost: reads some hundred nodes at most.
TreeExtent extent_of(const TreeView& tree);

constexpr int k_coordinate_padding = 32;

/// What was measured around each point of an octree, as index files store it. Null and 0: not measured.
struct PointLayers {
  /// Spacing of the point at each storage index (octree/spacing.h), and the greatest below each slot of each
  /// node, 0 in empty ones: slot s of node n at 16 n + s. The upper halves of floats, metres. `spacings` is
  /// readable for k_coordinate_padding values past the end.
  const std::uint16_t* spacings = nullptr;
  const std::uint16_t* slot_spacings = nullptr;
  int spacing_neighbours = 0;  ///< a spacing is the distance to this neighbour
  /// The surface each point lies on, and where its sheet ends (surface/point_surface.h), by point id, packed;
  /// lengths are in steps of surface_unit metres.
  const std::uint32_t* surfaces = nullptr;
  double surface_unit = 0.0;
  const std::uint8_t* sheet_edges = nullptr;
};

/// The id of the point at a storage index.
inline std::uint64_t point_id(const TreeView& tree, std::uint32_t index) {
  return tree.ids ? tree.ids[index] : index;
}

/// Up to frames of this level, 16 bits hold the steps from a frame's corner.
constexpr int k_exact_frame_level = 16;

/// How far coordinates of leaves under a frame of this level are shifted to fit 16 bits; where it is > 0,
/// TreeView::positions has them exactly.
constexpr int coordinate_shift(int level) {
  return level > k_exact_frame_level ? level - k_exact_frame_level : 0;
}

/// The index over a cloud's points; made by build() (octree/build.h), queried by the functions of
/// octree/query.h. Immutable, cheap to copy (copies share the arrays), safe to query from many threads.
class Octree {
 public:
  Octree() = default;
  /// `storage` keeps alive what the view points to.
  Octree(const TreeView& view, std::shared_ptr<const void> storage, InstructionSet instruction_set)
      : view_(view), storage_(std::move(storage)), instruction_set_(instruction_set) {
    view_.extent = extent_of(view_);
  }

  std::size_t size() const { return view_.point_count; }
  const Lattice& lattice() const { return view_.lattice; }
  /// Smallest box around the points, world coordinates; empty for an empty octree.
  const Bounds& bounds() const { return view_.bounds; }
  /// Bytes of nodes, coordinates, ids, positions, spacings and surfaces.
  std::size_t memory() const;

  const TreeView& view() const { return view_; }
  const PointLayers& layers() const { return layers_; }
  InstructionSet instruction_set() const { return instruction_set_; }
  /// This index (shared arrays), traversed with another instruction set. Errors: not available on this
  /// machine.
  Octree with_instruction_set(InstructionSet instruction_set) const {
    Octree octree = *this;
    octree.instruction_set_ = usable(instruction_set);
    return octree;
  }
  /// This index with other layers, whose arrays `arrays` keeps alive beside those it has.
  Octree with_layers(const PointLayers& layers, std::shared_ptr<const void> arrays = nullptr) const {
    Octree octree = *this;
    octree.layers_ = layers;
    if (arrays) octree.storage_ = std::make_shared<const std::pair<Storage, Storage>>(storage_, arrays);
    return octree;
  }

  /// Whether coordinates lie in a file that is mapped, on small pages and perhaps not in memory yet.
  bool is_mapped() const { return is_mapped_; }
  Octree with_mapped(bool is_mapped) const {
    Octree octree = *this;
    octree.is_mapped_ = is_mapped;
    return octree;
  }

  /// Where with_spacings() and with_surfaces() put what they measure: in memory, or in scratch files.
  const ScratchFolder& scratch() const { return scratch_; }
  Octree with_scratch(ScratchFolder scratch) const {
    Octree octree = *this;
    octree.scratch_ = std::move(scratch);
    return octree;
  }

 private:
  using Storage = std::shared_ptr<const void>;

  TreeView view_;
  PointLayers layers_;
  Storage storage_;
  InstructionSet instruction_set_ = InstructionSet::scalar;
  ScratchFolder scratch_;
  bool is_mapped_ = false;
};

}  // namespace alidade
