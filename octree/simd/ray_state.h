// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "base/morton.h"
#include "base/ray.h"
#include "cloud/lattice.h"
#include "octree/candidate.h"
#include "octree/octree.h"
#include "octree/tree_walk.h"

namespace alidade::simd {

/// A float that is not below a number, nor above it by more than its rounding; of numbers beyond 1e30,
/// infinite ones too, those of 1e30: squares of such floats are no numbers, so nothing follows from being
/// above.
inline float at_least(double value) {
  const auto f = static_cast<float>(std::clamp(value, -1e30, 1e30));
  return f + std::fabs(f) * 0x1p-23f + std::numeric_limits<float>::min();
}

inline float at_most(double value) {
  return -at_least(-value);
}

/// 2^exponent for exponents of normal numbers, without the library call.
inline double power_of_two(int exponent) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(1023 + exponent) << 52);
}

/// Replaces infinity where sums must stay finite.
constexpr double k_far = 1e30;

/// Rounds towards +infinity with a little room, for upper limits that must not discard too much. Requires:
/// |value| <= 2 * k_far.
inline float float_above(double value) {
  const auto f = static_cast<float>(value);
  return f + std::fabs(f) * 0x1p-22f + std::numeric_limits<float>::min();
}

inline float float_below(double value) {
  return -float_above(-value);
}

/// Bit per axis: the ray goes down.
inline unsigned octant_of(const glm::dvec3& direction) {
  return (direction.x < 0.0 ? 1u : 0u) | (direction.y < 0.0 ? 2u : 0u) | (direction.z < 0.0 ? 4u : 0u);
}
inline unsigned octant_of(const Ray& ray) {
  return octant_of(ray.direction);
}

/// Whether condition(i, i + 1) holds for most of 64 pairs of rays that follow one another, spread over a
/// batch of so many.
template <class Condition>
bool holds_for_most_pairs(std::size_t rays, const Condition& condition) {
  constexpr std::size_t k_samples = 64;
  if (rays < 2) return false;
  std::size_t count = 0;
  for (std::size_t s = 0; s < k_samples; ++s) {
    const std::size_t i = s * (rays - 1) / k_samples;
    count += condition(i, i + 1);
  }
  return 2 * count > k_samples;
}

/// Whether most rays start near the one before, measured by the size of the tree. origin(i): of so many rays.
template <class Origin>
bool start_side_by_side(const TreeExtent& extent, std::size_t rays, const Origin& origin) {
  const double near = std::min(extent.size, 3.0 * extent.site_width) / 64.0;
  return holds_for_most_pairs(rays, [&](std::size_t a, std::size_t b) {
    const glm::dvec3 apart = origin(b) - origin(a);
    return std::fabs(apart.x) + std::fabs(apart.y) + std::fabs(apart.z) <= near;
  });
}

/// Of a query, what its way through the tree depends on.
struct QueryConditions {
  double radius;  ///< no point's is greater
  double entry_min;
  int max_level;
  const CandidateFilter& filter;
  bool own_radii;   ///< points have radii of their own
  Measure measure;  ///< by which answers are ordered
};

/// What a traversal needs of tree and query, the same for all rays of a batch.
///
/// Boxes are tested in float against the ray's line widened by `box_radius`, which exceeds the radius by more
/// than everything that can go wrong between the float test and the double decision. With F the width of the
/// root's frame and r the radius, all positions relative to the root's corner, in units of 2^-24: rounding of
/// the lattice's scale, of 1/d and of their products with corner and grid step at most 4 F (corner and grid
/// steps together stay below F), of the ray's local origin F + r, of the four sums in t at most 8 F + 7 r,
/// of the widening 4 r. The sum stays below 13 (F + r); the budget is 16 (F + r). Where points have radii of
/// their own, theirs replace r in the widening; that is a sum and two products more, and the budget is
/// 32 (F + r).
///
/// In a tree with a site (TreeExtent) positions are relative to the site's corner. Boxes in the site are
/// widened by `site_radius`, in which 8 widths of the site replace F. So much suffices for rays whose local
/// origin is within 7 widths of its corner along each axis; others are traced alone, with a setup for the
/// whole tree.
///
/// What goes wrong in double comes on top: `double_error` exceeds 2^-48 (W + way) + 4e-12 way,
/// W the largest coordinate with the lattice's offset and `way` that from a ray's origin to the far end of
/// the points: cancellation in point - origin and in t, and direction components kept 1e-12 away from zero.
struct QuerySetup {
  /// For rays that start not farther away than a few times the extent of the points, and near the site if
  /// there is one; others get a setup of their own.
  QuerySetup(const TreeView& query_tree, const QueryConditions& conditions)
      : QuerySetup(query_tree, conditions, usual_way(query_tree, conditions)) {
    const TreeExtent& extent = tree.extent;
    if (extent.site_level >= tree.root_level) return;
    has_site = true;
    reference = extent.site_corner;
    for (int axis = 0; axis < 3; ++axis) corner[axis] += tree.lattice.scale[axis] * reference[axis];
    longest_origin = 7.0 * extent.site_width;
    site_margin = margin_in(8.0 * extent.site_width);
    site_radius = query.radius + site_margin;
  }

