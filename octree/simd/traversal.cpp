// SPDX-License-Identifier: MIT
#include "octree/simd/traversal.h"

#include <array>
#include <bit>
#include <cstring>

#include "octree/candidate.h"
#include "octree/simd/ray_setup.h"
#include "octree/tree_walk.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octree/simd/traversal.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, k_node_width>;
using Ints = hn::RebindToSigned<Floats>;

constexpr int k_stack_size = k_max_tree_depth * (k_node_width - 1) + 1;

/// A node still to be visited, with the frame that its parent told.
struct Visit {
  float t_near;
  std::uint32_t node;
  std::array<std::uint32_t, 3> corner;
  int level;
};

template <class T>
hn::Vec<Floats> load_as_float(const T* values) {
  return hn::ConvertTo(Floats(), hn::PromoteTo(Ints(), hn::LoadU(hn::Rebind<T, Floats>(), values)));
}

/// First `Lanes` bits of a mask.
template <class Mask>
unsigned mask_bits(const Mask& mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(Floats(), mask, bytes);
  return bytes[0];
}

template <Measure measure, bool any>
class RayTraversal {
 public:
  RayTraversal(const TreeView& tree, const Ray& ray, const RayQuery& query)
      : tree_(tree), ray_(ray), query_(query), setup_(set_up(tree, ray, query)) {}

  std::optional<Hit> run() {
    if (setup_.misses) return std::nullopt;
    if (setup_.exhaustive) return visit_all();
    cut_at(ray_.t_max);
    if (!(setup_.t_low <= t_cut_)) return std::nullopt;

    Visit stack[k_stack_size];
    int stack_count = 1;
    stack[0] = {-std::numeric_limits<float>::infinity(), 0, {0, 0, 0}, tree_.root_level};
    while (stack_count > 0) {
      const Visit visit = stack[--stack_count];
      if (visit.t_near > t_cut_) continue;
      visit_node(visit, stack, stack_count);
      if (any && best_) break;
    }
    return best_;
  }

 private:
  void visit_node(const Visit& visit, Visit* stack, int& stack_count) {
    const Node& node = tree_.nodes[visit.node];
    alignas(32) float t_near[k_node_width];
    std::uint64_t kinds;
    std::memcpy(&kinds, node.kind, 8);
    unsigned met = meet_boxes(node, visit, t_near);
    if (visit.level == k_min_frame_level) met &= ~twins_of_first(node);

    constexpr std::uint64_t k_high_bits = 0x8080808080808080u;
    const unsigned inner = gather_high_bits(kinds & k_high_bits);
    const std::uint64_t leaf_counts = kinds & ~((kinds >> 7 & 0x0101010101010101u) * 0xff);
    const unsigned leaf = gather_high_bits((leaf_counts + 0x7f7f7f7f7f7f7f7fu) & k_high_bits);
    // Each byte of the product holds the sum of all lower counts (at most 7 * 32).
    const std::uint64_t points_before = leaf_counts * 0x0101010101010100u;
    for (unsigned leaves = met & leaf; leaves != 0; leaves &= leaves - 1) {
      const int slot = std::countr_zero(leaves);
      if (t_near[slot] > t_cut_) continue;
      const auto before = static_cast<std::uint32_t>(points_before >> (8 * slot) & 0xff);
      visit_leaf(visit, t_near[slot], {node.first_point + before, node.kind[slot], visit.corner});
      if (any && best_) return;
    }

    // Farthest first on the stack, so that the nearest is visited next.
    const int bottom = stack_count;
    for (unsigned children = met & inner; children != 0; children &= children - 1) {
      const int slot = std::countr_zero(children);
      if (t_near[slot] > t_cut_) continue;
      const int drop = node.kind[slot] - k_inner_kind;
      Visit child;
      child.t_near = t_near[slot];
      child.node = node.first_child + static_cast<unsigned>(std::popcount(inner & ((1u << slot) - 1u)));
      for (int axis = 0; axis < 3; ++axis) {
        child.corner[axis] = visit.corner[axis] + child_corner(node.low[axis][slot], visit.level, drop);
      }
      child.level = visit.level - drop;
      int at = stack_count++;
      for (; at > bottom && stack[at - 1].t_near < child.t_near; --at) stack[at] = stack[at - 1];
      stack[at] = child;
    }
  }

