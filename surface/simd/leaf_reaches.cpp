// SPDX-License-Identifier: MIT
#include "surface/simd/leaf_reaches.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "surface/simd/leaf_reaches.cpp"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

#include "octree/simd/choose_table.h"
#include "octree/spacing.h"
#include "surface/simd/own_points-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

void write_leaf_reaches(const SurfaceView& view, const Node& node, std::uint16_t* reaches) {
  const PointLanes d;
  const SurfaceQuery query{.radius = 1.0, .discs = DiscQuery{}};
  const DiscTest test(view, query);
  const auto one = hn::Set(d, 1.0f);
  // Exceeds the error of a sine in float, which is greatest where it is near 0.
  const auto slack = hn::Set(d, 0x1p-10f);
  std::uint32_t first = node.first_point;
  for (int slot = 0; slot < k_node_width; ++slot) {
    const std::uint32_t count = is_leaf(node.kind[slot]) ? node.kind[slot] : 0;
    hn::Vec<PointLanes> greatest[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    for (std::uint32_t i = 0; i < count; i += static_cast<std::uint32_t>(hn::Lanes(d))) {
      const auto [planes, exists, is_amid] = test.sheets(first + i, count - i);
      const hn::Vec<PointLanes> normal[3] = {planes.x, planes.y, planes.z};
      // Infinite ones become finite, so that products are numbers.
      const auto spacing = scaled(d, view.layers.spacings + first + i, 1.0f, static_cast<float>(k_far));
      const auto in_leaf = hn::FirstN(d, count - i);
      for (int axis = 0; axis < 3; ++axis) {
        const auto cosine = hn::Div(hn::Abs(normal[axis]), planes.length);
        const auto sine = hn::Sqrt(hn::Max(hn::NegMulAdd(cosine, cosine, one), hn::Zero(d)));
        const auto across = hn::MulAdd(hn::Set(d, static_cast<float>(k_disc_spacings)), sine, slack);
        const auto of_disc = hn::MulAdd(hn::Abs(planes.height), cosine, hn::Mul(spacing, across));
        const auto of_sphere = hn::Mul(spacing, hn::Set(d, static_cast<float>(k_reach_of_lone)));
        const auto reach = hn::IfThenElse(exists, of_disc, of_sphere);
        greatest[axis] = hn::Max(greatest[axis], hn::IfThenElseZero(in_leaf, reach));
      }
    }
    first += count;
    for (int axis = 0; axis < 3; ++axis) {
      const double reach = hn::GetLane(hn::MaxOfLanes(d, greatest[axis]));
      reaches[k_node_width * axis + slot] = spacing_bits(reach * k_up);
    }
  }
}

constexpr LeafReaches k_leaf_reaches = &write_leaf_reaches;

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alidade::simd {

LeafReaches leaf_reaches(InstructionSet instruction_set) {
  ALIDADE_CHOOSE_TABLE(instruction_set, k_leaf_reaches)
}

}  // namespace alidade::simd
#endif  // HWY_ONCE
