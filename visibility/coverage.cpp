// SPDX-License-Identifier: MIT
#include "visibility/coverage.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "octree/distance.h"
#include "octree/error.h"
#include "visibility/raster.h"

namespace alidade {
namespace {

constexpr std::size_t k_lines_at_once = 65536;

/// What one observer may see of some targets.
struct Views {
  std::vector<std::size_t> targets;
  std::vector<SightLine> lines;
};

Views views_of(const Occluders& occluders, const Observer& observer, const SightEnd& eye,
               std::span<const PlacementTarget> targets, std::size_t first, double height) {
  const FieldOfView field(observer);
  Views views;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const glm::dvec3 place = targets[i].position + glm::dvec3(0.0, 0.0, height);
    if (!(distance(observer.position, place) <= observer.max_distance)) continue;
    if (field.contains(place - observer.position)) views.targets.push_back(first + i);
  }
  views.lines.resize(views.targets.size());
  tbb::parallel_for(std::size_t{0}, views.lines.size(), [&](std::size_t i) {
    const PlacementTarget& target = targets[views.targets[i] - first];
    const SightEnd end = height > 0.0
                             ? end_near_surface(occluders, target.position + glm::dvec3(0.0, 0.0, height))
                             : end_on_point(occluders, target.point_id, target.position, observer.position);
    views.lines[i] = sight_line(eye, end);
  });
  return views;
}

}  // namespace

Coverage::Coverage(std::size_t candidates, std::size_t targets)
    : candidates_(candidates), targets_(targets), row_words_((targets + 63) / 64) {
  std::uint64_t bytes = 0;
  if (__builtin_mul_overflow(std::uint64_t{candidates}, std::uint64_t{8} * row_words_, &bytes))
    bytes = std::numeric_limits<std::uint64_t>::max();
  check_memory(bytes, "who of the candidates sees which of the targets");
  words_.resize(candidates_ * row_words_);
}

Coverage see_targets(const Occluders& occluders, std::span<const Observer> candidates,
                     std::span<const PlacementTarget> targets, double height, const Progress& progress) {
  if (!(height >= 0.0 && std::isfinite(height))) {
    throw Error(
        {.problem = "bad height of targets", .expected = "0 or more", .found = std::to_string(height)});
  }
  Coverage coverage(candidates.size(), targets.size());
  const std::uint64_t total = std::uint64_t{candidates.size()} * targets.size();
  for (std::size_t candidate = 0; candidate < candidates.size(); ++candidate) {
    const Observer& observer = candidates[candidate];
    const SightEnd eye = end_near_surface(occluders, observer.position);
    for (std::size_t first = 0; first < targets.size(); first += k_lines_at_once) {
      report(progress, candidate * targets.size() + first, total);
      const std::span<const PlacementTarget> some =
          targets.subspan(first, std::min(k_lines_at_once, targets.size() - first));
      const Views views = views_of(occluders, observer, eye, some, first, height);
      std::vector<std::uint8_t> hidden(views.lines.size());
      blocked(occluders, views.lines, hidden);
      for (std::size_t i = 0; i < hidden.size(); ++i) {
        if (hidden[i] == 0) coverage.set(candidate, views.targets[i]);
      }
    }
  }
  report(progress, total, total);
  return coverage;
}

}  // namespace alidade