  /// Slots whose points all stand at the one place of slot 0. Boxes are exact at the lowest level, and only
  /// parts of one place can have equal boxes there; their ids are higher, so they never win over slot 0. This
  /// is what keeps a ray through a million equal points from testing each.
  static unsigned twins_of_first(const Node& node) {
    std::uint64_t difference = 0;
    for (int axis = 0; axis < 3; ++axis) {
      std::uint64_t low, high;
      std::memcpy(&low, node.low[axis], 8);
      std::memcpy(&high, node.high[axis], 8);
      const std::uint64_t first = node.low[axis][0] * 0x0101010101010101u;
      difference |= (low ^ first) | (high ^ first);
    }
    constexpr std::uint64_t k_low_bits = 0x7f7f7f7f7f7f7f7fu;
    const unsigned equal =
        gather_high_bits(~(((difference & k_low_bits) + k_low_bits) | difference) & ~k_low_bits);
    return (equal & 1u) != 0 ? equal & ~1u : 0u;
  }

  /// Bit 7 of byte i becomes bit i.
  static unsigned gather_high_bits(std::uint64_t word) {
    return static_cast<unsigned>(((word >> 7) * 0x0102040810204080u) >> 56);
  }

  /// Slots whose widened box the ray meets before t_cut_, empty ones included, and where it enters each.
  unsigned meet_boxes(const Node& node, const Visit& visit, float* t_near) const {
    float near_base[3], far_base[3], step[3];
    const double grid_step = power_of_two(visit.level - k_min_frame_level);
    for (int axis = 0; axis < 3; ++axis) {
      const double scale = tree_.lattice.scale[axis];
      const double corner = (scale * visit.corner[axis] - setup_.origin[axis]) * setup_.inverse[axis];
      const double step_t = scale * grid_step * setup_.inverse[axis];
      // `high` is inclusive: its far face stands one step further.
      const double low_face = corner, high_face = corner + step_t;
      const bool negative = setup_.near_row[axis] >= 3;
      near_base[axis] = static_cast<float>((negative ? high_face : low_face) - setup_.reach[axis]);
      far_base[axis] = static_cast<float>((negative ? low_face : high_face) + setup_.reach[axis]);
      step[axis] = static_cast<float>(step_t);
    }

    const Floats d;
    const auto* rows = &node.low[0][0];
    const auto low = hn::Set(d, setup_.t_low), cut = hn::Set(d, t_cut_);
    unsigned met = 0;
    for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
      const auto face = [&](const float* base, const int* row, int axis) {
        return hn::Add(hn::Set(d, base[axis]),
                       hn::Mul(load_as_float(rows + 8 * row[axis] + lane), hn::Set(d, step[axis])));
      };
      const auto enter =
          hn::Max(hn::Max(face(near_base, setup_.near_row, 0), face(near_base, setup_.near_row, 1)),
                  face(near_base, setup_.near_row, 2));
      const auto leave =
          hn::Min(hn::Min(face(far_base, setup_.far_row, 0), face(far_base, setup_.far_row, 1)),
                  face(far_base, setup_.far_row, 2));
      hn::StoreU(enter, d, t_near + lane);
      const auto meets = hn::And(hn::And(hn::Le(enter, leave), hn::Ge(leave, low)), hn::Le(enter, cut));
      met |= mask_bits(meets) << lane;
    }
    return met;
  }

  void visit_leaf(const Visit& frame, float t_near, const Leaf& leaf) {
    // The leaf is tested near where the ray enters it, relative to its frame's corner: small numbers, small
    // errors.
    const double local_shift = t_near;
    float origin[3];
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis] = static_cast<float>(setup_.origin[axis] + local_shift * ray_.direction[axis] -
                                        tree_.lattice.scale[axis] * frame.corner[axis]);
    }
    const int shift = coordinate_shift(frame.level);
    const double width = setup_.widest_scale * power_of_two(frame.level);
    const double lost = shift > 0 ? 2.0 * setup_.widest_scale * power_of_two(shift) : 0.0;
    const double error = setup_.double_error + 0x1p-18 * (width + query_.radius) + lost;
    const double widened = query_.radius + error;
    const auto step = static_cast<float>(power_of_two(shift));

    const Floats d;
    // Also good for the half chord: (r + e)^2 - (d + e)^2 >= r^2 - d^2 for every d <= r.
    const auto radius_sq_limit = hn::Set(d, float_above(widened * widened));
    const auto low = hn::Set(d, float_below(setup_.t_low - local_shift - error));
    const auto cut = hn::Set(d, float_above(t_cut_ - local_shift + error));
    const auto direction_x = hn::Set(d, setup_.direction[0]), direction_y = hn::Set(d, setup_.direction[1]),
               direction_z = hn::Set(d, setup_.direction[2]);

    const std::uint16_t* coordinates = tree_.coordinates + std::size_t{3} * leaf.place;
    const auto count = static_cast<int>(leaf.count);
    for (int first = 0; first < count; first += static_cast<int>(hn::Lanes(d))) {
      const auto offset = [&](int axis) {
        return hn::Sub(
            hn::Mul(load_as_float(coordinates + axis * count + first), hn::Set(d, setup_.scale[axis] * step)),
            hn::Set(d, origin[axis]));
      };
      const auto x = offset(0), y = offset(1), z = offset(2);
      const auto t =
          hn::Add(hn::Add(hn::Mul(x, direction_x), hn::Mul(y, direction_y)), hn::Mul(z, direction_z));
      const auto across_x = hn::Sub(x, hn::Mul(t, direction_x)),
                 across_y = hn::Sub(y, hn::Mul(t, direction_y)),
                 across_z = hn::Sub(z, hn::Mul(t, direction_z));
      const auto distance_sq = hn::Add(hn::Add(hn::Mul(across_x, across_x), hn::Mul(across_y, across_y)),
                                       hn::Mul(across_z, across_z));
      auto earliest = t;
      if constexpr (measure == Measure::entry) {
        earliest = hn::Sub(t, hn::Sqrt(hn::Max(hn::Sub(radius_sq_limit, distance_sq), hn::Zero(d))));
      }
      const auto may_count =
          hn::And(hn::And(hn::Le(distance_sq, radius_sq_limit), hn::Ge(t, low)), hn::Le(earliest, cut));
      unsigned candidates = mask_bits(may_count);
      if (count - first < k_node_width) candidates &= (1u << (count - first)) - 1u;
      for (; candidates != 0; candidates &= candidates - 1) {
        const auto i = static_cast<std::uint32_t>(first + std::countr_zero(candidates));
        decide(leaf.place + i, position_of(tree_, leaf, i));
        if (any && best_) return;
      }
    }
  }

  void decide(std::uint32_t place, const LatticePosition& lattice_position) {
    const std::optional<Hit> hit =
        evaluate(ray_, query_, to_world(tree_.lattice, lattice_position), tree_.ids[place]);
    if (!hit || (best_ && !precedes(measure, *hit, *best_))) return;
    best_ = hit;
    cut_at(std::min(measured(measure, *best_), ray_.t_max));
  }

  /// Nothing that begins after this place on the ray can count any more.
  void cut_at(double t) { t_cut_ = float_above(t - setup_.shift + setup_.double_error); }

  /// Every point, without pruning, tested in double only.
  std::optional<Hit> visit_all() {
    for_each_leaf(tree_, [&](const Leaf& leaf) {
      for (std::uint32_t i = 0; i < leaf.count; ++i) decide(leaf.place + i, position_of(tree_, leaf, i));
    });
    return best_;
  }

  const TreeView& tree_;
  const Ray& ray_;
  const RayQuery& query_;
  const RaySetup setup_;
  float t_cut_ = 0.0f;
  std::optional<Hit> best_;
};