  /// For rays from anywhere.
  QuerySetup(const TreeView& query_tree, const QueryConditions& conditions, double greatest_way)
      : tree(query_tree),
        query(conditions),
        longest_way(greatest_way),
        double_error(double_error_of(query_tree.extent, greatest_way)) {
    std::ranges::copy(tree.extent.corner, corner);
    box_margin = site_margin = margin_in(tree.extent.frame_width);
    box_radius = site_radius = query.radius + box_margin;
  }

  /// Whether the boxes below a frame are in the site.
  bool in_site(const std::array<std::uint32_t, 3>& frame_corner, int level) const {
    if (!has_site) return true;
    std::uint32_t outside = 0;
    for (int axis = 0; axis < 3; ++axis)
      outside |= (frame_corner[axis] ^ reference[axis]) >> tree.extent.site_level;
    return outside == 0 && level <= tree.extent.site_level;
  }

  /// Lattice steps from `corner` to that of a frame along an axis; exact.
  float steps_to(std::uint32_t frame_corner, int axis) const {
    const auto part = [](std::uint32_t steps) {
      return static_cast<std::int32_t>(steps >> k_min_frame_level);
    };
    return static_cast<float>(part(frame_corner) - part(reference[axis])) * 256.0f;
  }

  /// By how much boxes below a frame are widened beside what points with radii of their own reach.
  double widening(const std::array<std::uint32_t, 3>& frame_corner, int level) const {
    const bool within = in_site(frame_corner, level);
    if (query.own_radii) return within ? site_margin : box_margin;
    return within ? site_radius : box_radius;
  }

  /// How far before its limits a ray is still to meet boxes. Ordered by t, a point counts where the ray is
  /// inside its box and not before the limits; else its entry, which is the measure, may be before.
  double before_limits() const { return query.measure == Measure::t ? site_margin : site_radius; }

  /// Exceeds by how much lanes are wrong about t and distance of points in leaves below a frame of this
  /// level.
  double leaf_error(int level) const {
    const int shift = coordinate_shift(level);
    const double lost = shift > 0 ? 2.0 * tree.extent.widest_scale * power_of_two(shift) : 0.0;
    return double_error + lost + 0x1p-18 * (tree.extent.widest_scale * power_of_two(level) + box_radius);
  }

  /// For rays with a way of so many metres to the far end of the points.
  static double double_error_of(const TreeExtent& extent, double way) {
    // A ray's origin lies not farther from zero than the points by more than the way between them.
    return 0x1p-48 * (extent.largest_coordinate + 2.0 * way) + 4e-12 * way + 1e-30;
  }

  static double usual_way(const TreeView& tree, const QueryConditions& conditions) {
    return 8.0 * (tree.extent.size + conditions.radius);
  }

  const TreeView& tree;
  const QueryConditions query;
  const double longest_way;
  const double double_error;
  double box_radius = 0.0;
  double box_margin = 0.0;  ///< of it, what is not radius
  /// What boxes are measured from: the corner of the site, if there is one, or of the root's frame.
  bool has_site = false;
  std::array<std::uint32_t, 3> reference{};  ///< lattice steps from the root's corner
  double corner[4] = {};                     ///< world
  double longest_origin = k_far;             ///< of local origins, along each axis
  double site_radius = 0.0;
  double site_margin = 0.0;  ///< of it, what is not radius

 private:
  /// For positions within so many metres.
  double margin_in(double width) const {
    const double budget = query.own_radii ? 0x1p-19 : 0x1p-20;
    return budget * (width + query.radius) + double_error;
  }
};

/// What of a ray meets boxes, relative to the setup's corner. t of a face at x is x * inverse - origin_t.
struct alignas(32) RayBoxes {
  float inverse[3];  ///< 1 / direction, components kept 1e-12 away from zero
  float unused;
  float origin_t[3];  ///< local origin * inverse
  float t_cut;        ///< nothing that begins after counts

  /// Bit per axis: the ray goes down.
  unsigned octant() const {
    return (inverse[0] < 0.0f ? 1u : 0u) | (inverse[1] < 0.0f ? 2u : 0u) | (inverse[2] < 0.0f ? 4u : 0u);
  }
};

/// Limits along a ray, local t within k_far.
struct RayLimits {
  double t_min, t_max, entry_min;
  double cut;  ///< the best point's measure is not beyond
};

