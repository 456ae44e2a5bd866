// SPDX-License-Identifier: MIT
#include "octree/query.h"

#include <tbb/task_arena.h>

#include <algorithm>

#include "octree/answer_target.h"
#include "octree/check_query.h"
#include "octree/octree.h"

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
  for_each_range(rays, stream_grain(rays.size()), [&](std::size_t first, std::size_t last) {
    while (first < last) {
      const auto rest = rays.subspan(first, last - first);
      const auto suiting =
          static_cast<std::size_t>(std::ranges::find_if_not(rest, suits_traversal) - rest.begin());
      if (suiting > 0)
        stream(octree.view(), rest.first(suiting), query, first, answers.subspan(first, suiting));
      first += suiting;
      if (first < last) {
        answers[first] = ask(octree, rays[first], query, first);
        ++first;
      }
    }
  });
}

}  // namespace

template <AskableAlong T>
std::optional<Hit> closest(const Octree& octree, const T& target, const QueryOf<T>& query) {
  check_target(octree, target, query);
  return first_hit(octree, target, query, 0);
}

void closest(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
             std::span<std::optional<Hit>> hits) {
  ask_rays(octree, rays, query, hits, simd::traversal(octree.instruction_set()).closest_stream,
           first_hit<Ray, RayQuery>);
}

template <AskableAlong T>
bool occluded(const Octree& octree, const T& target, const QueryOf<T>& query) {
  check_target(octree, target, query);
  return any_hit(octree, target, query, 0);
}

void occluded(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
              std::span<std::uint8_t> answers) {
  ask_rays(octree, rays, query, answers, simd::traversal(octree.instruction_set()).occluded_stream,
           any_hit<Ray, RayQuery>);
}

template <Askable T>
std::vector<AnswerOf<T>> FamilyAnswers<T>::find(const Octree& octree, const T& target,
                                                const QueryOf<T>& query) {
  check_target(octree, target, query);
  std::vector<AnswerOf<T>> answers;
  find_into(octree, target, query, query.k, 0, answers);
  return answers;
}

template <Askable T>
Answers<AnswerOf<T>> FamilyAnswers<T>::find(const Octree& octree, std::span<const T> targets,
                                            const QueryOf<T>& query) {
  check_many(octree, targets, query);
  return answer_all<AnswerOf<T>>(targets, k_grain, [&](std::size_t i, std::vector<AnswerOf<T>>& answers) {
    find_into(octree, targets[i], query, query.k, i, answers);
  });
}

template <Askable T>
std::size_t FamilyAnswers<T>::count(const Octree& octree, const T& target, const QueryOf<T>& query) {
  check_target(octree, target, query);
  return count_to(octree, target, query, query.k, 0);
}

template <Askable T>
void FamilyAnswers<T>::count(const Octree& octree, std::span<const T> targets, const QueryOf<T>& query,
                             std::span<std::size_t> counts) {
  ask_many(octree, targets, query, counts,
           [](const Octree& tree, const T& target, const QueryOf<T>& asked, std::size_t i) {
             return count_to(tree, target, asked, asked.k, i);
           });
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
