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

/// A position as nodes and points are counted from, in units of a reach.
class Center {
 public:
  Center(const TreeView& tree, const glm::dvec3& position, double reach) : tree_(tree), reach_(reach) {
    const glm::dvec3 root_corner = to_world(tree.lattice, tree.base);
    for (int axis = 0; axis < 3; ++axis) {
      from_root_[axis] = position[axis] - root_corner[axis];
      scale_[axis] = static_cast<float>(tree.lattice.scale[axis] / reach);
    }
  }

  /// Of the lattice.
  const float* scale() const { return scale_; }

  /// The position from the corner of a frame.
  HWY_INLINE std::array<float, 3> from(const std::array<std::uint32_t, 3>& corner) const {
    std::array<float, 3> offset;
    for (int axis = 0; axis < 3; ++axis) {
      offset[axis] =
          static_cast<float>((from_root_[axis] - tree_.lattice.scale[axis] * corner[axis]) / reach_);
    }
    return offset;
  }

 private:
  const TreeView& tree_;
  const double reach_;
  double from_root_[3];  ///< metres
  float scale_[3];
};

/// Slots whose box is within reach of the box between two positions, given from the corner of the node's
/// frame; by rounding also some that are a little farther, but none is missed that has a point within reach.
HWY_INLINE unsigned near_slots(const Node& node, int level, const float* scale,
                               const std::array<float, 3>& box_low, const std::array<float, 3>& box_high) {
  constexpr float k_rounding = 0x1p-20f;
  const ChildLanes d;
  const auto grid_step = static_cast<float>(power_of_two(level - k_min_frame_level));
  const auto zero = hn::Zero(d);
  float margin = 1.0f;
  for (int axis = 0; axis < 3; ++axis) {
    margin = std::max(
        {margin, 256.0f * scale[axis] * grid_step, std::fabs(box_low[axis]), std::fabs(box_high[axis])});
  }
  const auto rounding = hn::Set(d, k_rounding * margin);
  unsigned near = 0;
  for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
    auto distance_sq = zero;
    for (int axis = 0; axis < 3; ++axis) {
      const auto step = hn::Set(d, scale[axis] * grid_step);
      const auto low = hn::Mul(load_as_float(d, node.low[axis] + lane), step);
      const auto high = hn::Mul(hn::Add(load_as_float(d, node.high[axis] + lane), hn::Set(d, 1.0f)), step);
      const auto before = hn::Sub(low, hn::Set(d, box_high[axis]));
      const auto behind = hn::Sub(hn::Set(d, box_low[axis]), high);
      const auto outside = hn::Max(hn::Sub(hn::Max(before, behind), rounding), zero);
      distance_sq = hn::Add(distance_sq, hn::Mul(outside, outside));
    }
    near |= mask_bits(d, hn::Lt(distance_sq, hn::Set(d, 1.0f))) << lane;
  }
  return near;
}

/// visit(frame, slots, leaves, offset): the nodes that have leaves within reach of the box between two
/// positions, those leaves as bits, and where the lower one lies from the frame's corner.
template <class Visit>
HWY_INLINE void walk(const TreeView& tree, const Center& low, const Center& high, const Visit& visit) {
  if (tree.node_count == 0) return;
  Frame waiting[k_max_tree_depth * k_node_width];
  std::size_t count = 0;
  waiting[count++] = root_frame(tree);
  while (count > 0) {
    const Frame frame = waiting[--count];
    const Node& node = tree.nodes[frame.node];
    const Slots slots(node);
    const auto offset = low.from(frame.corner);
    const unsigned near = near_slots(node, frame.level, low.scale(), offset, high.from(frame.corner));
    if ((near & slots.leaf) != 0) visit(frame, slots, near & slots.leaf, offset);
    for (unsigned inner = near & slots.inner; inner != 0; inner &= inner - 1)
      waiting[count++] = slots.child_in(node, frame, std::countr_zero(inner));
  }
}

/// Goes through the points of a ball.
class PointsOfBall {
 public:
  PointsOfBall(const TreeView& tree, const Ball& ball)
      : tree_(tree), nodes_(ball.nodes), center_(tree, ball.position, ball.reach) {}

  /// visit(part, x, y, z, closeness): a vector of points and 1 - |p|^2 of each, 0 of those that are not in
  /// the ball. Its lanes are the columns from part * k_lanes on.
  template <class Visit>
  HWY_INLINE void for_each(const Visit& visit) const {
    const auto visit_leaves = [&](const Frame& frame, const Slots& slots, unsigned leaves,
                                  const std::array<float, 3>& offset) {
      for (; leaves != 0; leaves &= leaves - 1) {
        const int slot = std::countr_zero(leaves);
        visit_leaf(slots.leaf_in(tree_.nodes[frame.node], frame, slot), offset, visit);
      }
    };
    if (nodes_ == nullptr) return walk(tree_, center_, center_, visit_leaves);
    for (const Frame& frame : *nodes_) {
      const Node& node = tree_.nodes[frame.node];
      const auto offset = center_.from(frame.corner);
      const Slots slots(node);
      visit_leaves(frame, slots, near_slots(node, frame.level, center_.scale(), offset, offset) & slots.leaf,
                   offset);
    }
  }

