// SPDX-License-Identifier: MIT
#include "visibility/raster/lowest_seen.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "octree/point_surface.h"
#include "octree/spacing.h"
#include "visibility/crossing.h"

namespace alidade {
namespace {

constexpr double k_finest = 0.01;  // of a height, in the unit of the cloud
/// Bent lines are made of many chords, which all stay in memory.
constexpr std::size_t k_chords_at_once = 1 << 16;

}  // namespace

LowestSeen::LowestSeen(const Occluders& occluders, const ViewshedOptions& options)
    : occluders_(occluders), options_(options), batch_(occluders, options.curve) {
  if (occluders.options().radius) return;
  check_memory(sizeof(double) * occluders.octree().size(), "the spacings of the points");
  spacings_ = spacings_in_order(occluders.octree().view());
}

double LowestSeen::radius_of(std::uint64_t point_id) const {
  const double radius = candidate_radius(occluders_, spacings_.empty() ? 0.0 : spacings_[point_id]);
  const bool is_disc = occluders_.has_surfaces() && surface_of(occluders_.octree().view(), point_id).exists;
  return is_disc ? radius : sphere_of(occluders_, radius);
}

std::size_t LowestSeen::aim(const MapObserver& observer, std::span<const MapTarget> targets,
                            std::size_t begin) {
  batch_.clear();
  std::size_t end = begin;
  for (; end < searches_.size() && batch_.chord_count() < k_chords_at_once; ++end) {
    const Search& search = searches_[end];
    batch_.add(observer.eye(), raised(targets[search.target].foot, search.tried));
  }
  line_count_ += batch_.size();
  return end;
}

void LowestSeen::climb(const MapObserver& observer, std::span<const MapTarget> targets,
                       std::span<double> heights) {
  while (!searches_.empty()) {
    std::size_t left = 0;
    for (std::size_t begin = 0, end = 0; begin < searches_.size(); begin = end) {
      end = aim(observer, targets, begin);
      const std::span<const std::optional<Blocker>> blockers = batch_.first_blockers();
      for (std::size_t i = begin; i < end; ++i) {
        Search search = searches_[i];
        const std::optional<Blocker>& blocker = blockers[i - begin];
        if (!blocker) {
          seen_.push_back(search);
          continue;
        }
        const glm::dvec3 place = raised(targets[search.target].foot, search.tried).position;
        const double magnified =
            glm::length(place - observer.eye().position) / std::max(blocker->distance, k_finest);
        search.blocked = search.tried;
        search.tried += std::max(k_finest, radius_of(blocker->point_id) * std::max(magnified, 1.0));
        search.tried = std::min(search.tried, search.highest);
        // Higher than what another observer sees, it does not matter.
        if (search.tried > search.blocked && search.tried < heights[search.target])
          searches_[left++] = search;
      }
    }
    searches_.resize(left);
  }
}

void LowestSeen::halve(const MapObserver& observer, std::span<const MapTarget> targets,
                       std::span<double> heights) {
  while (!seen_.empty()) {
    searches_.clear();
    std::size_t left = 0;
    for (const Search& search : seen_) {
      heights[search.target] = std::min(heights[search.target], search.tried);
      if (search.tried - search.blocked <= k_finest) continue;
      seen_[left++] = search;
      searches_.push_back(
          {search.target, search.blocked, 0.5 * (search.blocked + search.tried), search.tried});
    }
    seen_.resize(left);
    for (std::size_t begin = 0, end = 0; begin < left; begin = end) {
      end = aim(observer, targets, begin);
      const std::span<const std::uint8_t> blocked = batch_.blocked();
      for (std::size_t i = begin; i < end; ++i) {
        if (blocked[i - begin])
          seen_[i].blocked = searches_[i].tried;
        else
          seen_[i].tried = searches_[i].tried;
      }
    }
  }
}

void LowestSeen::look(const MapObserver& observer, std::span<const MapTarget> targets,
                      std::span<double> heights) {
  searches_.clear();
  seen_.clear();
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const std::optional<HeightRange> range =
        observer.heights_in_view(targets[i].foot.position, {options_.target_height, options_.highest});
    if (!range) continue;
    heights[i] = std::min(heights[i], options_.highest);
    if (range->low >= heights[i]) continue;
    // What is seen at once has nothing below it to halve into.
    searches_.push_back({i, range->low, range->low, range->high});
  }
  climb(observer, targets, heights);
  halve(observer, targets, heights);
}

}  // namespace alidade
