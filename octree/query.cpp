// SPDX-License-Identifier: MIT
#include "octree/query.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <numeric>

#include "base/huge_memory.h"
#include "base/morton.h"
#include "base/remote_map.h"
#include "octree/answer_target.h"
#include "octree/check_query.h"
#include "octree/octree.h"
#include "octree/simd/ray_state.h"
#include "octree/simd/sort_keys.h"

namespace alidade {
namespace {

// Enough work per task to hide the scheduler, few enough that the last tasks do not leave threads idle.
constexpr std::size_t k_grain = 256;
// Rays that go through the tree together: the more, the more often they share a node; the fewer, the longer
// their states stay in the second-level cache. Small batches are cut into smaller pieces, so that no thread
// is idle.
constexpr std::size_t k_most_stream_rays = 12288;
std::size_t stream_grain(std::size_t rays) {
  const auto threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  return threads == 1 ? k_most_stream_rays : std::clamp(rays / (16 * threads), k_grain, k_most_stream_rays);
}

/// Errors: the index file lies on a server and could not be read: what was answered may be wrong.
void check_arrival(const Octree& octree) {
  RemoteMap::check(octree.view().coordinates);
}

template <class Answer>
Answer arrived(const Octree& octree, Answer&& answer) {
  check_arrival(octree);
  return std::forward<Answer>(answer);
}

template <class Target, class Query>
void check_many(const Octree& octree, std::span<const Target>, const Query& query) {
  check_conditions<Target>(query);
  check_against(octree, query);
}

template <class Target, class Query, class Answer, class Ask>
void ask_many(const Octree& octree, std::span<const Target> targets, const Query& query,
              std::span<Answer> answers, const Ask& ask) {
  check_many(octree, targets, query);
  check_room(targets.size(), answers.size());
  for_each_range(targets, k_grain, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) answers[i] = ask(octree, targets[i], query, i);
  });
}

/// Brings targets, given by their numbers in the lower halves, into an order in which each is near the one
/// before. position(number): of a target.
template <class Position>
void sort_along_curve(const Position& position, std::vector<simd::SortKey>& numbers) {
  constexpr int k_bits = 10;
  Bounds bounds;
  for (const simd::SortKey key : numbers) bounds.grow(position(simd::number_of(key)));
  const glm::dvec3 size = bounds.size();
  const double widest = std::max({size.x, size.y, size.z});
  constexpr double k_least = 1e-290;  // its inverse times any number of cells is finite
  if (!(widest >= k_least) || std::isinf(widest)) return;
  const double cells = ((1 << k_bits) - 1) / widest;
  for (simd::SortKey& key : numbers) {
    const glm::dvec3 cell = (position(simd::number_of(key)) - bounds.min) * cells;
    key = simd::number_of(key) |
          morton_key(static_cast<std::uint32_t>(cell.x), static_cast<std::uint32_t>(cell.y),
                     static_cast<std::uint32_t>(cell.z))
              << 32;
  }
  simd::sort_keys(numbers);
}

/// Calls trace(rays, first_index, answers) for parts of a batch of rays whose origins are scattered, in an order in which
/// they start side by side: so they share their way through the tree. The order costs some 30 ns per ray, and rays that
/// bounce off surfaces, shuffled, take 0.6 to 0.7 of the time. Indices are those of the parts.
template <class Answer, class Trace>
void trace_side_by_side(const Octree& octree, std::span<const Ray> rays, std::span<Answer> answers,
                        const Trace& trace) {
  constexpr std::size_t k_most_sorted = std::size_t{1} << 20;      // bounds the memory for the order
  for_each_range(rays, k_grain, [](std::size_t, std::size_t) {});  // checks them
  for (std::size_t begin = 0; begin < rays.size(); begin += k_most_sorted) {
    const std::span<const Ray> part = rays.subspan(begin, std::min(k_most_sorted, rays.size() - begin));
    std::vector<simd::SortKey> order(part.size());
    std::iota(order.begin(), order.end(), simd::SortKey{0});
    const auto start = [&](std::uint32_t number) {
      return glm::clamp(part[number].origin, octree.bounds().min, octree.bounds().max);
    };
    sort_along_curve(start, order);
    const std::size_t grain = stream_grain(part.size());
    tbb::parallel_for(std::size_t{0}, (part.size() + grain - 1) / grain, [&](std::size_t p) {
      const std::span<const simd::SortKey> rest = std::span(order).subspan(p * grain);
      const std::span<const simd::SortKey> numbers = rest.first(std::min(rest.size(), grain));
      std::vector<Ray> sorted(numbers.size());
      std::vector<Answer> found(numbers.size());
      for (std::size_t i = 0; i < sorted.size(); ++i) sorted[i] = part[simd::number_of(numbers[i])];
      trace(std::span<const Ray>(sorted), std::size_t{0}, std::span<Answer>(found));
      for (std::size_t i = 0; i < sorted.size(); ++i) answers[begin + simd::number_of(numbers[i])] = found[i];
    });
  }
}

