// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_TRACER_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_TRACER_INL_H
#undef ALIDADE_SIMD_TRACER_INL_H
#else
#define ALIDADE_SIMD_TRACER_INL_H
#endif

#include <algorithm>
#include <array>
#include <memory>
#include <new>
#include <numeric>
#include <span>
#include <type_traits>
#include <vector>

#include "octree/simd/ray_order-inl.h"
#include "octree/simd/ray_packet-inl.h"
#include "octree/simd/ray_state.h"
#include "octree/simd/ray_stream-inl.h"
#include "octree/simd/recent_occluders-inl.h"
#include "octree/simd/traversal.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// How a ray is to be traced.
enum class Course : std::uint8_t {
  misses,  ///< does not come near the points, or its interval is empty
  usual,
  far_away,  ///< needs a setup for rays from anywhere
};

HWY_INLINE double clamped(double t) {
  return std::min(std::max(t, -k_far), k_far);
}

/// Fills boxes and state; nothing is found.
HWY_INLINE Course set_up(const QuerySetup& setup, const ActiveRay& active) {
  const Ray& ray = active.input;
  RayBoxes& boxes = active.boxes;
  RayState& state = active.state;
  const hn::CappedTag<double, 4> d;
  alignas(32) double inverse[4], way[4], enters[4], leaves[4];
  for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(d)) {
    // Lane 3 holds the next member of the ray; its results are not used. The sign is taken here and nowhere
    // else, so that -0.0 has the same sign everywhere.
    const auto origin = hn::LoadU(d, &ray.origin.x + lane), direction = hn::LoadU(d, &ray.direction.x + lane);
    const auto length = hn::Div(hn::Set(d, 1.0), hn::Max(hn::Abs(direction), hn::Set(d, 1e-12)));
    const auto inverses = hn::IfThenElse(hn::Lt(direction, hn::Zero(d)), hn::Neg(length), length);
    const auto radius = hn::Set(d, setup.box_radius);
    const auto below = hn::Sub(hn::Sub(hn::LoadU(d, setup.tree.extent.low + lane), radius), origin),
               above = hn::Sub(hn::Add(hn::LoadU(d, setup.tree.extent.high + lane), radius), origin);
    const auto a = hn::Mul(below, inverses), b = hn::Mul(above, inverses);
    hn::Store(inverses, d, inverse + lane);
    hn::Store(hn::Max(hn::Abs(below), hn::Abs(above)), d, way + lane);
    hn::Store(hn::Min(a, b), d, enters + lane);
    hn::Store(hn::Max(a, b), d, leaves + lane);
  }
  state.best_low = std::numeric_limits<double>::infinity();
  if (way[0] + way[1] + way[2] > setup.longest_way) return Course::far_away;
  const double first = std::max(ray.t_min, setup.query.entry_min);
  const double begin =
      std::max(std::max(enters[0], enters[1]), std::max(enters[2], first - setup.before_limits()));
  if (!(begin <= std::min(std::min(leaves[0], leaves[1]), leaves[2]))) return Course::misses;
  if (setup.has_site) {
    for (int axis = 0; axis < 3; ++axis) {
      const double from_corner = begin * ray.direction[axis] + (ray.origin[axis] - setup.corner[axis]);
      if (std::fabs(from_corner) > setup.longest_origin) return Course::far_away;
    }
  }
  state.shift = begin;
  state.limits.t_min = clamped(ray.t_min - begin);
  state.limits.t_max = clamped(ray.t_max - begin);
  state.limits.entry_min = clamped(setup.query.entry_min - begin);
  state.limits.cut = state.limits.t_max + setup.double_error;
  const float t_cut = float_above(state.limits.cut);
  const hn::Rebind<float, decltype(d)> floats;
  for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(d)) {
    const auto inverses = hn::Load(d, inverse + lane);
    const auto origin =
        hn::MulAdd(hn::Set(d, begin), hn::LoadU(d, &ray.direction.x + lane),
                   hn::Sub(hn::LoadU(d, &ray.origin.x + lane), hn::LoadU(d, setup.corner + lane)));
    // One store per vector: a vector load soon after stores of its parts would stall.
    const auto is_axis = hn::FirstN(floats, lane < 3 ? 3 - lane : 0);
    hn::Store(hn::DemoteTo(floats, inverses), floats, boxes.inverse + lane);
    hn::Store(
        hn::IfThenElse(is_axis, hn::DemoteTo(floats, hn::Mul(origin, inverses)), hn::Set(floats, t_cut)),
        floats, boxes.origin_t + lane);
  }
  return t_cut >= 0.0f ? Course::usual : Course::misses;
}

