// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "visibility/raster/map_observer.h"
#include "visibility/raster/map_places.h"
#include "visibility/raster/viewshed.h"

namespace alidade {

/// Finds for places on the ground the lowest height above them that is seen, as viewshed.h tells it.
class LowestSeen {
 public:
  /// The references must outlive this. Memory: 8 B per point, unless all have one radius. Errors: more than
  /// there is.
  LowestSeen(const Occluders& occluders, const ViewshedOptions& options);

  /// Lowers `heights`, one per target, where this observer sees something lower. Those it does not look at
  /// stay as they are; the others become `highest` at most.
  void look(const MapObserver& observer, std::span<const MapTarget> targets, std::span<double> heights);

  std::uint64_t line_count() const { return line_count_; }

 private:
  struct Search {
    std::size_t target;
    double blocked;  ///< highest that is not seen
    double tried;    ///< to look at next
    double highest;  ///< that the observer looks at
  };

  void climb(const MapObserver& observer, std::span<const MapTarget> targets, std::span<double> heights);
  void halve(const MapObserver& observer, std::span<const MapTarget> targets, std::span<double> heights);
  /// Fills the batch with lines to what the searches from `begin` on try next; the end of those.
  std::size_t aim(const MapObserver& observer, std::span<const MapTarget> targets, std::size_t begin);
  double radius_of(std::uint64_t point_id) const;

  const Occluders& occluders_;
  ViewshedOptions options_;
  std::vector<double> spacings_;  ///< by point id; empty if all points have one radius
  SightBatch batch_;
  std::vector<Search> searches_, seen_;
  std::uint64_t line_count_ = 0;
};

}  // namespace alidade
