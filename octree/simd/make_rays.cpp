// SPDX-License-Identifier: MIT
#include "octree/simd/make_rays.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octree/simd/make_rays.cpp"
#include <hwy/foreach_target.h>

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include "octree/simd/choose_table.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Directions, a column for each axis.
constexpr std::size_t k_block = 64;
struct Directions {
  alignas(64) double axis[3][k_block];

  /// unit_direction() of so many: its operations in its order. Returns whether all were finite and not zero;
  /// the rest of the last vector is read.
  bool normalize(std::size_t count) {
    const hn::CappedTag<double, 8> d;
    const auto zero = hn::Zero(d);
    auto all_good = hn::Eq(zero, zero);
    for (std::size_t lane = 0; lane < count; lane += hn::Lanes(d)) {
      const auto x = hn::Load(d, axis[0] + lane), y = hn::Load(d, axis[1] + lane),
                 z = hn::Load(d, axis[2] + lane);
      const auto largest = hn::Max(hn::Abs(x), hn::Max(hn::Abs(y), hn::Abs(z)));
      const auto a = hn::Div(x, largest), b = hn::Div(y, largest), c = hn::Div(z, largest);
      const auto length = hn::Sqrt(hn::Add(hn::Add(hn::Mul(a, a), hn::Mul(b, b)), hn::Mul(c, c)));
      // From 1 to the root of 3; NaN if something is infinite or NaN, or if all is zero.
      all_good = hn::And(all_good, hn::Ge(length, zero));
      hn::Store(hn::Div(a, length), d, axis[0] + lane);
      hn::Store(hn::Div(b, length), d, axis[1] + lane);
      hn::Store(hn::Div(c, length), d, axis[2] + lane);
    }
    return hn::AllTrue(d, all_good);
  }
};

/// row(i): of rays[i].
template <class Row>
bool make_rays_of(const RayColumns& columns, const Row& row, std::span<Ray> rays) {
  Directions directions;
  double no_number = 0.0;  // or NaN
  bool is_good = true;
  for (std::size_t begin = 0; begin < rays.size(); begin += k_block) {
    const std::span<Ray> block = rays.subspan(begin, std::min(k_block, rays.size() - begin));
    for (std::size_t i = 0; i < block.size(); ++i) {
      const std::size_t r = row(begin + i);
      const double *const origin = columns.origins[r], *const direction = columns.directions[r];
      Ray& ray = block[i];
      for (int axis = 0; axis < 3; ++axis) {
        ray.origin[axis] = origin[axis];
        directions.axis[axis][i] = direction[axis];
      }
      no_number += 0.0 * origin[0] + 0.0 * origin[1] + 0.0 * origin[2];
      ray.t_min = *columns.t_min[r];
      ray.t_max = *columns.t_max[r];
      is_good &= !std::isunordered(ray.t_min, ray.t_max);
    }
    for (std::size_t i = block.size(); i < std::min(block.size() + 7, k_block); ++i)
      for (auto& axis : directions.axis) axis[i] = 1.0;
    is_good &= directions.normalize(block.size());
    for (std::size_t i = 0; i < block.size(); ++i)
      block[i].direction = {directions.axis[0][i], directions.axis[1][i], directions.axis[2][i]};
  }
  return is_good && no_number == 0.0;
}

bool make_rays(const RayColumns& columns, std::size_t first_row, std::span<const SortKey> order,
               std::span<Ray> rays) {
  if (order.empty())
    return make_rays_of(
        columns, [&](std::size_t i) { return first_row + i; }, rays);
  const auto row_at = [&](std::size_t i) { return first_row + number_of(order[i]); };
  return make_rays_of(
      columns,
      [&](std::size_t i) {
        constexpr std::size_t k_ahead = 24;
        const std::size_t later = row_at(std::min(i + k_ahead, order.size() - 1));
        hwy::Prefetch(columns.origins[later]);
        hwy::Prefetch(columns.directions[later] + 2);
        return row_at(i);
      },
      rays);
}

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alidade::simd {

using MakeRays = bool(const RayColumns&, std::size_t, std::span<const SortKey>, std::span<Ray>);

static MakeRays* make_rays_with(InstructionSet instruction_set) {
  ALIDADE_CHOOSE_TABLE(instruction_set, make_rays)
}

bool make_rays(InstructionSet instruction_set, const RayColumns& columns, std::size_t first_row,
               std::span<const SortKey> order, std::span<Ray> rays) {
  return make_rays_with(instruction_set)(columns, first_row, order, rays);
}

}  // namespace alidade::simd
#endif  // HWY_ONCE
