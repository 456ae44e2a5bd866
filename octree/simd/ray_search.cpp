// SPDX-License-Identifier: MIT
#include "octree/simd/search.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octree/simd/ray_search.cpp"
#include <hwy/foreach_target.h>

#include "octree/query_targets.h"
#include "octree/simd/choose_table.h"
#include "octree/simd/nearest_first-inl.h"
#include "octree/simd/ray_state.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// Distances to a ray's line and lengths along it, for NearestFirst. Bounds are squares of distances for
/// Measure::distance, otherwise the measure itself, counted from LineFromRoot::shift.
///
/// Everything is relative to the foot of the perpendicular from the corner of a node's frame on the line:
/// with W the frame's width and D the length of the perpendicular, all numbers stay below 1.8 W + D however
/// far the ray begins. `error` exceeds what can go wrong between floats and the double numbers that decide,
/// in units of 2^-24:
/// - a coordinate: rounding of scale, foot and their difference, for centres and half sides of boxes twice:
///   3 W + 2 D;
/// - t, a sum of three products with components of the direction, whatever these are: three times 1.8 W + D
///   for their rounding, 5.2 W + 3.5 D from the coordinates; together 11 W + 7 D;
/// - a component of the cross product with a box, two products: the same rounding, 4.3 W + 2.9 D from
///   coordinates and 3 W from half sides; together 13 W + 6 D, and 1.8 times that for their norm;
/// - the part of a point across the line, coordinate - t * component: with t's error below 16 W + 10 D per
///   axis, but along the line, so the norm stays below 28 W + 18 D.
/// The budget is 64 (W + D). In double: 2^-48 (largest coordinate or offset + way), `way` that from the ray's
/// origin to the far end of the points. Squares out of the range of floats: 1e-18.
/// Boxes are widened by `error`; for the rounding of squares and sums, `limit` and k_up allow.
template <Measure measure>
class RayKernel {
 public:
  struct Local {
    float foot[3];
    float error;
    float t_error;  ///< of t counted from the shift
    float t;        ///< of the foot
  };

  RayKernel(const TreeView& tree, const LineFromRoot& line, const Ray& ray, const RayQuery& query,
            bool in_double)
      : tree_(tree), line_(line), all_in_double_(in_double), has_entry_min_(query.entry_min > -infinity()) {
    for (int axis = 0; axis < 3; ++axis) {
      float_scale_[axis] = static_cast<float>(tree.lattice.scale[axis]);
      direction_[axis] = static_cast<float>(line.direction[axis]);
      widest_scale_ = std::max(widest_scale_, tree.lattice.scale[axis]);
    }
    const bool unlimited = std::isinf(query.radius);
    radius_ = unlimited ? infinity() : at_least(query.radius);
    inner_radius_ = unlimited ? infinity() : at_most(query.radius);
    if (!unlimited && (measure == Measure::entry || has_entry_min_)) chord_error_ = 0x1p-20 * query.radius;
    // A sphere is never entered behind the projection of its centre.
    t_low_ = at_most(std::max(ray.t_min, query.entry_min) - line.shift - line.error);
    t_high_ = at_least(ray.t_max - line.shift + line.error);
    sure_t_low_ = at_least(ray.t_min - line.shift + line.error);
    sure_t_high_ = at_most(ray.t_max - line.shift - line.error);
    entry_min_ = at_least(query.entry_min - line.shift + line.error);
  }

  HWY_INLINE Local at(const std::array<std::uint32_t, 3>& corner, int level) const {
    double from_corner[3], foot[3], away = 0.0;
    for (int axis = 0; axis < 3; ++axis)
      from_corner[axis] = line_.origin[axis] - tree_.lattice.scale[axis] * corner[axis];
    const double t = -(from_corner[0] * line_.direction[0] + from_corner[1] * line_.direction[1] +
                       from_corner[2] * line_.direction[2]);
    Local local;
    for (int axis = 0; axis < 3; ++axis) {
      foot[axis] = from_corner[axis] + t * line_.direction[axis];
      away += std::fabs(foot[axis]);
      local.foot[axis] = static_cast<float>(foot[axis]);
    }
    const double reach = widest_scale_ * power_of_two(level) + away;
    local.error = static_cast<float>(line_.error + 0x1p-18 * reach) * k_up;
    local.t_error =
        static_cast<float>(line_.error + 0x1p-18 * reach + 0x1p-21 * std::fabs(t) + chord_error_) * k_up;
    local.t = static_cast<float>(t);
    return local;
  }

