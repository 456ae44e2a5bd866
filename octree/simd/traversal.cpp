// SPDX-License-Identifier: MIT
#include "octree/simd/search.h"

#include <array>
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octree/simd/traversal.cpp"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

#include "octree/simd/choose_table.h"
#include "octree/simd/ray_state.h"
#include "octree/simd/ray_stream-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// How a ray is to be traced.
enum class Course : std::uint8_t {
  misses,  ///< does not come near the points, or its interval is empty
  usual,
  far_away,  ///< needs a setup for a longer way
};

HWY_INLINE double clamped(double t) {
  return std::min(std::max(t, -k_far), k_far);
}

/// Fills boxes and state; nothing is found.
HWY_INLINE Course set_up(const QuerySetup& setup, const RayUnderWay& under_way) {
  const Ray& ray = under_way.asked;
  RayBoxes& boxes = under_way.boxes;
  RayState& state = under_way.state;
  state.best_low = std::numeric_limits<double>::infinity();
  double enter = -std::numeric_limits<double>::infinity(), leave = std::numeric_limits<double>::infinity();
  double inverse[3], way = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    // The sign is taken here and nowhere else, so that -0.0 cannot be seen differently in two computations.
    const double d = ray.direction[axis];
    const double sign = d < 0.0 ? -1.0 : 1.0;
    inverse[axis] = sign / std::max(std::fabs(d), 1e-12);
    const double below = setup.low_face[axis] - ray.origin[axis];
    const double above = setup.high_face[axis] - ray.origin[axis];
    way += std::max(std::fabs(below), std::fabs(above));
    enter = std::max(enter, std::min(below * inverse[axis], above * inverse[axis]));
    leave = std::min(leave, std::max(below * inverse[axis], above * inverse[axis]));
  }
  if (way > setup.longest_way) return Course::far_away;
  if (enter > leave) return Course::misses;
  state.shift = enter;
  for (int axis = 0; axis < 3; ++axis) {
    const double origin = (ray.origin[axis] - setup.corner[axis]) + enter * ray.direction[axis];
    boxes.inverse[axis] = static_cast<float>(inverse[axis]);
    boxes.origin_t[axis] = static_cast<float>(origin * inverse[axis]);
  }
  state.limits.t_min = clamped(ray.t_min - enter);
  state.limits.t_max = clamped(ray.t_max - enter);
  state.limits.entry_min = clamped(setup.query.entry_min - enter);
  state.limits.cut = state.limits.t_max + setup.double_error;
  boxes.t_low = float_below(std::max(state.limits.t_min, state.limits.entry_min) - setup.box_radius);
  boxes.t_cut = float_above(state.limits.cut);
  return boxes.t_low <= boxes.t_cut ? Course::usual : Course::misses;
}

/// Many rays, a few of them under way at a time by turns: while one does its step, the memory that the others
/// need next is on its way to the processor. For rays that have little of the tree in common.
/// rays: numbers in the batch.
template <Measure measure, bool any, Radii radii>
void trace_interleaved(const Traversed<measure, any, radii>& traversed, const RayBatch& batch,
                       std::span<const std::uint32_t> rays) {
  using Walk = RayWalk<measure, any, radii>;
  constexpr std::size_t k_under_way = 12;
  struct Turn {
    alignas(Walk) std::byte walk[sizeof(Walk)];
    bool has_leaves = false;
  };
  const auto turns = std::make_unique_for_overwrite<Turn[]>(k_under_way);
  const auto walk_of = [](Turn& turn) { return std::launder(reinterpret_cast<Walk*>(turn.walk)); };
  const Frame root = root_frame(traversed.setup.tree);
  std::size_t next = 0, active = 0;
  const auto start = [&](Turn& turn) {
    new (turn.walk) Walk(traversed, batch[rays[next++]], root);
    turn.has_leaves = false;
  };
  while (active < k_under_way && next < rays.size()) start(turns[active++]);
  while (active > 0) {
    for (std::size_t i = 0; i < active;) {
      Turn& turn = turns[i];
      Walk& walk = *walk_of(turn);
      if (!turn.has_leaves && walk.look(traversed)) {
        walk.prefetch_leaves(traversed);
        turn.has_leaves = true;
        ++i;
        continue;
      }
      if (turn.has_leaves) walk.test_leaves(traversed);
      turn.has_leaves = false;
      if (walk.go_on(traversed)) {
        walk.prefetch_node(traversed);
        ++i;
      } else if (next < rays.size()) {
        start(turn);
        ++i;
      } else {
        --active;
        if (i != active) turn = turns[active];
      }
    }
  }
}

