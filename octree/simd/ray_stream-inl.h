// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_RAY_STREAM_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_RAY_STREAM_INL_H
#undef ALIDADE_SIMD_RAY_STREAM_INL_H
#else
#define ALIDADE_SIMD_RAY_STREAM_INL_H
#endif

#include <hwy/cache_control.h>

#include <memory>
#include <span>
#include <vector>

#include "octree/simd/box_test-inl.h"
#include "octree/simd/leaf_group_test-inl.h"
#include "octree/simd/ray_state.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// What stays the same for all rays of a query.
template <Measure measure, bool any, Radii radii>
struct Traversed {
  const QuerySetup& setup;
  const LeafTest<measure, any, radii>& leaf_test;
  int max_depth;     ///< nodes below are not visited
  bool skips_twins;  ///< of points at one position only the first is examined

  Traversed(const QuerySetup& query_setup, const LeafTest<measure, any, radii>& test)
      : setup(query_setup),
        leaf_test(test),
        max_depth(setup.query.max_level),
        skips_twins(!setup.query.filter && setup.query.max_level == k_all_levels) {}
};

/// One ray on its way through the tree, nearest nodes first, in steps: look at a node's boxes, test the
/// leaves among them, go on to the next node.
template <Measure measure, bool any, Radii radii>
class RayWalk {
 public:
  RayWalk(const Traversed<measure, any, radii>& traversed, const RayUnderWay& ray, const Frame& from)
      : ray_(ray),
        on_grid_(traversed.setup, ray.boxes),
        at_{{static_cast<float>(from.corner[0]), static_cast<float>(from.corner[1]),
             static_cast<float>(from.corner[2])},
            from.node,
            static_cast<std::uint16_t>(from.level),
            static_cast<std::uint16_t>(from.depth)} {}

  /// Whether the ray meets leaves of the node.
  HWY_INLINE bool look(const Traversed<measure, any, radii>& traversed) {
    const TreeView& tree = traversed.setup.tree;
    const Node& node = tree.nodes[at_.node];
    const Slots slots(node);
    unsigned met = meet_boxes(ray_.boxes, on_grid_, node, at_.corner, at_.level,
                              traversed.leaf_test.own_radii(), slot_spacings(tree, at_.node), t_near_);
    single_ = 0;
    if (at_.level == k_min_frame_level && traversed.skips_twins) {
      const SamePositions same(node);
      met &= ~same.twins;
      single_ = same.single;
    }
    leaves_ = met & slots.leaf;
    inner_ = slots.inner;
    children_ = at_.depth < traversed.max_depth ? met & slots.inner : 0u;
    return leaves_ != 0;
  }

  /// Fetches the points of the leaves that the ray meets.
  HWY_INLINE void prefetch_leaves(const Traversed<measure, any, radii>& traversed) const {
    const Node& node = traversed.setup.tree.nodes[at_.node];
    const Slots slots(node);
    for (unsigned leaves = leaves_; leaves != 0; leaves &= leaves - 1) {
      const int slot = std::countr_zero(leaves);
      const std::uint16_t* coordinates =
          traversed.setup.tree.coordinates + std::size_t{3} * slots.first_point(node, slot);
      const int values = 3 * node.kind[slot];
      for (int value = 0; value < values; value += 32) hwy::Prefetch(coordinates + value);
    }
  }

  HWY_INLINE void prefetch_node(const Traversed<measure, any, radii>& traversed) const {
    hwy::Prefetch(traversed.setup.tree.nodes + at_.node);
  }

  /// Requires: look() was true.
  HWY_INLINE void test_leaves(const Traversed<measure, any, radii>& traversed) {
    const Node& node = traversed.setup.tree.nodes[at_.node];
    const Slots slots(node);
    const float cut_before = ray_.boxes.t_cut;
    const std::array<std::uint32_t, 3> corner = {lattice_steps(at_.corner[0]), lattice_steps(at_.corner[1]),
                                                 lattice_steps(at_.corner[2])};
    const auto index = traversed.leaf_test.index(corner, at_.level);
    do {
      const int slot = std::countr_zero(leaves_ | 1u << (k_node_width - 1));
      leaves_ &= leaves_ - 1;
      if (t_near_[slot] > ray_.boxes.t_cut) continue;
      const std::uint32_t count = node.kind[slot];
      const Leaf leaf{slots.first_point(node, slot), count, corner};
      traversed.leaf_test.visit(ray_, leaf, (single_ >> slot & 1u) != 0 ? 1u : count, index, t_near_[slot]);
      if (any && ray_.state.found()) return;
    } while (leaves_ != 0);
    if (ray_.boxes.t_cut < cut_before) children_ &= begin_before(t_near_, ray_.boxes.t_cut);
  }

