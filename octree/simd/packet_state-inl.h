// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_PACKET_STATE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_PACKET_STATE_INL_H
#undef ALIDADE_SIMD_PACKET_STATE_INL_H
#else
#define ALIDADE_SIMD_PACKET_STATE_INL_H
#endif

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>

#include "octree/simd/leaf_group_test-inl.h"
#include "octree/simd/ray_state.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

using DoubleLanes = hn::CappedTag<double, 8>;

/// float_above(), float_below() for lanes.
template <class D>
HWY_INLINE hn::Vec<hn::Rebind<float, D>> demote_above(D, hn::Vec<D> value) {
  const hn::Rebind<float, D> d;
  const auto f = hn::DemoteTo(d, value);
  return hn::Add(hn::MulAdd(hn::Abs(f), hn::Set(d, 0x1p-22f), f),
                 hn::Set(d, std::numeric_limits<float>::min()));
}
template <class D>
HWY_INLINE hn::Vec<hn::Rebind<float, D>> demote_below(D d, hn::Vec<D> value) {
  return hn::Neg(demote_above(d, hn::Neg(value)));
}

/// Where a ray passes a point, in lanes.
struct LaneProjection {
  hn::Vec<DoubleLanes> t, distance, entry;
};

/// Rays as columns, world.
struct GatheredRays {
  static constexpr std::size_t k_size = 64, k_most_lanes = 16;

  std::size_t count = 0;
  alignas(64) double origin[3][k_size], direction[3][k_size];
  alignas(64) double t_min[k_size], t_max[k_size];

  /// numbers: of at most k_size rays, at least one. Lanes up to the next multiple of k_most_lanes, whose end
  /// it returns, hold the last ray.
  std::size_t gather(std::span<const Ray> rays, std::span<const std::uint32_t> numbers) {
    count = numbers.size();
    const std::size_t lanes = (count + k_most_lanes - 1) / k_most_lanes * k_most_lanes;
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const Ray& ray = rays[numbers[std::min(lane, count - 1)]];
      for (int axis = 0; axis < 3; ++axis) {
        origin[axis][lane] = ray.origin[axis];
        direction[axis][lane] = ray.direction[axis];
      }
      t_min[lane] = ray.t_min;
      t_max[lane] = ray.t_max;
    }
    return lanes;
  }

  /// The operations of evaluate() (octree/candidate.h) for points with these radii, in their order, so that
  /// the numbers are the same bits. t and entry count in the world, also of a packet's rays.
  HWY_INLINE LaneProjection project(std::size_t lane, hn::Vec<DoubleLanes> point_x,
                                    hn::Vec<DoubleLanes> point_y, hn::Vec<DoubleLanes> point_z,
                                    hn::Vec<DoubleLanes> radius) const {
    const DoubleLanes d;
    const auto x = hn::Sub(point_x, hn::Load(d, origin[0] + lane)),
               y = hn::Sub(point_y, hn::Load(d, origin[1] + lane)),
               z = hn::Sub(point_z, hn::Load(d, origin[2] + lane));
    const auto dx = hn::Load(d, direction[0] + lane), dy = hn::Load(d, direction[1] + lane),
               dz = hn::Load(d, direction[2] + lane);
    const auto cross_x = hn::Sub(hn::Mul(y, dz), hn::Mul(z, dy)),
               cross_y = hn::Sub(hn::Mul(z, dx), hn::Mul(x, dz)),
               cross_z = hn::Sub(hn::Mul(x, dy), hn::Mul(y, dx));
    const auto t = hn::Add(hn::Add(hn::Mul(x, dx), hn::Mul(y, dy)), hn::Mul(z, dz));
    const auto distance = hn::Sqrt(
        hn::Add(hn::Add(hn::Mul(cross_x, cross_x), hn::Mul(cross_y, cross_y)), hn::Mul(cross_z, cross_z)));
    const auto half_chord_sq = hn::Sub(hn::Mul(radius, radius), hn::Mul(distance, distance));
    return {t, distance, hn::Sub(t, hn::Sqrt(hn::Max(half_chord_sq, hn::Zero(d))))};
  }
};

/// Rays of a packet, a column each. All of one octant; numbers marked as mirrored have their signs changed on
/// the axes along which the rays go down. Once they are loaded, t_min and t_max are local t, within k_far.
struct PacketRays : GatheredRays {
  static constexpr std::size_t k_lanes = hn::MaxLanes(RayLanes());

  unsigned groups = 0;         ///< bit per vector of floats: some ray of it goes through the tree
  std::uint64_t far_away = 0;  ///< rays that need a QuerySetup of their own; they do not go through the tree

