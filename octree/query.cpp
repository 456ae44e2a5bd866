// SPDX-License-Identifier: MIT
#include "octree/query.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/bounds.h"
#include "base/error.h"
#include "base/huge_memory.h"
#include "base/parallel.h"
#include "octree/answer_target.h"
#include "octree/check_query.h"
#include "octree/octree.h"
#include "octree/query_batch.h"
#include "octree/ray_batch.h"
#include "octree/simd/make_rays.h"
#include "octree/simd/sort_keys.h"
#include "octree/simd/traversal.h"

namespace alidade {
namespace {

// Enough work per task to hide the scheduler, few enough that the last tasks do not leave threads idle.
constexpr std::size_t k_grain = 256;

template <class Target, class Query>
void check_batch(const Octree& octree, const Query& query) {
  check_conditions<Target>(query);
  check_level(octree, query.max_level);
}

/// Targets one after another along a curve.
struct Turn {
  std::vector<simd::SortKey> numbers;  ///< in the lower halves
  std::vector<PointHit> answers;
  std::vector<std::size_t> ends;  ///< of each target's answers

  /// put(number, answers) for each target.
  template <class Put>
  void for_each(const Put& put) const {
    for (std::size_t i = 0, first = 0; i < ends.size(); first = ends[i++])
      put(simd::number_of(numbers[i]), std::span(answers).subspan(first, ends[i] - first));
  }
};

constexpr std::size_t k_turn = 1024;

void check_in_turns(std::span<const glm::dvec3> targets) {
  in_blocks(targets.size(), k_turn,
            [&](std::size_t first, std::size_t end) { check_range(targets, first, end); });
}

/// Answers targets along a curve through all of them, whatever the order of the caller: use(t, turn), in
/// parallel. Requires checked targets.
template <class Use>
void answer_in_turns(const Octree& octree, std::span<const glm::dvec3> targets, const PointQuery& query,
                     const Use& use) {
  const auto position = [&](std::uint32_t number) { return targets[number]; };
  std::vector<simd::SortKey> order(targets.size());
  std::iota(order.begin(), order.end(), simd::SortKey{0});
  sort_along_curve(position, order);
  in_blocks(order.size(), k_turn, [&](std::size_t first, std::size_t end) {
    const auto numbers = std::span<const simd::SortKey>(order).subspan(first, end - first);
    Turn turn;
    turn.numbers.assign(numbers.begin(), numbers.end());
    sort_along_curve(position, turn.numbers);
    std::vector<glm::dvec3> some(numbers.size());
    for (std::size_t i = 0; i < some.size(); ++i) some[i] = targets[simd::number_of(turn.numbers[i])];
    turn.ends.reserve(some.size());
    double reach = 0.0;
    find_in_turn(octree, some, query, reach, turn.answers, turn.ends);
    use(first / k_turn, std::move(turn));
  });
}

Answers<PointHit> find_in_turns(const Octree& octree, std::span<const glm::dvec3> targets,
                                const PointQuery& query) {
  check_in_turns(targets);
  Answers<PointHit> answers;
  std::vector<std::size_t>& begin = answers.begin;
  begin.resize(targets.size() + 1);
  // `begin` holds how many answers each target has, and then where they begin.
  const auto make_room = [&] {
    begin.back() = 0;
    std::exclusive_scan(begin.begin(), begin.end(), begin.begin(), std::size_t{0});
    answers.all.reserve(begin.back());
    request_huge_pages(answers.all.data(), begin.back() * sizeof(PointHit));
    answers.all.resize(begin.back());
  };
  const auto put_in_place = [&](const Turn& turn) {
    turn.for_each([&](std::size_t number, std::span<const PointHit> some) {
      std::ranges::copy(some, answers.all.data() + begin[number]);
    });
  };
  // Without radius and level the number of answers is known, and they are written in place.
  if (std::isinf(query.radius) && query.max_level == k_all_levels) {
    std::ranges::fill(begin, std::min(query.k, octree.size()));
    make_room();
    answer_in_turns(octree, targets, query, [&](std::size_t, const Turn& turn) { put_in_place(turn); });
    return answers;
  }
  std::vector<Turn> turns((targets.size() + k_turn - 1) / k_turn);
  answer_in_turns(octree, targets, query, [&](std::size_t t, Turn&& turn) { turns[t] = std::move(turn); });
  for (const Turn& turn : turns) {
    turn.for_each([&](std::size_t number, std::span<const PointHit> some) { begin[number] = some.size(); });
  }
  make_room();
  in_parallel(turns.size(), 1, [&](std::size_t t) { put_in_place(turns[t]); });
  return answers;
}

/// Rays in columns, each made when it is traced, and columns for their answers.
template <class AnswerOfRay, class AnswerColumns>
class RaysInColumns {
 public:
  using Answer = AnswerOfRay;

