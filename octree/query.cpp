// SPDX-License-Identifier: MIT
#include "octree/query.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "base/huge_memory.h"
#include "base/parallel.h"
#include "base/remote_map.h"
#include "octree/answer_target.h"
#include "octree/check_query.h"
#include "octree/curve_order.h"
#include "octree/octree.h"
#include "octree/query_batch.h"
#include "octree/simd/sort_keys.h"

namespace alidade {
namespace {

// Enough work per task to hide the scheduler, few enough that the last tasks do not leave threads idle.
constexpr std::size_t k_grain = 256;

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
void check_batch(const Octree& octree, std::span<const Target>, const Query& query) {
  check_conditions<Target>(query);
  check_against(octree, query);
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

}  // namespace

template <LineGeometry T>
std::optional<Hit> closest(const Octree& octree, const T& target, const QueryOf<T>& query) {
  check_target(octree, target, query);
  return arrived(octree, first_hit(octree, target, query, 0));
}

template <LineGeometry T>
bool occluded(const Octree& octree, const T& target, const QueryOf<T>& query) {
  check_target(octree, target, query);
  return arrived(octree, any_hit(octree, target, query, 0));
}

template <TargetGeometry T>
std::vector<AnswerOf<T>> FamilyAnswers<T>::find(const Octree& octree, const T& target,
                                                const QueryOf<T>& query) {
  check_target(octree, target, query);
  std::vector<AnswerOf<T>> answers;
  find_into(octree, target, query, query.k, 0, answers);
  check_arrival(octree);
  return answers;
}

template <TargetGeometry T>
Answers<AnswerOf<T>> FamilyAnswers<T>::find(const Octree& octree, std::span<const T> targets,
                                            const QueryOf<T>& query) {
  check_batch(octree, targets, query);
  if constexpr (std::same_as<T, glm::dvec3>) {
    if (suits_turns(octree, query) && targets.size() <= std::numeric_limits<std::uint32_t>::max())
      return arrived(octree, CurveBatch(octree, targets, query).find());
  }
  const auto find_one = [&](std::size_t i, std::vector<AnswerOf<T>>& answers) {
    find_into(octree, targets[i], query, query.k, i, answers);
  };
  return arrived(octree, answer_all<AnswerOf<T>>(targets, k_grain, find_one));
}

template <TargetGeometry T>
std::size_t FamilyAnswers<T>::count(const Octree& octree, const T& target, const QueryOf<T>& query) {
  check_target(octree, target, query);
  return arrived(octree, count_to(octree, target, query, query.k, 0));
}

template <TargetGeometry T>
void FamilyAnswers<T>::count(const Octree& octree, std::span<const T> targets, const QueryOf<T>& query,
                             std::span<std::size_t> counts) {
  check_batch(octree, targets, query);
  check_room(targets.size(), counts.size());
  for_each_target(targets, k_grain,
                  [&](std::size_t i) { counts[i] = count_to(octree, targets[i], query, query.k, i); });
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
