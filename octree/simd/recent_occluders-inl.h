// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_RECENT_OCCLUDERS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_RECENT_OCCLUDERS_INL_H
#undef ALIDADE_SIMD_RECENT_OCCLUDERS_INL_H
#else
#define ALIDADE_SIMD_RECENT_OCCLUDERS_INL_H
#endif

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "octree/simd/packet_state-inl.h"
#include "octree/simd/ray_state.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// The last two points that hid rays. Most hidden rays of a camera, or to the sun, are hidden by a point that
/// hides a neighbour, too (nine in ten on campuses of 1 and 10 million points), and need no way through the
/// tree.
class RecentOccluders {
 public:
  struct Occluder {
    LatticePosition position;
    std::uint32_t index;
  };

  void add(std::uint32_t index, const LatticePosition& position) {
    for (const Occluder& occluder : all())
      if (occluder.index == index) return;
    occluders_[added_++ % occluders_.size()] = {position, index};
  }
  std::span<const Occluder> all() const {
    return std::span(occluders_).first(std::min(added_, occluders_.size()));
  }

 private:
  std::array<Occluder, 2> occluders_;
  std::size_t added_ = 0;
};

/// Tests rays against recent occluders, as long as that pays.
template <class Points>
class OccluderTest {
 public:
  OccluderTest(const QuerySetup& setup, const Points& points) : setup_(setup), points_(points) {}

  /// Bit per ray, of at most GatheredRays::k_size: one of the points hides it. first_index: query_index of
  /// rays[0].
  std::uint64_t hidden(const RecentOccluders& recent, std::span<const Ray> rays,
                       std::span<const std::uint32_t> numbers, std::size_t first_index) {
    constexpr std::size_t k_trial = 256, k_most_tests_per_hidden = 16;
    const bool pays = tested_ < k_trial || k_most_tests_per_hidden * hidden_ >= tested_;
    if (recent.all().empty() || !pays) return 0;
    std::uint64_t hidden = 0;
    if constexpr (Points::are_discs) {
      for (std::size_t lane = 0; lane < numbers.size(); ++lane)
        if (is_hidden(recent, rays[numbers[lane]], first_index + numbers[lane]))
          hidden |= std::uint64_t{1} << lane;
    } else {
      rays_.gather(rays, numbers);
      const DoubleLanes d;
      for (std::size_t lane = 0; lane < numbers.size(); lane += hn::Lanes(d))
        hidden |= std::uint64_t{hidden_in_lanes(recent, lane)} << lane;
      if (numbers.size() < GatheredRays::k_size) hidden &= (std::uint64_t{1} << numbers.size()) - 1;
    }
    tested_ += numbers.size();
    hidden_ += static_cast<std::size_t>(std::popcount(hidden));
    return hidden;
  }

 private:
  bool is_hidden(const RecentOccluders& recent, const Ray& ray, std::size_t query_index) const {
    return std::ranges::any_of(recent.all(), [&](const RecentOccluders::Occluder& occluder) {
      const glm::dvec3 position = to_world(setup_.tree.lattice, occluder.position);
      return points_.evaluate(ray, occluder.index, position, query_index, Filters::all).has_value();
    });
  }

  HWY_INLINE unsigned hidden_in_lanes(const RecentOccluders& recent, std::size_t lane) const {
    const DoubleLanes d;
    const auto t_min = hn::Load(d, rays_.t_min + lane), t_max = hn::Load(d, rays_.t_max + lane);
    const auto entry_min = hn::Set(d, setup_.query.entry_min);
    unsigned hidden = 0;
    for (const auto& [position, index] : recent.all()) {
      const glm::dvec3 at = to_world(setup_.tree.lattice, position);
      const auto radius = hn::Set(d, points_.radius_at(index));
      const LaneProjection point =
          rays_.project(lane, hn::Set(d, at.x), hn::Set(d, at.y), hn::Set(d, at.z), radius);
      const auto counts = hn::And(hn::And(hn::Le(point.distance, radius), hn::Ge(point.t, t_min)),
                                  hn::And(hn::Le(point.t, t_max), hn::Ge(point.entry, entry_min)));
      hidden |= mask_bits(d, counts);
      if (hidden == (1u << hn::Lanes(d)) - 1) break;
    }
    return hidden;
  }

  const QuerySetup& setup_;
  const Points& points_;
  GatheredRays rays_;
  std::size_t tested_ = 0, hidden_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