  RaysInColumns(const Octree& octree, const RayColumns& columns, const RayQuery& query,
                const AnswerColumns& answers, const Progress& progress)
      : instruction_set_(octree.instruction_set()),
        columns_(columns),
        answers_(answers),
        piece_({.first = query.filter ? k_few_rays : k_most_stream_rays,
                .most = k_most_stream_rays,
                .wanted = k_wanted_time}),
        done_(progress, columns.count) {}

  std::size_t size() const { return columns_.count; }
  glm::dvec3 origin(std::size_t number) const { return columns_.origin(number); }
  glm::dvec3 direction(std::size_t number) const { return columns_.direction(number); }
  void check(std::size_t, std::size_t) const {}  // rays are good once they are made

  template <class Trace>
  void answer_range(std::size_t first, std::size_t last, const Trace& trace) const {
    for (std::size_t begin = first; begin < last;) {
      const PieceSize::Clock::time_point start = PieceSize::Clock::now();
      const std::size_t end = std::min(begin + piece_.next(), last);
      rooms_.with_room(end - begin, [&](std::span<Ray> rays, std::span<Answer> answers) {
        if (!simd::make_rays(instruction_set_, columns_, begin, {}, rays)) name_bad(begin, end);
        trace(std::span<const Ray>(rays), begin, answers);
        for (std::size_t i = 0; i < answers.size(); ++i) answers_.put(begin + i, answers[i]);
      });
      piece_.learn(end - begin, PieceSize::Clock::now() - start);
      done_.add(end - begin);
      begin = end;
    }
  }
  void copy_rays(std::size_t begin, std::span<const simd::SortKey> numbers, std::span<Ray> rays) const {
    if (!simd::make_rays(instruction_set_, columns_, begin, numbers, rays)) name_bad(0, size());
  }
  void put(std::size_t begin, std::span<const simd::SortKey> numbers, std::span<const Answer> answers) const {
    constexpr std::size_t k_ahead = 24;
    const auto row = [&](std::size_t i) { return begin + simd::number_of(numbers[i]); };
    for (std::size_t i = 0; i < answers.size(); ++i) {
      answers_.prefetch(row(std::min(i + k_ahead, answers.size() - 1)));
      answers_.put(row(i), answers[i]);
    }
    done_.add(answers.size());
  }

 private:
  static constexpr std::chrono::milliseconds k_wanted_time{100};
  static constexpr std::size_t k_few_rays = 64;  // a filter may make each take milliseconds

  /// Errors: always.
  [[noreturn]] void name_bad(std::size_t first, std::size_t last) const {
    for (std::size_t row = first; row < last; ++row) (void)columns_.ray(row);
    throw input_error("the rays changed during the query", "arrays that stay as they are");
  }