std::optional<Hit> closest(const TreeView& tree, const Ray& ray, const RayQuery& query) {
  if (query.measure == Measure::t) return RayTraversal<Measure::t, false>(tree, ray, query).run();
  return RayTraversal<Measure::entry, false>(tree, ray, query).run();
}

bool occluded(const TreeView& tree, const Ray& ray, const RayQuery& query) {
  return RayTraversal<Measure::t, true>(tree, ray, query).run().has_value();
}

constexpr Traversal k_traversal{closest, occluded};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alidade::simd {

const Traversal& traversal(InstructionSet instruction_set) {
  switch (instruction_set) {
#if HWY_TARGETS & HWY_AVX3
    case InstructionSet::avx512:
      return N_AVX3::k_traversal;
#endif
#if HWY_TARGETS & HWY_AVX2
    case InstructionSet::avx2:
      return N_AVX2::k_traversal;
#endif
#if HWY_TARGETS & HWY_SSE4
    case InstructionSet::sse4:
      return N_SSE4::k_traversal;
#endif
#if HWY_TARGETS & HWY_SSSE3
    case InstructionSet::ssse3:
      return N_SSSE3::k_traversal;
#endif
      // Which of its two scalar targets Highway compiles depends on the compiler.
#if HWY_TARGETS & HWY_SCALAR
    default:
      return N_SCALAR::k_traversal;
#else
    default:
      return N_EMU128::k_traversal;
#endif
  }
}

}  // namespace alidade::simd
#endif  // HWY_ONCE
