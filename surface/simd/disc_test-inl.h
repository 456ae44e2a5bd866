// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_DISC_TEST_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_DISC_TEST_INL_H
#undef ALIDADE_SIMD_DISC_TEST_INL_H
#else
#define ALIDADE_SIMD_DISC_TEST_INL_H
#endif

#include "octree/simd/lanes-inl.h"
#include "octree/simd/ray_state.h"
#include "surface/packed_surface.h"
#include "surface/point_disc.h"
#include "surface/surface_cloud.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

using DiscVector = hn::Vec<PointLanes>;
using DiscMask = hn::Mask<PointLanes>;

/// Points near rays, in lanes: their offset from a point of the ray, the t of their projection and the square
/// of their distance, each within `error`; `outer` is their radius and the error, or more, `inner` their
/// radius less the error, or less (inner_sq below 0: no point certainly counts).
struct NearRay {
  DiscVector x, y, z;
  DiscVector t, distance_sq;
  DiscVector error, outer_sq, inner_sq, radius;
};

/// Bounds of the t at which the ray crosses each of them, if it does; `sure`: that it does, whatever its
/// interval and entry_min are.
struct Crossings {
  DiscVector low, high;
  DiscMask sure;
};

/// The sheet that a ray begins on, and how far from there the ray is where it enters a leaf.
struct LeftSheet {
  bool is_near = false;  ///< points of the leaf may be of the sheet
  float normal[3] = {}, reach = 0.0f, thickness = 0.0f;
  float way = 0.0f;

  LeftSheet(const ActiveRay& ray, const SurfaceQuery& query, double start, double error) {
    if (query.discs->begins.empty()) return;
    const SheetOrigin& begin = query.discs->begins[ray.query_index];
    if (!(begin.reach > 0.0f)) return;
    // The ray meets the points that count behind `there`: none is nearer by more than its radius.
    const double there = start + ray.state.shift;
    constexpr double k_slack = 1.0 - 0x1p-20;
    is_near =
        k_slack * there - query.radius - 2.0 * error <= std::fmax(begin.reach, k_part_radii * query.radius);
    for (int axis = 0; axis < 3; ++axis) normal[axis] = static_cast<float>(begin.normal[axis]);
    reach = begin.reach;
    thickness = begin.thickness;
    way = static_cast<float>(there);
  }
};

/// Directions of rays, and the sheets that they begin on: of one ray in all lanes, or of one ray per lane.
struct RaysAtDiscs {
  DiscVector along[3];
  bool leave_near_sheets = false;  ///< any of them; otherwise what is below does not apply
  DiscMask is_near;
  DiscVector normal[3], reach, thickness, way;

  RaysAtDiscs() = default;
  HWY_INLINE RaysAtDiscs(const float* direction, const LeftSheet& left) : leave_near_sheets(left.is_near) {
    const PointLanes d;
    for (int axis = 0; axis < 3; ++axis) along[axis] = hn::Set(d, direction[axis]);
    if (!leave_near_sheets) return;
    is_near = hn::FirstN(d, hn::Lanes(d));
    for (int axis = 0; axis < 3; ++axis) normal[axis] = hn::Set(d, left.normal[axis]);
    reach = hn::Set(d, left.reach);
    thickness = hn::Set(d, left.thickness);
    way = hn::Set(d, left.way);
  }
};

/// The planes of the sheets of points: normals m that are not of length 1, their length, and the points'
/// heights.
struct SheetPlanes {
  DiscVector x, y, z, length, height;

  HWY_INLINE DiscVector dot(DiscVector a, DiscVector b, DiscVector c) const {
    return hn::MulAdd(a, x, hn::MulAdd(b, y, hn::Mul(c, z)));
  }
};

/// SheetPlanes of points, one per lane; which of them have a sheet, and which have no edge near.
struct PointSheets {
  SheetPlanes planes;
  DiscMask exists, is_amid;
};

