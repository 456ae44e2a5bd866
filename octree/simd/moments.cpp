// SPDX-License-Identifier: MIT
#include "octree/simd/moments.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octree/simd/moments.cpp"
#include <hwy/foreach_target.h>

#include "cloud/lattice.h"
#include "octree/simd/box_test-inl.h"
#include "octree/simd/choose_table.h"
#include "octree/tree_walk.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

using PointVector = hn::Vec<PointLanes>;

/// What is added up for Moments.
struct MomentTerms {
  static constexpr int k_rows = 11;

  template <class Add>
  HWY_INLINE void add(PointVector x, PointVector y, PointVector z, PointVector closeness,
                      const Add& sum) const {
    const PointLanes d;
    const auto weight = hn::Mul(closeness, closeness);
    const auto wx = hn::Mul(weight, x), wy = hn::Mul(weight, y), wz = hn::Mul(weight, z);
    sum(0, weight);
    sum(1, hn::IfThenElseZero(hn::Gt(closeness, hn::Zero(d)), hn::Set(d, 1.0f)));
    sum(2, wx);
    sum(3, wy);
    sum(4, wz);
    sum(5, hn::Mul(wx, x));
    sum(6, hn::Mul(wx, y));
    sum(7, hn::Mul(wx, z));
    sum(8, hn::Mul(wy, y));
    sum(9, hn::Mul(wy, z));
    sum(10, hn::Mul(wz, z));
  }
};

/// What is added up for HeightSums.
struct HeightTerms {
  static constexpr int k_rows = 5;
  glm::vec3 direction;
  float level;

  template <class Add>
  HWY_INLINE void add(PointVector x, PointVector y, PointVector z, PointVector closeness,
                      const Add& sum) const {
    const PointLanes d;
    const auto along =
        hn::Add(hn::Add(hn::Mul(x, hn::Set(d, direction.x)), hn::Mul(y, hn::Set(d, direction.y))),
                hn::Mul(z, hn::Set(d, direction.z)));
    const auto height = hn::Sub(along, hn::Set(d, level));
    auto term = hn::Mul(closeness, closeness);
    for (int row = 0; row < k_rows; ++row) {
      sum(row, term);
      term = hn::Mul(term, height);
    }
  }
};

/// Adds up terms of the points around one position.
template <class Terms>
class SumsAround {
 public:
  SumsAround(const TreeView& tree, const glm::dvec3& index, double reach, const Terms& terms)
      : tree_(tree), reach_(reach), terms_(terms) {
    const glm::dvec3 root_corner = to_world(tree.lattice, tree.base);
    for (int axis = 0; axis < 3; ++axis) {
      index_[axis] = index[axis] - root_corner[axis];
      scale_[axis] = static_cast<float>(tree.lattice.scale[axis] / reach);
    }
    const PointLanes d;
    for (auto& row : sums_)
      for (auto& part : row) part = hn::Zero(d);
  }

  void run() {
    Frame waiting[k_max_tree_depth * k_node_width];
    std::size_t count = 0;
    waiting[count++] = root_frame(tree_);
    while (count > 0) {
      const Frame frame = waiting[--count];
      const Node& node = tree_.nodes[frame.node];
      const Slots slots(node);
      float index[3];
      local_index(frame.corner, index);
      for (unsigned near = near_slots(node, frame.level, index) & (slots.inner | slots.leaf); near != 0;
           near &= near - 1) {
        const int slot = std::countr_zero(near);
        if ((slots.inner >> slot & 1u) != 0) {
          waiting[count++] = slots.child_in(node, frame, slot);
        } else {
          add_leaf(slots.leaf_in(node, frame, slot), index);
        }
      }
    }
  }

  std::array<float, Terms::k_rows> totals() const {
    const PointLanes d;
    std::array<float, Terms::k_rows> totals{};
    for (int row = 0; row < Terms::k_rows; ++row) {
      alignas(64) float columns[k_columns];
      for (int part = 0; part < k_parts; ++part) hn::Store(sums_[row][part], d, columns + part * k_lanes);
      for (const float column : columns) totals[row] += column;
    }
    return totals;
  }

 private:
  static constexpr int k_columns = 16, k_lanes = hn::MaxLanes(PointLanes()), k_parts = k_columns / k_lanes;

  /// The position from the corner of a frame, in units of the reach.
  void local_index(const std::array<std::uint32_t, 3>& corner, float* index) const {
    for (int axis = 0; axis < 3; ++axis)
      index[axis] = static_cast<float>((index_[axis] - tree_.lattice.scale[axis] * corner[axis]) / reach_);
  }