template <Measure measure, bool any, Radii radii>
class Tracer {
 public:
  /// first_index: query_index of rays[0].
  Tracer(const TreeView& tree, const RayQuery& query, std::span<const Ray> rays, std::size_t first_index)
      : setup_(tree, query),
        rays_(rays),
        first_index_(first_index),
        leaf_test_(setup_),
        traversed_(setup_, leaf_test_) {}

  void trace(const RayUnderWay& ray) const {
    if (start(ray)) simd::HWY_NAMESPACE::trace(traversed_, ray, root_frame(setup_.tree));
  }

  /// Calls take(number, ray) for every ray.
  template <class Take>
  void trace_together(const Take& take) const {
    // Not filled with zeros first: a ray's setup writes all that is read.
    const auto boxes = std::make_unique_for_overwrite<RayBoxes[]>(rays_.size());
    const auto states = std::make_unique_for_overwrite<RayState[]>(rays_.size());
    const RayBatch batch{rays_.data(), boxes.get(), states.get(), first_index_};
    if (share_nodes()) {
      std::array<std::vector<std::uint32_t>, 8> octants;
      start_all(batch, [&](std::uint32_t number) { octants[boxes[number].octant()].push_back(number); });
      RayStream<measure, any, radii> stream(traversed_);
      for (unsigned octant = 0; octant < 8; ++octant) {
        if (const std::size_t count = octants[octant].size(); count != 0) {
          octants[octant].resize(count + k_list_padding);
          stream.run(batch, std::span(octants[octant]).first(count), octant);
        }
      }
    } else {
      std::vector<std::uint32_t> under_way;
      start_all(batch, [&](std::uint32_t number) { under_way.push_back(number); });
      // Turns hide the way to memory, and cost more than that where the nodes are in the processor's cache.
      constexpr std::uint32_t k_nearby_nodes = 1u << 15;
      if (setup_.tree.node_count <= k_nearby_nodes) {
        for (const std::uint32_t number : under_way)
          simd::HWY_NAMESPACE::trace(traversed_, batch[number], root_frame(setup_.tree));
      } else {
        trace_interleaved(traversed_, batch, std::span<const std::uint32_t>(under_way));
      }
    }
    for (std::size_t i = 0; i < rays_.size(); ++i) take(i, batch[i]);
  }

  std::optional<Hit> answer(const RayUnderWay& ray) const { return leaf_test_.answer(ray); }

 private:
  /// Whether the rays meet many nodes together: if they are many beside the tree's nodes, or if most start
  /// near the one before. This decides about speed only: measured with campuses of 1, 10 and 50 million
  /// points, rays that bounce off neighbouring pixels are 1.4 times faster together, the same rays in random
  /// order too once there is one for every 64 nodes.
  bool share_nodes() const {
    if (64 * rays_.size() >= setup_.tree.node_count) return true;
    constexpr std::size_t k_samples = 64;
    const glm::dvec3 size = setup_.tree.bounds.size();
    const double near = (size.x + size.y + size.z) / 64.0;
    const std::size_t samples = std::min(k_samples, rays_.size() - 1);
    std::size_t near_count = 0;
    for (std::size_t s = 0; s < samples; ++s) {
      const std::size_t i = s * (rays_.size() - 1) / samples;
      const glm::dvec3 apart = rays_[i + 1].origin - rays_[i].origin;
      near_count += std::fabs(apart.x) + std::fabs(apart.y) + std::fabs(apart.z) <= near;
    }
    return 2 * near_count > samples;
  }

