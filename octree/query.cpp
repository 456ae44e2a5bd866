// SPDX-License-Identifier: MIT
#include "octree/query.h"

#include <tbb/parallel_for.h>

#include <cassert>

#include "octree/candidate.h"
#include "octree/octree.h"
#include "octree/simd/traversal.h"

namespace alidade {
namespace {

// Enough work per task to hide the scheduler, few enough that the last tasks do not leave threads idle.
constexpr std::size_t k_rays_per_task = 256;

template <class Visit>
void for_each_ray(std::size_t count, const Visit& visit) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, k_rays_per_task), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) visit(i);
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
  assert(rays.size() == hits.size());
  for_each_ray(rays.size(), [&](std::size_t i) { hits[i] = closest(octree, rays[i], query); });
}

void occluded(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
              std::span<std::uint8_t> answers) {
  assert(rays.size() == answers.size());
  for_each_ray(rays.size(), [&](std::size_t i) { answers[i] = occluded(octree, rays[i], query); });
}

}  // namespace alidade