  /// To the next node; false at the end of the way.
  HWY_INLINE bool go_on(const Traversed<measure, any, radii>& traversed) {
    if (any && ray_.state.found()) return false;
    const Node* nodes = traversed.setup.tree.nodes;
    if (children_ != 0) {
      const Node& node = nodes[at_.node];
      int slot = std::countr_zero(children_);
      children_ &= children_ - 1;
      if (children_ != 0) slot = keep_waiting(slot);
      at_ = child(at_, node, slot, inner_);
      return true;
    }
    // Of floats that are not below 0, and those that are, too.
    const auto cut = std::bit_cast<std::int32_t>(ray_.boxes.t_cut);
    Waiting chosen;
    do {
      if (waiting_count_ == 0) return false;
      chosen = waiting_[--waiting_count_];
    } while (static_cast<std::int32_t>(chosen >> 32) > cut);
    const Index& parent = way_[chosen >> 8 & 0xff];
    const Node& node = nodes[parent.node];
    const int slot = static_cast<int>(chosen & 0xff);
    at_ = child(parent, node, slot, inner_slots(node));
    return true;
  }

 private:
  /// A node, with the corner of its frame as floats, which hold it exactly: it is a multiple of 256 below
  /// 2^32.
  struct Index {
    float corner[3];  ///< lattice steps from the root's
    std::uint32_t node;
    std::uint16_t level;
    std::uint16_t depth;
  };

  static std::uint32_t lattice_steps(float corner) { return static_cast<std::uint32_t>(corner); }

  /// inner: of the parent's slots.
  HWY_INLINE static Index child(const Index& parent, const Node& node, int slot, unsigned inner) {
    const int drop = node.kind[slot] - k_inner_kind;
    const auto grid_step =
        std::bit_cast<float>(static_cast<std::uint32_t>(127 + parent.level - k_min_frame_level) << 23);
    Index index;
    for (int axis = 0; axis < 3; ++axis)
      index.corner[axis] =
          parent.corner[axis] + static_cast<float>(node.low[axis][slot] & (-256 >> drop)) * grid_step;
    index.node = node.first_child + static_cast<unsigned>(std::popcount(inner & ((1u << slot) - 1u)));
    index.level = static_cast<std::uint16_t>(parent.level - drop);
    index.depth = static_cast<std::uint16_t>(parent.depth + 1);
    return index;
  }

  /// A child still to be visited: from high to low 32 bits its t, 24 bits depth of its parent, 8 bits slot.
  using Waiting = std::uint64_t;

  /// All children but the nearest wait, the farthest first, so that the nearer ones are visited earlier.
  HWY_INLINE int keep_waiting(int slot) {
    way_[at_.depth] = at_;
    const int bottom = waiting_count_;
    do {
      int other = std::countr_zero(children_);
      children_ &= children_ - 1;
      if (t_near_[other] < t_near_[slot]) std::swap(slot, other);
      const Waiting farther = Waiting{std::bit_cast<std::uint32_t>(t_near_[other])} << 32 |
                              Waiting{at_.depth} << 8 | static_cast<unsigned>(other);
      int at = waiting_count_++;
      for (; at > bottom && waiting_[at - 1] < farther; --at) waiting_[at] = waiting_[at - 1];
      waiting_[at] = farther;
    } while (children_ != 0);
    return slot;
  }

  RayUnderWay ray_;
  RayOnGrid<radii> on_grid_;
  Index at_;
  unsigned leaves_, children_, inner_, single_;
  int waiting_count_ = 0;
  alignas(64) float t_near_[k_node_width];
  Index way_[k_max_tree_depth + 1];  ///< the nodes whose other children wait, by depth
  Waiting waiting_[k_max_tree_depth * (k_node_width - 1) + 1];
};

/// One ray from one node on.
template <Measure measure, bool any, Radii radii>
void trace(const Traversed<measure, any, radii>& traversed, const RayUnderWay& ray, const Frame& from) {
  RayWalk<measure, any, radii> walk(traversed, ray, from);
  do {
    if (walk.look(traversed)) walk.test_leaves(traversed);
  } while (walk.go_on(traversed));
}

/// Many rays of one octant through the tree together, one lane per ray: every node is read once for all rays
/// that meet it, its boxes are turned into floats once, and so are the points of leaves. Where few are left,
/// each goes on alone.
template <Measure measure, bool any, Radii radii>
class RayStream {
 public:
  explicit RayStream(const Traversed<measure, any, radii>& traversed)
      : traversed_(traversed), setup_(traversed.setup) {}