  alignas(64) double shift[k_size];  ///< t = local t + shift; nothing that ends before local t = 0 counts
  // Local t, within k_far.
  alignas(64) float limit_low[k_size];   ///< not below t_min nor entry_min
  alignas(64) float limit_high[k_size];  ///< not above t_max
  alignas(64) float t_cut[k_size];  ///< nothing that begins after counts; -infinity of rays that are done
  /// What boxes need of a vector of rays, side by side. t of a face at x is x * inverse - origin_t, all
  /// mirrored.
  struct Boxes {
    alignas(64) float inverse[3][k_lanes], origin_t[3][k_lanes];
    alignas(64) float cut[k_lanes];  ///< t_cut of the rays that are active at a node, -infinity of others
  };
  Boxes boxes[k_size / k_lanes];
  alignas(64) float along[3][k_size];  ///< direction
  /// How far along the ray local t = 0 is from the foot of the setup's corner.
  alignas(64) float start[k_size];
  // Of all rays that go through the tree, from the setup's corner, metres, mirrored.
  float origin_min[3], origin_max[3], inverse_min[3], inverse_max[3];

  /// numbers: of at most k_size rays, at least one.
  void load(std::span<const Ray> rays, std::span<const std::uint32_t> numbers, unsigned octant,
            const QuerySetup& setup) {
    const std::size_t lanes = gather(rays, numbers);
    far_away = 0;
    const DoubleLanes d;
    Extremes extremes;
    for (std::size_t lane = 0; lane < lanes; lane += hn::Lanes(d)) set_up(lane, octant, setup, extremes);
    for (int axis = 0; axis < 3; ++axis) {
      origin_min[axis] = float_below(hn::GetLane(hn::MinOfLanes(d, extremes.origin_min[axis])));
      origin_max[axis] = float_above(hn::GetLane(hn::MaxOfLanes(d, extremes.origin_max[axis])));
      inverse_min[axis] = static_cast<float>(hn::GetLane(hn::MinOfLanes(d, extremes.inverse_min[axis])));
      inverse_max[axis] = static_cast<float>(hn::GetLane(hn::MaxOfLanes(d, extremes.inverse_max[axis])));
    }
    const RayLanes all;
    groups = 0;
    for (std::size_t lane = 0; lane < lanes; lane += hn::Lanes(all))
      if (!hn::AllFalse(all, hn::Ge(hn::Load(all, t_cut + lane), hn::Zero(all))))
        groups |= 1u << (lane / hn::Lanes(all));
  }

  /// An upper limit of local t of the points in a box. far: its last corner, widened, from the setup's
  /// corner, mirrored; widening: by which it is widened beside what covers the rounding.
  HWY_INLINE RayVector last_projection(std::size_t first, const float (&far)[3], float widening) const {
    const RayLanes d;
    auto t = hn::Neg(hn::Load(d, start + first));
    for (int axis = 0; axis < 3; ++axis)
      t = hn::MulAdd(hn::Abs(hn::Load(d, along[axis] + first)), hn::Set(d, far[axis] - widening), t);
    return t;
  }

 private:
  struct Extremes {
    hn::Vec<DoubleLanes> origin_min[3], origin_max[3], inverse_min[3], inverse_max[3];
    Extremes() {
      const DoubleLanes d;
      for (int axis = 0; axis < 3; ++axis) {
        origin_min[axis] = inverse_min[axis] = hn::Set(d, k_far);
        origin_max[axis] = hn::Set(d, -k_far);
        inverse_max[axis] = hn::Zero(d);
      }
    }
  };