  HWY_INLINE float limit(float cut) const {
    if constexpr (measure != Measure::distance) return cut;
    const float distance = std::min(cut, radius_);
    return distance * distance * k_up;
  }

  template <bool tests_inside>
  HWY_INLINE void test_boxes(const Local& local, const Node& node, int level, float cut,
                             TestedBoxes& boxes) const {
    const ChildLanes d;
    using V = hn::Vec<ChildLanes>;
    const auto grid_step = static_cast<float>(power_of_two(level - k_min_frame_level));
    const auto zero = hn::Zero(d), error = hn::Set(d, local.error), t_error = hn::Set(d, local.t_error);
    const auto limit_sq = hn::Set(d, measure == Measure::distance ? limit(cut) : radius_ * radius_ * k_up);
    const float inner = std::max(inner_radius_ - local.error, 0.0f);
    for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
      V center[3], half[3];
      for (int axis = 0; axis < 3; ++axis) {
        const float step = float_scale_[axis] * grid_step;
        const auto low = load_as_float(d, node.low[axis] + lane),
                   high = load_as_float(d, node.high[axis] + lane);
        // `high` is inclusive: its points are up to one lattice step below the next grid step.
        const float last = 0.5f * (step - float_scale_[axis]);
        const auto half_step = hn::Set(d, 0.5f * step);
        center[axis] = hn::MulAdd(hn::Add(low, high), half_step, hn::Set(d, last - local.foot[axis]));
        half[axis] = hn::MulAdd(hn::Sub(high, low), half_step, hn::Set(d, last));
      }
      auto nearest_sq = zero, farthest_sq = zero;
      for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        const auto across = hn::Abs(
            hn::MulSub(center[u], hn::Set(d, direction_[v]), hn::Mul(center[v], hn::Set(d, direction_[u]))));
        const auto width = hn::MulAdd(half[u], hn::Set(d, std::fabs(direction_[v])),
                                      hn::MulAdd(half[v], hn::Set(d, std::fabs(direction_[u])), error));
        const auto gap = hn::Max(hn::Sub(across, width), zero);
        nearest_sq = hn::MulAdd(gap, gap, nearest_sq);
        if constexpr (tests_inside) {
          const auto reach = hn::Add(across, width);
          farthest_sq = hn::MulAdd(reach, reach, farthest_sq);
        }
      }
      const auto along = [&](const V* v, bool of_half) {
        auto sum = of_half ? t_error : hn::Set(d, local.t);
        for (int axis = 0; axis < 3; ++axis)
          sum =
              hn::MulAdd(v[axis], hn::Set(d, of_half ? std::fabs(direction_[axis]) : direction_[axis]), sum);
        return sum;
      };
      const auto t = along(center, false), t_reach = along(half, true);
      const auto t_low = hn::Sub(t, t_reach), t_high = hn::Add(t, t_reach);
      auto met = hn::And(hn::Le(nearest_sq, limit_sq),
                         hn::And(hn::Le(t_low, hn::Set(d, t_high_)), hn::Ge(t_high, hn::Set(d, t_low_))));
      if constexpr (measure == Measure::distance) {
        hn::Store(nearest_sq, d, boxes.bound + lane);
      } else {
        auto bound = t_low;
        if constexpr (measure == Measure::entry) {
          const auto chord_sq = hn::Sub(hn::Set(d, radius_ * radius_ * k_up), nearest_sq);
          bound = hn::Sub(t_low, hn::Mul(hn::Sqrt(hn::Max(chord_sq, zero)), hn::Set(d, k_up)));
        }
        hn::Store(bound, d, boxes.bound + lane);
        met = hn::And(met, hn::Le(bound, hn::Set(d, cut)));
      }
      boxes.met |= mask_bits(d, met) << lane;
      if constexpr (tests_inside) {
        if (all_in_double_ || has_entry_min_ || !(inner > 0.0f)) continue;
        const auto inside = hn::And(
            hn::Le(farthest_sq, hn::Set(d, inner * inner * k_down)),
            hn::And(hn::Ge(t_low, hn::Set(d, sure_t_low_)), hn::Le(t_high, hn::Set(d, sure_t_high_))));
        boxes.inside |= mask_bits(d, inside) << lane;
      }
    }
  }

  HWY_INLINE void test_points(const Local& local, const Leaf& leaf, int level, float cut,
                              TestedPoints& points) const {
    const PointLanes d;
    using V = hn::Vec<PointLanes>;
    const float lost = LeafCoordinates::lost(level, widest_scale_);
    const float float_error = local.error + lost, float_t_error = local.t_error + lost;
    const float outer = (measure == Measure::distance ? std::min(cut, radius_) : radius_) + float_error;
    const float rim = radius_ + float_error, inner = inner_radius_ - float_error;
    // For the half chord h = sqrt(r^2 - x^2) of the sphere of a point at distance x, known within e:
    // (r + e)^2 - (x + e)^2 >= r^2 - x^2 >= (r - e)^2 - (x - e)^2 for e <= x + e <= r.
    const auto outer_sq = hn::Set(d, outer * outer * k_up), rim_sq = hn::Set(d, rim * rim * k_up);
    const auto inner_sq = hn::Set(d, inner > 0.0f && !all_in_double_ ? inner * inner * k_down : -1.0f);
    const auto error = hn::Set(d, float_error), t_error = hn::Set(d, float_t_error);
    const auto t_low = hn::Set(d, t_low_ - float_t_error),
               t_high =
                   hn::Set(d, (measure == Measure::t ? std::min(cut, t_high_) : t_high_) + float_t_error),
               sure_t_low = hn::Set(d, sure_t_low_ + float_t_error),
               sure_t_high = hn::Set(d, sure_t_high_ - float_t_error), foot_t = hn::Set(d, local.t),
               zero = hn::Zero(d);
    const LeafCoordinates coordinates(tree_, leaf, level, float_scale_, local.foot);
    const auto along_x = hn::Set(d, direction_[0]), along_y = hn::Set(d, direction_[1]),
               along_z = hn::Set(d, direction_[2]);
    points.possible = points.certain = 0;
    for (int first = 0; first < coordinates.count; first += static_cast<int>(hn::Lanes(d))) {
      const auto [from_foot, distance_sq] = on_line(coordinates(0, first), coordinates(1, first),
                                                    coordinates(2, first), along_x, along_y, along_z);
      const auto t = hn::Add(foot_t, from_foot);
      const auto near = hn::And(hn::Le(distance_sq, outer_sq), hn::And(hn::Ge(t, t_low), hn::Le(t, t_high)));
      const unsigned bits = coordinates.in_leaf(near, first);
      if (bits == 0) continue;

      auto counts =
          hn::And(hn::Le(distance_sq, inner_sq), hn::And(hn::Ge(t, sure_t_low), hn::Le(t, sure_t_high)));
      V low = hn::Sub(t, t_error), high = hn::Add(t, t_error);
      if (measure == Measure::entry || has_entry_min_) {
        const auto entry_low = hn::Sub(low, hn::Sqrt(hn::Max(hn::Sub(rim_sq, distance_sq), zero)));
        if (has_entry_min_) counts = hn::And(counts, hn::Ge(entry_low, hn::Set(d, entry_min_)));
        if constexpr (measure == Measure::entry) {
          low = entry_low;
          high = hn::Sub(high, hn::Sqrt(hn::Max(hn::Sub(inner_sq, distance_sq), zero)));
        }
      }
      if constexpr (measure == Measure::distance) {
        const auto distance = hn::Sqrt(distance_sq);
        low = hn::Sub(distance, error);
        high = hn::Add(distance, error);
      }
      hn::Store(low, d, points.low + first);
      hn::Store(high, d, points.high + first);
      points.possible |= bits << first;
      points.certain |= (mask_bits(d, counts) & bits) << first;
    }
  }

 private:
  static constexpr float infinity() { return std::numeric_limits<float>::infinity(); }
  const TreeView& tree_;
  const LineFromRoot& line_;
  const bool all_in_double_, has_entry_min_;
  double widest_scale_ = 0.0;
  double chord_error_ = 0.0;  ///< rounding of the way from t to the sphere's rim
  float float_scale_[3], direction_[3];
  float radius_, inner_radius_;     ///< not below and not above the radius
  float t_low_, t_high_;            ///< nothing outside counts
  float sure_t_low_, sure_t_high_;  ///< everything between is inside the ray's interval
  float entry_min_;
};

