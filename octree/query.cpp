// SPDX-License-Identifier: MIT
#include "octree/query.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <string>

#include "octree/candidate.h"
#include "octree/octree.h"
#include "octree/simd/traversal.h"

namespace alidade {
namespace {

// Enough work per task to hide the scheduler, few enough that the last tasks do not leave threads idle.
constexpr std::size_t k_rays_per_task = 256;

template <class Answer, class Ask>
void for_each_ray(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
                  std::span<Answer> answers, const Ask& ask) {
  check(query);
  if (answers.size() != rays.size()) {
    throw Error({.problem = "room for the answers does not fit the rays",
                 .expected = std::to_string(rays.size()),
                 .found = std::to_string(answers.size())});
  }
  if (octree.size() == 0) {
    std::ranges::fill(answers, Answer{});
    return;
  }
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rays.size(), k_rays_per_task), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i)
      answers[i] = ask(octree.view(), rays[i], query);
  });
}

}  // namespace

std::optional<Hit> closest(const Octree& octree, const Ray& ray, const RayQuery& query) {
  check(query);
  if (octree.size() == 0) return std::nullopt;
  return simd::traversal(octree.instruction_set()).closest(octree.view(), ray, query);
}

bool occluded(const Octree& octree, const Ray& ray, const RayQuery& query) {
  check(query);
  if (octree.size() == 0) return false;
  return simd::traversal(octree.instruction_set()).occluded(octree.view(), ray, query);
}

void closest(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
             std::span<std::optional<Hit>> hits) {
  for_each_ray(octree, rays, query, hits, simd::traversal(octree.instruction_set()).closest);
}

void occluded(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
              std::span<std::uint8_t> answers) {
  for_each_ray(octree, rays, query, answers, simd::traversal(octree.instruction_set()).occluded);
}

}  // namespace alidade