/// Where rays cross the discs of points, and enter the spheres of those without a sheet
/// (evaluate_disc()).
///
/// With the normal m, not yet of length 1, the height h and the direction d:
///
///   t = (p m - h |m|) / (d m)
///
/// Components of m err by less than 2^-21, and so do |m| and d m, within a few roundings; `error` exceeds
/// 2^-18 (|p| + radius). So the numerator errs by less than 3 error + 2^-20 h, the denominator by less than
/// 2^-19; the budgets are 4 error + 2^-18 h and 2^-18. Where the ray runs along the plane all is possible
/// that the sphere admits.
class DiscTest {
 public:
  DiscTest(const SurfaceView& view, const SurfaceQuery& query)
      : surfaces_(view.stored_surfaces),
        edges_(view.stored_edges),
        unit_(static_cast<float>(view.layers.surface_unit)),
        lone_share_(float_above(std::min(query.discs->lone_factor / query.spacing_factor, 1.0))),
        lone_radius_(float_above(std::min(query.discs->lone_radius, query.radius))) {}

  /// The points from this storage index on; lanes from `count` on are not used.
  HWY_INLINE PointSheets sheets(std::uint32_t index, std::size_t count) const {
    const PointLanes d;
    using V = DiscVector;
    const hn::RebindToUnsigned<PointLanes> bits;
    const OwnLanes<std::uint32_t> own_surfaces(surfaces_ + index, count);
    const auto packed = hn::LoadU(bits, own_surfaces.values);
    const V one = hn::Set(d, 1.0f), half = hn::Set(d, 0.5f);
    const auto side = [&](auto shifted) {
      const auto steps = hn::And(shifted, hn::Set(bits, packed_surface::k_side_mask));
      return hn::MulSub(as_float(steps), hn::Set(d, static_cast<float>(2.0 / packed_surface::k_side_steps)),
                        one);
    };
    const V u = side(hn::ShiftRight<packed_surface::k_first_side>(packed)),
            v = side(hn::ShiftRight<packed_surface::k_second_side>(packed));
    SheetPlanes planes{hn::Mul(half, hn::Add(u, v)), hn::Mul(half, hn::Sub(u, v)), one, one,
                       height_of(packed)};
    planes.z = hn::Sub(one, hn::Add(hn::Abs(planes.x), hn::Abs(planes.y)));
    planes.length = hn::Sqrt(planes.dot(planes.x, planes.y, planes.z));
    const OwnLanes<std::uint8_t> own_edges(edges_ + index, count);
    const auto edges =
        hn::PromoteTo(bits, hn::LoadU(hn::Rebind<std::uint8_t, PointLanes>(), own_edges.values));
    return {planes, hn::RebindMask(d, hn::TestBit(packed, hn::Set(bits, packed_surface::k_exists))),
            hn::RebindMask(d, hn::Eq(edges, hn::Zero(bits)))};
  }

  /// Points in lanes, whether they have a sheet or not.
  HWY_INLINE Crossings operator()(const PointSheets& sheets, const NearRay& points,
                                  const RaysAtDiscs& rays) const {
    const Crossings discs = of_discs(sheets.planes, sheets.is_amid, points, rays),
                    spheres = of_spheres(points);
    return {hn::IfThenElse(sheets.exists, discs.low, spheres.low),
            hn::IfThenElse(sheets.exists, discs.high, spheres.high),
            hn::Or(hn::And(sheets.exists, discs.sure), hn::AndNot(sheets.exists, spheres.sure))};
  }

