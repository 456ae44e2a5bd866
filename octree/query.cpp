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
void check_one(const Octree& octree, const Target& target, const Query& query) {
  check_target(target, query);
  check_level(octree, query.max_level);
  if constexpr (std::is_same_v<Query, RayQuery>) check_spacings(octree, query);
}

template <class Target, class Query>
void check_many(const Octree& octree, std::span<const Target>, const Query& query) {
  check_conditions<Target>(query);
  check_level(octree, query.max_level);
  if constexpr (std::is_same_v<Query, RayQuery>) check_spacings(octree, query);
}

template <class Answer, class Target, class Query>
std::vector<Answer> find_one(const Octree& octree, const Target& target, const Query& query) {
  check_one(octree, target, query);
  std::vector<Answer> answers;
  find_into(octree, target, query, query.k, 0, answers);
  return answers;
}

template <class Answer, class Target, class Query>
Answers<Answer> find_many(const Octree& octree, std::span<const Target> targets, const Query& query) {
  check_many(octree, targets, query);
  return answer_all<Answer>(targets, k_grain, [&](std::size_t i, std::vector<Answer>& answers) {
    find_into(octree, targets[i], query, query.k, i, answers);
  });
}

template <class Target, class Query>
std::size_t count_one(const Octree& octree, const Target& target, const Query& query) {
  check_one(octree, target, query);
  return count_to(octree, target, query, query.k, 0);
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

template <class Target, class Query>
void count_many(const Octree& octree, std::span<const Target> targets, const Query& query,
                std::span<std::size_t> counts) {
  ask_many(octree, targets, query, counts,
           [](const Octree& tree, const Target& target, const Query& asked, std::size_t i) {
             return count_to(tree, target, asked, asked.k, i);
           });
}

}  // namespace

std::optional<Hit> closest(const Octree& octree, const Ray& ray, const RayQuery& query) {
  check_one(octree, ray, query);
  return first_hit(octree, ray, query, 0);
}

std::optional<Hit> closest(const Octree& octree, const Cone& cone, const ConeQuery& query) {
  check_one(octree, cone, query);
  return first_hit(octree, cone, query, 0);
}

void closest(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
             std::span<std::optional<Hit>> hits) {
  ask_rays(octree, rays, query, hits, simd::traversal(octree.instruction_set()).closest_stream,
           first_hit<Ray, RayQuery>);
}

bool occluded(const Octree& octree, const Ray& ray, const RayQuery& query) {
  check_one(octree, ray, query);
  return any_hit(octree, ray, query, 0);
}

bool occluded(const Octree& octree, const Cone& cone, const ConeQuery& query) {
  check_one(octree, cone, query);
  return any_hit(octree, cone, query, 0);
}

void occluded(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
              std::span<std::uint8_t> answers) {
  ask_rays(octree, rays, query, answers, simd::traversal(octree.instruction_set()).occluded_stream,
           any_hit<Ray, RayQuery>);
}

std::vector<Hit> find(const Octree& octree, const Ray& ray, const RayQuery& query) {
  return find_one<Hit>(octree, ray, query);
}

std::vector<Hit> find(const Octree& octree, const Cone& cone, const ConeQuery& query) {
  return find_one<Hit>(octree, cone, query);
}

std::vector<PathHit> find(const Octree& octree, const Path& path, const PathQuery& query) {
  return find_one<PathHit>(octree, path, query);
}

std::vector<PointHit> find(const Octree& octree, const HalfSpaces& region, const PointQuery& query) {
  return find_one<PointHit>(octree, region, query);
}

std::vector<PointHit> find(const Octree& octree, const Bounds& box, const PointQuery& query) {
  return find_one<PointHit>(octree, box, query);
}

std::vector<PointHit> find(const Octree& octree, const glm::dvec3& point, const PointQuery& query) {
  return find_one<PointHit>(octree, point, query);
}

Answers<Hit> find(const Octree& octree, std::span<const Ray> rays, const RayQuery& query) {
  return find_many<Hit>(octree, rays, query);
}

Answers<Hit> find(const Octree& octree, std::span<const Cone> cones, const ConeQuery& query) {
  return find_many<Hit>(octree, cones, query);
}

Answers<PathHit> find(const Octree& octree, std::span<const Path> paths, const PathQuery& query) {
  return find_many<PathHit>(octree, paths, query);
}

Answers<PointHit> find(const Octree& octree, std::span<const HalfSpaces> regions, const PointQuery& query) {
  return find_many<PointHit>(octree, regions, query);
}

Answers<PointHit> find(const Octree& octree, std::span<const Bounds> boxes, const PointQuery& query) {
  return find_many<PointHit>(octree, boxes, query);
}

Answers<PointHit> find(const Octree& octree, std::span<const glm::dvec3> points, const PointQuery& query) {
  return find_many<PointHit>(octree, points, query);
}

std::size_t count(const Octree& octree, const Ray& ray, const RayQuery& query) {
  return count_one(octree, ray, query);
}

std::size_t count(const Octree& octree, const Cone& cone, const ConeQuery& query) {
  return count_one(octree, cone, query);
}

std::size_t count(const Octree& octree, const Path& path, const PathQuery& query) {
  return count_one(octree, path, query);
}

std::size_t count(const Octree& octree, const HalfSpaces& region, const PointQuery& query) {
  return count_one(octree, region, query);
}

std::size_t count(const Octree& octree, const Bounds& box, const PointQuery& query) {
  return count_one(octree, box, query);
}

std::size_t count(const Octree& octree, const glm::dvec3& point, const PointQuery& query) {
  return count_one(octree, point, query);
}

void count(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
           std::span<std::size_t> counts) {
  count_many(octree, rays, query, counts);
}

void count(const Octree& octree, std::span<const Cone> cones, const ConeQuery& query,
           std::span<std::size_t> counts) {
  count_many(octree, cones, query, counts);
}

void count(const Octree& octree, std::span<const Path> paths, const PathQuery& query,
           std::span<std::size_t> counts) {
  count_many(octree, paths, query, counts);
}

void count(const Octree& octree, std::span<const HalfSpaces> regions, const PointQuery& query,
           std::span<std::size_t> counts) {
  count_many(octree, regions, query, counts);
}

void count(const Octree& octree, std::span<const Bounds> boxes, const PointQuery& query,
           std::span<std::size_t> counts) {
  count_many(octree, boxes, query, counts);
}

void count(const Octree& octree, std::span<const glm::dvec3> points, const PointQuery& query,
           std::span<std::size_t> counts) {
  count_many(octree, points, query, counts);
}

}  // namespace alidade
