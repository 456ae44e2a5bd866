// SPDX-License-Identifier: MIT
#include "octree/brute_force.h"

#include <algorithm>
#include <limits>

#include "base/error.h"
#include "octree/candidate.h"
#include "octree/check_query.h"
#include "octree/spacing.h"

namespace alidade::brute_force {
namespace {

/// A path with its segments ready, so that all families are decided by evaluate(target, query, ...).
struct ReadyPath {
  const Path& path;
  std::vector<Segment> segments;
};

std::optional<PathHit> evaluate(const ReadyPath& ready, const PathQuery& query, const glm::dvec3& position,
                                std::uint64_t point_id) {
  return alidade::evaluate(project(ready.segments, position), ready.path.t_min, ready.path.t_max, query,
                           position, point_id);
}

/// A ray, and the spacings of the points it may meet.
struct ReadyRay {
  const Ray& ray;
  std::span<const double> spacings;
};

std::optional<Hit> evaluate(const ReadyRay& ready, const RayQuery& query, const glm::dvec3& position,
                            std::uint64_t point_id) {
  const bool own = query.spacing_factor > 0.0;
  const double radius = own ? own_radius(query, ready.spacings[point_id]) : query.radius;
  return alidade::evaluate(ready.ray, query, radius, position, point_id, 0);
}

template <class Target>
const Target& ready(const Target& target) {
  return target;
}
ReadyPath ready(const Path& path) {
  return {path, segments_of(path)};
}

template <class Query>
Measure measure_of(const Query& query) {
  if constexpr (requires { query.measure; }) return query.measure;
  return Measure::distance;
}

void check_target(const ReadyRay& ready, const RayQuery& query) {
  alidade::check_target(ready.ray, query);
}

/// The ray of a query, once there is a spacing for every point if the query asks for them.
ReadyRay with_spacings(const PointCloud& cloud, const Ray& ray, const RayQuery& query,
                       std::span<const double> spacings) {
  check(query);
  if (query.spacing_factor > 0.0 && spacings.size() != cloud.size()) {
    throw Error({.problem = "spacing_factor needs the spacings of the points",
                 .expected = std::to_string(cloud.size()),
                 .found = std::to_string(spacings.size())});
  }
  return {ray, spacings};
}

template <class Target, class Query>
void check_all(const Target& target, const Query& query) {
  check_target(target, query);
  if (query.max_level != k_all_levels)
    throw Error({.problem = "a cloud without an octree has no levels", .expected = "no max_level"});
}

/// All answers, in the order of the points.
template <class Target, class Query>
auto all(const PointCloud& cloud, const Target& target, const Query& query) {
  check_all(target, query);
  const auto& asked = ready(target);
  std::vector<typename decltype(evaluate(asked, query, glm::dvec3(), 0))::value_type> answers;
  for (std::size_t id = 0; id < cloud.size(); ++id) {
    if (const auto answer = evaluate(asked, query, cloud.world(id), id)) answers.push_back(*answer);
  }
  return answers;
}

template <class Target, class Query>
auto find_first(const PointCloud& cloud, const Target& target, const Query& query, std::size_t k) {
  auto answers = all(cloud, target, query);
  std::sort(answers.begin(), answers.end(),
            [&](const auto& a, const auto& b) { return precedes(measure_of(query), a, b); });
  if (answers.size() > k) answers.resize(k);
  return answers;
}

template <class Target, class Query>
std::optional<Hit> first(const PointCloud& cloud, const Target& target, const Query& query) {
  const std::vector<Hit> answers = find_first(cloud, target, query, 1);
  return answers.empty() ? std::nullopt : std::optional(answers.front());
}

template <class Target, class Query>
std::size_t count_to_k(const PointCloud& cloud, const Target& target, const Query& query) {
  return std::min(all(cloud, target, query).size(), query.k);
}

}  // namespace

std::vector<double> spacings(const PointCloud& cloud, int neighbours) {
  std::vector<double> answers;
  for (std::size_t id = 0; id < cloud.size(); ++id) {
    std::vector<double> distances;
    for (std::size_t other = 0; other < cloud.size(); ++other) {
      const double d = distance(cloud.world(id), cloud.world(other));
      if (d > 0.0) distances.push_back(d);
    }
    double spacing = std::numeric_limits<double>::infinity();
    if (distances.size() >= static_cast<std::size_t>(neighbours)) {
      const auto nth = distances.begin() + (neighbours - 1);
      std::nth_element(distances.begin(), nth, distances.end());
      spacing = *nth;
    }
    answers.push_back(spacing_of(spacing_bits(spacing)));
  }
  return answers;
}

std::optional<Hit> closest(const PointCloud& cloud, const Ray& ray, const RayQuery& query,
                           std::span<const double> spacings) {
  return first(cloud, with_spacings(cloud, ray, query, spacings), query);
}

std::optional<Hit> closest(const PointCloud& cloud, const Cone& cone, const ConeQuery& query) {
  return first(cloud, cone, query);
}

bool occluded(const PointCloud& cloud, const Ray& ray, const RayQuery& query,
              std::span<const double> spacings) {
  return !all(cloud, with_spacings(cloud, ray, query, spacings), query).empty();
}

bool occluded(const PointCloud& cloud, const Cone& cone, const ConeQuery& query) {
  return !all(cloud, cone, query).empty();
}

std::vector<Hit> find(const PointCloud& cloud, const Ray& ray, const RayQuery& query,
                      std::span<const double> spacings) {
  return find_first(cloud, with_spacings(cloud, ray, query, spacings), query, query.k);
}

std::vector<Hit> find(const PointCloud& cloud, const Cone& cone, const ConeQuery& query) {
  return find_first(cloud, cone, query, query.k);
}

std::vector<PathHit> find(const PointCloud& cloud, const Path& path, const PathQuery& query) {
  return find_first(cloud, path, query, query.k);
}

std::vector<PointHit> find(const PointCloud& cloud, const HalfSpaces& region, const PointQuery& query) {
  return find_first(cloud, region, query, query.k);
}

std::vector<PointHit> find(const PointCloud& cloud, const Bounds& box, const PointQuery& query) {
  return find_first(cloud, box, query, query.k);
}

std::vector<PointHit> find(const PointCloud& cloud, const glm::dvec3& point, const PointQuery& query) {
  return find_first(cloud, point, query, query.k);
}

std::size_t count(const PointCloud& cloud, const Ray& ray, const RayQuery& query,
                  std::span<const double> spacings) {
  return count_to_k(cloud, with_spacings(cloud, ray, query, spacings), query);
}

std::size_t count(const PointCloud& cloud, const Cone& cone, const ConeQuery& query) {
  return count_to_k(cloud, cone, query);
}

std::size_t count(const PointCloud& cloud, const Path& path, const PathQuery& query) {
  return count_to_k(cloud, path, query);
}

std::size_t count(const PointCloud& cloud, const HalfSpaces& region, const PointQuery& query) {
  return count_to_k(cloud, region, query);
}

std::size_t count(const PointCloud& cloud, const Bounds& box, const PointQuery& query) {
  return count_to_k(cloud, box, query);
}

std::size_t count(const PointCloud& cloud, const glm::dvec3& point, const PointQuery& query) {
  return count_to_k(cloud, point, query);
}

}  // namespace alidade::brute_force
