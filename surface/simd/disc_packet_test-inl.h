// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_DISC_PACKET_TEST_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_DISC_PACKET_TEST_INL_H
#undef ALIDADE_SIMD_DISC_PACKET_TEST_INL_H
#else
#define ALIDADE_SIMD_DISC_PACKET_TEST_INL_H
#endif

#include <optional>
#include <span>

#include "octree/simd/packet_state-inl.h"
#include "octree/simd/recent_occluders-inl.h"
#include "surface/simd/disc_group_test-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// Those rays of a batch that are in a packet, by lane.
struct PacketBatch {
  const Ray* inputs;
  const std::uint32_t* numbers;  ///< in the batch
  RayBoxes* boxes;
  RayState* states;
  std::size_t first_index;  ///< query_index of ray 0 of the batch

  ActiveRay operator[](std::size_t lane) const {
    return {inputs[numbers[lane]], boxes[lane], states[lane], first_index + numbers[lane]};
  }
};

/// PacketLeafTest for discs. Those of one sheet overlap, and too many rays would be left to be traced alone
/// if nothing was decided on the way. So rays have states, and those that meet a leaf are tested as a stream
/// tests them.
template <bool any>
class DiscPacketTest {
 public:
  using Single = LeafTest<Discs, any>;

  DiscPacketTest(const QuerySetup& setup, const Single& single, PacketRays& rays)
      : setup_(setup), single_(single), rays_(rays) {}

  /// For the rays that are loaded.
  void start(std::span<const Ray> inputs, std::span<const std::uint32_t> numbers, std::size_t first_index) {
    batch_ = {inputs.data(), numbers.data(), boxes_, states_, first_index};
    for (std::size_t lane = 0; lane < rays_.count; ++lane) {
      boxes_[lane].t_cut = rays_.t_cut[lane];
      RayState& state = states_[lane];
      state.shift = rays_.shift[lane];
      state.limits = {rays_.t_min[lane], rays_.t_max[lane],
                      std::clamp(setup_.query.entry_min - state.shift, -k_far, k_far),
                      rays_.t_max[lane] + setup_.double_error};
      state.best_low = std::numeric_limits<double>::infinity();
    }
  }

  /// The leaves that follow are below this frame.
  void enter(const Frame& frame) { frame_.emplace(setup_, frame.corner, frame.level); }

  /// As PacketLeafTest::visit().
  void visit(const Leaf& leaf, std::uint32_t count, unsigned groups, const float* t_near, const float (&)[3],
             float) {
    const RayLanes d;
    const RayNumbers n;
    alignas(64) std::uint32_t lanes[PacketRays::k_size + k_list_padding];
    alignas(64) float ts[PacketRays::k_size + k_list_padding];
    RayList list{lanes, ts, 0};
    for (; groups != 0; groups &= groups - 1) {
      const std::uint32_t first = index_of_lowest_bit(groups) * static_cast<std::uint32_t>(hn::Lanes(d));
      const auto t = hn::Load(d, t_near + first);
      list.add(hn::Iota(n, first), t, hn::Le(t, hn::Load(d, rays_.t_cut + first)));
    }
    if (list.count == 0) return;
    list.pad();
    std::uint64_t tests = 0;
    test_leaf(setup_, single_, leaf, count, *frame_, batch_, list, tests);
    if (tests == 0) return;
    for (std::uint32_t i = 0; i < list.count; ++i) rays_.t_cut[lanes[i]] = boxes_[lanes[i]].t_cut;
  }

  void finish() {
    if constexpr (any) {
      for (std::size_t lane = 0; lane < rays_.count; ++lane)
        if (states_[lane].found()) recent_.add(states_[lane].best_index, states_[lane].best_position);
    }
  }

  /// Of this packet and of those before.
  const RecentOccluders& recent_occluders() const { return recent_; }

  /// Bit per ray: it must be traced alone. The states of the others hold the answers.
  std::uint64_t unclear() const { return rays_.far_away; }
  ActiveRay ray(std::size_t lane) const { return batch_[lane]; }

 private:
  const QuerySetup& setup_;
  const Single& single_;
  PacketRays& rays_;
  PacketBatch batch_{};
  std::optional<typename Single::LeafFrame> frame_;
  RayBoxes boxes_[PacketRays::k_size];  ///< only t_cut
  RayState states_[PacketRays::k_size];
  RecentOccluders recent_;
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
