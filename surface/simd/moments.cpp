// SPDX-License-Identifier: MIT
#include "surface/simd/moments.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "surface/simd/moments.cpp"
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

constexpr int k_columns = 16, k_lanes = hn::MaxLanes(PointLanes()), k_parts = k_columns / k_lanes;

/// Gathers the points of a ball, and calls use() with one full block of them after another and with the rest;
/// use() returns false to end.
template <class Use>
class Gatherer {
 public:
  Gatherer(const TreeView& tree, const Ball& ball, BallPoints& points, const Use& use)
      : tree_(tree), center_(tree, ball.position, ball.reach), points_(points), use_(use) {
    points.count = 0;
    const auto visit_leaves = [&](const Frame& frame, const Slots& slots, unsigned leaves,
                                  const std::array<float, 3>& offset) {
      for (; leaves != 0 && !has_ended_; leaves &= leaves - 1) {
        const int slot = std::countr_zero(leaves);
        add_leaf(slots.leaf_in(tree.nodes[frame.node], frame, slot), offset);
        if (points_.count >= BallPoints::k_most_in_block) use_block();
      }
    };
    if (ball.nodes == nullptr) {
      walk(tree, center_, center_, visit_leaves);
    } else {
      for (const Frame& frame : *ball.nodes) {
        if (has_ended_) return;
        const Node& node = tree.nodes[frame.node];
        const auto offset = center_.from(frame.corner);
        const Slots slots(node);
        visit_leaves(frame, slots,
                     near_slots(node, frame.level, center_.scale(), offset, offset) & slots.leaf, offset);
      }
    }
    if (has_ended_) return;
    reserve();
    const PointLanes d;
    for (std::size_t i = 0; i < k_columns; i += k_lanes) {
      for (std::vector<float>* column : {&points.x, &points.y, &points.z, &points.closeness})
        hn::StoreU(hn::Zero(d), d, column->data() + points.count + i);
    }
    use_();
  }

 private:
  /// What does not fill the block is put to the front of the next one, so that every point keeps its column.
  void use_block() {
    static_assert(BallPoints::k_most_in_block % k_columns == 0);
    const std::size_t rest = points_.count - BallPoints::k_most_in_block;
    points_.count = BallPoints::k_most_in_block;
    has_ended_ = !use_();
    if (has_ended_) return;
    for (std::vector<float>* column : {&points_.x, &points_.y, &points_.z, &points_.closeness})
      std::copy_n(column->data() + BallPoints::k_most_in_block, rest, column->data());
    points_.count = rest;
  }

  /// For a leaf and the zeros.
  void reserve() {
    const std::size_t room = points_.count + k_max_leaf_size + k_columns;
    if (points_.closeness.size() >= room) return;  // the last to grow
    for (std::vector<float>* column : {&points_.x, &points_.y, &points_.z, &points_.closeness})
      column->resize(2 * room);
  }