  /// Of points with a sheet. is_amid: no edge of it is near.
  HWY_INLINE Crossings of_discs(const SheetPlanes& planes, const DiscMask& is_amid, const NearRay& points,
                                const RaysAtDiscs& rays) const {
    const PointLanes d;
    using V = DiscVector;
    const V zero = hn::Zero(d);
    const V across = hn::NegMulAdd(planes.height, planes.length, planes.dot(points.x, points.y, points.z));
    const V slope = planes.dot(rays.along[0], rays.along[1], rays.along[2]);
    const V steepness = hn::Abs(slope), t = hn::Div(across, slope);
    const V slope_error = hn::Set(d, 0x1p-18f);
    const V wrong =
        hn::MulAdd(hn::Set(d, 4.0f), points.error,
                   hn::MulAdd(hn::Abs(planes.height), slope_error, hn::Mul(hn::Abs(t), slope_error)));
    const V error = hn::Div(hn::Mul(hn::Set(d, 2.0f), wrong), steepness);

    const V half_chord = hn::Sqrt(hn::Max(hn::Sub(points.outer_sq, points.distance_sq), zero));
    const V enters = hn::Sub(hn::Sub(points.t, points.error), half_chord),
            leaves = hn::Add(hn::Add(points.t, points.error), half_chord);
    const auto grazes = hn::Not(hn::Gt(steepness, hn::Set(d, 8.0f * 0x1p-18f)));
    const V low = hn::IfThenElse(grazes, enters, hn::Max(hn::Sub(t, error), enters)),
            high = hn::IfThenElse(grazes, leaves, hn::Min(hn::Add(t, error), leaves));
    // Within the radius on the plane, and at no edge.
    const V inner_chord = hn::Sqrt(hn::Max(hn::Sub(points.inner_sq, points.distance_sq), zero));
    const V beside =
        hn::MulAdd(hn::Set(d, 2.0f), points.error, hn::Add(hn::Abs(hn::Sub(t, points.t)), error));
    auto is_sure = hn::And(hn::And(hn::Le(points.distance_sq, points.inner_sq), is_amid),
                           hn::AndNot(grazes, hn::Le(beside, inner_chord)));
    auto never = hn::FirstN(d, 0);
    if (rays.leave_near_sheets) leave_sheet(planes, points, rays, is_sure, never);
    return {hn::IfThenElse(never, hn::Set(d, std::numeric_limits<float>::infinity()), low), high, is_sure};
  }

  /// Of points without a sheet.
  HWY_INLINE Crossings of_spheres(const NearRay& points) const {
    const PointLanes d;
    using V = DiscVector;
    const V zero = hn::Zero(d);
    const V lone = hn::Min(hn::Mul(points.radius, hn::Set(d, lone_share_)), hn::Set(d, lone_radius_));
    const V lone_outer = hn::Add(lone, points.error);
    const V lone_chord_sq =
        hn::Sub(hn::Mul(hn::Mul(lone_outer, lone_outer), hn::Set(d, k_up)), points.distance_sq);
    const auto meets_lone = hn::Ge(lone_chord_sq, zero);
    const V lone_low = hn::Sub(hn::Sub(points.t, points.error), hn::Sqrt(hn::Max(lone_chord_sq, zero)));
    const V lone_inner_sq = SquaredRadius::inner(d, lone, points.error);
    const V lone_high = hn::Sub(hn::Add(points.t, points.error),
                                hn::Sqrt(hn::Max(hn::Sub(lone_inner_sq, points.distance_sq), zero)));
    const auto is_lone_sure =
        hn::And(hn::Le(points.distance_sq, points.inner_sq), hn::Le(points.distance_sq, lone_inner_sq));
    return {hn::IfThenElse(meets_lone, lone_low, hn::Set(d, std::numeric_limits<float>::infinity())),
            lone_high, is_lone_sure};
  }

 private:
  /// A vector of values that are stored one after another, of which the first `count` are used. Other threads
  /// may be fitting the points behind them (LeafFitter), which sanitizers report.
  template <class T>
  struct OwnLanes {
#if defined(__SANITIZE_THREAD__)
    OwnLanes(const T* stored, std::size_t count) {
      std::copy_n(stored, std::min<std::size_t>(count, 16), values);
    }
    T values[16] = {};
#else
    HWY_INLINE OwnLanes(const T* stored, std::size_t) : values(stored) {}
    const T* values;
#endif
  };