  static constexpr int k_columns = 16, k_lanes = hn::MaxLanes(PointLanes()), k_parts = k_columns / k_lanes;

 private:
  template <class Visit>
  HWY_INLINE void visit_leaf(const Leaf& leaf, const std::array<float, 3>& offset, const Visit& visit) const {
    const PointLanes d;
    if (tree_.positions && leaf.first >= tree_.first_exact) {
      const ExactSteps exact(tree_, leaf);
      visit_points(leaf.count, offset, visit,
                   [&](int axis, std::uint32_t first) { return hn::Load(d, exact.steps[axis] + first); });
      return;
    }
    const std::uint16_t* coordinates = tree_.coordinates + std::size_t{3} * leaf.first;
    visit_points(leaf.count, offset, visit, [&](int axis, std::uint32_t first) {
      return load_as_float(d, coordinates + axis * leaf.count + first);
    });
  }

  /// Of points whose 16-bit coordinates are not exact.
  struct ExactSteps {
    alignas(64) float steps[3][k_max_leaf_size + k_columns] = {};

    HWY_NOINLINE ExactSteps(const TreeView& tree, const Leaf& leaf) {
      for (std::uint32_t i = 0; i < leaf.count; ++i) {
        const LatticePosition position = position_of(tree, leaf, i);
        for (int axis = 0; axis < 3; ++axis)
          steps[axis][i] =
              static_cast<float>(static_cast<std::uint32_t>(position[axis]) -
                                 static_cast<std::uint32_t>(tree.base[axis]) - leaf.corner[axis]);
      }
    }
  };

  /// steps(axis, first): lattice steps from the frame's corner of a vector of points.
  template <class Visit, class Steps>
  HWY_INLINE void visit_points(std::uint32_t count, const std::array<float, 3>& offset, const Visit& visit,
                               const Steps& steps) const {
    const PointLanes d;
    const auto zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    for (std::uint32_t first = 0; first < count; first += k_lanes) {
      const auto on_axis = [&](int axis) {
        return hn::Sub(hn::Mul(steps(axis, first), hn::Set(d, center_.scale()[axis])),
                       hn::Set(d, offset[axis]));
      };
      const auto x = on_axis(0), y = on_axis(1), z = on_axis(2);
      const auto square = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
      const auto closeness =
          hn::IfThenElseZero(hn::FirstN(d, count - first), hn::Max(hn::Sub(one, square), zero));
      visit(static_cast<int>(first / k_lanes) % k_parts, x, y, z, closeness);
    }
  }

  const TreeView& tree_;
  const std::vector<Frame>* const nodes_;
  const Center center_;
};

HWY_INLINE PointVector height_above(const Level& level, PointVector x, PointVector y, PointVector z) {
  const PointLanes d;
  const glm::vec3& direction = level.direction;
  const auto along =
      hn::Add(hn::Add(hn::Mul(x, hn::Set(d, direction.x)), hn::Mul(y, hn::Set(d, direction.y))),
              hn::Mul(z, hn::Set(d, direction.z)));
  return hn::Sub(along, hn::Set(d, level.level));
}

/// Closeness of the points of a layer, 0 of the others.
HWY_INLINE PointVector in_layer(const Layer& layer, PointVector x, PointVector y, PointVector z,
                                PointVector closeness) {
  const PointLanes d;
  const auto height = hn::Abs(height_above(layer.level, x, y, z)), limit = hn::Set(d, layer.limit);
  return layer.side == Layer::Side::within ? hn::IfThenElseZero(hn::Le(height, limit), closeness)
                                           : hn::IfThenElseZero(hn::Gt(height, limit), closeness);
}

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
  const Level& level;

  template <class Add>
  HWY_INLINE void add(PointVector x, PointVector y, PointVector z, PointVector closeness,
                      const Add& sum) const {
    const auto height = height_above(level, x, y, z);
    auto term = hn::Mul(closeness, closeness);
    for (int row = 0; row < k_rows; ++row) {
      sum(row, term);
      term = hn::Mul(term, height);
    }
  }
};

/// Adds up terms of points in columns.
template <class Terms>
class Sums {
 public:
  explicit Sums(const Terms& terms) : terms_(terms) {
    const PointLanes d;
    for (auto& row : sums_)
      for (auto& part : row) part = hn::Zero(d);
  }

  HWY_INLINE void add(int part, PointVector x, PointVector y, PointVector z, PointVector closeness) {
    terms_.add(x, y, z, closeness,
               [&](int row, PointVector value) { sums_[row][part] = hn::Add(sums_[row][part], value); });
  }

