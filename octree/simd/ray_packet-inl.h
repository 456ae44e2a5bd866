// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_RAY_PACKET_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_RAY_PACKET_INL_H
#undef ALIDADE_SIMD_RAY_PACKET_INL_H
#else
#define ALIDADE_SIMD_RAY_PACKET_INL_H
#endif

#include <hwy/cache_control.h>

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "octree/candidate.h"
#include "octree/simd/packet_leaf_test-inl.h"
#include "octree/simd/packet_state-inl.h"
#include "octree/simd/ray_stream-inl.h"
#include "octree/tree_walk.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// Up to 64 rays of one octant through the tree together, for rays that start and go much alike. A node is
/// first compared with the space between all of its rays, 16 boxes at once, then those boxes that are left
/// with vectors of rays. Where only a few rays are left, their boxes are in lanes.
///
/// Nothing of a ray is in memory but one column of the packet, and what the leaves make of it (PacketLeafTest;
/// for discs DiscPacketTest). Rays that these do not decide are traced alone.
template <class Points, bool any>
class RayPacket {
 public:
  static constexpr std::size_t k_size = PacketRays::k_size;
  using LeafTester = typename Points::template PacketTest<any>;

  explicit RayPacket(const Traversed<Points, any>& traversed)
      : traversed_(traversed),
        setup_(traversed.setup),
        leaf_test_(traversed.setup, traversed.leaf_test, rays_),
        stack_(std::make_unique_for_overwrite<Waiting[]>(
            static_cast<std::size_t>(traversed.setup.tree.level_count * (k_node_width - 1) + 1))) {}

  /// Traces the rays with these numbers, at most k_size, all of this octant. first_index: query_index of
  /// rays[0].
  void run(std::span<const Ray> rays, std::span<const std::uint32_t> numbers, unsigned octant,
           std::size_t first_index) {
    rays_.load(rays, numbers, octant, setup_);
    leaf_test_.start(rays, numbers, first_index);
    octant_ = octant;
    stack_count_ = 0;
    for (std::size_t lane = 0; lane < k_size; lane += k_lanes)
      hn::Store(hn::Zero(RayLanes()), RayLanes(), root_t_near_ + lane);
    if (activate(~0u, root_t_near_)) {
      Frame frame = root_frame(setup_.tree);
      do {
        visit(frame);
      } while (pop(frame));
    }
    leaf_test_.finish();
  }

  const PacketRays& rays() const { return rays_; }
  const LeafTester& results() const { return leaf_test_; }

  /// Nodes visited, and the rays that met them, since the start.
  std::uint64_t nodes() const { return nodes_; }
  std::uint64_t rays_at_nodes() const { return rays_at_nodes_; }

 private:
  static constexpr std::size_t k_lanes = hn::MaxLanes(RayLanes());
  static constexpr int k_few_rays = 2;  ///< so many and fewer have boxes in lanes

  struct Waiting {
    alignas(64) float t_near[k_size];  ///< infinite for rays that do not meet the node; only of `groups`
    Frame frame;
    unsigned groups;  ///< bit per vector of rays: one of them meets the node
  };

  /// Faces of a node's boxes, widened, from the setup's corner, metres, mirrored so that all rays rise.
  struct Faces {
    alignas(64) float near[3][k_node_width], far[3][k_node_width];

    /// What a ray travels inside the box at most.
    float extent(int slot) const {
      return (far[0][slot] - near[0][slot]) + (far[1][slot] - near[1][slot]) + (far[2][slot] - near[2][slot]);
    }
  };