  const InstructionSet instruction_set_;
  const RayColumns& columns_;
  const AnswerColumns answers_;
  mutable PieceSize piece_;  ///< rays between two reports of the progress
  mutable RoomOfTasks<Answer> rooms_;
  mutable JoinedProgress done_;
};

/// The next store there does not wait for the memory.
inline void prefetch_to_store(void* memory) {
  __builtin_prefetch(memory, 1);
}

struct HitsOfRows {
  const HitColumns& columns;
  void put(std::size_t row, const std::optional<Hit>& hit) const {
    hit ? columns.set(row, *hit) : columns.set_none(row);
  }
  void prefetch(std::size_t row) const {
    prefetch_to_store(columns.point_ids + row);
    prefetch_to_store(columns.t + row);
    prefetch_to_store(columns.distance + row);
    prefetch_to_store(columns.entry + row);
  }
};

struct BytesOfRows {
  std::uint8_t* answers;
  void put(std::size_t row, std::uint8_t answer) const { answers[row] = answer; }
  void prefetch(std::size_t row) const { prefetch_to_store(answers + row); }
};

template <class Batch, class Stream, class Answer>
void trace_checked(const Octree& octree, const Batch& batch, const RayQuery& query, Stream* stream,
                   const Answer& answer_one) {
  check(query);
  check_level(octree, query.max_level);
  const auto some = [&](std::span<const Ray> rays, std::size_t first_index, auto answers) {
    stream(octree.view(), rays, query, first_index, answers);
  };
  trace_batch(octree.view(), batch, has_traversal(octree.view(), query), static_cast<bool>(query.filter),
              some, [&](const Ray& ray, std::size_t index) { return answer_one(octree, ray, query, index); });
}

template <class Batch>
void closest_batch(const Octree& octree, const Batch& batch, const RayQuery& query) {
  trace_checked(octree, batch, query, simd::traversal(octree.instruction_set()).closest_stream,
                first_hit<Ray, RayQuery>);
}

template <class Batch>
void occluded_batch(const Octree& octree, const Batch& batch, const RayQuery& query) {
  trace_checked(octree, batch, query, simd::traversal(octree.instruction_set()).occluded_stream,
                any_hit<Ray, RayQuery>);
}

/// The first hit of each ray as the answers of `find`.
Answers<Hit> closest_answers(const Octree& octree, std::span<const Ray> rays, const RayQuery& query) {
  std::vector<std::optional<Hit>> hits(rays.size());
  closest_batch(octree, RaysInMemory<std::optional<Hit>>(rays, hits), query);
  Answers<Hit> answers;
  answers.begin.reserve(rays.size() + 1);
  for (const std::optional<Hit>& hit : hits) {
    if (hit) answers.all.push_back(*hit);
    answers.begin.push_back(answers.all.size());
  }
  return answers;
}

}  // namespace

template <LineGeometry T>
std::optional<Hit> closest(const Octree& octree, const T& target, const QueryOf<T>& query) {
  check_target(octree, target, query);
  return first_hit(octree, target, query, 0);
}

template <LineGeometry T>
bool occluded(const Octree& octree, const T& target, const QueryOf<T>& query) {
  check_target(octree, target, query);
  return any_hit(octree, target, query, 0);
}

template <TargetGeometry T>
std::vector<AnswerOf<T>> FamilyAnswers<T>::find(const Octree& octree, const T& target,
                                                const QueryOf<T>& query) {
  check_target(octree, target, query);
  std::vector<AnswerOf<T>> answers;
  find_into(octree, target, query, query.k, 0, answers);
  return answers;
}

template <TargetGeometry T>
Answers<AnswerOf<T>> FamilyAnswers<T>::find(const Octree& octree, std::span<const T> targets,
                                            const QueryOf<T>& query) {
  check_batch<T>(octree, query);
  if constexpr (std::same_as<T, Ray>) {
    if (query.k == 1) return closest_answers(octree, targets, query);
  }
  if constexpr (std::same_as<T, glm::dvec3>) {
    if (suits_turns(octree, query, targets.size())) return find_in_turns(octree, targets, query);
  }
  const auto find_one = [&](std::size_t i, std::vector<AnswerOf<T>>& answers) {
    find_into(octree, targets[i], query, query.k, i, answers);
  };
  return answer_all<AnswerOf<T>>(targets, k_grain, find_one);
}

template <TargetGeometry T>
std::size_t FamilyAnswers<T>::count(const Octree& octree, const T& target, const QueryOf<T>& query) {
  check_target(octree, target, query);
  return count_to(octree, target, query, query.k, 0);
}

template <TargetGeometry T>
void FamilyAnswers<T>::count(const Octree& octree, std::span<const T> targets, const QueryOf<T>& query,
                             std::span<std::size_t> counts) {
  check_batch<T>(octree, query);
  check_room(targets.size(), counts.size());
  if constexpr (std::same_as<T, Ray>) {
    if (query.k == 1) {
      std::vector<std::uint8_t> answers(targets.size());
      occluded_batch(octree, RaysInMemory<std::uint8_t>(targets, answers), query);
      std::ranges::copy(answers, counts.begin());
      return;
    }
  }
  for_each_target(targets, k_grain,
                  [&](std::size_t i) { counts[i] = count_to(octree, targets[i], query, query.k, i); });
}

Ray RayColumns::ray(std::size_t row) const {
  try {
    return make_ray(origin(row), direction(row), *t_min[row], *t_max[row]);
  } catch (const Error& error) {
    Error::Parts parts = error.parts();
    parts.problem = fmt::format("ray {}: {}", row, parts.problem);
    throw Error(parts);
  }
}

void closest(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
             std::span<std::optional<Hit>> hits) {
  closest_batch(octree, RaysInMemory<std::optional<Hit>>(rays, hits), query);
}

void closest(const Octree& octree, const RayColumns& rays, const RayQuery& query, const HitColumns& hits,
             const Progress& progress) {
  closest_batch(octree, RaysInColumns<std::optional<Hit>, HitsOfRows>(octree, rays, query, {hits}, progress),
                query);
}

void find(const Octree& octree, std::span<const glm::dvec3> targets, const PointQuery& query,
          const PointHitColumns& hits, const Progress& progress) {
  check_batch<glm::dvec3>(octree, query);
  if (query.k == k_all)
    throw input_error("columns require a k", "the number of rows for each target", "none");
  JoinedProgress done(progress, targets.size());
  if (suits_turns(octree, query, k_most_sorted)) {
    check_in_turns(targets);
    for (std::size_t begin = 0; begin < targets.size(); begin += k_most_sorted) {
      const auto some = targets.subspan(begin, std::min(k_most_sorted, targets.size() - begin));
      answer_in_turns(octree, some, query, [&](std::size_t, const Turn& turn) {
        turn.for_each([&](std::size_t number, std::span<const PointHit> answers) {
          hits.set(query.k, begin + number, answers);
        });
        done.add(turn.ends.size());
      });
    }
    return;
  }
  // A filter, or many neighbours, may make each take milliseconds.
  constexpr std::size_t k_few_targets = 8;
  in_blocks(targets.size(), k_few_targets, [&](std::size_t first, std::size_t end) {
    check_range(targets, first, end);
    std::vector<PointHit> answers;
    for (std::size_t i = first; i < end; ++i) {
      answers.clear();
      find_into(octree, targets[i], query, query.k, i, answers);
      hits.set(query.k, i, answers);
    }
    done.add(end - first);
  });
}

void occluded(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
              std::span<std::uint8_t> answers) {
  occluded_batch(octree, RaysInMemory<std::uint8_t>(rays, answers), query);
}

void occluded(const Octree& octree, const RayColumns& rays, const RayQuery& query,
              std::span<std::uint8_t> answers, const Progress& progress) {
  check_room(rays.count, answers.size());
  occluded_batch(octree,
                 RaysInColumns<std::uint8_t, BytesOfRows>(octree, rays, query, {answers.data()}, progress),
                 query);
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