/// A sphere without limits is entered nowhere.
bool admits_none(const RayQuery& query) {
  return std::isinf(query.radius) && query.entry_min > -std::numeric_limits<double>::infinity();
}

template <Measure measure>
void find_by(const TreeView& tree, const Ray& ray, const RayQuery& query, std::size_t k,
             std::size_t query_index, std::vector<Hit>& answers) {
  const LineFromRoot line(tree, ray);
  const RayKernel<measure> kernel(tree, line, ray, query, static_cast<bool>(query.filter));
  constexpr bool is_along_line = measure != Measure::distance;
  find_first(tree, kernel, RayTarget(ray, query, query_index), query, k, is_along_line ? line.shift : 0.0,
             is_along_line ? line.error : 0.0, answers);
}

void find(const TreeView& tree, const Ray& ray, const RayQuery& query, std::size_t k, std::size_t query_index,
          std::vector<Hit>& answers) {
  if (admits_none(query)) return;
  if (k >= tree.point_count) {
    const LineFromRoot line(tree, ray);
    const RayKernel<Measure::t> kernel(tree, line, ray, query, static_cast<bool>(query.filter));
    find_all(tree, kernel, RayTarget(ray, query, query_index), query, answers);
  } else if (query.measure == Measure::distance) {
    find_by<Measure::distance>(tree, ray, query, k, query_index, answers);
  } else if (query.measure == Measure::t) {
    find_by<Measure::t>(tree, ray, query, k, query_index, answers);
  } else {
    find_by<Measure::entry>(tree, ray, query, k, query_index, answers);
  }
}