  /// Makes those rays the active ones that meet the node at t_near before their cuts. Whether there are any.
  bool activate(unsigned groups, const float* t_near) {
    const RayLanes d;
    const auto none = hn::Set(d, -std::numeric_limits<float>::infinity());
    auto greatest = none;
    groups_ = 0;
    active_count_ = 0;
    for (groups &= rays_.groups; groups != 0; groups &= groups - 1) {
      const auto group = static_cast<std::size_t>(std::countr_zero(groups));
      const std::size_t first = group * k_lanes;
      const auto cut = hn::Load(d, rays_.t_cut + first);
      const auto is_active = hn::Le(hn::Load(d, t_near + first), cut);
      const std::size_t count = hn::CountTrue(d, is_active);
      if (count == 0) continue;
      const auto active_cut = hn::IfThenElse(is_active, cut, none);
      hn::Store(active_cut, d, rays_.boxes[group].cut);
      greatest = hn::Max(greatest, active_cut);
      active_count_ += static_cast<int>(count);
      groups_ |= 1u << group;
    }
    if (groups_ == 0) return false;
    greatest_cut_ = hn::GetLane(hn::MaxOfLanes(d, greatest));
    return true;
  }

  bool pop(Frame& frame) {
    while (stack_count_ > 0) {
      const Waiting& waiting = stack_[--stack_count_];
      if (!activate(waiting.groups, waiting.t_near)) continue;
      frame = waiting.frame;
      return true;
    }
    return false;
  }

  void visit(const Frame& frame) {
    ++nodes_;
    rays_at_nodes_ += static_cast<unsigned>(active_count_);
    const Node& node = setup_.tree.nodes[frame.node];
    const Slots slots(node);
    unsigned single = 0, wanted = slots.leaf | (frame.depth < traversed_.max_depth ? slots.inner : 0u);
    if (frame.level == k_min_frame_level && traversed_.skips_twins) {
      const SamePositions same(node);
      wanted &= ~same.twins;
      single = same.single;
    }
    Faces faces;
    fill(faces, node, frame);
    const unsigned met =
        active_count_ <= k_few_rays ? meet_boxes_in_lanes(faces, wanted) : meet_rays_in_lanes(faces, wanted);
    if ((met & slots.leaf) != 0) visit_leaves(node, frame, slots, faces, met & slots.leaf, single);
    push(node, frame, slots, met & slots.inner, (met & slots.leaf) != 0);
  }