  /// What set_up() of tracer-inl.h does, for several rays.
  HWY_INLINE void set_up(std::size_t lane, unsigned octant, const QuerySetup& setup, Extremes& extremes) {
    const DoubleLanes d;
    const hn::Rebind<float, DoubleLanes> floats;
    using V = hn::Vec<DoubleLanes>;
    const auto infinity = hn::Set(d, std::numeric_limits<double>::infinity());
    V enter = hn::Neg(infinity), leave = infinity, way = hn::Zero(d), inverses[3];
    for (int axis = 0; axis < 3; ++axis) {
      const V o = hn::Load(d, origin[axis] + lane);
      const V below = hn::Sub(hn::Set(d, setup.tree.extent.low[axis] - setup.box_radius), o),
              above = hn::Sub(hn::Set(d, setup.tree.extent.high[axis] + setup.box_radius), o);
      inverses[axis] =
          hn::Div(hn::Set(d, 1.0), hn::Max(hn::Abs(hn::Load(d, direction[axis] + lane)), hn::Set(d, 1e-12)));
      way = hn::Add(way, hn::Max(hn::Abs(below), hn::Abs(above)));
      const bool down = (octant >> axis & 1) != 0;
      enter = hn::Max(enter, hn::Mul(down ? hn::Neg(above) : below, inverses[axis]));
      leave = hn::Min(leave, hn::Mul(down ? hn::Neg(below) : above, inverses[axis]));
    }
    const V world_min = hn::Load(d, t_min + lane), world_max = hn::Load(d, t_max + lane);
    const V entry_min = hn::Set(d, setup.query.entry_min);
    const V first = hn::Max(enter, hn::Sub(hn::Max(world_min, entry_min), hn::Set(d, setup.before_limits())));
    const auto is_ray = hn::FirstN(d, count > lane ? count - lane : 0);
    auto is_far = hn::And(is_ray, hn::Gt(way, hn::Set(d, setup.longest_way)));
    auto comes_near = hn::And(hn::AndNot(is_far, is_ray), hn::Le(first, leave));
    V begin = hn::IfThenElseZero(comes_near, first), from[3];
    for (int axis = 0; axis < 3; ++axis) {
      from[axis] = hn::MulAdd(begin, hn::Load(d, direction[axis] + lane),
                              hn::Sub(hn::Load(d, origin[axis] + lane), hn::Set(d, setup.corner[axis])));
      is_far =
          hn::Or(is_far, hn::And(comes_near, hn::Gt(hn::Abs(from[axis]), hn::Set(d, setup.longest_origin))));
    }
    comes_near = hn::AndNot(is_far, comes_near);
    const auto local = [&](V t) {
      return hn::Min(hn::Max(hn::Sub(t, begin), hn::Set(d, -k_far)), hn::Set(d, k_far));
    };
    const V local_min = local(world_min), local_max = local(world_max);
    const auto cut = demote_above(d, hn::Add(local_max, hn::Set(d, setup.double_error)));
    // Floats, since their masks are of another kind on some machines.
    const auto is_live = hn::Ge(
        hn::DemoteTo(floats, hn::IfThenElse(comes_near, hn::Zero(d), hn::Set(d, -1.0))), hn::Zero(floats));
    hn::Store(begin, d, shift + lane);
    hn::Store(local_min, d, t_min + lane);
    hn::Store(local_max, d, t_max + lane);
    hn::Store(demote_above(d, hn::Max(local_min, local(entry_min))), floats, limit_low + lane);
    hn::Store(demote_below(d, local_max), floats, limit_high + lane);
    const auto lives = hn::And(is_live, hn::Ge(cut, hn::Zero(floats)));
    hn::Store(hn::IfThenElse(lives, cut, hn::Set(floats, -std::numeric_limits<float>::infinity())), floats,
              t_cut + lane);
    V start_along = hn::Zero(d);
    for (int axis = 0; axis < 3; ++axis) {
      const V to = hn::Load(d, direction[axis] + lane);
      start_along = hn::MulAdd(from[axis], to, start_along);
      const V mirrored = (octant >> axis & 1) != 0 ? hn::Neg(from[axis]) : from[axis];
      Boxes& group = boxes[lane / k_lanes];
      hn::Store(hn::DemoteTo(floats, inverses[axis]), floats, group.inverse[axis] + lane % k_lanes);
      hn::Store(hn::DemoteTo(floats, hn::Mul(mirrored, inverses[axis])), floats,
                group.origin_t[axis] + lane % k_lanes);
      hn::Store(hn::DemoteTo(floats, to), floats, along[axis] + lane);
      extremes.origin_min[axis] =
          hn::Min(extremes.origin_min[axis], hn::IfThenElse(comes_near, mirrored, hn::Set(d, k_far)));
      extremes.origin_max[axis] =
          hn::Max(extremes.origin_max[axis], hn::IfThenElse(comes_near, mirrored, hn::Set(d, -k_far)));
      extremes.inverse_min[axis] =
          hn::Min(extremes.inverse_min[axis], hn::IfThenElse(comes_near, inverses[axis], hn::Set(d, k_far)));
      extremes.inverse_max[axis] =
          hn::Max(extremes.inverse_max[axis], hn::IfThenElseZero(comes_near, inverses[axis]));
    }
    hn::Store(hn::DemoteTo(floats, start_along), floats, this->start + lane);
    alignas(64) double flags[8];
    hn::Store(hn::IfThenElseZero(is_far, hn::Set(d, 1.0)), d, flags);
    for (std::size_t i = 0; i < hn::Lanes(d); ++i)
      if (flags[i] != 0.0) far_away |= std::uint64_t{1} << (lane + i);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