std::size_t count(const TreeView& tree, const Ray& ray, const RayQuery& query, std::size_t k,
                  std::size_t query_index) {
  if (admits_none(query)) return 0;
  const LineFromRoot line(tree, ray);
  const RayKernel<Measure::t> kernel(tree, line, ray, query, !knows_all_points(query));
  return count_first(tree, kernel, RayTarget(ray, query, query_index), query, k);
}

constexpr Search<Ray> k_ray_search{find, count};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alidade::simd {

template <>
const Search<Ray>& search(InstructionSet instruction_set) {
  ALIDADE_CHOOSE_TABLE(instruction_set, k_ray_search)
}

bool suits_lanes(const TreeView& tree, const Ray& ray, const RayQuery& query) {
  if (tree.node_count == 0) return false;
  const glm::dvec3& d = ray.direction;
  const double square = d.x * d.x + d.y * d.y + d.z * d.z;
  double width = 0.0;
  for (int axis = 0; axis < 3; ++axis)
    width = std::max(width, tree.lattice.scale[axis] * power_of_two(tree.root_level));
  const LineFromRoot line(tree, ray);
  return std::fabs(square - 1.0) <= 2e-15 && width < 1e15 && line.away <= 256.0 * width && line.error < 1.0 &&
         (query.radius < 1e15 || std::isinf(query.radius));
}

}  // namespace alidade::simd
#endif  // HWY_ONCE