/// Many rays to `closest` or `occluded`: through the tree together, those that lanes do not answer one by
/// one.
template <class Answer, class Stream, class Ask>
void ask_rays(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
              std::span<Answer> answers, const Stream& stream, const Ask& ask) {
  if (octree.size() == 0 || !has_traversal(octree, query)) {
    ask_many(octree, rays, query, answers, ask);
    return;
  }
  check_many(octree, rays, query);
  check_room(rays.size(), answers.size());
  const auto trace = [&](std::span<const Ray> rest, std::size_t first_index, std::span<Answer> room) {
    while (!rest.empty()) {
      const auto suiting =
          static_cast<std::size_t>(std::ranges::find_if_not(rest, suits_traversal) - rest.begin());
      if (suiting > 0) stream(octree.view(), rest.first(suiting), query, first_index, room.first(suiting));
      if (suiting == rest.size()) return;
      room[suiting] = ask(octree, rest[suiting], query, first_index + suiting);
      rest = rest.subspan(suiting + 1);
      room = room.subspan(suiting + 1);
      first_index += suiting + 1;
    }
  };
  // Filters receive the index of the ray, which sorting changes.
  if (rays.size() >= 4 * k_most_stream_rays && !query.filter &&
      !simd::start_side_by_side(octree.view().extent, rays))
    return trace_side_by_side(octree, rays, answers, trace);
  for_each_range(rays, stream_grain(rays.size()), [&](std::size_t first, std::size_t last) {
    trace(rays.subspan(first, last - first), first, answers.subspan(first, last - first));
  });
}

/// A batch that is answered along a curve through the targets, whatever the order of the caller.
class CurveBatch {
 public:
  CurveBatch(const Octree& octree, std::span<const glm::dvec3> targets, const PointQuery& query)
      : octree_(octree), targets_(targets), query_(query) {}

  Answers<PointHit> find() {
    for_each_range(targets_, k_turn, [](std::size_t, std::size_t) {});  // checks them
    std::vector<simd::SortKey> order(targets_.size());
    std::iota(order.begin(), order.end(), simd::SortKey{0});
    sort_along_curve([&](std::uint32_t number) { return targets_[number]; }, order);
    std::vector<std::size_t>& begin = answers_.begin;
    begin.resize(targets_.size() + 1);
    // Without radius and level the number of answers is known, and they are written in place.
    const bool is_known = std::isinf(query_.radius) && query_.max_level == k_all_levels;
    if (is_known) {
      for (std::size_t& first : begin) first = std::min(query_.k, octree_.size());
      make_room();
    }
    std::vector<Turn> turns((order.size() + k_turn - 1) / k_turn);
    tbb::parallel_for(std::size_t{0}, turns.size(), [&](std::size_t t) {
      const std::span<const simd::SortKey> rest = std::span(order).subspan(t * k_turn);
      const auto numbers = rest.first(std::min(rest.size(), k_turn));
      turns[t].numbers.assign(numbers.begin(), numbers.end());
      answer(turns[t]);
      if (!is_known) return;
      put_in_place(turns[t]);
      turns[t] = {};
    });
    if (is_known) return std::move(answers_);
    for (const Turn& turn : turns)
      for (std::size_t i = 0; i < turn.numbers.size(); ++i)
        begin[simd::number_of(turn.numbers[i])] = turn.ends[i] - (i == 0 ? 0 : turn.ends[i - 1]);
    make_room();
    tbb::parallel_for(std::size_t{0}, turns.size(), [&](std::size_t t) { put_in_place(turns[t]); });
    return std::move(answers_);
  }

 private:
  static constexpr std::size_t k_turn = 1024;

  /// Targets one after another along the curve.
  struct Turn {
    std::vector<simd::SortKey> numbers;  ///< in the lower halves
    std::vector<PointHit> answers;
    std::vector<std::size_t> ends;  ///< of each target's answers
  };

