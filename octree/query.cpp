// SPDX-License-Identifier: MIT
#include "octree/query.h"

#include <fmt/format.h>
#include <tbb/concurrent_queue.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/bounds.h"
#include "base/error.h"
#include "base/huge_memory.h"
#include "base/morton.h"
#include "base/parallel.h"
#include "octree/answer_target.h"
#include "octree/check_query.h"
#include "octree/octree.h"
#include "octree/query_batch.h"
#include "octree/simd/make_rays.h"
#include "octree/simd/ray_state.h"
#include "octree/simd/sort_keys.h"
#include "octree/simd/traversal.h"

namespace alidade {
namespace {

// Enough work per task to hide the scheduler, few enough that the last tasks do not leave threads idle.
constexpr std::size_t k_grain = 256;

template <class Target, class Query>
void check_batch(const Octree& octree, std::span<const Target> targets, const Query& query) {
  check_conditions<Target>(query);
  if constexpr (std::is_same_v<Query, RayQuery>) check_begins(query, targets.size());
  check_against(octree, query);
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

/// A batch that is answered along a curve through the targets, whatever the order of the caller.
class CurveBatch {
 public:
  CurveBatch(const Octree& octree, std::span<const glm::dvec3> targets, const PointQuery& query)
      : octree_(octree), targets_(targets), query_(query) {}

  Answers<PointHit> find() {
    in_blocks(targets_.size(), k_turn,
              [&](std::size_t first, std::size_t end) { check_range(targets_, first, end); });
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
    in_blocks(order.size(), k_turn, [&](std::size_t first, std::size_t end) {
      const auto numbers = std::span<const simd::SortKey>(order).subspan(first, end - first);
      Turn& turn = turns[first / k_turn];
      turn.numbers.assign(numbers.begin(), numbers.end());
      answer(turn);
      if (!is_known) return;
      put_in_place(turn);
      turn = {};
    });
    if (is_known) return std::move(answers_);
    for (const Turn& turn : turns)
      for (std::size_t i = 0; i < turn.numbers.size(); ++i)
        begin[simd::number_of(turn.numbers[i])] = turn.ends[i] - (i == 0 ? 0 : turn.ends[i - 1]);
    make_room();
    in_parallel(turns.size(), 1, [&](std::size_t t) { put_in_place(turns[t]); });
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

// Many rays to `closest` or `occluded`: through the tree together, those that lanes do not answer one by one.

// Rays that go through the tree together: the more, the more often they share a node; the fewer, the longer
// their states stay in the second-level cache. Small batches are cut into smaller pieces, so that no thread
// is idle.
constexpr std::size_t k_least_stream_rays = 256, k_most_stream_rays = 12288;
std::size_t stream_grain(std::size_t rays) {
  const std::size_t threads = thread_count();
  return threads == 1 ? k_most_stream_rays
                      : std::clamp(rays / (16 * threads), k_least_stream_rays, k_most_stream_rays);
}

/// Rays and answers of one task. Tasks hand their memory on, since new memory costs more than what is done
/// with it.
template <class Answer>
class RoomOfTasks {
 public:
  struct Room {
    std::vector<Ray> rays;
    std::vector<Answer> answers;
  };

  /// Calls use(rays, answers) with room for so many.
  template <class Use>
  void with_room(std::size_t count, const Use& use) {
    std::unique_ptr<Room> room;
    if (!free_.try_pop(room)) room = std::make_unique<Room>();
    if (room->rays.size() < count) {
      room->rays.resize(count);
      room->answers.resize(count);
    }
    use(std::span(room->rays).first(count), std::span(room->answers).first(count));
    free_.push(std::move(room));
  }

 private:
  tbb::concurrent_queue<std::unique_ptr<Room>> free_;
};

/// An array of rays, and one for their answers.
template <class AnswerOfRay>
class RaysInMemory {
 public:
  using Answer = AnswerOfRay;

  RaysInMemory(std::span<const Ray> rays, std::span<Answer> answers) : rays_(rays), answers_(answers) {
    check_room(rays.size(), answers.size());
  }

  std::size_t size() const { return rays_.size(); }
  const glm::dvec3& origin(std::size_t number) const { return rays_[number].origin; }
  void check(std::size_t first, std::size_t last) const { check_range(rays_, first, last); }

  template <class Trace>
  void answer_range(std::size_t first, std::size_t last, const Trace& trace) const {
    check(first, last);
    trace(rays_.subspan(first, last - first), first, answers_.subspan(first, last - first));
  }
  void copy_rays(std::size_t begin, std::span<const simd::SortKey> numbers, std::span<Ray> rays) const {
    for (std::size_t i = 0; i < rays.size(); ++i) rays[i] = rays_[begin + simd::number_of(numbers[i])];
  }
  void put(std::size_t begin, std::span<const simd::SortKey> numbers, std::span<const Answer> answers) const {
    for (std::size_t i = 0; i < answers.size(); ++i)
      answers_[begin + simd::number_of(numbers[i])] = answers[i];
  }

 private:
  const std::span<const Ray> rays_;
  const std::span<Answer> answers_;
};

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
        progress_(progress),
        piece_({.first = has_filter(query) ? k_few_rays : k_most_stream_rays,
                .most = k_most_stream_rays,
                .wanted = k_wanted_time}) {}

  std::size_t size() const { return columns_.count; }
  glm::dvec3 origin(std::size_t number) const { return columns_.origin(number); }
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
      add_done(end - begin);
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
    add_done(answers.size());
  }

 private:
  static constexpr std::chrono::milliseconds k_wanted_time{100};
  static constexpr std::size_t k_few_rays = 64;  // a filter may make each take milliseconds

  /// Errors: always.
  [[noreturn]] void name_bad(std::size_t first, std::size_t last) const {
    for (std::size_t row = first; row < last; ++row) (void)columns_.ray(row);
    throw input_error("the rays changed during the query", "arrays that stay as they are");
  }
  /// One thread reports at a time, and none waits for it: Python runs handlers of signals there, which may
  /// call queries and with them tasks of this one.
  void add_done(std::size_t rays) const {
    done_ += rays;
    while (reported_ < done_ && !is_reporting_.exchange(true)) {
      const std::shared_ptr<void> end(nullptr, [&](void*) { is_reporting_ = false; });
      const std::uint64_t done = done_;
      if (reported_ < done) report(progress_, reported_ = done, size());
    }
  }

  const InstructionSet instruction_set_;
  const RayColumns& columns_;
  const AnswerColumns answers_;
  const Progress& progress_;
  mutable PieceSize piece_;  ///< rays between two reports of the progress
  mutable RoomOfTasks<Answer> rooms_;
  mutable std::atomic<std::uint64_t> done_ = 0, reported_ = 0;
  mutable std::atomic<bool> is_reporting_ = false;
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

/// Calls trace(rays, first_index, answers) for parts of a batch of rays whose origins are scattered. Those of
/// a part start side by side, so that they share their way through the tree. The order costs some 30 ns per
/// ray, and rays that bounce off surfaces, shuffled, take 0.6 to 0.7 of the time. Indices are those of the
/// parts.
template <class Batch, class Trace>
void trace_side_by_side(const Octree& octree, const Batch& batch, const Trace& trace) {
  using Answer = typename Batch::Answer;
  constexpr std::size_t k_most_sorted = std::size_t{1} << 20;  // bounds the memory for the order
  in_blocks(batch.size(), k_least_stream_rays,
            [&](std::size_t first, std::size_t last) { batch.check(first, last); });
  RoomOfTasks<Answer> rooms;
  for (std::size_t begin = 0; begin < batch.size(); begin += k_most_sorted) {
    std::vector<simd::SortKey> order(std::min(k_most_sorted, batch.size() - begin));
    std::iota(order.begin(), order.end(), simd::SortKey{0});
    const auto start = [&](std::uint32_t number) {
      // NaN becomes the minimum: rays in columns are not checked yet.
      return glm::min(octree.bounds().max, glm::max(octree.bounds().min, batch.origin(begin + number)));
    };
    sort_along_curve(start, order);
    in_blocks(order.size(), stream_grain(order.size()), [&](std::size_t first, std::size_t last) {
      const std::span<const simd::SortKey> numbers = std::span(order).subspan(first, last - first);
      rooms.with_room(numbers.size(), [&](std::span<Ray> rays, std::span<Answer> answers) {
        batch.copy_rays(begin, numbers, rays);
        trace(std::span<const Ray>(rays), std::size_t{0}, answers);
        batch.put(begin, numbers, std::span<const Answer>(answers));
      });
    });
  }
}

template <class Batch, class Stream, class TraceOne>
void trace_batch(const Octree& octree, const Batch& batch, const RayQuery& query, const Stream& stream,
                 const TraceOne& trace_one) {
  using Answer = typename Batch::Answer;
  check(query);
  check_begins(query, batch.size());
  check_against(octree, query);
  if (octree.size() == 0 || !has_traversal(octree, query)) {
    const auto trace_each = [&](std::span<const Ray> rays, std::size_t first_index,
                                std::span<Answer> answers) {
      for (std::size_t i = 0; i < rays.size(); ++i)
        answers[i] = trace_one(octree, rays[i], query, first_index + i);
    };
    in_blocks(batch.size(), k_least_stream_rays,
              [&](std::size_t first, std::size_t last) { batch.answer_range(first, last, trace_each); });
    return;
  }
  const auto trace = [&](std::span<const Ray> rest, std::size_t first_index, std::span<Answer> room) {
    while (!rest.empty()) {
      const auto suiting =
          static_cast<std::size_t>(std::ranges::find_if_not(rest, suits_traversal) - rest.begin());
      if (suiting > 0) stream(octree.view(), rest.first(suiting), query, first_index, room.first(suiting));
      if (suiting == rest.size()) return;
      room[suiting] = trace_one(octree, rest[suiting], query, first_index + suiting);
      rest = rest.subspan(suiting + 1);
      room = room.subspan(suiting + 1);
      first_index += suiting + 1;
    }
  };
  // Filters and sheets go by the index of the ray, which sorting changes.
  const auto origin = [&](std::size_t number) { return batch.origin(number); };
  if (batch.size() >= 4 * k_most_stream_rays && !has_filter(query) && query.discs.begins.empty() &&
      !simd::start_side_by_side(octree.view().extent, batch.size(), origin))
    return trace_side_by_side(octree, batch, trace);
  in_blocks(batch.size(), stream_grain(batch.size()),
            [&](std::size_t first, std::size_t last) { batch.answer_range(first, last, trace); });
}

template <class Batch>
void closest_batch(const Octree& octree, const Batch& batch, const RayQuery& query) {
  trace_batch(octree, batch, query, simd::traversal(octree.instruction_set()).closest_stream,
              first_hit<Ray, RayQuery>);
}

template <class Batch>
void occluded_batch(const Octree& octree, const Batch& batch, const RayQuery& query) {
  trace_batch(octree, batch, query, simd::traversal(octree.instruction_set()).occluded_stream,
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
  check_batch(octree, targets, query);
  if constexpr (std::same_as<T, Ray>) {
    if (query.k == 1) return closest_answers(octree, targets, query);
  }
  if constexpr (std::same_as<T, glm::dvec3>) {
    if (suits_turns(octree, query) && targets.size() <= std::numeric_limits<std::uint32_t>::max())
      return CurveBatch(octree, targets, query).find();
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
  check_batch(octree, targets, query);
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
    return make_ray(origin(row), {directions[row][0], directions[row][1], directions[row][2]}, *t_min[row],
                    *t_max[row]);
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
