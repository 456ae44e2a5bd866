// SPDX-License-Identifier: MIT
#include "octree/simd/traversal.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octree/simd/traversal.cpp"
#include <hwy/foreach_target.h>

#include "octree/simd/ray_stream-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

template <Measure measure, bool any>
class Tracer {
 public:
  /// first_index: query_index of rays[0].
  Tracer(const TreeView& tree, const RayQuery& query, std::span<const Ray> rays, std::size_t first_index)
      : setup_(tree, query), rays_(rays), leaf_test_(setup_, rays, first_index), alone_(setup_, leaf_test_) {}

  void trace(RayState& state) const {
    start(0, state);
    if (needs_tree(state)) alone_.run(state, root_visit(setup_.tree));
  }

  /// Calls tell(number, state) for every ray.
  template <class Tell>
  void trace_together(const Tell& tell) const {
    std::vector<RayState> states(rays_.size());
    std::vector<std::uint32_t> octants[8];
    for (std::size_t i = 0; i < states.size(); ++i) {
      RayState& state = states[i];
      start(i, state);
      if (!needs_tree(state)) continue;
      if (state.double_error <= setup_.stream_error) {
        octants[state.octant].push_back(static_cast<std::uint32_t>(i));
      } else {
        alone_.run(state, root_visit(setup_.tree));
      }
    }
    RayStream<measure, any> stream(setup_, leaf_test_, alone_);
    for (unsigned octant = 0; octant < 8; ++octant)
      if (!octants[octant].empty()) stream.run(states, octants[octant], octant);
    for (std::size_t i = 0; i < states.size(); ++i) tell(i, states[i]);
  }

  std::optional<Hit> answer(const RayState& state) const { return leaf_test_.answer(state); }

 private:
  void start(std::size_t number, RayState& state) const {
    set_up(setup_, rays_[number], static_cast<std::uint32_t>(number), state);
    if (state.exhaustive)
      for_each_leaf(setup_.tree, [&](const Leaf& leaf) { leaf_test_.visit_in_double(state, leaf); });
  }
  static bool needs_tree(const RayState& state) { return !state.misses && !state.exhaustive; }

  const QuerySetup setup_;
  const std::span<const Ray> rays_;
  const LeafTest<measure, any> leaf_test_;
  const RayTraversal<measure, any> alone_;
};

template <Measure measure>
std::optional<Hit> closest_measured(const TreeView& tree, const Ray& ray, const RayQuery& query,
                                    std::size_t query_index) {
  const Tracer<measure, false> tracer(tree, query, {&ray, 1}, query_index);
  RayState state;
  tracer.trace(state);
  return tracer.answer(state);
}

std::optional<Hit> closest(const TreeView& tree, const Ray& ray, const RayQuery& query,
                           std::size_t query_index) {
  return query.measure == Measure::t ? closest_measured<Measure::t>(tree, ray, query, query_index)
                                     : closest_measured<Measure::entry>(tree, ray, query, query_index);
}

bool occluded(const TreeView& tree, const Ray& ray, const RayQuery& query, std::size_t query_index) {
  RayState state;
  Tracer<Measure::t, true>(tree, query, {&ray, 1}, query_index).trace(state);
  return state.found;
}

template <Measure measure>
void stream_measured(const TreeView& tree, std::span<const Ray> rays, const RayQuery& query,
                     std::size_t first_index, std::span<std::optional<Hit>> hits) {
  const Tracer<measure, false> tracer(tree, query, rays, first_index);
  tracer.trace_together(
      [&](std::size_t number, const RayState& state) { hits[number] = tracer.answer(state); });
}

void closest_stream(const TreeView& tree, std::span<const Ray> rays, const RayQuery& query,
                    std::size_t first_index, std::span<std::optional<Hit>> hits) {
  if (query.measure == Measure::t) {
    stream_measured<Measure::t>(tree, rays, query, first_index, hits);
  } else {
    stream_measured<Measure::entry>(tree, rays, query, first_index, hits);
  }
}

void occluded_stream(const TreeView& tree, std::span<const Ray> rays, const RayQuery& query,
                     std::size_t first_index, std::span<std::uint8_t> answers) {
  const Tracer<Measure::t, true> tracer(tree, query, rays, first_index);
  tracer.trace_together(
      [&](std::size_t number, const RayState& state) { answers[number] = state.found ? 1 : 0; });
}

constexpr Traversal k_traversal{closest, occluded, closest_stream, occluded_stream};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alidade::simd {

const Traversal& traversal(InstructionSet instruction_set) {
  switch (instruction_set) {
#if HWY_TARGETS & HWY_AVX3
    case InstructionSet::avx512:
      return N_AVX3::k_traversal;
#endif
#if HWY_TARGETS & HWY_AVX2
    case InstructionSet::avx2:
      return N_AVX2::k_traversal;
#endif
#if HWY_TARGETS & HWY_SSE4
    case InstructionSet::sse4:
      return N_SSE4::k_traversal;
#endif
#if HWY_TARGETS & HWY_SSSE3
    case InstructionSet::ssse3:
      return N_SSSE3::k_traversal;
#endif
      // Which of its two scalar targets Highway compiles depends on the compiler.
#if HWY_TARGETS & HWY_SCALAR
    default:
      return N_SCALAR::k_traversal;
#else
    default:
      return N_EMU128::k_traversal;
#endif
  }
}

}  // namespace alidade::simd
#endif  // HWY_ONCE