  HWY_INLINE void add_leaf(const Leaf& leaf, const std::array<float, 3>& offset) {
    const PointLanes d;
    reserve();
    if (tree_.positions && leaf.first >= tree_.first_exact) {
      const ExactSteps exact(tree_, leaf);
      add_points(leaf.count, offset,
                 [&](int axis, std::uint32_t first) { return hn::Load(d, exact.steps[axis] + first); });
      return;
    }
    const std::uint16_t* coordinates = tree_.coordinates + std::size_t{3} * leaf.first;
    add_points(leaf.count, offset, [&](int axis, std::uint32_t first) {
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
  template <class Steps>
  HWY_INLINE void add_points(std::uint32_t count, const std::array<float, 3>& offset, const Steps& steps) {
    const PointLanes d;
    const auto one = hn::Set(d, 1.0f);
    for (std::uint32_t first = 0; first < count; first += k_lanes) {
      const auto on_axis = [&](int axis) {
        return hn::Sub(hn::Mul(steps(axis, first), hn::Set(d, center_.scale()[axis])),
                       hn::Set(d, offset[axis]));
      };
      const auto x = on_axis(0), y = on_axis(1), z = on_axis(2);
      const auto square = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
      const auto closeness = hn::Sub(one, square);
      const auto is_in = hn::And(hn::Gt(closeness, hn::Zero(d)), hn::FirstN(d, count - first));
      if (hn::AllFalse(d, is_in)) continue;
      const Compressor compress(d, is_in);
      hn::StoreU(compress(x), d, points_.x.data() + points_.count);
      hn::StoreU(compress(y), d, points_.y.data() + points_.count);
      hn::StoreU(compress(z), d, points_.z.data() + points_.count);
      hn::StoreU(compress(closeness), d, points_.closeness.data() + points_.count);
      points_.count += compress.count();
    }
  }

  const TreeView& tree_;
  const Center center_;
  BallPoints& points_;
  const Use& use_;
  bool has_ended_ = false;
};

void gather(const TreeView& tree, const Ball& ball, BallPoints& points) {
  bool fits = true;
  points.tree = nullptr;
  const auto use = [&] {
    fits = points.count < BallPoints::k_most_in_block;
    return fits;
  };
  Gatherer(tree, ball, points, use);
  if (fits) return;
  points.tree = &tree;
  points.ball = ball;
}

/// visit(part, x, y, z, closeness): a vector of points, closeness 0 behind the last one. Its lanes are the
/// columns from part * k_lanes on.
template <class Visit>
HWY_INLINE void for_each_in_block(const BallPoints& points, const Visit& visit) {
  const PointLanes d;
  for (std::size_t first = 0; first < points.count; first += k_lanes) {
    visit(static_cast<int>(first / k_lanes) % k_parts, hn::LoadU(d, points.x.data() + first),
          hn::LoadU(d, points.y.data() + first), hn::LoadU(d, points.z.data() + first),
          hn::LoadU(d, points.closeness.data() + first));
  }
}

template <class Visit>
HWY_INLINE void for_each(const BallPoints& points, const Visit& visit) {
  if (points.tree == nullptr) return for_each_in_block(points, visit);
  BallPoints block;
  const auto use = [&] {
    for_each_in_block(block, visit);
    return true;
  };
  Gatherer(*points.tree, points.ball, block, use);
}

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
    std::array<float, Terms::k_rows> totals{};
    for (int row = 0; row < Terms::k_rows; ++row) totals[row] = total_of(sums_[row]);
    return totals;
  }

 private:
  /// The upper half of the columns is added to the lower one, until one is left.
  static HWY_INLINE float total_of(const PointVector (&parts)[k_parts]) {
    PointVector sums[k_parts];
    std::copy_n(parts, k_parts, sums);
    for (int width = k_parts / 2; width > 0; width /= 2)
      for (int part = 0; part < width; ++part) sums[part] = hn::Add(sums[part], sums[part + width]);
    return total_of(PointLanes(), sums[0]);
  }
#if HWY_TARGET == HWY_SCALAR
  static float total_of(PointLanes, PointVector sum) {
    return hn::GetLane(sum);
  }
#else
  template <class D>
  static HWY_INLINE float total_of(D d, hn::Vec<D> sum) {
    if constexpr (hn::MaxLanes(D()) > 4) {
      const hn::Half<D> half;
      return total_of(half, hn::Add(hn::LowerHalf(half, sum), hn::UpperHalf(half, sum)));
    } else {
      static_assert(hn::MaxLanes(D()) == 4);
      alignas(16) float columns[4];
      hn::Store(sum, d, columns);
      return (columns[0] + columns[2]) + (columns[1] + columns[3]);
    }
  }
#endif

  const Terms terms_;
  PointVector sums_[Terms::k_rows][k_parts];
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

Moments moments(const BallPoints& points) {
  Sums sums(MomentTerms{});
  for_each(points, [&](int part, PointVector x, PointVector y, PointVector z, PointVector closeness) {
    sums.add(part, x, y, z, closeness);
  });
  return moments_of(sums);
}

Moments of_layer(const BallPoints& points, const Layer& layer) {
  Sums sums(MomentTerms{});
  for_each(points, [&](int part, PointVector x, PointVector y, PointVector z, PointVector closeness) {
    sums.add(part, x, y, z, in_layer(layer, x, y, z, closeness));
  });
  return moments_of(sums);
}

HeightSums heights(const BallPoints& points, const Level& level) {
  Sums sums(HeightTerms{level});
  for_each(points, [&](int part, PointVector x, PointVector y, PointVector z, PointVector closeness) {
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
    for (int i = 0; i < packed_surface::k_edge_directions; ++i) {
      x_[i] = fan.directions[i].x;
      y_[i] = fan.directions[i].y;
    }
  }

  HWY_INLINE void add(PointVector x, PointVector y, PointVector z, PointVector closeness) {
    const PointLanes d;
    alignas(64) float across[2][k_columns];
    hn::Store(height_above({fan_.first_axis, 0.0f}, x, y, z), d, across[0]);
    hn::Store(height_above({fan_.second_axis, 0.0f}, x, y, z), d, across[1]);
    for (unsigned in = mask_bits(d, hn::Gt(closeness, hn::Zero(d))); in != 0; in &= in - 1)
      add_point(across[0][std::countr_zero(in)], across[1][std::countr_zero(in)]);
  }

  Extents extents() const {
    Extents extents;
    std::copy_n(extents_, packed_surface::k_edge_directions, extents.begin());
    return extents;
  }

 private:
  HWY_INLINE void add_point(float first, float second) {
    const PointLanes d;
    const auto u = hn::Set(d, first), v = hn::Set(d, second), half_width = hn::Set(d, fan_.half_width);
    for (int i = 0; i < packed_surface::k_edge_directions; i += k_lanes) {
      const auto x = hn::Load(d, x_ + i), y = hn::Load(d, y_ + i), extent = hn::Load(d, extents_ + i);
      const auto beside = hn::Abs(hn::Sub(hn::Mul(u, y), hn::Mul(v, x)));
      const auto along = hn::Add(hn::Mul(u, x), hn::Mul(v, y));
      const auto counts = hn::And(hn::Lt(beside, half_width), hn::Gt(along, extent));
      hn::Store(hn::IfThenElse(counts, along, extent), d, extents_ + i);
    }
  }

  const Fan& fan_;
  alignas(64) float x_[packed_surface::k_edge_directions];
  alignas(64) float y_[packed_surface::k_edge_directions];
  alignas(64) float extents_[packed_surface::k_edge_directions] = {};
};

Extents extents(const BallPoints& points, const Layer& layer, const Fan& fan) {
  FanExtents made(fan);
  for_each(points, [&](int, PointVector x, PointVector y, PointVector z, PointVector closeness) {
    made.add(x, y, z, in_layer(layer, x, y, z, closeness));
  });
  return made.extents();
}

constexpr LocalSums k_local_sums{find_nodes, gather, moments, of_layer, heights, extents};

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
