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

/// Whether a point answers: evaluate() of octree/candidate.h, with what a path needs made ready.
template <class Target, class Query>
auto evaluator(const Target& target, const Query& query) {
  if constexpr (std::is_same_v<Target, Path>) {
    return [&, segments = segments_of(target)](const glm::dvec3& position, std::uint64_t id) {
      return evaluate(project(segments, position), target.t_min, target.t_max, query, position, id);
    };
  } else {
    return
        [&](const glm::dvec3& position, std::uint64_t id) { return evaluate(target, query, position, id); };
  }
}

/// All answers, in the order of the points.
template <TargetGeometry T>
std::vector<AnswerOf<T>> all(const PointCloud& cloud, const T& target, const QueryOf<T>& query) {
  check_target(target, query);
  if (query.max_level != k_all_levels)
    throw Error({.problem = "max_level requires an octree", .expected = "no max_level"});
  const auto answer_of = evaluator(target, query);
  std::vector<AnswerOf<T>> answers;
  for (std::size_t id = 0; id < cloud.size(); ++id) {
    if (const auto answer = answer_of(cloud.world(id), id)) answers.push_back(*answer);
  }
  return answers;
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

template <TargetGeometry T>
std::vector<AnswerOf<T>> find(const PointCloud& cloud, const T& target, const QueryOf<T>& query) {
  std::vector<AnswerOf<T>> answers = all(cloud, target, query);
  std::ranges::sort(answers, [&](const auto& a, const auto& b) { return precedes(measure_of(query), a, b); });
  if (answers.size() > query.k) answers.resize(query.k);
  return answers;
}

template <TargetGeometry T>
std::size_t count(const PointCloud& cloud, const T& target, const QueryOf<T>& query) {
  return std::min(all(cloud, target, query).size(), query.k);
}

template <LineGeometry T>
std::optional<Hit> closest(const PointCloud& cloud, const T& target, const QueryOf<T>& query) {
  const std::vector<Hit> answers = find(cloud, target, query);
  return answers.empty() ? std::nullopt : std::optional(answers.front());
}

template <LineGeometry T>
bool occluded(const PointCloud& cloud, const T& target, const QueryOf<T>& query) {
  return !all(cloud, target, query).empty();
}

template std::optional<Hit> closest(const PointCloud&, const Ray&, const RayQuery&);
template std::optional<Hit> closest(const PointCloud&, const Cone&, const ConeQuery&);
template bool occluded(const PointCloud&, const Ray&, const RayQuery&);
template bool occluded(const PointCloud&, const Cone&, const ConeQuery&);
template std::vector<Hit> find(const PointCloud&, const Ray&, const RayQuery&);
template std::vector<Hit> find(const PointCloud&, const Cone&, const ConeQuery&);
template std::vector<PathHit> find(const PointCloud&, const Path&, const PathQuery&);
template std::vector<PointHit> find(const PointCloud&, const HalfSpaces&, const PointQuery&);
template std::vector<PointHit> find(const PointCloud&, const Bounds&, const PointQuery&);
template std::vector<PointHit> find(const PointCloud&, const glm::dvec3&, const PointQuery&);
template std::size_t count(const PointCloud&, const Ray&, const RayQuery&);
template std::size_t count(const PointCloud&, const Cone&, const ConeQuery&);
template std::size_t count(const PointCloud&, const Path&, const PathQuery&);
template std::size_t count(const PointCloud&, const HalfSpaces&, const PointQuery&);
template std::size_t count(const PointCloud&, const Bounds&, const PointQuery&);
template std::size_t count(const PointCloud&, const glm::dvec3&, const PointQuery&);

}  // namespace alidade::brute_force