  void fill(Faces& faces, const Node& node, const Frame& frame) const {
    const ChildLanes d;
    const auto grid_step = static_cast<float>(power_of_two(frame.level - k_min_frame_level));
    const auto margin = static_cast<float>(setup_.widening(frame.corner, frame.level));
    for (int axis = 0; axis < 3; ++axis) {
      const bool down = (octant_ >> axis & 1) != 0;
      const float corner = setup_.steps_to(frame.corner[axis], axis) * setup_.tree.extent.scale[axis];
      const float step = grid_step * setup_.tree.extent.scale[axis];
      const float low = corner - margin, high = corner + (step + margin);
      const std::uint8_t *const first = down ? node.high[axis] : node.low[axis], *const last =
                                                                                     down ? node.low[axis]
                                                                                          : node.high[axis];
      const auto signed_step = hn::Set(d, down ? -step : step);
      for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
        auto near = hn::MulAdd(load_as_float(d, first + lane), signed_step, hn::Set(d, down ? -high : low));
        auto far = hn::MulAdd(load_as_float(d, last + lane), signed_step, hn::Set(d, down ? -low : high));
        if constexpr (Points::own_radii) {
          const auto radius = traversed_.leaf_test.points().slot_reach(d, frame.node, axis, lane);
          near = hn::Sub(near, radius);
          far = hn::Add(far, radius);
        }
        hn::Store(near, d, faces.near[axis] + lane);
        hn::Store(far, d, faces.far[axis] + lane);
      }
    }
  }

  /// The slots that any active ray meets, of those wanted; fills t_near_, groups_met_ and earliest_ of these.
  unsigned meet_rays_in_lanes(const Faces& faces, unsigned wanted) {
    unsigned met = 0;
    const RayLanes d;
    const auto none = hn::Set(d, std::numeric_limits<float>::infinity()), zero = hn::Zero(d);
    for (unsigned slots = meet_all_rays(faces) & wanted; slots != 0; slots &= slots - 1) {
      const int slot = std::countr_zero(slots);
      unsigned groups_met = 0;
      const auto near_x = hn::Set(d, faces.near[0][slot]), near_y = hn::Set(d, faces.near[1][slot]),
                 near_z = hn::Set(d, faces.near[2][slot]), far_x = hn::Set(d, faces.far[0][slot]),
                 far_y = hn::Set(d, faces.far[1][slot]), far_z = hn::Set(d, faces.far[2][slot]);
      for (unsigned groups = groups_; groups != 0; groups &= groups - 1) {
        const auto group = static_cast<std::size_t>(std::countr_zero(groups));
        const PacketRays::Boxes& ray = rays_.boxes[group];
        const auto inverse_x = hn::Load(d, ray.inverse[0]), inverse_y = hn::Load(d, ray.inverse[1]),
                   inverse_z = hn::Load(d, ray.inverse[2]), origin_x = hn::Load(d, ray.origin_t[0]),
                   origin_y = hn::Load(d, ray.origin_t[1]), origin_z = hn::Load(d, ray.origin_t[2]);
        const auto enter =
            hn::Max(hn::Max(hn::MulSub(near_x, inverse_x, origin_x), hn::MulSub(near_y, inverse_y, origin_y)),
                    hn::Max(hn::MulSub(near_z, inverse_z, origin_z), zero));
        const auto leave =
            hn::Min(hn::Min(hn::MulSub(far_x, inverse_x, origin_x), hn::MulSub(far_y, inverse_y, origin_y)),
                    hn::Min(hn::MulSub(far_z, inverse_z, origin_z), hn::Load(d, ray.cut)));
        const auto meets = hn::Le(enter, leave);
        if (hn::AllFalse(d, meets)) continue;
        hn::Store(hn::IfThenElse(meets, enter, none), d, t_near_[slot] + group * k_lanes);
        groups_met |= 1u << group;
      }
      groups_met_[slot] = groups_met;
      if (groups_met != 0) met |= 1u << slot;
    }
    return met;
  }

  /// The slots whose boxes the space between all rays of the packet meets before the last of the active rays'
  /// cuts. Fills earliest_. The errors are those of single rays, whose margins suffice: the differences and
  /// products are of the same numbers or of such that make the interval wider.
  unsigned meet_all_rays(const Faces& faces) {
    const ChildLanes d;
    unsigned met = 0;
    for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
      auto enter = hn::Zero(d), leave = hn::Set(d, greatest_cut_);
      for (int axis = 0; axis < 3; ++axis) {
        const auto least = hn::Set(d, rays_.inverse_min[axis]),
                   greatest = hn::Set(d, rays_.inverse_max[axis]);
        const auto near = hn::Sub(hn::Load(d, faces.near[axis] + lane), hn::Set(d, rays_.origin_max[axis]));
        const auto far = hn::Sub(hn::Load(d, faces.far[axis] + lane), hn::Set(d, rays_.origin_min[axis]));
        enter = hn::Max(enter, hn::Min(hn::Mul(near, least), hn::Mul(near, greatest)));
        leave = hn::Min(leave, hn::Max(hn::Mul(far, least), hn::Mul(far, greatest)));
      }
      hn::Store(enter, d, earliest_ + lane);
      met |= mask_bits(d, hn::Le(enter, leave)) << lane;
    }
    return met;
  }

  /// As meet_rays_in_lanes, for few rays.
  unsigned meet_boxes_in_lanes(const Faces& faces, unsigned wanted) {
    const ChildLanes d;
    const RayLanes all;
    const auto none = hn::Set(all, std::numeric_limits<float>::infinity());
    unsigned met = 0;
    for (unsigned groups = groups_; groups != 0; groups &= groups - 1) {
      const auto group = static_cast<std::size_t>(std::countr_zero(groups));
      const std::size_t first = group * k_lanes;
      const PacketRays::Boxes& boxes = rays_.boxes[group];
      unsigned active = mask_bits(all, hn::Ge(hn::Load(all, boxes.cut), hn::Zero(all)));
      for (; active != 0; active &= active - 1) {
        const auto in_group = static_cast<std::size_t>(std::countr_zero(active));
        const std::size_t ray = first + in_group;
        alignas(64) float enters[k_node_width];
        unsigned meets = 0;
        for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
          auto enter = hn::Zero(d), leave = hn::Set(d, boxes.cut[in_group]);
          for (int axis = 0; axis < 3; ++axis) {
            const auto inverse = hn::Set(d, boxes.inverse[axis][in_group]),
                       origin_t = hn::Set(d, boxes.origin_t[axis][in_group]);
            enter = hn::Max(enter, hn::MulSub(hn::Load(d, faces.near[axis] + lane), inverse, origin_t));
            leave = hn::Min(leave, hn::MulSub(hn::Load(d, faces.far[axis] + lane), inverse, origin_t));
          }
          hn::Store(enter, d, enters + lane);
          meets |= mask_bits(d, hn::Le(enter, leave)) << lane;
        }
        for (meets &= wanted; meets != 0; meets &= meets - 1) {
          const int slot = std::countr_zero(meets);
          if ((met >> slot & 1u) == 0) {
            met |= 1u << slot;
            groups_met_[slot] = 0;
            earliest_[slot] = enters[slot];
          }
          if ((groups_met_[slot] >> group & 1u) == 0) {
            groups_met_[slot] |= 1u << group;
            hn::Store(none, all, t_near_[slot] + first);
          }
          t_near_[slot][ray] = enters[slot];
          earliest_[slot] = std::min(earliest_[slot], enters[slot]);
        }
      }
    }
    return met;
  }

  /// Slots as bits, the one met first in front.
  SlotOrder nearest_first(unsigned slots) const {
    std::array<std::uint64_t, k_node_width> keys;
    SlotOrder order;
    for (; slots != 0; slots &= slots - 1) {
      const int slot = std::countr_zero(slots);
      const std::uint64_t key =
          std::uint64_t{std::bit_cast<std::uint32_t>(earliest_[slot])} << 8 | static_cast<unsigned>(slot);
      int at = order.count++;
      for (; at > 0 && keys[at - 1] > key; --at) keys[at] = keys[at - 1];
      keys[at] = key;
    }
    for (int i = 0; i < order.count; ++i) order.slot[i] = static_cast<std::uint8_t>(keys[i] & 0xff);
    return order;
  }

  void visit_leaves(const Node& node, const Frame& frame, const Slots& slots, const Faces& faces,
                    unsigned leaves, unsigned single) {
    for (unsigned rest = leaves; rest != 0; rest &= rest - 1) {
      const int slot = std::countr_zero(rest);
      traversed_.leaf_test.fetch(slots.first_point(node, slot), node.kind[slot]);
    }
    leaf_test_.enter(frame);
    const SlotOrder order = nearest_first(leaves);
    for (int i = 0; i < order.count; ++i) {
      const int slot = order.slot[i];
      const Leaf leaf = slots.leaf_in(node, frame, slot);
      leaf_test_.visit(leaf, (single >> slot & 1u) != 0 ? 1u : leaf.count, groups_met_[slot], t_near_[slot],
                       {faces.far[0][slot], faces.far[1][slot], faces.far[2][slot]}, faces.extent(slot));
    }
  }

  /// Puts the children on the stack, the farthest first. after_leaves: cuts may have changed.
  void push(const Node& node, const Frame& frame, const Slots& slots, unsigned children, bool after_leaves) {
    const RayLanes d;
    if (after_leaves) {
      for (unsigned rest = children; rest != 0; rest &= rest - 1) {
        const int slot = std::countr_zero(rest);
        for (unsigned groups = groups_met_[slot]; groups != 0; groups &= groups - 1) {
          const auto group = static_cast<std::size_t>(std::countr_zero(groups));
          const std::size_t first = group * k_lanes;
          if (hn::AllFalse(d, hn::Le(hn::Load(d, t_near_[slot] + first), hn::Load(d, rays_.t_cut + first))))
            groups_met_[slot] &= ~(1u << group);
        }
        if (groups_met_[slot] == 0) children &= ~(1u << slot);
      }
    }
    const SlotOrder order = nearest_first(children);
    for (int i = order.count; i-- > 0;) {
      const int slot = order.slot[i];
      Waiting& waiting = stack_[stack_count_++];
      waiting.frame = slots.child_in(node, frame, slot);
      waiting.groups = groups_met_[slot];
      hwy::Prefetch(setup_.tree.nodes + waiting.frame.node);
      hwy::Prefetch(&setup_.tree.nodes[waiting.frame.node].high[1]);
      for (unsigned groups = waiting.groups; groups != 0; groups &= groups - 1) {
        const std::size_t first = static_cast<std::size_t>(std::countr_zero(groups)) * k_lanes;
        hn::Store(hn::Load(d, t_near_[slot] + first), d, waiting.t_near + first);
      }
    }
  }

  const Traversed<Points, any>& traversed_;
  const QuerySetup& setup_;
  PacketRays rays_;
  LeafTester leaf_test_;
  unsigned octant_ = 0;
  // Of the node that is visited: its rays.
  unsigned groups_ = 0;  ///< bit per vector of rays: one of them is active
  int active_count_ = 0;
  float greatest_cut_ = 0.0f;
  // Of its slots that are met.
  alignas(64) float t_near_[k_node_width][k_size];
  unsigned groups_met_[k_node_width];
  alignas(64) float earliest_[k_node_width];  ///< no ray enters before
  alignas(64) float root_t_near_[k_size];
  int stack_count_ = 0;
  std::unique_ptr<Waiting[]> stack_;
  std::uint64_t nodes_ = 0, rays_at_nodes_ = 0;
};