/// Many rays, a few of them active at a time by turns: while one does its step, the memory that the others
/// need next is on its way to the processor. For rays that have little of the tree in common.
/// rays: numbers in the batch.
template <class Points, bool any>
void trace_interleaved(const Traversed<Points, any>& traversed, const RayBatch& batch,
                       std::span<const std::uint32_t> rays) {
  using Walk = RayWalk<Points, any>;
  constexpr std::size_t k_turns = 12;
  struct Turn {
    alignas(Walk) std::byte walk[sizeof(Walk)];
    bool has_leaves = false;
  };
  const auto turns = std::make_unique_for_overwrite<Turn[]>(k_turns);
  const auto walk_of = [](Turn& turn) { return std::launder(reinterpret_cast<Walk*>(turn.walk)); };
  const Frame root = root_frame(traversed.setup.tree);
  std::size_t next = 0, active = 0;
  const auto start = [&](Turn& turn) {
    new (turn.walk) Walk(traversed, batch[rays[next++]], root);
    turn.has_leaves = false;
  };
  while (active < k_turns && next < rays.size()) start(turns[active++]);
  while (active > 0) {
    for (std::size_t i = 0; i < active;) {
      Turn& turn = turns[i];
      Walk& walk = *walk_of(turn);
      if (!turn.has_leaves && walk.meet_children(traversed)) {
        walk.prefetch_leaves(traversed);
        turn.has_leaves = true;
        ++i;
        continue;
      }
      if (turn.has_leaves) walk.test_leaves(traversed);
      turn.has_leaves = false;
      if (walk.next_node(traversed)) {
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

/// Answers rays on a tree whose points are of one kind (shared_radius-inl.h).
template <class Points, bool any>
class Tracer {
 public:
  /// first_index: query_index of rays[0].
  Tracer(const TreeView& tree, const Points& points, std::span<const Ray> rays, std::size_t first_index)
      : points_(points),
        setup_(tree, points_.conditions()),
        rays_(rays),
        first_index_(first_index),
        leaf_test_(setup_, points_),
        traversed_(setup_, leaf_test_) {}

  void trace(const ActiveRay& ray) const {
    if (start(ray)) simd::HWY_NAMESPACE::trace(traversed_, ray, root_frame(setup_.tree));
  }

  /// The answer to a query for any point, or for the closest one.
  using Answer = std::conditional_t<any, std::uint8_t, std::optional<typename Points::Answer>>;

  /// Answers all rays; answers: as long as they.
  void answer_all(std::span<Answer> answers) const {
    const bool side_by_side =
        start_side_by_side(setup_.tree.extent, rays_.size(), [&](std::size_t i) { return rays_[i].origin; });
    if (!side_by_side && !are_many()) return answer_interleaved(answers);
    constexpr std::size_t k_least_lanes = 4;
    if constexpr (hn::MaxLanes(RayLanes()) >= k_least_lanes) {
      if (!leaf_test_.all_in_double() && go_alike()) {
        return answer_in_packets(side_by_side, answers);
      }
    }
    Octants octants;
    for (std::uint32_t number = 0; number < rays_.size(); ++number)
      octants[octant_of(rays_[number])].push_back(number);
    answer_in_stream(RayMemory(*this).batch, octants, answers);
  }

  Answer answer(const ActiveRay& ray) const {
    if constexpr (any) {
      return ray.state.found() ? 1 : 0;
    } else {
      return leaf_test_.answer(ray);
    }
  }

  /// Answers one ray alone.
  Answer answer(std::size_t number) const {
    RayState state;
    RayBoxes boxes;
    const ActiveRay ray{rays_[number], boxes, state, first_index_ + number};
    trace(ray);
    return answer(ray);
  }

 private:
  using Octants = std::array<std::vector<std::uint32_t>, 8>;

  /// Whether most rays go in nearly the direction of the one before. This affects speed only: measured with
  /// campuses of 1 and 10 million points, packets take 0.6 to 0.95 of the stream's time for such rays
  /// (primary rays, rays to the sun), and up to twice its time for others.
  bool go_alike() const {
    constexpr double k_near = 0.05;
    return holds_for_most_pairs(rays_.size(), [&](std::size_t a, std::size_t b) {
      const glm::dvec3 turn = rays_[b].direction - rays_[a].direction;
      return std::fabs(turn.x) + std::fabs(turn.y) + std::fabs(turn.z) <= k_near;
    });
  }

  /// Answers by packets; by the stream what is left once packets meet nodes with too few rays to pay.
  void answer_in_packets(bool side_by_side, std::span<Answer> answers) const {
    using Packet = RayPacket<Points, any>;
    constexpr std::size_t k_first_look = 8;
    constexpr std::uint64_t k_fewest_rays_at_nodes = 8;  // on average
    const glm::dvec3 size = setup_.tree.bounds.size();
    const RayOrder order(rays_,
                         0.25 * std::min(std::max({size.x, size.y, size.z}), setup_.tree.extent.site_width),
                         side_by_side);
    const auto packet = std::make_unique<Packet>(traversed_);
    std::array<std::uint32_t, Packet::k_size> next;
    Octants left;
    bool pays = true;
    std::size_t packets = 0;
    for (unsigned octant = 0; octant < 8; ++octant) {
      std::span<const std::uint32_t> numbers = order.of_octant(octant);
      OccluderTest occluders(setup_, points_);
      while (!numbers.empty()) {
        const std::span<const std::uint32_t> some =
            next_packet(packet->results().recent_occluders(), occluders, numbers, next, answers);
        if (!pays) {
          left[octant].insert(left[octant].end(), some.begin(), some.end());
        } else if (!some.empty()) {
          answer_packet(*packet, some, octant, answers);
          if (++packets >= k_first_look)
            pays = packet->rays_at_nodes() >= k_fewest_rays_at_nodes * packet->nodes();
        }
      }
    }
    if (std::ranges::any_of(left, [](const auto& numbers) { return !numbers.empty(); }))
      answer_in_stream(RayMemory(*this).batch, left, answers);
  }

  /// Takes rays from the front of `numbers` for a packet, answers those that recent occluders hide, and
  /// returns the others, which it puts into `next`.
  std::span<const std::uint32_t> next_packet(const RecentOccluders& recent, OccluderTest<Points>& occluders,
                                             std::span<const std::uint32_t>& numbers,
                                             std::span<std::uint32_t> next, std::span<Answer> answers) const {
    constexpr std::size_t k_full_enough = 48;
    std::size_t count = 0;
    while (count < k_full_enough && !numbers.empty()) {
      const std::span<const std::uint32_t> some =
          numbers.first(std::min(next.size() - count, numbers.size()));
      numbers = numbers.subspan(some.size());
      for (const std::uint32_t number : some) hwy::Prefetch(&answers[number]);
      for (const std::uint32_t number : numbers.first(std::min(next.size(), numbers.size())))
        hwy::Prefetch(&rays_[number]);
      std::uint64_t hidden = 0;
      if constexpr (any) hidden = occluders.hidden(recent, rays_, some, first_index_);
      for (std::size_t i = 0; i < some.size(); ++i) {
        if ((hidden >> i & 1) == 0) {
          next[count++] = some[i];
        } else if constexpr (any) {
          answers[some[i]] = 1;
        }
      }
    }
    return next.first(count);
  }

  void answer_packet(RayPacket<Points, any>& packet, std::span<const std::uint32_t> numbers, unsigned octant,
                     std::span<Answer> answers) const {
    packet.run(rays_, numbers, octant, first_index_);
    const auto& results = packet.results();
    PacketHits hits;
    if constexpr (!any && !Points::are_discs) {
      for (std::uint64_t rest = results.found(); rest != 0; rest &= rest - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
        hits.add(points_, setup_.tree, lane, results.leaf_of(lane), results.point_of(lane));
      }
      hits.evaluate(packet.rays());
    }
    for (std::size_t lane = 0; lane < numbers.size(); ++lane) {
      const std::uint32_t number = numbers[lane];
      if ((results.unclear() >> lane & 1) != 0) {
        answers[number] = answer(std::size_t{number});
      } else if constexpr (Points::are_discs) {
        answers[number] = answer(results.ray(lane));
      } else if ((results.found() >> lane & 1) == 0) {
        answers[number] = Answer();
      } else if constexpr (any) {
        answers[number] = 1;
      } else {
        // Coordinates of a damaged index file can lie where floats are sure of them and doubles are not.
        if (!hits.template write<Points>(setup_, rays_[number], lane, answers[number]))
          answers[number] = answer(std::size_t{number});
      }
    }
  }

  void answer_in_stream(const RayBatch& batch, Octants& octants, std::span<Answer> answers) const {
    RayStream<Points, any> stream(traversed_);
    for (unsigned octant = 0; octant < 8; ++octant) {
      std::vector<std::uint32_t>& numbers = octants[octant];
      std::vector<std::uint32_t> active = start_all(batch, numbers);
      if (const std::size_t count = active.size(); count != 0) {
        active.resize(count + k_list_padding);
        stream.run(batch, std::span(active).first(count), octant);
      }
      for (const std::uint32_t number : numbers) answers[number] = answer(batch[number]);
    }
  }

  void answer_interleaved(std::span<Answer> answers) const {
    std::vector<std::uint32_t> numbers(rays_.size());
    std::iota(numbers.begin(), numbers.end(), 0u);
    const RayMemory memory(*this);
    const std::vector<std::uint32_t> active = start_all(memory.batch, numbers);
    // Turns hide the way to memory, and cost more than that where the nodes are in the processor's cache.
    constexpr std::uint32_t k_nearby_nodes = 1u << 14;
    if (setup_.tree.node_count <= k_nearby_nodes) {
      for (const std::uint32_t number : active)
        simd::HWY_NAMESPACE::trace(traversed_, memory.batch[number], root_frame(setup_.tree));
    } else {
      trace_interleaved(traversed_, memory.batch, std::span<const std::uint32_t>(active));
    }
    for (const std::uint32_t number : numbers) answers[number] = answer(memory.batch[number]);
  }

  /// Boxes and states of all rays; not filled with zeros first, since a ray's setup writes all that is read.
  struct RayMemory {
    explicit RayMemory(const Tracer& tracer)
        : boxes(std::make_unique_for_overwrite<RayBoxes[]>(tracer.rays_.size())),
          states(std::make_unique_for_overwrite<RayState[]>(tracer.rays_.size())),
          batch{tracer.rays_.data(), boxes.get(), states.get(), tracer.first_index_} {}
    const std::unique_ptr<RayBoxes[]> boxes;
    const std::unique_ptr<RayState[]> states;
    const RayBatch batch;
  };

  /// Whether the rays are many beside the tree's nodes. Such rays meet many nodes together, as do those of
  /// which most start near the one before. This affects speed only: measured with campuses of 1, 10 and 50
  /// million points, rays that bounce off neighbouring pixels are 1.4 times faster together, the same rays in
  /// random order too once there is one for every 128 nodes (measured as 64 nodes of 8 children); blocks of
  /// 256 of these are 1.15 times slower together.
  bool are_many() const {
    constexpr std::size_t k_many_rays = 2048;
    return rays_.size() >= k_many_rays && 128 * rays_.size() >= setup_.tree.node_count;
  }

  /// The rays that are to go through the tree; the states of the others hold the answer.
  std::vector<std::uint32_t> start_all(const RayBatch& batch, std::span<const std::uint32_t> numbers) const {
    // The processor's own prefetching ends with every page.
    constexpr std::size_t k_ahead = 12;
    std::vector<std::uint32_t> active;
    active.reserve(numbers.size() + k_list_padding);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      if (i + k_ahead < numbers.size()) hwy::Prefetch(&rays_[numbers[i + k_ahead]]);
      if (start(batch[numbers[i]])) active.push_back(numbers[i]);
    }
    return active;
  }

  /// Whether the ray is to go through the tree; if not, its state holds the answer.
  bool start(const ActiveRay& ray) const {
    const Course course = set_up(setup_, ray);
    if (course == Course::far_away) trace_far_away(ray);
    return course == Course::usual;
  }

  void trace_far_away(const ActiveRay& ray) const {
    double way = setup_.query.radius;
    for (int axis = 0; axis < 3; ++axis) {
      way += std::max(std::fabs(setup_.tree.bounds.min[axis] - ray.input.origin[axis]),
                      std::fabs(setup_.tree.bounds.max[axis] - ray.input.origin[axis]));
    }
    // Twice and more, since the way is measured to the widened bounds.
    const QuerySetup setup(setup_.tree, setup_.query, 2.0 * (way + 3.0 * setup_.box_radius));
    const LeafTest<Points, any> leaf_test(setup, points_);
    if (set_up(setup, ray) == Course::usual)
      simd::HWY_NAMESPACE::trace(Traversed<Points, any>(setup, leaf_test), ray, root_frame(setup.tree));
  }

  const Points points_;
  const QuerySetup setup_;
  const std::span<const Ray> rays_;
  const std::size_t first_index_;
  const LeafTest<Points, any> leaf_test_;
  const Traversed<Points, any> traversed_;
};

/// The functions of a table. with_tracer: a struct whose call<any>(view, query, rays, first_index, use) calls
/// use with the Tracer that suits a query. any: the measure does not matter.
template <class View, class Query, class AnswerHit, class WithTracer>
struct TraversalBy {
  static std::optional<AnswerHit> closest(const View& view, const Ray& ray, const Query& query,
                                          std::size_t query_index) {
    return WithTracer::template call<false>(view, query, std::span(&ray, 1), query_index,
                                            [](const auto& tracer) { return tracer.answer(std::size_t{0}); });
  }
  static bool occluded(const View& view, const Ray& ray, const Query& query, std::size_t query_index) {
    return WithTracer::template call<true>(
        view, query, std::span(&ray, 1), query_index,
        [](const auto& tracer) { return tracer.answer(std::size_t{0}) != 0; });
  }
  static void closest_stream(const View& view, std::span<const Ray> rays, const Query& query,
                             std::size_t first_index, std::span<std::optional<AnswerHit>> hits) {
    WithTracer::template call<false>(view, query, rays, first_index,
                                     [&](const auto& tracer) { tracer.answer_all(hits); });
  }
  static void occluded_stream(const View& view, std::span<const Ray> rays, const Query& query,
                              std::size_t first_index, std::span<std::uint8_t> answers) {
    WithTracer::template call<true>(view, query, rays, first_index,
                                    [&](const auto& tracer) { tracer.answer_all(answers); });
  }
  static constexpr RayTraversal<View, Query, AnswerHit> k_table{closest, occluded, closest_stream,
                                                                occluded_stream};
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
