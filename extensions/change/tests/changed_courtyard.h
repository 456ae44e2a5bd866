// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "cloud/point_cloud.h"
#include "extensions/change/change.h"
#include "simulation/site.h"

// The courtyard in two states, scans of both, and what is true of their points.

namespace alidade::test {

/// A state of the courtyard and where it is scanned from.
struct SiteState {
  simulation::Site site;
  std::vector<glm::dvec3> stations;
};

struct ChangedCourtyard {
  SiteState before, after;
};

/// A car is removed, another is parked elsewhere; a bench is removed, another moved by 1.5 m; three crates
/// and a drum are new. A block of stone moves by 2, 4 and -1 cm, 5 cm of soil are heaped up and a slab of 3
/// cm is taken away. AFTER is scanned from 8 stations instead of 10, at least a metre from those of BEFORE.
ChangedCourtyard changed_courtyard();

/// A terrestrial scan of `points` points, with a noise of 1.5 mm along the beams. point_source_id: number of
/// the station, from 1.
PointCloud scan_of(const SiteState& state, std::uint64_t points, std::uint64_t seed);

/// The true changes of the points of a scan of `own`, by exact lines through both sites: `same` and `moved`
/// if a station of `other` sees a surface parallel within 45 degrees on the normal of the exact surface,
/// within max_distance metres; otherwise `lost` (gone or appeared) if the line from one of its stations
/// passes through the position and ends on something behind it; else never_seen. `ignored`: the exact surface
/// of the point is unknown.
struct TrueChanges {
  std::vector<visibility::ChangeClass> classes;
  std::vector<double>
      distances;  ///< from own to other along the normal that shows to the scanner; NaN if none
  /// How densely the other epoch's stations scan the counterpart: beams one radian apart are 1 / density
  /// metres apart on it, for the best station. 0 without a counterpart.
  std::vector<double> densities;
};
TrueChanges true_changes(const SiteState& own, const PointCloud& cloud, const SiteState& other,
                         double max_distance, visibility::ChangeClass lost);

}  // namespace alidade::test