/// The points that rays of a packet meet as hits, several at a time.
class PacketHits {
 public:
  template <class Points>
  HWY_INLINE void add(const Points& points, const TreeView& tree, std::size_t lane, const Leaf& leaf,
                      std::uint32_t point) {
    index_[lane] = leaf.first + point;
    if (tree.ids) hwy::Prefetch(tree.ids + index_[lane]);
    const glm::dvec3 position = to_world(tree.lattice, position_of(tree, leaf, point));
    for (int axis = 0; axis < 3; ++axis) position_[axis][lane] = position[axis];
    radius_[lane] = points.radius_at(index_[lane]);
  }

  void evaluate(const PacketRays& rays) {
    const DoubleLanes d;
    for (std::size_t lane = 0; lane < rays.count; lane += hn::Lanes(d)) {
      const LaneProjection point =
          rays.project(lane, hn::Load(d, position_[0] + lane), hn::Load(d, position_[1] + lane),
                       hn::Load(d, position_[2] + lane), hn::Load(d, radius_ + lane));
      hn::Store(point.t, d, t_ + lane);
      hn::Store(point.distance, d, distance_ + lane);
      hn::Store(point.entry, d, entry_ + lane);
    }
  }

  /// Whether the point meets the conditions of the query.
  template <class Points>
  HWY_INLINE bool write(const QuerySetup& setup, const Ray& ray, std::size_t lane,
                        std::optional<typename Points::Answer>& hit) const {
    if (!(distance_[lane] <= radius_[lane] && t_[lane] >= ray.t_min && t_[lane] <= ray.t_max &&
          entry_[lane] >= setup.query.entry_min))
      return false;
    hit = Points::answer({point_id(setup.tree, index_[lane]),
                          {position_[0][lane], position_[1][lane], position_[2][lane]},
                          t_[lane],
                          distance_[lane],
                          entry_[lane]},
                         index_[lane]);
    return true;
  }

 private:
  static constexpr std::size_t k_size = PacketRays::k_size;
  std::uint32_t index_[k_size];
  alignas(64) double position_[3][k_size], radius_[k_size];
  alignas(64) double t_[k_size], distance_[k_size], entry_[k_size];
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