/// What else describes a ray on its way, a cache line of it. Lengths are in local t, which counts from
/// where the ray is both inside the root's box and not before its limits by more than
/// QuerySetup::before_limits(), so that origins far away cost no precision.
struct alignas(64) RayState {
  RayLimits limits;
  double shift;  ///< t = local t + shift
  /// The best point's measure lies in [best_low, limits.cut], local t. They are equal but for rounding once
  /// it was decided in double. Infinite if there is none, -infinity if any point will do and there is one.
  double best_low;
  LatticePosition best_position;
  std::uint32_t best_index;

  bool found() const { return best_low < std::numeric_limits<double>::infinity(); }
};

/// A ray in its traversal.
struct ActiveRay {
  const Ray& input;  ///< as the caller gave it, world coordinates
  RayBoxes& boxes;
  RayState& state;
  std::size_t query_index;
};

/// Rays in their traversal, by number.
struct RayBatch {
  const Ray* inputs;
  RayBoxes* boxes;
  RayState* states;
  std::size_t first_index;  ///< query_index of ray 0

  ActiveRay operator[](std::size_t number) const {
    return {inputs[number], boxes[number], states[number], first_index + number};
  }
};

/// The line of a ray as seen from the corner of the octree's root, so that origins far away cost no
/// precision.
struct LineFromRoot {
  double origin[3];  ///< foot of the perpendicular from the root's corner
  double direction[3];
  double shift = 0.0;  ///< t of that foot
  /// Exceeds the error of all this, and that of the formulas of octree/distance.h for points of the tree.
  double error = 0.0;
  double away = 0.0;  ///< an upper limit of the perpendicular's length

  /// Requires a direction of length 1 within 2e-15 (a rounding of its square).
  LineFromRoot(const TreeView& tree, const Ray& ray) {
    const glm::dvec3 corner = to_world(tree.lattice, tree.base);
    double largest = 0.0, way = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis] = ray.origin[axis] - corner[axis];
      direction[axis] = ray.direction[axis];
      shift -= origin[axis] * direction[axis];
      largest = std::max({largest, std::fabs(ray.origin[axis]), std::fabs(corner[axis]),
                          std::fabs(tree.bounds.max[axis]), std::fabs(tree.lattice.offset[axis])});
      way += std::fabs(origin[axis]) + (tree.bounds.max[axis] - corner[axis]);
    }
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis] += shift * direction[axis];
      away += std::fabs(origin[axis]);
    }
    error = 0x1p-48 * (largest + way) + 1e-18;
  }
};

/// The numbers of the bits of a byte, the lowest first, four bits each.
constexpr std::array<std::uint32_t, 256> k_numbers_of_bits = [] {
  std::array<std::uint32_t, 256> numbers{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    int count = 0;
    for (std::uint32_t bit = 0; bit < 8; ++bit)
      if ((byte >> bit & 1) != 0) numbers[byte] |= bit << (4 * count++);
  }
  return numbers;
}();

/// Slots in the order in which rays meet them.
struct SlotOrder {
  std::array<std::uint8_t, k_node_width> slot;
  int count = 0;
};

/// Every third bit.
constexpr std::array<std::uint32_t, 256> k_spread_byte = [] {
  std::array<std::uint32_t, 256> spread{};
  for (std::uint32_t value = 0; value < 256; ++value)
    spread[value] = static_cast<std::uint32_t>(morton_spread(value));
  return spread;
}();

/// The slots of a set (bits) in the order in which any ray of this octant (bit per axis: direction negative)
/// meets them. Cells of one tree are disjoint, so their order is that of the Morton keys of any point inside,
/// mirrored on the axes along which the ray goes down.
inline SlotOrder front_to_back(const Node& node, unsigned octant, unsigned slots) {
  const std::uint8_t mirror[3] = {static_cast<std::uint8_t>((octant & 1u) != 0 ? 0xff : 0),
                                  static_cast<std::uint8_t>((octant & 2u) != 0 ? 0xff : 0),
                                  static_cast<std::uint8_t>((octant & 4u) != 0 ? 0xff : 0)};
  std::array<std::uint32_t, k_node_width> keys;
  SlotOrder order;
  for (; slots != 0; slots &= slots - 1) {
    const int slot = std::countr_zero(slots);
    const std::uint32_t key =
        (k_spread_byte[node.low[0][slot] ^ mirror[0]] | k_spread_byte[node.low[1][slot] ^ mirror[1]] << 1 |
         k_spread_byte[node.low[2][slot] ^ mirror[2]] << 2)
            << 4 |
        static_cast<std::uint32_t>(slot);
    int at = order.count++;
    for (; at > 0 && keys[at - 1] > key; --at) keys[at] = keys[at - 1];
    keys[at] = key;
  }
  for (int i = 0; i < order.count; ++i) order.slot[i] = static_cast<std::uint8_t>(keys[i] & 15u);
  return order;
}

}  // namespace alidade::simd