  std::array<float, Terms::k_rows> totals() const {
    const PointLanes d;
    std::array<float, Terms::k_rows> totals{};
    for (int row = 0; row < Terms::k_rows; ++row) {
      alignas(64) float columns[PointsOfBall::k_columns];
      for (int part = 0; part < PointsOfBall::k_parts; ++part)
        hn::Store(sums_[row][part], d, columns + part * PointsOfBall::k_lanes);
      for (const float column : columns) totals[row] += column;
    }
    return totals;
  }

 private:
  const Terms terms_;
  PointVector sums_[Terms::k_rows][PointsOfBall::k_parts];
};

Moments moments_of(const Sums<MomentTerms>& sums) {
  const auto totals = sums.totals();
  Moments moments{totals[0], totals[1], {}, {}};
  std::copy_n(totals.begin() + 2, 3, moments.first.begin());
  std::copy_n(totals.begin() + 5, 6, moments.second.begin());
  return moments;
}

void find_nodes(const TreeView& tree, const Bounds& box, double reach, std::vector<Frame>& nodes) {
  nodes.clear();
  walk(tree, Center(tree, box.min, reach), Center(tree, box.max, reach),
       [&](const Frame& frame, const auto&...) { nodes.push_back(frame); });
}

Moments around(const TreeView& tree, const Ball& ball) {
  Sums sums(MomentTerms{});
  PointsOfBall(tree, ball)
      .for_each([&](int part, PointVector x, PointVector y, PointVector z, PointVector closeness) {
        sums.add(part, x, y, z, closeness);
      });
  return moments_of(sums);
}

Moments of_layer(const TreeView& tree, const Ball& ball, const Layer& layer) {
  Sums sums(MomentTerms{});
  PointsOfBall(tree, ball)
      .for_each([&](int part, PointVector x, PointVector y, PointVector z, PointVector closeness) {
        sums.add(part, x, y, z, in_layer(layer, x, y, z, closeness));
      });
  return moments_of(sums);
}

HeightSums heights(const TreeView& tree, const Ball& ball, const Level& level) {
  Sums sums(HeightTerms{level});
  PointsOfBall(tree, ball)
      .for_each([&](int part, PointVector x, PointVector y, PointVector z, PointVector closeness) {
        sums.add(part, x, y, z, closeness);
      });
  const auto totals = sums.totals();
  HeightSums heights{totals[0], {}};
  std::copy_n(totals.begin() + 1, 4, heights.powers.begin());
  return heights;
}

/// Lets points lengthen the extents of a fan.
class FanExtents {
 public:
  explicit FanExtents(const Fan& fan) : fan_(fan) {
    for (int i = 0; i < k_directions; ++i) {
      x_[i] = fan.directions[i].x;
      y_[i] = fan.directions[i].y;
    }
  }

  HWY_INLINE void add(PointVector x, PointVector y, PointVector z, PointVector closeness) {
    const PointLanes d;
    alignas(64) float across[2][PointsOfBall::k_columns];
    hn::Store(height_above({fan_.first_axis, 0.0f}, x, y, z), d, across[0]);
    hn::Store(height_above({fan_.second_axis, 0.0f}, x, y, z), d, across[1]);
    for (unsigned in = mask_bits(d, hn::Gt(closeness, hn::Zero(d))); in != 0; in &= in - 1)
      add_point(across[0][std::countr_zero(in)], across[1][std::countr_zero(in)]);
  }

  Extents extents() const {
    Extents extents;
    std::copy_n(extents_, k_directions, extents.begin());
    return extents;
  }

 private:
  HWY_INLINE void add_point(float first, float second) {
    const PointLanes d;
    const auto u = hn::Set(d, first), v = hn::Set(d, second), half_width = hn::Set(d, fan_.half_width);
    for (int i = 0; i < k_directions; i += PointsOfBall::k_lanes) {
      const auto x = hn::Load(d, x_ + i), y = hn::Load(d, y_ + i), extent = hn::Load(d, extents_ + i);
      const auto beside = hn::Abs(hn::Sub(hn::Mul(u, y), hn::Mul(v, x)));
      const auto along = hn::Add(hn::Mul(u, x), hn::Mul(v, y));
      const auto counts = hn::And(hn::Lt(beside, half_width), hn::Gt(along, extent));
      hn::Store(hn::IfThenElse(counts, along, extent), d, extents_ + i);
    }
  }

  const Fan& fan_;
  alignas(64) float x_[k_directions];
  alignas(64) float y_[k_directions];
  alignas(64) float extents_[k_directions] = {};
};

Extents extents(const TreeView& tree, const Ball& ball, const Layer& layer, const Fan& fan) {
  FanExtents made(fan);
  PointsOfBall(tree, ball)
      .for_each([&](int, PointVector x, PointVector y, PointVector z, PointVector closeness) {
        made.add(x, y, z, in_layer(layer, x, y, z, closeness));
      });
  return made.extents();
}

constexpr LocalSums k_local_sums{find_nodes, around, of_layer, heights, extents};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alidade::simd {

const LocalSums& local_sums(InstructionSet instruction_set) {
  ALIDADE_CHOOSE_TABLE(instruction_set, k_local_sums)
}

}  // namespace alidade::simd
#endif  // HWY_ONCE