  /// Slots whose box is within reach.
  unsigned near_slots(const Node& node, int level, const float* index) const {
    const ChildLanes d;
    const auto grid_step = static_cast<float>(power_of_two(level - k_min_frame_level));
    const auto zero = hn::Zero(d);
    unsigned near = 0;
    for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
      auto distance_sq = zero;
      for (int axis = 0; axis < 3; ++axis) {
        const auto step = hn::Set(d, scale_[axis] * grid_step), from = hn::Set(d, index[axis]);
        const auto low = hn::Sub(hn::Mul(load_as_float(d, node.low[axis] + lane), step), from);
        const auto high =
            hn::Sub(hn::Mul(hn::Add(load_as_float(d, node.high[axis] + lane), hn::Set(d, 1.0f)), step), from);
        const auto outside = hn::Max(hn::Max(low, hn::Neg(high)), zero);
        distance_sq = hn::Add(distance_sq, hn::Mul(outside, outside));
      }
      near |= mask_bits(d, hn::Lt(distance_sq, hn::Set(d, 1.0f))) << lane;
    }
    return near;
  }

  void add_leaf(const Leaf& leaf, const float* index) {
    if (tree_.positions && leaf.first >= tree_.first_exact) {
      add_exact(leaf, index);
      return;
    }
    const std::uint16_t* coordinates = tree_.coordinates + std::size_t{3} * leaf.first;
    add_points(leaf.count, index, [&](int axis, std::uint32_t first) {
      return load_as_float(PointLanes(), coordinates + axis * leaf.count + first);
    });
  }

  /// Points whose 16-bit coordinates are not exact.
  void add_exact(const Leaf& leaf, const float* index) {
    alignas(64) float steps[3][k_max_leaf_size + k_columns] = {};
    for (std::uint32_t i = 0; i < leaf.count; ++i) {
      const LatticePosition position = position_of(tree_, leaf, i);
      for (int axis = 0; axis < 3; ++axis)
        steps[axis][i] = static_cast<float>(static_cast<std::uint32_t>(position[axis]) -
                                            static_cast<std::uint32_t>(tree_.base[axis]) - leaf.corner[axis]);
    }
    add_points(leaf.count, index,
               [&](int axis, std::uint32_t first) { return hn::Load(PointLanes(), steps[axis] + first); });
  }

  /// steps(axis, first): lattice steps from the frame's corner of a vector of points.
  template <class Steps>
  HWY_INLINE void add_points(std::uint32_t count, const float* index, const Steps& steps) {
    const PointLanes d;
    const auto zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    for (std::uint32_t first = 0; first < count; first += k_lanes) {
      const auto offset = [&](int axis) {
        return hn::Sub(hn::Mul(steps(axis, first), hn::Set(d, scale_[axis])), hn::Set(d, index[axis]));
      };
      const auto x = offset(0), y = offset(1), z = offset(2);
      const auto square = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
      const auto closeness =
          hn::IfThenElseZero(hn::FirstN(d, count - first), hn::Max(hn::Sub(one, square), zero));
      const int part = static_cast<int>(first / k_lanes) % k_parts;
      terms_.add(x, y, z, closeness,
                 [&](int row, PointVector value) { sums_[row][part] = hn::Add(sums_[row][part], value); });
    }
  }

  const TreeView& tree_;
  const double reach_;
  const Terms terms_;
  double index_[3];  ///< from the root's corner, metres
  float scale_[3];   ///< of the lattice, in units of the reach
  PointVector sums_[Terms::k_rows][k_parts];
};

template <class Terms>
std::array<float, Terms::k_rows> sums_around(const TreeView& tree, const glm::dvec3& index, double reach,
                                             const Terms& terms) {
  if (tree.node_count == 0) return {};
  SumsAround<Terms> sums(tree, index, reach, terms);
  sums.run();
  return sums.totals();
}

Moments around(const TreeView& tree, const glm::dvec3& index, double reach) {
  const auto totals = sums_around(tree, index, reach, MomentTerms{});
  Moments moments{totals[0], totals[1], {}, {}};
  std::copy_n(totals.begin() + 2, 3, moments.first.begin());
  std::copy_n(totals.begin() + 5, 6, moments.second.begin());
  return moments;
}

HeightSums heights(const TreeView& tree, const glm::dvec3& index, double reach, const glm::vec3& direction,
                   float level) {
  const auto totals = sums_around(tree, index, reach, HeightTerms{direction, level});
  HeightSums sums{totals[0], {}};
  std::copy_n(totals.begin() + 1, 4, sums.powers.begin());
  return sums;
}

constexpr MomentSums k_moment_sums{around, heights};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alidade::simd {

const MomentSums& moment_sums(InstructionSet instruction_set) {
  ALIDADE_CHOOSE_TABLE(instruction_set, k_moment_sums)
}

}  // namespace alidade::simd
#endif  // HWY_ONCE