  /// rays: numbers in the batch, all of this octant; k_list_padding more may be written over.
  void run(const RayBatch& batch, std::span<std::uint32_t> rays, unsigned octant) {
    batch_ = batch;
    octant_ = octant;
    if (lists_.empty()) lists_.resize(k_max_tree_depth + 1);
    RayList list{rays.data(), nullptr, static_cast<std::uint32_t>(rays.size())};
    list.pad();
    visit_node(root_frame(setup_.tree), list);
  }

 private:
  static constexpr std::uint32_t k_min_rays = 4;  ///< at a node
  static constexpr std::uint32_t k_min_rays_at_leaf = 3;

  /// Room for the rays that meet each slot of a node.
  struct Lists {
    std::unique_ptr<std::uint32_t[]> rays;
    std::unique_ptr<float[]> t_near;
    std::size_t room = 0;

    void reserve(std::size_t count) {
      if (room >= count + k_list_padding) return;
      room = count + k_list_padding;
      rays = std::make_unique_for_overwrite<std::uint32_t[]>(k_node_width * room);
      t_near = std::make_unique_for_overwrite<float[]>(k_node_width * room);
    }
    RayList list(std::size_t index) const {
      return {rays.get() + index * room, t_near.get() + index * room, 0};
    }
  };

  /// Faces of a node's boxes, widened, from the root's corner, metres; first met, last met.
  struct Faces {
    alignas(64) float near[3][k_node_width], far[3][k_node_width];
  };

  void visit_node(const Frame& frame, const RayList& list) {
    if (list.count < k_min_rays) {
      for (std::uint32_t i = 0; i < list.count; ++i) trace(traversed_, batch_[list.rays[i]], frame);
      ++answers_;
      return;
    }
    const Node& node = setup_.tree.nodes[frame.node];
    const Slots slots(node);
    unsigned single = 0, wanted = slots.leaf | (frame.depth < traversed_.max_depth ? slots.inner : 0u);
    if (frame.level == k_min_frame_level && traversed_.skips_twins) {
      const SamePositions same(node);
      wanted &= ~same.twins;
      single = same.single;
    }
    Lists& lists = lists_[frame.depth];
    lists.reserve(list.count);
    RayList met[k_node_width];
    unsigned next_list = 0;
    for (unsigned rest = wanted; rest != 0; rest &= rest - 1)
      met[std::countr_zero(rest)] = lists.list(next_list++);
    const Faces faces = faces_of(node, frame);
    constexpr std::uint32_t k_few_rays = 8;
    if (list.count <= k_few_rays) {
      meet_boxes_in_lanes(faces, list, wanted, met);
    } else {
      meet_rays_in_lanes(faces, list, wanted, met);
    }
    unsigned any_met = 0;
    for (unsigned rest = wanted; rest != 0; rest &= rest - 1) {
      const int slot = std::countr_zero(rest);
      if (met[slot].count == 0) continue;
      any_met |= 1u << slot;
      met[slot].pad();
      if ((slots.leaf >> slot & 1u) != 0) {
        const std::uint16_t* coordinates =
            setup_.tree.coordinates + std::size_t{3} * slots.first_point(node, slot);
        for (int line = 0; line < 3; ++line) hwy::Prefetch(coordinates + 32 * line);
      } else {
        hwy::Prefetch(setup_.tree.nodes + slots.child(node, slot));
        hwy::Prefetch(&setup_.tree.nodes[slots.child(node, slot)].high[1]);
      }
    }
    const SlotOrder order = front_to_back(node, octant_, any_met);
    const std::uint64_t answers_before = answers_;
    const auto leaf_index = traversed_.leaf_test.index(frame.corner, frame.level);
    for (int index = 0; index < order.count; ++index) {
      const int slot = order.slot[index];
      RayList& rays = met[slot];
      if (answers_ != answers_before) rays.discard(batch_.boxes);
      if (rays.count == 0) continue;
      if ((slots.leaf >> slot & 1u) != 0) {
        const Leaf leaf = slots.leaf_in(node, frame, slot);
        test_leaf(leaf, (single >> slot & 1u) != 0 ? 1u : leaf.count, leaf_index, rays);
      } else {
        visit_node(slots.child_in(node, frame, slot), rays);
      }
    }
  }

  void test_leaf(const Leaf& leaf, std::uint32_t count,
                 const typename LeafTest<measure, any, radii>::Index& index, const RayList& list) {
    if (list.count >= k_min_rays_at_leaf && !traversed_.leaf_test.all_in_double()) {
      LeafGroupTest<measure, any, radii>(setup_, traversed_.leaf_test, leaf, count, index)
          .visit(batch_, list, answers_);
      return;
    }
    for (std::uint32_t i = 0; i < list.count; ++i)
      traversed_.leaf_test.visit(batch_[list.rays[i]], leaf, count, index, list.t_near[i]);
    ++answers_;
  }