  /// Calls go(number) for every ray that is to go through the tree; the states of the others hold the answer.
  template <class Go>
  void start_all(const RayBatch& batch, const Go& go) const {
    // What the processor foresees by itself ends with every page.
    constexpr std::size_t k_ahead = 12;
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      if (i + k_ahead < rays_.size()) hwy::Prefetch(&rays_[i + k_ahead]);
      if (start(batch[i])) go(static_cast<std::uint32_t>(i));
    }
  }

  /// Whether the ray is to go through the tree; if not, its state holds the answer.
  bool start(const RayUnderWay& ray) const {
    const Course course = set_up(setup_, ray);
    if (course == Course::far_away) trace_far_away(ray);
    return course == Course::usual;
  }

  void trace_far_away(const RayUnderWay& ray) const {
    double way = setup_.query.radius;
    for (int axis = 0; axis < 3; ++axis) {
      way += std::max(std::fabs(setup_.tree.bounds.min[axis] - ray.asked.origin[axis]),
                      std::fabs(setup_.tree.bounds.max[axis] - ray.asked.origin[axis]));
    }
    // Twice and more, since the way is measured to the widened bounds.
    const QuerySetup setup(setup_.tree, setup_.query, 2.0 * (way + 3.0 * setup_.box_radius));
    const LeafTest<measure, any, radii> leaf_test(setup);
    if (set_up(setup, ray) == Course::usual)
      simd::HWY_NAMESPACE::trace(Traversed<measure, any, radii>(setup, leaf_test), ray,
                                 root_frame(setup.tree));
  }

  const QuerySetup setup_;
  const std::span<const Ray> rays_;
  const std::size_t first_index_;
  const LeafTest<measure, any, radii> leaf_test_;
  const Traversed<measure, any, radii> traversed_;
};

template <Measure measure, bool any, Radii radii>
using TracerTag = std::type_identity<Tracer<measure, any, radii>>;

/// Calls use(TracerTag) for the tracer that suits a query for any point.
template <class Use>
auto with_tracer_of_any(const RayQuery& query, const Use& use) {
  return query.spacing_factor > 0.0 ? use(TracerTag<Measure::t, true, Radii::own>())
                                    : use(TracerTag<Measure::t, true, Radii::shared>());
}

/// The same for the closest point.
template <class Use>
auto with_tracer_of_closest(const RayQuery& query, const Use& use) {
  if (query.spacing_factor > 0.0) {
    return query.measure == Measure::t ? use(TracerTag<Measure::t, false, Radii::own>())
                                       : use(TracerTag<Measure::entry, false, Radii::own>());
  }
  return query.measure == Measure::t ? use(TracerTag<Measure::t, false, Radii::shared>())
                                     : use(TracerTag<Measure::entry, false, Radii::shared>());
}

std::optional<Hit> closest(const TreeView& tree, const Ray& ray, const RayQuery& query,
                           std::size_t query_index) {
  return with_tracer_of_closest(query, [&](auto tag) {
    const typename decltype(tag)::type tracer(tree, query, {&ray, 1}, query_index);
    RayState state;
    RayBoxes boxes;
    const RayUnderWay under_way{ray, boxes, state, query_index};
    tracer.trace(under_way);
    return tracer.answer(under_way);
  });
}

bool occluded(const TreeView& tree, const Ray& ray, const RayQuery& query, std::size_t query_index) {
  return with_tracer_of_any(query, [&](auto tag) {
    RayState state;
    RayBoxes boxes;
    typename decltype(tag)::type(tree, query, {&ray, 1}, query_index).trace({ray, boxes, state, query_index});
    return state.found();
  });
}

void closest_stream(const TreeView& tree, std::span<const Ray> rays, const RayQuery& query,
                    std::size_t first_index, std::span<std::optional<Hit>> hits) {
  with_tracer_of_closest(query, [&](auto tag) {
    const typename decltype(tag)::type tracer(tree, query, rays, first_index);
    tracer.trace_together(
        [&](std::size_t number, const RayUnderWay& ray) { hits[number] = tracer.answer(ray); });
  });
}

void occluded_stream(const TreeView& tree, std::span<const Ray> rays, const RayQuery& query,
                     std::size_t first_index, std::span<std::uint8_t> answers) {
  with_tracer_of_any(query, [&](auto tag) {
    const typename decltype(tag)::type tracer(tree, query, rays, first_index);
    tracer.trace_together(
        [&](std::size_t number, const RayUnderWay& ray) { answers[number] = ray.state.found() ? 1 : 0; });
  });
}

constexpr Traversal k_traversal{closest, occluded, closest_stream, occluded_stream};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alidade::simd {

const Traversal& traversal(InstructionSet instruction_set) {
  ALIDADE_CHOOSE_TABLE(instruction_set, k_traversal)
}

}  // namespace alidade::simd
#endif  // HWY_ONCE