  /// `begin` holds how many answers each target has, and then where they begin.
  void make_room() {
    std::vector<std::size_t>& begin = answers_.begin;
    begin.back() = 0;
    std::exclusive_scan(begin.begin(), begin.end(), begin.begin(), std::size_t{0});
    answers_.all.reserve(begin.back());
    request_huge_pages(answers_.all.data(), begin.back() * sizeof(PointHit));
    answers_.all.resize(begin.back());
  }

  void answer(Turn& turn) const {
    sort_along_curve([&](std::uint32_t number) { return targets_[number]; }, turn.numbers);
    std::vector<glm::dvec3> targets(turn.numbers.size());
    for (std::size_t i = 0; i < targets.size(); ++i) targets[i] = targets_[simd::number_of(turn.numbers[i])];
    turn.ends.reserve(targets.size());
    double reach = 0.0;
    find_in_turn(octree_, targets, query_, reach, turn.answers, turn.ends);
  }

  void put_in_place(const Turn& turn) {
    for (std::size_t i = 0, first = 0; i < turn.ends.size(); first = turn.ends[i++])
      std::copy_n(turn.answers.data() + first, turn.ends[i] - first,
                  answers_.all.data() + answers_.begin[simd::number_of(turn.numbers[i])]);
  }

  const Octree& octree_;
  const std::span<const glm::dvec3> targets_;
  const PointQuery& query_;
  Answers<PointHit> answers_;
};

}  // namespace

template <AskableAlong T>
std::optional<Hit> closest(const Octree& octree, const T& target, const QueryOf<T>& query) {
  check_target(octree, target, query);
  return arrived(octree, first_hit(octree, target, query, 0));
}

void closest(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
             std::span<std::optional<Hit>> hits) {
  ask_rays(octree, rays, query, hits, simd::traversal(octree.instruction_set()).closest_stream,
           first_hit<Ray, RayQuery>);
  check_arrival(octree);
}

template <AskableAlong T>
bool occluded(const Octree& octree, const T& target, const QueryOf<T>& query) {
  check_target(octree, target, query);
  return arrived(octree, any_hit(octree, target, query, 0));
}

void occluded(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
              std::span<std::uint8_t> answers) {
  ask_rays(octree, rays, query, answers, simd::traversal(octree.instruction_set()).occluded_stream,
           any_hit<Ray, RayQuery>);
  check_arrival(octree);
}

template <Askable T>
std::vector<AnswerOf<T>> FamilyAnswers<T>::find(const Octree& octree, const T& target,
                                                const QueryOf<T>& query) {
  check_target(octree, target, query);
  std::vector<AnswerOf<T>> answers;
  find_into(octree, target, query, query.k, 0, answers);
  check_arrival(octree);
  return answers;
}

template <Askable T>
Answers<AnswerOf<T>> FamilyAnswers<T>::find(const Octree& octree, std::span<const T> targets,
                                            const QueryOf<T>& query) {
  check_many(octree, targets, query);
  if constexpr (std::same_as<T, glm::dvec3>) {
    if (suits_turns(octree, query) && targets.size() <= std::numeric_limits<std::uint32_t>::max())
      return arrived(octree, CurveBatch(octree, targets, query).find());
  }
  const auto find_one = [&](std::size_t i, std::vector<AnswerOf<T>>& answers) {
    find_into(octree, targets[i], query, query.k, i, answers);
  };
  return arrived(octree, answer_all<AnswerOf<T>>(targets, k_grain, find_one));
}

template <Askable T>
std::size_t FamilyAnswers<T>::count(const Octree& octree, const T& target, const QueryOf<T>& query) {
  check_target(octree, target, query);
  return arrived(octree, count_to(octree, target, query, query.k, 0));
}

template <Askable T>
void FamilyAnswers<T>::count(const Octree& octree, std::span<const T> targets, const QueryOf<T>& query,
                             std::span<std::size_t> counts) {
  ask_many(octree, targets, query, counts,
           [](const Octree& tree, const T& target, const QueryOf<T>& asked, std::size_t i) {
             return count_to(tree, target, asked, asked.k, i);
           });
  check_arrival(octree);
}

template std::optional<Hit> closest(const Octree&, const Ray&, const RayQuery&);
template std::optional<Hit> closest(const Octree&, const Cone&, const ConeQuery&);
template bool occluded(const Octree&, const Ray&, const RayQuery&);
template bool occluded(const Octree&, const Cone&, const ConeQuery&);
template struct FamilyAnswers<Ray>;
template struct FamilyAnswers<Cone>;
template struct FamilyAnswers<Path>;
template struct FamilyAnswers<HalfSpaces>;
template struct FamilyAnswers<Bounds>;
template struct FamilyAnswers<glm::dvec3>;

}  // namespace alidade