  Faces faces_of(const Node& node, const Frame& frame) const {
    const ChildLanes d;
    Faces faces;
    const auto grid_step = static_cast<float>(power_of_two(frame.level - k_min_frame_level));
    const auto margin = static_cast<float>(radii == Radii::own ? setup_.box_margin : setup_.box_radius);
    const OwnRadii& own_radii = traversed_.leaf_test.own_radii();
    const std::uint16_t* spacings = slot_spacings(setup_.tree, frame.node);
    for (int axis = 0; axis < 3; ++axis) {
      const bool negative = (octant_ >> axis & 1) != 0;
      const float corner = static_cast<float>(static_cast<std::int32_t>(frame.corner[axis] >> 8)) * 256.0f *
                           setup_.float_scale[axis];
      const float step = grid_step * setup_.float_scale[axis];
      const float low_base = corner - margin, high_base = corner + (step + margin);
      for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
        auto low =
            hn::MulAdd(load_as_float(d, node.low[axis] + lane), hn::Set(d, step), hn::Set(d, low_base));
        auto high =
            hn::MulAdd(load_as_float(d, node.high[axis] + lane), hn::Set(d, step), hn::Set(d, high_base));
        if constexpr (radii == Radii::own) {
          const auto radius = own_radii.above(d, spacings + lane);
          low = hn::Sub(low, radius);
          high = hn::Add(high, radius);
        }
        hn::Store(negative ? high : low, d, faces.near[axis] + lane);
        hn::Store(negative ? low : high, d, faces.far[axis] + lane);
      }
    }
    return faces;
  }

  /// Fills the lists of the slots in the set (bits), one lane per slot.
  void meet_boxes_in_lanes(const Faces& faces, const RayList& list, unsigned wanted, RayList* met) const {
    const ChildLanes d;
    for (std::uint32_t i = 0; i < list.count; ++i) {
      const std::uint32_t number = list.rays[i];
      const RayBoxes& ray = batch_.boxes[number];
      alignas(64) float enters[k_node_width];
      unsigned meets = 0;
      for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
        auto enter = hn::Set(d, ray.t_low), leave = hn::Set(d, ray.t_cut);
        for (int axis = 0; axis < 3; ++axis) {
          const auto inverse = hn::Set(d, ray.inverse[axis]), origin_t = hn::Set(d, ray.origin_t[axis]);
          enter = hn::Max(enter, hn::MulSub(hn::Load(d, faces.near[axis] + lane), inverse, origin_t));
          leave = hn::Min(leave, hn::MulSub(hn::Load(d, faces.far[axis] + lane), inverse, origin_t));
        }
        hn::Store(enter, d, enters + lane);
        meets |= mask_bits(d, hn::Le(enter, leave)) << lane;
      }
      for (meets &= wanted; meets != 0; meets &= meets - 1) {
        const int slot = std::countr_zero(meets);
        RayList& rays = met[slot];
        rays.rays[rays.count] = number;
        rays.t_near[rays.count++] = enters[slot];
      }
    }
  }

  /// The same with one lane per ray.
  void meet_rays_in_lanes(const Faces& faces, const RayList& list, unsigned wanted, RayList* met) const {
    const RayLanes d;
    const RayNumbers n;
    for (std::uint32_t i = 0; i < list.count; i += static_cast<std::uint32_t>(hn::Lanes(d))) {
      const RayGroup ray(batch_.boxes, list.rays + i, list.count - i);
      const auto numbers = hn::LoadU(n, list.rays + i);
      for (unsigned rest = wanted; rest != 0; rest &= rest - 1) {
        const int slot = std::countr_zero(rest);
        const auto t = [&](int axis, float face) {
          return hn::MulSub(hn::Set(d, face), ray.inverse[axis], ray.origin_t[axis]);
        };
        const auto enter =
            hn::Max(hn::Max(t(0, faces.near[0][slot]), t(1, faces.near[1][slot])), t(2, faces.near[2][slot]));
        const auto leave =
            hn::Min(hn::Min(t(0, faces.far[0][slot]), t(1, faces.far[1][slot])), t(2, faces.far[2][slot]));
        const auto meets =
            hn::And(hn::Le(enter, leave), hn::And(hn::Ge(leave, ray.t_low), hn::Le(enter, ray.t_cut)));
        if (!hn::AllFalse(d, meets)) met[slot].add(numbers, enter, meets);
      }
    }
  }

  const Traversed<measure, any, radii>& traversed_;
  const QuerySetup& setup_;
  RayBatch batch_{};
  unsigned octant_ = 0;
  std::uint64_t answers_ = 0;  ///< grows when rays may have found better points
  std::vector<Lists> lists_;   ///< by depth
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