  /// Which discs certainly are of the sheet that the ray leaves (is_left()): `never`. Of those that may be,
  /// none is sure. Offsets from the ray's origin err by less than `error`; heights on them by less than
  /// 4 error + 2^-18 h and what the normal makes of the offset.
  HWY_INLINE void leave_sheet(const SheetPlanes& planes, const NearRay& points, const RaysAtDiscs& rays,
                              DiscMask& is_sure, DiscMask& never) const {
    const PointLanes d;
    using V = DiscVector;
    const V x = hn::MulAdd(rays.way, rays.along[0], points.x),
            y = hn::MulAdd(rays.way, rays.along[1], points.y),
            z = hn::MulAdd(rays.way, rays.along[2], points.z);
    const V error = hn::MulAdd(hn::Abs(rays.way), hn::Set(d, 0x1p-21f), points.error);
    const V offset_sq = hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z)));
    const V widest =
        hn::Max(rays.reach, hn::Mul(points.radius, hn::Set(d, static_cast<float>(k_part_radii))));
    const V outer_sq = SquaredRadius::outer(d, hn::Mul(widest, hn::Set(d, k_up)), hn::Add(error, error));
    const DiscMask may_be_near = hn::And(rays.is_near, hn::Le(offset_sq, outer_sq));
    if (hn::AllFalse(d, may_be_near)) return;
    const V inner_sq = SquaredRadius::inner(d, widest, hn::Add(error, error));

    const V alike = hn::Abs(planes.dot(rays.normal[0], rays.normal[1], rays.normal[2]));
    const V least = hn::Mul(planes.length, hn::Set(d, static_cast<float>(k_same_sheet_cosine))),
            slack = hn::Set(d, 0x1p-17f);
    const V height = hn::Abs(hn::MulSub(planes.height, planes.length, planes.dot(x, y, z)));
    const V thickness = hn::Mul(planes.length, rays.thickness);
    const V height_error = hn::MulAdd(
        hn::Set(d, 4.0f), error,
        hn::Mul(hn::Set(d, 0x1p-18f), hn::Add(hn::Abs(planes.height), hn::Add(widest, thickness))));
    never = hn::And(
        hn::And(hn::And(rays.is_near, hn::Le(offset_sq, inner_sq)), hn::Ge(alike, hn::Add(least, slack))),
        hn::Le(hn::Add(height, height_error), thickness));
    const DiscMask may_be = hn::And(hn::And(may_be_near, hn::Ge(alike, hn::Sub(least, slack))),
                                    hn::Le(hn::Sub(height, height_error), thickness));
    is_sure = hn::AndNot(may_be, is_sure);
  }

  using Bits = hn::Vec<hn::RebindToUnsigned<PointLanes>>;

  static HWY_INLINE hn::Vec<PointLanes> as_float(const Bits& whole) {
    const hn::RebindToSigned<PointLanes> ints;
    return hn::ConvertTo(PointLanes(), hn::BitCast(ints, whole));
  }

  /// packed_surface::k_lengths by its law, with the sign.
  HWY_INLINE hn::Vec<PointLanes> height_of(const Bits& packed) const {
    const PointLanes d;
    const hn::RebindToUnsigned<PointLanes> bits;
    const auto all = hn::Set(bits, packed_surface::k_length_mask);
    const auto number = hn::And(hn::ShiftRight<packed_surface::k_height>(packed), all);
    constexpr std::uint32_t k_exponent = 127 + 2;  // of the greatest length
    static_assert(packed_surface::k_greatest_length == 4.0);
    const auto exponent = hn::Sub(hn::Set(bits, k_exponent), hn::ShiftRight<1>(hn::Sub(all, number)));
    const auto whole = hn::BitCast(d, hn::ShiftLeft<23>(exponent));
    const auto is_whole = hn::RebindMask(d, hn::TestBit(number, hn::Set(bits, 1u)));
    const auto length = hn::IfThenElse(
        is_whole, whole, hn::Mul(whole, hn::Set(d, static_cast<float>(packed_surface::k_root_of_half))));
    const auto is_zero = hn::RebindMask(d, hn::Eq(number, hn::Zero(bits)));
    const auto sized = hn::Mul(hn::IfThenZeroElse(is_zero, length), hn::Set(d, unit_));
    const auto below = hn::RebindMask(d, hn::TestBit(packed, hn::Set(bits, packed_surface::k_below)));
    return hn::IfThenElse(below, hn::Neg(sized), sized);
  }

  const std::uint32_t* const surfaces_;
  const std::uint8_t* const edges_;
  const float unit_;
  const float lone_share_, lone_radius_;
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
